"""A default stands in the declaration of its key, and the code takes it from there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import hydrocrane as hc

ROOT = Path(__file__).resolve().parents[3]
DECLARED = ROOT / "crates/machine/src/keys"
#: A number after the name of a key, as in a table of defaults or in the place of what a file leaves out.
SECOND = (r'\(\s*"{key}"\s*,\s*[-+]?\d', r'"{key}"\s*\)\s*\.unwrap_or\(\s*[-+]?\d', r'"{key}"\s*:\s*[-+]?\d')


def controls() -> dict[str, str]:
    """Default of each key of `[control]` that has one."""
    text = (DECLARED / "control.rs").read_text(encoding="utf-8")
    return dict(re.findall(r'gain\("([a-z-]+)"[^;]*?\.defaults\(&\["([^"]+)"\]\)', text.replace("gain(", ";gain(")))


def sources() -> list[Path]:
    """What is shipped: tests, the tools that ask for drives, and the declarations are left out."""
    left_out = {DECLARED, ROOT / "crates/evidence"}
    rust = [path for path in (ROOT / "crates").glob("*/src/**/*.rs") if not left_out & set(path.parents)]
    return rust + list((ROOT / "python/hydrocrane").rglob("*.py"))


def test_no_second_table_of_defaults():
    keys = "|".join(map(re.escape, controls()))
    assert {"damping-ratio", "flow-tolerance"} <= set(controls())
    pattern = re.compile("|".join(form.format(key=f"(?:{keys})") for form in SECOND))
    found = [
        f"{path.relative_to(ROOT)}: {match.group(0)}"
        for path in sources()
        for match in pattern.finditer(path.read_text(encoding="utf-8"))
    ]
    assert not found, found


@pytest.mark.parametrize("name", ["hiab-xs031", "single-cylinder"])
def test_what_runs_is_what_is_declared(name):
    gains = hc.load_machine(name).tip_gains
    declared = {key: text for key, text in controls().items() if key in gains}
    assert len(declared) == len(gains) == 14
    stated = hc.load_machine(name, {f"control.tip.{key}": text for key, text in declared.items()})
    assert stated.tip_gains == gains
