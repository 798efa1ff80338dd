"""The JSON Schemas of machine and scenario files: valid, whole, and never stricter than the reader."""

from __future__ import annotations

import copy
import datetime
import json
import random
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft7Validator

import hydrocrane as hc
from hydrocrane import _core
from hydrocrane.app.cli import main

ROOT = Path(__file__).resolve().parents[3]
SCHEMAS = {kind: json.loads(_core.json_schema(kind)) for kind in ("machine", "scenario")}
VALIDATORS = {kind: Draft7Validator(schema) for kind, schema in SCHEMAS.items()}
BUNDLED = {"machine": hc.bundled_machines(), "scenario": hc.bundled_scenarios()}
FILES = {
    name: (kind, tomllib.loads(_core.bundled_text(kind, name))) for kind, names in BUNDLED.items() for name in names
}
READ = {"machine": hc.load_machine, "scenario": hc.load_scenario}


@pytest.mark.parametrize("kind", SCHEMAS)
def test_schemas_are_valid(kind):
    Draft7Validator.check_schema(SCHEMAS[kind])
    assert SCHEMAS[kind]["$schema"] == "http://json-schema.org/draft-07/schema#"
    assert all(re.fullmatch(r"[A-Za-z0-9-]+", name) for name in SCHEMAS[kind]["definitions"])
    used = set(re.findall(r'"\$ref": "([^"]*)"', _core.json_schema(kind)))
    assert used == {f"#/definitions/{name}" for name in SCHEMAS[kind]["definitions"]}


@pytest.mark.parametrize("name", FILES)
def test_bundled_files_are_valid(name):
    kind, file = FILES[name]
    assert not [error.message for error in VALIDATORS[kind].iter_errors(file)]


def place(schema: dict[str, Any], path: str) -> dict[str, Any]:
    """What a schema says of the key at a dotted path; names in angle brackets stand for any name."""
    for name in path.split("."):
        schema = schema["additionalProperties"] if name.startswith("<") else schema["properties"][name]
    return schema


@pytest.mark.parametrize("kind", SCHEMAS)
def test_every_declared_key_is_described(kind):
    keys = json.loads(_core.key_list(kind))
    assert len(keys) > 60
    for key in keys:
        found = place(SCHEMAS[kind], key["path"])
        assert key["means"] and found["description"].startswith(key["means"]), key["path"]
        assert all(value in found["description"] for value in key["defaults"]), key["path"]
        assert all(f'"{choice}"' in json.dumps(found) for choice in key["choices"]), key["path"]


def test_a_description_says_what_is_declared():
    bore = place(SCHEMAS["machine"], "cylinder.<name>.bore")["description"]
    what, holds = bore.split("\n\n")
    assert what == "Diameter of the piston."
    assert (
        holds
        == 'Length (SI: m), for example "10 mm"; greater than zero. Usual: 10 mm to 600 mm. Required without `motor`.'
    )
    step = place(SCHEMAS["scenario"], "solver.max-step")
    assert step["default"] == "50 ms" and "Default: 50 ms." in step["description"]
    assert place(SCHEMAS["machine"], "control.tip.reserve")["default"] == 0.95


# Files of tests/data/bad whose mistake shows without other files, other values and the meaning of names.
SHOWN = (
    "bad-quantity", "empty-file", "invalid-choice", "missing-unit", "unknown-key", "unknown-unit", "wrong-dimension",
    "wrong-kind-of-file", "wrong-type",
)  # fmt: skip


@pytest.mark.parametrize("name", SHOWN)
def test_mistakes_that_show_are_refused(name):
    text = (ROOT / "tests/data/bad" / f"{name}.toml").read_text(encoding="utf-8")
    assert not VALIDATORS["machine"].is_valid(tomllib.loads(text))


# Kind of file, key, and a value for it; none removes the key.
WRONG = [
    ("scenario", "scenario.duration", None),
    ("scenario", "scenario", None),
    ("scenario", "solver.method", "rodas5"),
    ("scenario", "scenario.duration", "5 mm"),
    ("scenario", "scenario.duration", "-5 s"),
    ("scenario", "solver.rtol", 0),
    ("machine", "supply", None),
    ("machine", "cylinder.lift.joint", None),
    ("machine", "cylinder.lift.bore", "0.1"),
    ("machine", "cylinder.lift.bore", ["1 mm", "2 mm"]),
    ("machine", "friction.lift.coulomb", ["1 N", "2 N", "3 N"]),
    ("machine", "friction.lift.coulomb", "-1 N"),
    ("machine", "friction.lift.viscous", "5 bar"),
    ("machine", "machine.tip", 5),
    ("machine", "link.boom.point", {"pin": "0.1 m"}),
    ("machine", "supply.pressure", {"value": "5 bar", "clas": "assumed"}),
    ("machine", "supply.pressure", {"value": "5 bar", "class": "guessed"}),
    ("machine", "errata.gravity-sign", "printed"),
]


@pytest.mark.parametrize(("kind", "key", "value"), WRONG, ids=lambda part: str(part)[:40])
def test_a_wrong_value_is_refused(kind, key, value, tmp_path):
    name = "rottne-f9-lab" if kind == "machine" else "vertical-lift-open-loop"
    file = copy.deepcopy(FILES[name][1])
    *tables, last = key.split(".")
    table = file
    for one in tables:
        table = table.setdefault(one, {})
    table.pop(last, None)
    if value is not None:
        table[last] = value
    assert not VALIDATORS[kind].is_valid(file)
    assert refused_by_the_reader(kind, file, tmp_path)


@pytest.mark.parametrize("above", ["extends", "include"])
def test_a_file_that_lies_over_others_need_not_be_whole(above):
    file = {above: "rottne-f9-lab" if above == "extends" else ["friction.toml"], "supply": {"pressure": "100 bar"}}
    assert VALIDATORS["machine"].is_valid(file)
    assert not VALIDATORS["machine"].is_valid({"supply": file["supply"]})


# --- random edits -----------------------------------------------------------------------------------------------------

VALUES: list[Any] = [
    5, 0, -0.5, True, "word", "", "5", "-0.2", "5 bar", "-5 bar", "5 mm", "5mm", "0 mm", "-0 N", "-3 deg", "20 N s/m",
    "5 m m", "5 1/s", "3 %", "1e400 m", "inf m", "(1, 2) m", "(1 2) m", [], [1, 2], ["1 mm", "2 mm"], ["1 bar"] * 3, {},
    {"value": 5}, {"value": "5 mm", "class": "guessed"}, {"value": "5 mm", "clas": "assumed"},
    datetime.date(2020, 1, 1),
]  # fmt: skip


def toml(value: object) -> str:
    """A value as TOML, on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {toml(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return value.isoformat() if isinstance(value, datetime.date) else json.dumps(value)


def refused_by_the_reader(kind: str, file: dict[str, Any], folder: Path) -> bool:
    path = folder / "file.toml"
    path.write_text("\n".join(f"{json.dumps(key)} = {toml(value)}" for key, value in file.items()), encoding="utf-8")
    try:
        READ[kind](str(path))
    except hc.MachineFileError:
        return True
    return False


def tables(table: dict[str, Any]) -> list[dict[str, Any]]:
    inner = [one for value in table.values() if isinstance(value, dict) for one in tables(value)]
    return [table, *inner] if table else inner


def edited(file: dict[str, Any], draw: random.Random) -> dict[str, Any]:
    """The file with one key removed, renamed, added or given another value."""
    changed = copy.deepcopy(file)
    table = draw.choice(tables(changed))
    key = draw.choice(list(table))
    match draw.randrange(4):
        case 0:
            del table[key]
        case 1:
            table[key + "x"] = table.pop(key)
        case 2:
            table["further"] = draw.choice(VALUES)
        case _:
            table[key] = draw.choice(VALUES)
    return changed


def stricter(edits: int, seed: int, folder: Path) -> tuple[int, list[object]]:
    """How many of some random edits the schemas refuse, and those that the reader takes all the same."""
    draw, refused, taken = random.Random(seed), 0, []
    for _ in range(edits):
        name = draw.choice(list(FILES))
        kind, file = FILES[name]
        changed = edited(file, draw)
        if not VALIDATORS[kind].is_valid(changed):
            refused += 1
            if not refused_by_the_reader(kind, changed, folder):
                taken.append([name, [error.message[:200] for error in VALIDATORS[kind].iter_errors(changed)]])
    return refused, taken


def test_what_the_schema_refuses_the_reader_refuses(tmp_path):
    refused, taken = stricter(120, 1, tmp_path)
    assert refused > 50 and not taken, taken


@pytest.mark.evidence
def test_what_the_schema_refuses_the_reader_refuses_in_many_cases(tmp_path):
    refused, taken = stricter(3000, 2, tmp_path)
    assert refused > 1000 and not taken, taken


# What a machine must have right although nothing uses it.
UNUSED = [
    {"cylinder": {"lift": {"piston-length": 5}}},
    {"link": {"pillar": {"mass": "1 kg", "centre-of-gravity": "(0, 0) m", "inertia-about": "there"}}},
    {"ground": {"height": "-9 m", "support": {"old": {"status": "inactive", "height": 5}}}},
]


@pytest.mark.parametrize("changes", UNUSED, ids=["piston-length", "inertia-about", "support"])
def test_values_that_nothing_uses_must_be_right(changes, tmp_path):
    file = {"extends": "hiab-xs031", "machine": {"class": "assumed"}, **changes}
    assert not VALIDATORS["machine"].is_valid(file)
    assert refused_by_the_reader("machine", file, tmp_path)


# --- the command ------------------------------------------------------------------------------------------------------


def test_the_command_prints_or_writes_a_schema(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["schema", "scenario"])
    assert not ended.value.code and capsys.readouterr().out == _core.json_schema("scenario")
    with pytest.raises(SystemExit) as ended:
        main(["schema", "--output", str(tmp_path / "machine.schema.json")])
    assert not ended.value.code
    assert (tmp_path / "machine.schema.json").read_text(encoding="utf-8") == _core.json_schema("machine")
