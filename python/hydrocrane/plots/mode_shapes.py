"""Modes drawn on the crane, and their frequency and damping along a joint."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from hydrocrane.errors import InputError
from hydrocrane.machine.machine import MachineLike, as_machine
from hydrocrane.plots.style import ACCENT, COLOURS, draw_crane, figure, shown, styled, title
from hydrocrane.plots.workspace import metres

if TYPE_CHECKING:
    from hydrocrane.linear.shapes import DampingCurves, ModeShapes

# Largest motion of the tip in the picture, as a share of the crane's reach.
_SWING = 0.12


@styled
def mode_shapes(machine: MachineLike, shapes: ModeShapes) -> Figure:
    """Each mode: the crane at rest (dark) and at both ends of its oscillation (pale), much enlarged.

    The imaginary parts of a mode shape (motions with a phase lag) are not drawn.
    """
    machine = as_machine(machine)
    if not shapes.frequency.size:
        raise InputError(
            f"{machine.name} has no oscillating mode in this pose except those of the spools: nothing to draw"
        )
    count = shapes.frequency.size
    fig, panels = figure(4.2 * count, 4.4, ncols=count, squeeze=False)
    lines = machine.drawing(shapes.q)
    every = np.concatenate([points for _, _, points in lines])
    reach = np.ptp(every, axis=0).max()
    low, high = machine.joint_limits.T
    for panel, joints, frequency, damping in zip(
        panels.flat, shapes.joints.real, shapes.frequency, shapes.damping, strict=True
    ):
        # Inside the joint limits, because a drawing exists only there.
        room = np.min((high - low) / 2 / np.maximum(np.abs(joints), 1e-12))
        swing = min(_SWING * reach, 0.9 * room)
        for side in (-swing, swing):
            draw_crane(panel, machine.drawing(np.clip(shapes.q + side * joints, low, high)), alpha=0.25)
        draw_crane(panel, lines)
        metres(panel)
        panel.set_title(f"{frequency:.3g} Hz, damping {100 * damping:.2g} %")
    title(fig, "Modes of small motions, enlarged", machine.name)
    return fig


@styled
def damping_curves(curves: DampingCurves) -> Figure:
    """Frequency and damping ratio of each mode along a joint."""
    unit, factor = shown(curves.unit)
    fig, (upper, lower) = figure(7.0, 5.5, nrows=2, sharex=True)
    for k in range(curves.frequency.shape[1]):
        colour = COLOURS[k % len(COLOURS)]
        upper.plot(curves.coordinate * factor, curves.frequency[:, k], color=colour, label=f"mode {k + 1}")
        lower.plot(curves.coordinate * factor, 100 * curves.damping[:, k], color=colour)
    upper.set_ylabel("natural frequency [Hz]")
    lower.set_ylabel("damping ratio [%]")
    lower.set_xlabel(f"joint {curves.joint} [{unit}]")
    lower.axhline(0.0, color=ACCENT, lw=0.8)
    upper.legend(ncols=3)
    title(fig, "Modes along a joint", f"friction {curves.friction}")
    return fig
