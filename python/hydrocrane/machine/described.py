"""The HTML view of a machine in notebooks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hydrocrane import _core
from hydrocrane.machine.poses import SHOWN
from hydrocrane.notebook import card
from hydrocrane.result_warning import ResultWarning


def described(machine: _core.Machine, tally: Mapping[str, int], warnings: Sequence[ResultWarning]) -> str:
    """Joints, cylinders with their valves, supply, overrides, provenance and warnings, as HTML."""
    lines = [f"title  {machine.title}"] if machine.title else []
    for joint, unit, (low, high) in zip(machine.joint_names, machine.joint_units, machine.joint_limits, strict=True):
        name, size = SHOWN[unit]
        lines.append(f"joint {joint}  {low / size:.4g} to {high / size:.4g} {name}")
    words = dict(machine.words)
    valves = {words[key]: key.split(".")[1] for key in words if key.startswith("valve.") and key.endswith(".cylinder")}
    for cylinder, (low, high) in zip(machine.cylinder_names, machine.stroke_limits, strict=True):
        valve = valves[cylinder]
        kind = words.get(f"valve.{valve}.type", "")
        lines.append(f"cylinder {cylinder}  stroke {(high - low) * 1e3:.4g} mm, valve {valve} ({kind})")
    pumps = [
        f", pump {key.split('.')[1]} ({word})"
        for key, word in words.items()
        if key.startswith("pump.") and key.endswith(".type")
    ]
    lines.append(f"supply  {machine.supply_pressure * 1e-5:.4g} bar{''.join(pumps)}")
    lines.append(f"states  {len(machine.state_names)}")
    if machine.overrides:
        lines.append(f"overrides  {', '.join(f'{key} = {value}' for key, value in machine.overrides)}")
    classes = ", ".join(f"{count} {kind}" for kind, count in tally.items() if count)
    lines.append(f"provenance  of {sum(tally.values())} values: {classes}")
    lines += [f"warning  {warning}" for warning in warnings]
    return card(f"Machine {machine.name}", lines, "crane.warnings")
