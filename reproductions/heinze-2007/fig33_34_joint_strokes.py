"""Figures 33 and 34: piston stroke over joint angle, with the printed dimensions and with 0.670 m.

The text around the figures prints two points of each curve. Both curves miss them by a constant
(E13); one pin-to-pin length at mid-stroke, the same for both cylinders, brings them in.
"""

from __future__ import annotations

import numpy as np
from common import figure, save

import hydrocrane as hc

POINTS = {
    "33": (np.deg2rad([45.0, 172.0]), np.array([-0.155, 0.217])),
    "34": (np.deg2rad([178.0, 5.0]), np.array([-0.101, 0.210])),
}
LENGTH = 0.670
PRINTED_LENGTHS = {"lift": 0.635, "jib": 0.7125}  # offsets, rod, half barrel and half piston of DIMENSION
PRINTED_OFFSETS = {"lift": 0.010, "jib": 0.095}


def other_lengths():
    """The crane with 0.670 m between the pins of both cylinders at mid-stroke."""
    overrides = {
        f"cylinder.{name}.rod-offset": PRINTED_OFFSETS[name] + LENGTH - PRINTED_LENGTHS[name]
        for name in PRINTED_LENGTHS
    }
    return hc.load_machine("heinze-2007", overrides=overrides)


def curve(crane, which: str, angle: np.ndarray) -> np.ndarray:
    """Stroke of the cylinder of one figure over its joint angle, m."""
    column = {"33": 0, "34": 1}[which]
    q = np.full((len(angle), 3), [np.pi / 2, np.pi / 2, 0.0])
    q[:, column] = angle
    return crane.strokes(q)[:, column]


def compute() -> dict[str, float]:
    numbers = {}
    for label, crane in (("", hc.load_machine("heinze-2007")), ("with_0670_", other_lengths())):
        for which, (angle, stroke) in POINTS.items():
            gap = stroke - curve(crane, which, angle)
            numbers[f"figure_{which}_{label}deviation_m"] = float(np.abs(gap).max())
            numbers[f"figure_{which}_{label}mean_offset_m"] = float(gap.mean())
    return numbers


def draw() -> None:
    fig, axes = figure(1, 2, (9.0, 3.8))
    cranes = {"printed dimensions": hc.load_machine("heinze-2007"), "0.670 m at mid-stroke": other_lengths()}
    for axis, (which, (angle, stroke)), symbol in zip(axes.flat, POINTS.items(), (r"\alpha", r"\beta")):
        sweep = np.linspace(angle.min(), angle.max(), 300)
        for name, crane in cranes.items():
            axis.plot(np.rad2deg(sweep), 1e3 * curve(crane, which, sweep), label=name)
        axis.plot(np.rad2deg(angle), 1e3 * stroke, "ko", label="printed points")
        axis.set(title=f"Figure {which}", xlabel=rf"${symbol}$ [deg]", ylabel="piston stroke [mm]")
    axes[0, 0].legend(frameon=False)
    save(fig, "fig33_34_joint_strokes")
