"""A folder to start one's own machine in: a copy of a bundled machine and of a scenario that runs it."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from hydrocrane import _core
from hydrocrane.app.starter_pump import pump_text
from hydrocrane.errors import InputError, unknown
from hydrocrane.files.whole_file import write_text
from hydrocrane.machine.machine import bundled_machines
from hydrocrane.scenario.scenario_file import bundled_scenarios, load_scenario


def write_starter(folder: Path, machine: str, pump: str | None = None) -> tuple[Path, Path]:
    """Write ``machine.toml``, with a `pump` of that kind, and ``scenario.toml`` into `folder`; overwrites nothing."""
    if machine not in bundled_machines():
        raise unknown("machine", machine, bundled_machines())
    machine_file, scenario_file = folder / "machine.toml", folder / "scenario.toml"
    for path in (machine_file, scenario_file):
        if path.exists():
            raise InputError(f"{path} exists already; choose another folder")
    name, driven = _scenario_of(machine)
    scenario = _core.bundled_text("scenario", name)
    own, count = re.subn(
        rf'^(\s*machine\s*=\s*)"{re.escape(driven)}"', r'\1"machine.toml"', scenario, count=1, flags=re.MULTILINE
    )
    if not count:
        raise InputError(f"the bundled scenario of {machine} does not name its machine on a separate line")
    described = _core.bundled_text("machine", machine) + (pump_text(machine, pump) if pump else "")
    return write_text(machine_file, described), write_text(scenario_file, own)


def _scenario_of(machine: str) -> tuple[str, str]:
    """A bundled scenario with the machine that it names: this one, or the one that this one extends."""
    base = tomllib.loads(_core.bundled_text("machine", machine)).get("extends")
    for wanted in filter(None, (machine, base)):
        for name in bundled_scenarios():
            if load_scenario(name).machine == wanted:
                return name, wanted
    raise InputError(f"no bundled scenario runs {machine}; start from another machine")
