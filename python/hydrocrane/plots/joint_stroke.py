"""Joint coordinate against piston position, as Figures 33 and 34."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrocrane.errors import HydrocraneError, unknown
from hydrocrane.machine.machine import MachineLike, as_machine
from hydrocrane.plots.style import COLOURS, MUTED, figure, shown, styled, title

if TYPE_CHECKING:
    from hydrocrane.machine.machine import Machine


@styled
def joint_stroke(machine: MachineLike, joint: str | None = None) -> Figure:
    """Piston position over each revolute joint (or the one named), with limits and stroke ends."""
    machine = as_machine(machine)
    if joint is not None and joint not in machine.joint_names:
        raise unknown("joint", joint, machine.joint_names)
    turning = [j for j, unit in zip(machine.joint_names, machine.joint_units, strict=True) if unit == "rad"]
    chosen = [joint] if joint else (turning or list(machine.joint_names))
    fig, axes = figure(4.8 * max(len(chosen), 1.4), 4.5, ncols=len(chosen), squeeze=False)
    for panel, name in zip(axes.flat, chosen, strict=True):
        _curve(panel, machine, machine.joint_names.index(name))
    handles, labels = axes[0, 0].get_legend_handles_labels()
    fig.legend(handles, labels, loc="outside lower center", ncols=3)
    title(fig, "Joint and piston", machine.name)
    return fig


def _curve(axes: Axes, machine: Machine, index: int) -> None:
    unit, factor = shown(machine.joint_units[index])
    low, high = machine.joint_limits[index]
    angle, stroke = _sweep(machine, index, low, high)
    inside = (angle >= low) & (angle <= high)
    axes.plot(angle * factor, stroke * 1e3, color=MUTED, lw=1.2, ls="--", label="linkage alone")
    axes.plot(angle[inside] * factor, stroke[inside] * 1e3, color=COLOURS[0], lw=2.2, label="inside the joint limits")
    ends = machine.stroke_limits[index] * 1e3
    axes.axhspan(*ends, color=COLOURS[0], alpha=0.07, lw=0, label="stroke of the cylinder")
    reasons = machine.joint_limit_reasons[index]
    for value, reason, side in ((low, reasons[0], "left"), (high, reasons[1], "right")):
        axes.axvline(value * factor, color=COLOURS[4], lw=1.0)
        # The text is placed away from the curve.
        above = np.interp(value, angle, stroke) * 1e3 < np.mean(axes.get_ylim())
        axes.annotate(
            f"{value * factor:.1f} {unit}: {reason}", (value * factor, 0.98 if above else 0.02),
            xycoords=("data", "axes fraction"), rotation=90, ha=side, va="top" if above else "bottom",
            fontsize=8, color=COLOURS[4],
            bbox={"facecolor": "white", "alpha": 0.8, "lw": 0, "pad": 1.5},
        )  # fmt: skip
    axes.set_title(f"cylinder {machine.cylinder_names[index]}")
    axes.set_xlabel(f"joint {machine.joint_names[index]} [{unit}]")
    axes.set_ylabel("piston position from mid-stroke [mm]")


def _sweep(machine: Machine, index: int, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """Joint coordinate and stroke from well below to well above the limits, where the linkage closes."""
    beyond = 0.25 * (high - low)
    grid = np.unique(np.concatenate([np.linspace(low - beyond, high + beyond, 301), [low, high]]))
    values, strokes = [], []
    for value in grid:
        q = machine.home.copy()
        q[index] = value
        try:
            stroke = machine.strokes(q)[index]
        except HydrocraneError:
            continue
        if np.isfinite(stroke):
            values.append(value)
            strokes.append(stroke)
    return np.array(values), np.array(strokes)
