"""A folder to start one's own machine in: a machine and a scenario that runs it."""

from __future__ import annotations

import re
from pathlib import Path

from hydrocrane import _core
from hydrocrane.app.starter_pump import pump_text
from hydrocrane.errors import InputError, unknown
from hydrocrane.files.toml_file import parsed
from hydrocrane.files.whole_file import write_text
from hydrocrane.machine.machine import bundled_machines
from hydrocrane.scenario.scenario_file import bundled_scenarios, load_scenario

# A machine of no maker: what a newcomer replaces value by value.
TEMPLATE = Path(__file__).parent / "template"


def write_starter(folder: Path, machine: str | None = None, pump: str | None = None) -> tuple[Path, Path]:
    """Write ``machine.toml``, with a `pump` of that kind, and ``scenario.toml`` into `folder`; overwrites nothing.

    They are the template, or copies of a bundled `machine` and of a scenario that runs it.
    """
    if machine is not None and machine not in bundled_machines():
        raise unknown("machine", machine, bundled_machines())
    files = folder / "machine.toml", folder / "scenario.toml"
    for path in files:
        if path.exists():
            raise InputError(f"{path} exists already; choose another folder")
    described, scenario = _template() if machine is None else _bundled(machine)
    added = pump_text(machine or str(TEMPLATE / "machine.toml"), pump) if pump else ""
    return write_text(files[0], described + added), write_text(files[1], scenario)


def _template() -> tuple[str, str]:
    return (TEMPLATE / "machine.toml").read_text("utf-8"), (TEMPLATE / "scenario.toml").read_text("utf-8")


def _bundled(machine: str) -> tuple[str, str]:
    name, driven = _scenario_of(machine)
    scenario = _core.bundled_text("scenario", name)
    own, count = re.subn(
        rf'^(\s*machine\s*=\s*)"{re.escape(driven)}"', r'\1"machine.toml"', scenario, count=1, flags=re.MULTILINE
    )
    if not count:
        raise InputError(f"the bundled scenario of {machine} does not name its machine on a separate line")
    return _core.bundled_text("machine", machine), own


def _scenario_of(machine: str) -> tuple[str, str]:
    """A bundled scenario with the machine that it names: this one, or the one that this one extends."""
    base = parsed(_core.bundled_text("machine", machine), machine).get("extends")
    for wanted in filter(None, (machine, base)):
        for name in bundled_scenarios():
            if load_scenario(name).machine == wanted:
                return name, wanted
    raise InputError(f"no bundled scenario runs {machine}; start from another machine")
