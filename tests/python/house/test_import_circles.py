"""No file of a crate or of the page needs a file that needs it. Python's own files: test_layout.py."""

from __future__ import annotations

import graphlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
CRATES = sorted(path.parent.name for path in (ROOT / "crates").glob("*/Cargo.toml"))


def modules(crate: str) -> dict[str, Path]:
    """Path of a module inside its crate -> its file; the root only lists modules, binaries and tests stand apart."""
    source = ROOT / "crates" / crate / "src"
    files = {}
    for path in source.rglob("*.rs"):
        parts = [part for part in path.relative_to(source).with_suffix("").parts if part != "mod"]
        if parts != ["lib"] and parts[0] != "bin" and not parts[-1].endswith("tests"):
            files["::".join(parts)] = path
    return files


def named(path: str, known: dict[str, Path]) -> str | None:
    """The longest module that a path of names begins with."""
    parts = path.split("::")
    heads = ("::".join(parts[:count]) for count in range(len(parts), 0, -1))
    return next((head for head in heads if head in known), None)


def uses(module: str, known: dict[str, Path]) -> set[str]:
    """Modules of the same crate that a module names outside of its tests and comments."""
    code = known[module].read_text(encoding="utf-8").split("#[cfg(test)]\nmod tests")[0]
    code = re.sub(r"//.*", "", code)
    own = module if known[module].name == "mod.rs" else module.rpartition("::")[0]
    paths = re.findall(r"\bcrate::((?:\w+::)*\w+)", code)
    paths += [f"{own}::{path}".removeprefix("::") for path in re.findall(r"\bsuper::((?:\w+::)*\w+)", code)]
    for root, group in re.findall(r"use (crate|super)::((?:\w+::)*\{[^;]*\});", code):
        paths += [f"{own}::{path}" if root == "super" and own else path for path in ungrouped(group)]
    return {found for path in paths if (found := named(path, known)) and found != module}


def ungrouped(path: str) -> list[str]:
    """The paths of `a::{b, c::{d, e}}`, one by one."""
    head, brace, inner = path.partition("{")
    if not brace:
        return [path.partition(" as ")[0].strip()]
    depth, parts = 0, [""]
    for letter in inner.rpartition("}")[0]:
        depth += {"{": 1, "}": -1}.get(letter, 0)
        if letter == "," and not depth:
            parts.append("")
        else:
            parts[-1] += letter
    return [head.strip() + path for part in parts if part.strip() for path in ungrouped(part)]


def circle(graph: dict[str, set[str]]) -> list[str]:
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        return error.args[1]
    return []


@pytest.mark.parametrize("crate", CRATES)
def test_files_of_a_crate_use_each_other_in_no_circle(crate):
    known = modules(crate)
    assert not circle({module: uses(module, known) for module in known})


@pytest.mark.parametrize("crate", CRATES)
def test_rooms_of_a_crate_use_each_other_in_no_circle(crate):
    known = modules(crate)
    rooms = {module: module.partition("::")[0] for module in known}
    graph: dict[str, set[str]] = {room: set() for room in rooms.values()}
    for module, room in rooms.items():
        graph[room] |= {rooms[used] for used in uses(module, known)} - {room}
    assert not circle(graph)


def test_files_of_the_page_import_each_other_in_no_circle():
    files = {path.stem: path.read_text(encoding="utf-8") for path in (ROOT / "cockpit/src").glob("*.ts")}
    assert len(files) > 20
    assert not circle({name: set(re.findall(r'from "\./([\w-]+)"', text)) for name, text in files.items()})


def test_a_circle_is_found():
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"a"}}) and not circle({"a": {"b"}, "b": set()})


@pytest.mark.parametrize(
    "grouped",
    [
        "use super::{b, Kind};",
        "use crate::room::{b::B, Kind};",
        "use crate::{room::b, other};",
        "use crate::{other, room::{b::B, c}};",
    ],
)
def test_grouped_imports_are_seen(tmp_path, grouped):
    (tmp_path / "a.rs").write_text(f"{grouped}\n")
    (tmp_path / "b.rs").write_text("use super::a::A;\n")
    known = {"room::a": tmp_path / "a.rs", "room::b": tmp_path / "b.rs"}
    assert circle({module: uses(module, known) for module in known})
