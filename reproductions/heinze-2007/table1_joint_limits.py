"""Table 1: limits of the joint variables, printed against those the printed dimensions give."""

from __future__ import annotations

import numpy as np
from common import TABLE_1, figure, save
from fig33_34_joint_strokes import other_lengths

import hydrocrane as hc

JOINTS = ("alpha", "beta", "x3")
TOLERANCE = {"alpha": np.deg2rad(1.0), "beta": np.deg2rad(1.0), "x3": 1e-3}


def missed(crane) -> int:
    """How many of the six printed limits the crane does not have."""
    gaps = {joint: np.abs(limits - TABLE_1[joint]) for joint, limits in zip(JOINTS, np.asarray(crane.joint_limits))}
    return int(sum((gap > TOLERANCE[joint]).sum() for joint, gap in gaps.items()))


def compute() -> dict[str, float]:
    printed = hc.load_machine("heinze-2007")
    limits = np.array(printed.joint_limits)
    limits[:2] = np.rad2deg(limits[:2])
    numbers = {
        f"{joint}_{end}": float(value)
        for joint, pair in zip(JOINTS, limits)
        for end, value in zip(("low", "high"), pair)
    }
    return numbers | {
        "limits_missed": float(missed(printed)),
        "limits_missed_with_0670": float(missed(other_lengths())),
    }


def draw() -> None:
    fig, axes = figure(1, 3, (9.5, 2.6))
    cranes = {"printed cylinders": hc.load_machine("heinze-2007"), "0.670 m": other_lengths()}
    for i, (axis, joint) in enumerate(zip(axes.flat, JOINTS)):
        scale, unit = (np.rad2deg(1.0), "deg") if i < 2 else (1e3, "mm")
        rows = {"Table 1": TABLE_1[joint]} | {name: crane.joint_limits[i] for name, crane in cranes.items()}
        for height, (low, high) in enumerate(rows.values()):
            axis.plot([scale * low, scale * high], [height, height], "|-", ms=14, lw=4)
        axis.set(
            title=joint,
            xlabel=f"[{unit}]",
            yticks=range(len(rows)),
            yticklabels=rows if i == 0 else [],
            ylim=(-0.5, len(rows) - 0.5),
        )
        axis.invert_yaxis()
    save(fig, "table1_joint_limits")
