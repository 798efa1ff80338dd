"""Writes the bundled scenarios of the friction rig from the experiments of ``hydrocrane.rig``, numbers rounded."""

from __future__ import annotations

import textwrap
from pathlib import Path

import hydrocrane as hc
from hydrocrane import rig

FOLDER = Path(__file__).resolve().parents[2] / "scenarios"
# Scenario's name -> rig, experiment, and what is set in it.
SCENARIOS = {f"rig-{name}": ("rig-rottne", name, {}) for name in rig.experiments()}
SCENARIOS["rig-load-variation"][2].update(payload=115.0)
SCENARIOS["rig-pressure-variation"][2].update(supply="100 bar")
SCENARIOS["rig-kalmar-ramp"] = ("rig-kalmar", "ramp", {})

HEAD = """\
# {title}: experiment `{experiment}` of hydrocrane.rig on {machine}.
# Written by docs/reference/rig_scenarios.py.

[scenario]
name = "{name}"
title = "{title}"
machine = "{machine}"
{payload}duration = "{duration:.6g} s"
record-interval = "{interval:g} ms"
{overrides}
[initial.joint]
slide = "{start:.3f} mm"

[initial.pressure]
test = ["{p1:.4f} bar", "{p2:.4f} bar"]

[command.test]
interpolation = "linear"
time = [
{time}
]
spool = [
{spool}
]

[solver]
rtol = 1e-6
max-step = "50 ms"
"""


def text(name: str) -> str:
    """The file of one scenario."""
    machine, experiment, settings = SCENARIOS[name]
    plan = rig.scenario(machine, experiment, **settings)
    command, (p1, p2) = plan.commands["test"], plan.pressures["test"]
    supply = settings.get("supply")
    return HEAD.format(
        title=f"Friction rig: {plan.title}",
        experiment=experiment,
        machine=machine,
        name=name,
        payload="" if plan.payload is None else f'payload = "{plan.payload:g} kg"\n',
        overrides="" if supply is None else f'\n[overrides]\n"supply.pressure" = "{supply}"\n',
        duration=plan.duration,
        interval=plan.record_interval * 1e3,
        start=plan.joints["slide"] * 1e3,
        p1=p1 / 1e5,
        p2=p2 / 1e5,
        time=_list([f'"{t:.6g} s"' for t in command.time]),
        spool=_list([f'"{u * 1e3:.5g} mm"' for u in command.spool]),
    )


def _list(values: list[str]) -> str:
    lines = textwrap.wrap(", ".join(value.replace(" ", "\0") for value in values) + ",", 114)
    return "\n".join(f"    {line}" for line in lines).replace("\0", " ")


def main() -> None:
    """Write all of them."""
    for name in SCENARIOS:
        (FOLDER / f"{name}.toml").write_text(text(name), encoding="utf-8")
    print(f"{len(SCENARIOS)} scenarios in {FOLDER} with hydrocrane {hc.__version__}")


if __name__ == "__main__":
    main()
