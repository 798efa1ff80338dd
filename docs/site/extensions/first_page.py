"""The first page, with the moving crane and, where it has been built, the cockpit itself."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

COCKPIT = Path("python/hydrocrane/app/cockpit_page")
PICTURES = ("docs/pictures/lift.gif", "docs/pictures/cockpit.png")


def has_cockpit(app: Sphinx) -> bool:
    return (Path(app.srcdir) / COCKPIT / "index.html").is_file()


def first_page(app: Sphinx) -> Iterator[tuple[str, dict[str, Any], str]]:
    yield "index", {"title": app.config.project, "has_cockpit": has_cockpit(app)}, "landing.html"


def lead_home(app: Sphinx, pagename: str, templatename: str, context: dict[str, Any], doctree: object) -> None:
    """The name of the project in every page's bar leads to the first page, not to the table of contents."""
    context["master_doc"] = context["root_doc"] = "index"


def copy_what_it_shows(app: Sphinx, error: Exception | None) -> None:
    if error is not None or app.builder.format != "html":
        return
    root, site = Path(app.srcdir), Path(app.outdir)
    for picture in PICTURES:
        shutil.copy(root / picture, site / "_static")
    if has_cockpit(app):
        shutil.copytree(root / COCKPIT, site / "cockpit", dirs_exist_ok=True)


def setup(app: Sphinx) -> dict[str, Any]:
    app.connect("html-collect-pages", first_page)
    app.connect("html-page-context", lead_home)
    app.connect("build-finished", copy_what_it_shows)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
