"""Pages of which a script writes what stands below a marker; what stands above it is written by hand."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


def write(page: Path, lines: Iterable[str], part: str = "") -> None:
    """Put `lines` below the marker of `page`; below that of a `part` of it up to the next section."""
    marker = f"<!-- numbers of {part} -->" if part else "<!-- numbers -->"
    head, below = page.read_text(encoding="utf-8").split(marker)
    rest = below[below.find("\n## ") :] if part and "\n## " in below else ""
    page.write_text(head + "\n".join([marker, "", *lines, ""]) + rest, encoding="utf-8")
    print(page)
