"""Working area of the crane tip, as Figure 35."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from hydrocrane.analysis.poses import pose_grid
from hydrocrane.machine.machine import MachineLike, as_machine
from hydrocrane.plots.field import patches
from hydrocrane.plots.style import COLOURS, GRID, MUTED, draw_crane, one_chart, styled, title

if TYPE_CHECKING:
    from hydrocrane.machine.machine import Machine

_AREA = "#dfebf0"


@styled
def workspace(machine: MachineLike) -> Figure:
    """Reach of the tip inside the joint limits, its boundary, and keep-out regions, with the crane in mid-range."""
    machine = as_machine(machine)
    fig, axes = one_chart(7.5, 7.0)
    if len(machine.joint_names) > 1:
        poses = pose_grid(machine, 48)
        axes.add_collection(
            PolyCollection(list(patches(machine.tip(poses))[0]), color=_AREA, antialiaseds=False, zorder=0.5)
        )
    draw_boundary(axes, machine)
    draw_keep_out(axes, machine)
    draw_crane(axes, machine.drawing(machine.home))
    metres(axes)
    title(fig, "Working area of the tip", machine.name)
    return fig


def draw_boundary(axes: Axes, machine: Machine, *, colour: str = COLOURS[0]) -> None:
    """Draw the boundary curves of the workspace."""
    for curve in machine.workspace():
        axes.plot(curve[:, 0], curve[:, 1], color=colour, lw=1.4, zorder=1.5)


def draw_keep_out(axes: Axes, machine: Machine) -> None:
    """Hatch the keep-out regions; they do not extend the picture."""
    for outline in machine.keep_out.values():
        axes.add_artist(Polygon(outline, facecolor=GRID, edgecolor=MUTED, hatch="///", lw=0.8, alpha=0.7, zorder=1))


def metres(axes: Axes, *, fixed: bool = False) -> None:
    """Inertial x and z in metres at equal scale; `fixed` keeps the limits and shrinks the box instead."""
    axes.set_aspect("equal", adjustable="box" if fixed else "datalim")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("z [m]")
