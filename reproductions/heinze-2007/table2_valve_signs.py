"""Table 2: which way each joint moves for each valve position."""

from __future__ import annotations

import numpy as np
from common import figure, save

import hydrocrane as hc

POSE = np.array([np.deg2rad(100.0), np.deg2rad(100.0), 0.0])
JOINTS = ("boom", "jib", "extension")
# Rows: valve of cylinder 1, 2, 3. Columns: spool positive, negative, closed (footnote 3 of the table).
PRINTED = np.array([[1, -1, 0], [-1, 1, 0], [1, -1, 0]])
SPOOL = 0.025
SAMPLE, SAMPLES = 0.01, 50
TOLERANCE = 1e-9  # tight, so that the numbers outlive changes of the solver


def responses() -> np.ndarray:
    """Joint motion (3 valves, 3 positions) after half a second from rest, rad or m."""
    crane = hc.load_machine("rottne-f9-lab")
    simulator = hc.Simulator(crane, sample_time=SAMPLE, rtol=TOLERANCE)
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


def compute() -> dict[str, float]:
    motion = responses()
    # A closed valve holds when the joint creeps less than a hundredth of its driven motion.
    signs = np.where(np.abs(motion) < 0.01 * np.abs(motion[:, :1]), 0, np.sign(motion))
    numbers = {
        f"{joint}_{position}": float(value)
        for joint, row in zip(JOINTS, motion)
        for position, value in zip(("positive", "negative", "closed"), row)
    }
    return numbers | {"entries_missed": float((signs != PRINTED).sum())}


def draw() -> None:
    fig, axes = figure(1, 3, (9.5, 3.0))
    for axis, joint, row, scale, unit in zip(
        axes.flat, JOINTS, responses(), (57.2958, 57.2958, 1e3), ("deg", "deg", "mm")
    ):
        axis.bar(("$x_s>0$", "$x_s<0$", "$x_s=0$"), scale * row)
        axis.axhline(0.0, color="black", lw=0.8)
        axis.set(title=f"Table 2, {joint}", ylabel=f"motion in 0.5 s [{unit}]")
    save(fig, "table2_valve_signs")
