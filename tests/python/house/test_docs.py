"""The documentation says what is so: code runs, files load, references are complete, links lead somewhere."""

from __future__ import annotations

import json
import re
import runpy
import shlex
import shutil
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import pytest

import hydrocrane as hc
from hydrocrane import _core
from hydrocrane.app.cli import app, main
from hydrocrane.results.outcome import Outcome

ROOT = Path(__file__).resolve().parents[3]
TOP = ("README.md", "NOTATION.md", "ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")
PAGES = [*(ROOT / name for name in TOP), *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
NAMED = re.compile(r"# (machine|scenario|study): (\S+\.toml)\n")


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


def text_of(path: str) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


def blocks(page: Path) -> list[tuple[str, str]]:
    """(language, text) of each fenced block that is meant to be run, in order."""
    found = BLOCK.findall(page.read_text(encoding="utf-8"))
    return [(language, text) for language, text in found if language in ("python", "console", "toml")]


@pytest.mark.evidence
@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p)], ids=name_of)
def test_every_block_of_a_page_runs(page, tmp_path, monkeypatch):
    """Top to bottom as a reader would, in a folder with the logs beside the page: files are written, commands run,
    Python shares its names.
    """
    for log in page.parent.glob("*.csv"):
        shutil.copy(log, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    names: dict[str, Any] = {"__name__": "page"}
    for language, text in blocks(page):
        if language == "python":
            exec(compile(text, name_of(page), "exec"), names)
        elif language == "toml":
            load_complete_file(text)
        else:
            for line in text.splitlines():
                run_command(line)


def load_complete_file(text: str) -> None:
    """A file that says its name in its first line is complete; others are excerpts."""
    named = NAMED.match(text)
    if not named:
        return
    kind, name = named.groups()
    Path(name).write_text(text, encoding="utf-8")
    if kind == "machine":
        hc.load_machine(name)
    elif kind == "study":
        assert hc.load_study(name).study.cases.count
    else:
        plan = hc.load_scenario(name)
        assert plan.initial_state(plan.load_machine()).size


def run_command(line: str) -> None:
    prompt, program, *arguments = shlex.split(line)
    assert (prompt, program) == ("$", "hydrocrane"), f"a console block holds `$ hydrocrane ...` lines, not {line!r}"
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    plt.close("all")
    assert not ended.value.code, line


def headings(page: Path) -> set[str]:
    """Anchors of a page, as GitHub makes them."""
    titles = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title).strip().lower().replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_lead_somewhere(page):
    text = BLOCK.sub("", page.read_text(encoding="utf-8"))
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if "://" in target:
            continue
        path, _, anchor = target.partition("#")
        there = (page.parent / path).resolve() if path else page
        assert there.exists(), f"{name_of(page)} links to {target}"
        assert not anchor or anchor in headings(there), f"{name_of(page)} links to {target}"


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_named_paths_exist(page):
    """A path in backticks that begins with a folder of the project is one that exists; a star stands for any."""
    text = BLOCK.sub("", page.read_text(encoding="utf-8"))
    rooms = r"crates|docs|python|tests|machines|scenarios|reproductions|benches"
    for path in re.findall(rf"`((?:{rooms})/[\w./*<>-]*)`", text):
        assert list(ROOT.glob(path.replace("<crate>", "*").rstrip("/"))), f"{name_of(page)} names `{path}`"


def words_in_backticks(text: str) -> set[str]:
    """Every key-like word inside backticks; `a.b = "c"` holds a, b and c."""
    return {word for span in re.findall(r"`([^`]+)`", text) for word in re.findall(r"\d+(?:[.,]\d+)+|[\w/-]+", span)}


def test_the_reference_names_every_key_of_the_files():
    keys = [key for kind in ("machine", "scenario") for key in json.loads(_core.key_list(kind))]
    known = {word for key in keys for word in [key["path"].split(".")[-1].strip("<>"), *key["choices"]]}
    assert {"bore", "rocker-pivot", "record-interval", "regenerative", "bulk-c1"} <= known and len(known) > 130
    pages = [text_of(f"docs/reference/{page}.md") for page in ("machine-file", "machine-file-circuit", "scenario-file")]
    missing = known - words_in_backticks("".join(pages))
    assert not missing, sorted(missing)


def test_the_reference_names_every_error():
    slugs = set(re.findall(r'^ {4}\w+ = "([\w-]+)",', text_of("crates/machine/src/errors.rs"), re.MULTILINE))
    slugs |= set(re.findall(r"\[(cannot-[\w-]+)\]", text_of("crates/python/src/handed/errors.rs")))
    rows = re.findall(r"^\| `([a-z-]+)` \|", text_of("docs/reference/errors.md"), re.MULTILINE)
    assert len(slugs) > 20 and slugs == set(rows)


def test_the_reference_names_every_warning():
    """The kinds in the sources: of each `Warning` in Rust and `ResultWarning` in Python, and that of Ctrl-C."""
    kinds = {doubt.kind for doubt in Outcome.stopped(0.0).doubts(1.0)}
    for path in sorted((ROOT / "crates").glob("*/src/**/*.rs")):
        text = path.read_text(encoding="utf-8")
        if re.search(r"\bWarning \{", text):
            kinds |= set(re.findall(r'(?:\bkind: |\(\s*)"([a-z]+(?:-[a-z]+)*)",', text))
    for path in sorted((ROOT / "python").rglob("*.py")):
        kinds |= set(re.findall(r'\bResultWarning\(\s*"([a-z-]+)"', path.read_text(encoding="utf-8")))
    rows = re.findall(r"^\| `([a-z-]+)` \|", text_of("docs/reference/warnings.md"), re.MULTILINE)
    assert "tip-off-path" in kinds and kinds == set(rows)


def test_the_reference_names_every_exception():
    exceptions = re.findall(r"^class (\w+)\(", text_of("python/hydrocrane/errors.py"), re.MULTILINE)
    page = text_of("docs/reference/errors.md")
    assert exceptions and all(name in page for name in exceptions)


def test_the_reference_shows_every_command():
    commands = {command.name or command.callback.__name__ for command in app.registered_commands}
    page = text_of("docs/reference/command-line.md")
    assert commands == set(re.findall(r"^## (\w+)$", page, re.MULTILINE))
    assert all(f"hydrocrane {name}" in page for name in commands)


def test_states_and_outputs_are_current():
    written = runpy.run_path(str(ROOT / "docs/reference/states_and_outputs.py"))
    assert written["page"]() == written["PAGE"].read_text(encoding="utf-8"), "run docs/reference/states_and_outputs.py"


def test_what_is_written_from_the_declared_keys_is_current():
    written = runpy.run_path(str(ROOT / "docs/reference/keys.py"))
    for path, text in written["FILES"].items():
        assert text() == path.read_text(encoding="utf-8"), "run docs/reference/keys.py"


def test_every_page_is_reachable_from_the_front_page():
    seen, todo = set(), [ROOT / "README.md"]
    while todo:
        page = todo.pop()
        if page in seen or page.suffix != ".md":
            continue
        seen.add(page)
        links = re.findall(r"\]\(([^)\s#]+)", page.read_text(encoding="utf-8"))
        todo += [(page.parent / link).resolve() for link in links if "://" not in link]
    assert not {name_of(page) for page in PAGES} - {name_of(page) for page in seen}


def test_the_evidence_on_the_front_page_is_current():
    written = runpy.run_path(str(ROOT / "docs/reference/front_page.py"))
    assert written["page"]() == written["PAGE"].read_text(encoding="utf-8"), "run docs/reference/front_page.py"


def test_the_tables_about_sensitivities_are_current():
    written = runpy.run_path(str(ROOT / "docs/reference/sensitivities.py"))
    for path in written["PAGES"]:
        assert written["page"](path) == path.read_text(encoding="utf-8"), "run docs/reference/sensitivities.py"


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_tables_are_whole(page):
    """Every row of a table has as many cells as its head: a bar inside a formula would cut it."""
    cells = 0
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        bars = len(re.findall(r"(?<!\\)\|", line)) if line.startswith("|") else 0
        assert not (bars and cells) or bars == cells, f"{name_of(page)}:{number}"
        cells = bars
