"""Pages of which a script writes what stands below a marker; what stands above it is written by hand."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

MARKER = "<!-- numbers -->"


def write(page: Path, lines: Iterable[str]) -> None:
    """Put `lines` below the marker of `page`."""
    head = page.read_text(encoding="utf-8").split(MARKER)[0]
    page.write_text(head + "\n".join([MARKER, "", *lines, ""]), encoding="utf-8")
    print(page)
