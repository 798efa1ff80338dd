"""Links to files of the repository that are no pages lead to views of these files.

A link to a folder leads to the list of its files. A path in backticks that exists is a link as well. Tables, logs and
anything else that is no text are downloads.
"""

from __future__ import annotations

import posixpath
from functools import cache
from pathlib import Path, PurePosixPath
from typing import Any

from docutils import nodes
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import TextLexer, get_lexer_for_filename
from pygments.util import ClassNotFound
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.transforms import SphinxTransform

# What is shown; anything else that a page links to is a download.
SHOWN = {
    ".rs",
    ".py",
    ".pyi",
    ".toml",
    ".ts",
    ".mjs",
    ".js",
    ".c",
    ".h",
    ".cff",
    ".sh",
    ".yml",
    ".lock",
    ".html",
    ".css",
    "",
}
# Files of these folders are built or fetched, not written.
NOT_SHOWN = {"__pycache__", "node_modules", "target", "cockpit_page", ".venv", "results"}
LONGEST = 300_000
VIEW = "{}.view"


class LinkToViews(SphinxTransform):
    """Before images and downloads are collected, and before Sphinx looks for pages."""

    default_priority = 400

    def apply(self, **kwargs: Any) -> None:
        root = Path(self.env.srcdir)
        for link in list(self.document.findall(addnodes.download_reference)):
            self.replace(link, link["reftarget"], root)
        for link in list(self.document.findall(addnodes.pending_xref)):
            if link.get("reftype") == "myst" and link.get("refdomain") is None:
                self.replace(link, link["reftarget"], root)
        for literal in list(self.document.findall(nodes.literal)):
            if not isinstance(literal.parent, nodes.reference | addnodes.download_reference | addnodes.pending_xref):
                self.name_path(literal, root)

    def replace(self, link: nodes.Element, target: str, root: Path) -> None:
        """`link` leads to the view of its file, or of its folder, where it has one."""
        here = PurePosixPath(self.env.doc2path(self.env.docname, base=False)).parent
        path = posixpath.normpath((here / target).as_posix())
        if not self.shown(root / path):
            return
        found = view_reference(path, *link.children)
        link.replace_self(found)
        self.remember(path)

    def name_path(self, literal: nodes.literal, root: Path) -> None:
        """A path in backticks that exists becomes a link to its page or its view."""
        path = literal.astext().rstrip("/")
        if "/" not in path or " " in path or path.startswith(("/", ".", "results/")) or not (root / path).exists():
            return
        page = self.env.path2doc(str(root / path))
        if page and page in self.env.found_docs:
            xref = addnodes.pending_xref(
                "",
                refdomain="doc",
                reftype="myst",
                reftarget=page,
                reftargetid=None,
                refdoc=self.env.docname,
                refexplicit=True,
            )
            literal.replace_self(xref)
            xref += literal
        elif self.shown(root / path):
            link = view_reference(path)
            literal.replace_self(link)
            link += literal
            self.remember(path)

    def shown(self, path: Path) -> bool:
        relative = path.relative_to(self.env.srcdir) if path.is_relative_to(self.env.srcdir) else None
        if relative is None or NOT_SHOWN & set(relative.parts):
            return False
        return path.is_dir() or is_shown(path)

    def remember(self, path: str) -> None:
        views(self.env).setdefault(self.env.docname, set()).add(path)


def view_reference(path: str, *children: nodes.Node) -> nodes.reference:
    """A link whose address is made relative when the page that holds it is written."""
    return nodes.reference("", "", *children, internal=True, refuri="", view=path, classes=["source-view"])


def views(env: BuildEnvironment) -> dict[str, set[str]]:
    """Per page, the files and folders that it leads to."""
    if not hasattr(env, "source_views"):
        env.source_views = {}  # type: ignore[attr-defined]
    return env.source_views  # type: ignore[attr-defined, no-any-return]


def forget(app: Sphinx, env: BuildEnvironment, docname: str) -> None:
    views(env).pop(docname, None)


def merge(app: Sphinx, env: BuildEnvironment, docnames: list[str], other: BuildEnvironment) -> None:
    views(env).update({name: paths for name, paths in views(other).items() if name in docnames})


def make_relative(app: Sphinx, doctree: nodes.document, docname: str) -> None:
    for link in doctree.findall(nodes.reference):
        if "view" in link:
            link["refuri"] = app.builder.get_relative_uri(docname, VIEW.format(link["view"]))


@cache
def is_shown(path: Path) -> bool:
    """Whether `path` is a text of a kind and size that a reader may want to see."""
    if not path.is_file() or path.suffix not in SHOWN or path.stat().st_size > LONGEST:
        return False
    try:
        path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        return False
    return True


def write_views(app: Sphinx, error: Exception | None) -> None:
    """A view of each file, and a list for each folder; what a list names has a view too.

    They are plain pages of their own: the bar of the site's pages, written a thousand times, would take minutes.
    """
    if error is not None or app.builder.format != "html":
        return
    root, site = Path(app.srcdir), Path(app.outdir)
    todo, done = sorted(set().union(*views(app.env).values())), set[str]()
    while todo:
        path = todo.pop()
        if path in done:
            continue
        done.add(path)
        there, view = root / path, site / (VIEW.format(path) + ".html")
        facts: dict[str, Any] = {"path": path, "top": "../" * path.count("/"), "project": app.config.html_title}
        if there.is_dir():
            facts["entries"] = entries(app, there)
            todo += [name.rstrip("/") for name, _, viewed in facts["entries"] if viewed]
        elif view.exists() and view.stat().st_mtime > there.stat().st_mtime:
            continue
        else:
            facts["source"] = highlighted(there, app.config.source_colours)
        view.parent.mkdir(parents=True, exist_ok=True)
        view.write_text(app.builder.templates.render("source.html", facts), encoding="utf-8")


def entries(app: Sphinx, folder: Path) -> list[tuple[str, str, bool]]:
    """(path, address from the top of the site, whether it is a view) of what somebody wrote in `folder`."""
    found = []
    for entry in sorted(folder.iterdir()):
        name = entry.relative_to(app.srcdir).as_posix()
        page = app.env.path2doc(str(entry))
        if page in app.env.found_docs:
            found.append((name, f"{page}.html", False))
        elif entry.name not in NOT_SHOWN and not entry.name.startswith(".") and (entry.is_dir() or is_shown(entry)):
            found.append((name + "/" * entry.is_dir(), VIEW.format(name) + ".html", True))
    return found


def highlighted(path: Path, colours: bool) -> str:
    """A text with numbers of its lines; without colours it is a third of the work of the whole site less."""
    text = path.read_text(encoding="utf-8")
    try:
        lexer = get_lexer_for_filename(path.name) if colours else TextLexer()
    except ClassNotFound:
        lexer = TextLexer()
    return highlight(text, lexer, HtmlFormatter(linenos="table", anchorlinenos=True, lineanchors="line"))


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_config_value("source_colours", True, "")
    app.add_transform(LinkToViews)
    app.connect("env-purge-doc", forget)
    app.connect("env-merge-info", merge)
    app.connect("doctree-resolved", make_relative)
    app.connect("build-finished", write_views)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
