"""The site: every page stands in a table of contents, and what is built is whole and needs no network."""

from __future__ import annotations

import re
import subprocess
import sys
from collections import Counter
from functools import cache
from html import unescape
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from hydrocrane.plots.style import ACCENT, COLOURS, INK, MUTED

ROOT = Path(__file__).resolve().parents[3]
SITE = ROOT / "docs" / "site"
TOP = ("README.md", "NOTATION.md", "ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")


def entries(contents: Path) -> list[Path]:
    """Pages in the order of a table of contents; a pattern takes those that its own table does not name."""
    found: list[Path] = []
    for table in re.findall(r"^\.\. toctree::\n((?: {3}.*\n|\n)*)", contents.read_text(encoding="utf-8"), re.MULTILINE):
        lines = [line.strip() for line in table.splitlines() if line.strip() and not line.strip().startswith(":")]
        named: list[Path] = []
        for line in lines:
            target = re.sub(r".*<(.*)>$", r"\1", line)
            there = sorted(
                path.resolve() for ending in (".md", ".rst") for path in contents.parent.glob(target + ending)
            )
            assert there, f"{contents.name} names {target}"
            named += [path for path in there if path not in named]
        found += named
    return found


def test_every_page_stands_in_one_table_of_contents():
    listed: Counter[Path] = Counter()
    todo = [SITE / "contents.rst"]
    while todo:
        here = entries(todo.pop())
        listed.update(here)
        todo += [page for page in here if page.suffix == ".rst"]
    assert not [page for page, times in listed.items() if times > 1]
    pages = {*(ROOT / name for name in TOP), *(ROOT / "docs").rglob("*.md"), *SITE.glob("*/*.rst")}
    assert not pages - set(listed)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site as `make site` builds it, warnings being errors, with views of sources in one colour;
    `test_notebooks.py` runs the notebooks.
    """
    pytest.importorskip("sphinx", reason="the extra `docs` is not installed")
    if not (ROOT / "results/katex/static").is_dir():
        pytest.skip("`make site` fetches the mathematics, which are not here")
    out = tmp_path_factory.mktemp("site")
    command = [
        "-q",
        "-W",
        "--keep-going",
        "-b",
        "html",
        "-c",
        str(SITE),
        "-d",
        str(out / "cache"),
        "-D",
        "nb_execution_mode=off",
        "-D",
        "source_colours=0",
        ".",
        str(out / "html"),
    ]
    done = subprocess.run([sys.executable, "-m", "sphinx", *command], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-4000:]
    return out / "html"


@cache
def lies(folder: Path, address: str) -> Path | None:
    """The file or folder that an address names, if there is one."""
    there = (folder / address).resolve()
    return there if there.exists() else None


@pytest.mark.evidence
def test_links_and_anchors_of_the_site_lead_somewhere(site):
    code = re.compile(r"<pre>.*?</pre>", re.DOTALL)
    texts = {page: code.sub("", page.read_text(encoding="utf-8")) for page in site.rglob("*.html")}
    anchors = {page: set(re.findall(r'\bid="([^"]+)"', text)) for page, text in texts.items()}
    assert len(texts) > 500
    broken = []
    for page, text in texts.items():
        for target in re.findall(r'\b(?:href|src)="([^"]*)"', text):
            address, _, anchor = unquote(unescape(target)).partition("#")
            if re.match(r"[a-z]+:", address):
                continue
            there = lies(page.parent, address.partition("?")[0]) if address else page
            if there is None or (anchor and there in anchors and anchor not in anchors[there]):
                broken.append(f"{page.relative_to(site)}: {target}")
    assert not broken, broken[:20]


@pytest.mark.evidence
def test_the_site_fetches_nothing_from_elsewhere(site):
    """Scripts, styles, fonts and pictures are its own files."""
    fetched = re.compile(r'<(?:script|img|iframe|link)\b[^>]*\b(?:src|href)="((?:https?:)?//[^"]+)"')
    for page in site.rglob("*.html"):
        assert not fetched.findall(page.read_text(encoding="utf-8")), page
    for style in site.rglob("*.css"):
        assert not re.findall(r"url\(\s*[\"']?(?:https?:)?//|@import", style.read_text(encoding="utf-8")), style
    assert list(site.rglob("KaTeX_Main-Regular*.woff2"))


def test_pictures_are_readable_in_the_dark():
    """Every colour of the pictures has on the turned background three quarters of its contrast on white, at least 3."""
    share, angle = re.search(r"invert\(([\d.]+)\) hue-rotate\((\d+)deg\)", (SITE / "conf.py").read_text()).groups()
    assert ".content img { filter: var(--pictures); }" in (SITE / "static/site.css").read_text() and angle == "180"
    # The matrix of hue-rotate by 180 degrees, https://www.w3.org/TR/filter-effects-1/#feColorMatrixElement.
    weights = np.array([0.213, 0.715, 0.072])
    turned = 2.0 * np.tile(weights, (3, 1)) - np.eye(3)

    def dark(colour):
        inverted = float(share) + np.array(to_rgb(colour)) * (1.0 - 2.0 * float(share))
        return np.clip(turned @ inverted, 0.0, 1.0)

    def contrast(one, other):
        light = [(np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4) @ weights) for c in (one, other)]
        return (max(light) + 0.05) / (min(light) + 0.05)

    for colour in (INK, MUTED, ACCENT, *COLOURS):
        on_white = contrast(np.array(to_rgb(colour)), np.ones(3))
        assert contrast(dark(colour), dark("white")) > max(3.0, 0.75 * on_white), colour
