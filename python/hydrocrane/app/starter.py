"""A folder to start one's own machine in: a machine, with a pump of the size and kind asked for, and a scenario."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from hydrocrane import _core
from hydrocrane.errors import InputError, unknown
from hydrocrane.files.toml_file import parsed
from hydrocrane.files.whole_file import write_text
from hydrocrane.machine.machine import Machine, bundled_machines, load_machine
from hydrocrane.scenario.scenario_file import bundled_scenarios, load_scenario

# Type of the pump by its short name.
KINDS = {"fixed": "fixed", "pressure-compensated": "pressure-compensated", "ls": "load-sensing"}
SPEED, EFFICIENCY, SPARE = 1450.0, 0.94, 1.05

HEAD = """
# --- Supply -----------------------------------------------------------------------------------------------------------
# One pump for all valves: supply.pressure is its highest set pressure. `hydrocrane check` reports what does not fit.

[pump.main]
class = "assumed"
source = "an example of `hydrocrane new`, to be replaced: sized for the valves, efficiencies as of axial piston pumps"
type = "{kind}"
displacement = "{displacement:.3g} ml"    # per revolution; {enough_for}
speed = "{speed:.0f} rpm"
volumetric-efficiency = {efficiency}
hydromechanical-efficiency = 0.9
"""
CONTROL = """control-range = "4 bar"      # at this pressure below its setting the displacement is full
time-constant = "50 ms"      # of the displacement
# torque-limit = "60 N m"    # limit of the engine
"""
SENSING = """ls-margin = "20 bar"         # above the highest load pressure
ls-time-constant = "20 ms"   # of the line from the valves
"""
UNLOADING = """# ls-margin = "15 bar"       # unloads the pump: it idles this far above the highest load pressure
"""
MAINS = """
[mains]
class = "assumed"
source = "three metres of hose: an example of `hydrocrane new`, to be replaced"
volume = "0.4 l"
hose-compliance = "0.04 ml/bar"
relief-gradient = "4 l/(min bar)"
# relief-pressure = "..."    # 1.15 times supply.pressure; with a fixed pump supply.pressure
"""
SECTIONS = """
# Compensated sections: the flow depends on the spool, not on the load. Add to [valve.<name>] of each 4/3 valve:
#   compensator = "before-spool"         # or "behind-spool": all sections share the flow of the pump
#   compensator-setting = "8 bar"        # with "before-spool": drop over the edge, below ls-margin - control-range
#   nominal-pressure-drop = "16 bar"     # of nominal-flow: twice that drop
#   return-area-ratio = [0.4, 1.0]       # a narrow edge from the chamber with the load brakes it
# A counterbalance valve holds a load:
#   [counterbalance.lift]
#   cylinder = "lift"
#   side = "piston-side"
#   setting = "150 bar"                  # 1.3 times the highest load pressure
#   pilot-ratio = 4
#   nominal-flow = "40 l/min"
#   nominal-pressure-drop = "10 bar"
"""


def pump_text(machine: str, pump: str) -> str:
    """The tables ``[pump.main]`` and ``[mains]`` for a machine, as text to be added to its file."""
    if pump not in KINDS:
        raise unknown("pump", pump, tuple(KINDS))
    crane = load_machine(machine)
    if "mains.p" in crane.state_names:
        raise InputError(f"{machine} has a pump already; start from a machine with an ideal supply, or omit --pump")
    kind, flows = KINDS[pump], _flows(crane)
    displacement = 1e6 * SPARE * sum(flows[:2]) / (EFFICIENCY * SPEED / 60)
    enough_for = f"what {'the two largest valves take' if len(flows) > 1 else 'the valve takes'} without load"
    head = HEAD.format(kind=kind, displacement=displacement, speed=SPEED, efficiency=EFFICIENCY, enough_for=enough_for)
    control = {"fixed": UNLOADING, "pressure-compensated": CONTROL, "load-sensing": CONTROL + SENSING}[kind]
    return head + control + MAINS + (SECTIONS if kind == "load-sensing" else "")


def _flows(crane: Machine) -> list[float]:
    """What the valves take at full stroke while the supply pressure falls over both edges, m^3/s, largest first."""
    stated = {key for key, _, _ in crane.provenance}

    def value(key: str) -> float:
        return np.asarray(crane.value(key).si).item()

    def flow(valve: str) -> float:
        one = f"{valve}.nominal-edge-pressure-drop"
        edge = value(one) if one in stated else 0.5 * value(f"{valve}.nominal-pressure-drop")
        drop = 0.5 * (value("supply.pressure") - value("supply.tank-pressure"))
        return value(f"{valve}.nominal-flow") * math.sqrt(drop / edge)

    valves = [key.rpartition(".")[0] for key in stated if key.startswith("valve.") and key.endswith(".nominal-flow")]
    return sorted(map(flow, valves), reverse=True)


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
