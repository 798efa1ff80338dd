"""Notebooks are run where the package is compiled, and shown without results where it is not."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

FOLDER = "docs/notebooks/"
NOT_RUN = "*The cells were not run: the package was not compiled here. `make demo site` runs them.*"


def compiled(root: Path) -> list[Path]:
    """The compiled core, where it has been built in place."""
    return [path for ending in ("so", "pyd") for path in (root / "python/hydrocrane").glob(f"_core*.{ending}")]


def settings(root: Path) -> dict[str, Any]:
    """What `conf.py` says of notebooks. Results are kept as long as neither the core nor a line of Python changes."""
    core = compiled(root)
    if not core:
        return {"nb_execution_mode": "off"}
    content = hashlib.sha256()
    for path in sorted([*core, *(root / "python/hydrocrane").rglob("*.py")]):
        content.update(path.read_bytes())
    return {
        "nb_execution_mode": "cache",
        "nb_execution_cache_path": str(root / "results" / "notebooks" / content.hexdigest()[:16]),
        "nb_execution_in_temp": True,
        "nb_execution_raise_on_error": True,
        "nb_execution_timeout": 600,
        # It trains for minutes and needs PyTorch.
        "nb_execution_excludepatterns": [f"{FOLDER}train-a-policy.md"],
        "nb_merge_streams": True,
    }


def say_not_run(app: Sphinx, docname: str, source: list[str]) -> None:
    if docname.startswith(FOLDER) and app.config.nb_execution_mode == "off":
        head, title, rest = source[0].partition("\n# Notebook: ")
        heading, end, body = rest.partition("\n")
        source[0] = f"{head}{title}{heading}{end}\n{NOT_RUN}\n{body}" if title else source[0]


def setup(app: Sphinx) -> dict[str, Any]:
    app.connect("source-read", say_not_run)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
