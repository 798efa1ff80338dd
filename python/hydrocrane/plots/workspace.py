"""Working area of the crane tip, as Figure 35."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrocrane.plots.style import COLOURS, draw_crane, figure, styled, title

if TYPE_CHECKING:
    from hydrocrane.machine import Machine


@styled
def workspace(crane: Machine) -> Figure:
    """Boundary of the tip's reach inside the joint limits, with the crane in the middle of its limits."""
    fig, axes = figure(7.5, 7.0)
    draw_boundary(axes, crane, filled=True)
    draw_crane(axes, crane.drawing(crane.home))
    metres(axes)
    title(fig, "Working area of the tip", crane.name)
    return fig


def draw_boundary(axes: Axes, crane: Machine, *, filled: bool = False, colour: str = COLOURS[0]) -> None:
    """Draw the boundary curves of the workspace."""
    for curve in crane.workspace():
        if filled:
            axes.fill(curve[:, 0], curve[:, 1], color=colour, alpha=0.10, lw=0)
        axes.plot(curve[:, 0], curve[:, 1], color=colour, lw=1.4)


def metres(axes: Axes, *, fixed: bool = False) -> None:
    """Inertial x and z in metres at equal scale; `fixed` keeps the limits that were set and shrinks the box instead."""
    axes.set_aspect("equal", adjustable="box" if fixed else "datalim")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("z [m]")
