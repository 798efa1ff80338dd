"""Table 2: which way each joint moves for each valve position, on the machine as printed and on the corrected one."""

from __future__ import annotations

from functools import cache

import numpy as np
from common import figure, save

import hydrocrane as hc

POSE = np.array([np.deg2rad(100.0), np.deg2rad(100.0), 0.0])
JOINTS = ("boom", "jib", "extension")
POSITIONS = ("positive", "negative", "closed")
# Rows: valve of cylinder 1, 2, 3. Columns: spool positive, negative, closed (footnote 3 of the table).
PRINTED = np.array([[1, -1, 0], [-1, 1, 0], [1, -1, 0]])
SPOOL = 0.025
SAMPLE, SAMPLES = 0.01, 50
# The printed laws jump, which takes fixed steps; the corrected ones take a tolerance so tight that the numbers outlive
# changes of the solver.
SOLVERS = {"heinze-2007": {"method": "tsit5", "step": 2e-5}, "rottne-f9-lab": {"rtol": 1e-9}}
AS_PRINTED = "heinze-2007"


# What the printed machine is without one of its properties.
WITHOUT = {
    "leakage gap of 10 um": {f"cylinder.{name}.leakage-gap": "10 um" for name in ("lift", "jib", "extension")},
    "gravity downwards": {"errata.gravity-sign": "corrected"},
}


@cache
def responses(machine: str, changed: str = "") -> np.ndarray:
    """Joint motion (3 valves, 3 positions) after half a second from rest, rad or m; `changed` is a key of WITHOUT."""
    crane = hc.load_machine(machine, overrides=WITHOUT.get(changed))
    simulator = hc.Simulator(crane, sample_time=SAMPLE, **SOLVERS[machine])
    motion = np.empty((3, 3))
    for valve in range(3):
        for column, spool in enumerate((SPOOL, -SPOOL, 0.0)):
            simulator.reset(q=POSE)
            command = np.zeros(3)
            command[valve] = spool
            for _ in range(SAMPLES):
                observed = simulator.step(command)
            motion[valve, column] = observed.q[valve] - POSE[valve]
    return motion


def missed(motion: np.ndarray) -> np.ndarray:
    """Entries (3, 3) that contradict the table; a closed valve holds if the joint creeps by less than a hundredth of
    its driven motion."""
    signs = np.where(np.abs(motion) < 0.01 * np.abs(motion[:, :1]), 0, np.sign(motion))
    return signs != PRINTED


def compute() -> dict[str, float]:
    numbers = {}
    for machine in SOLVERS:
        motion = responses(machine)
        for joint, row in zip(JOINTS, motion):
            for position, value in zip(POSITIONS, row):
                numbers[f"{machine}.{joint}_{position}"] = float(value)
        numbers[f"{machine}.driven_missed"] = float(missed(motion)[:, :2].sum())
        numbers[f"{machine}.closed_missed"] = float(missed(motion)[:, 2].sum())
        numbers[f"{machine}.entries_missed"] = float(missed(motion).sum())
        creep = np.abs(motion[:, 2] / motion[:, 0])
        numbers[f"{machine}.largest_creep_share"] = float(creep.max())
    for changed in WITHOUT:
        numbers[f"{AS_PRINTED}, {changed}.entries_missed"] = float(missed(responses(AS_PRINTED, changed)).sum())
    return numbers


def repeatability(key: str) -> float:
    """Friction that jumps at rest amplifies rounding: half the step moves a joint by up to 5e-5 rad, which is 0.3 % of
    its driven motion."""
    return 5e-3 if key.endswith("share") else 1e-4 if key.startswith(AS_PRINTED) else 1e-9


def report(numbers: dict[str, float]) -> list[str]:
    """Entries missed, machine by machine."""
    lines = [
        "| machine | driven entries missed, of 6 | closed entries missed, of 3 | largest creep with the valve closed |"
    ]
    lines.append("|---|---|---|---|")
    for machine in SOLVERS:
        cells = " | ".join(f"{numbers[f'{machine}.{kind}_missed']:.0f}" for kind in ("driven", "closed"))
        creep = 100 * numbers[f"{machine}.largest_creep_share"]
        lines.append(f"| `{machine}` | {cells} | {creep:.2g} % of the driven motion |")
    return lines


def draw() -> None:
    fig, axes = figure(2, 3, (9.5, 5.5))
    for machine, row in zip(SOLVERS, axes):
        motions = responses(machine)
        for axis, joint, motion, scale, unit in zip(
            row, JOINTS, motions, (57.2958, 57.2958, 1e3), ("deg", "deg", "mm")
        ):
            axis.bar(("$x_s>0$", "$x_s<0$", "$x_s=0$"), scale * motion)
            axis.axhline(0.0, color="black", lw=0.8)
            axis.set(title=f"{joint}, {machine}", ylabel=f"motion in 0.5 s [{unit}]")
    save(fig, "table2_valve_signs")
