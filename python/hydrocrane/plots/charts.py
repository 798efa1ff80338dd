"""Characteristic charts of the cylinders, as Figures 86-88."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, check_known
from hydrocrane.plots.style import COLOURS, INK, MUTED, RC, figure, shown, styled, title, write
from hydrocrane.plots.tip_path import mark_payload_changes

if TYPE_CHECKING:
    from hydrocrane.results.record import Record

# Values from which matplotlib writes a power of ten above an axis.
LARGE = 1e6

__all__ = ["cylinder_charts", "overview", "write"]


class Quantity(NamedTuple):
    """A chart of a cylinder: a signal, and optionally a second one as a dark thin line."""

    name: str
    heading: str
    axis: str
    thin: str = ""


def _quantities(run: Record, cylinder: str) -> list[Quantity]:
    """The charts of a cylinder."""
    number = run.cylinder_names.index(cylinder)
    joint, name = run.joint_names[number], f"cylinder.{cylinder}"
    turns = run.columns[f"joint.{joint}.q"].attrs.get("units") == "rad"
    of_joint = ("angle", "angular velocity") if turns else ("position", "velocity")
    return [
        Quantity(f"joint.{joint}.q", f"joint {joint}", of_joint[0]),
        Quantity(f"joint.{joint}.qd", f"rate of joint {joint}", of_joint[1]),
        Quantity(f"{name}.p1", "pressure p1, piston side", "pressure"),
        Quantity(f"{name}.p2", "pressure p2, rod side", "pressure"),
        Quantity(f"{name}.x", "piston position", "position"),
        Quantity(f"{name}.v", "piston velocity", "velocity"),
        Quantity(f"{name}.xs", "spool; command thin", "position", f"{name}.command"),
        Quantity(f"{name}.force", "net force on the rod; friction thin", "force", f"{name}.friction"),
    ]


@styled
def cylinder_charts(run: Record, cylinder: str) -> Figure:
    """Joint, pressures, piston, spool with its command, force with friction of one cylinder against time."""
    check_known("cylinder", cylinder, run.cylinder_names)
    check_recorded(run)
    fig, axes = figure(9.5, 9.6, nrows=4, ncols=2, sharex=True)
    colour = COLOURS[run.cylinder_names.index(cylinder) % len(COLOURS)]
    for panel, quantity in zip(axes.flat, _quantities(run, cylinder), strict=True):
        _curve(panel, run, quantity, colour, quantity.heading)
    for panel in axes[-1]:
        panel.set_xlabel("time [s]")
    title(fig, f"Cylinder {cylinder}", subject(run))
    return fig


@styled
def overview(run: Record) -> Figure:
    """The charts of all cylinders, one column each."""
    check_recorded(run)
    cylinders = run.cylinder_names
    fig, axes = figure(4.2 * max(len(cylinders), 1.6), 15.0, nrows=8, ncols=len(cylinders), sharex=True, squeeze=False)
    for column, cylinder in enumerate(cylinders):
        for row, quantity in enumerate(_quantities(run, cylinder)):
            heading = f"{cylinder}: {quantity.heading}" if row > 1 else quantity.heading
            _curve(axes[row, column], run, quantity, COLOURS[column % len(COLOURS)], heading, size=9.5)
        axes[-1, column].set_xlabel("time [s]")
    title(fig, "Cylinders", subject(run))
    return fig


def check_recorded(run: Record) -> None:
    if not run.columns.rows:
        raise InputError(f"this run recorded nothing to draw: {run.outcome.kind}, {run.outcome.message}")


def _curve(
    axes: Axes, run: Record, quantity: Quantity, colour: str, heading: str, size: float = RC["axes.titlesize"]
) -> None:
    variable = run.columns[quantity.name]
    unit, factor = shown(str(variable.attrs.get("units", "")))
    values = variable.values * factor
    axes.plot(run.columns.time, values, color=colour)
    if quantity.thin:
        thin = run.columns[quantity.thin].values * factor
        axes.plot(run.columns.time, thin, color=INK, lw=0.8)
        values = np.concatenate([values, thin])
    # A heading must move above a power of ten; to detect this costs a fifth of the drawing time.
    axes.set_title(heading, fontsize=size, y=1.0 if np.abs(values).max() < LARGE else None)
    axes.set_ylabel(f"{quantity.axis} [{unit}]")
    axes.margins(x=0)
    mark_payload_changes(axes, run)
    _keep_flat(axes, values)
    if values.min() < 0 < values.max():
        axes.axhline(0.0, color=MUTED, lw=0.7, zorder=1)


def _keep_flat(axes: Axes, values: Array) -> None:
    """Prevents that the rounding errors of a constant fill the height of the chart."""
    middle, spread = 0.5 * (values.max() + values.min()), values.max() - values.min()
    least = 1e-2 * max(abs(middle), 1.0)
    if spread < least:
        axes.set_ylim(middle - least, middle + least)


def subject(run: Record) -> str:
    about = run.columns.attrs
    return f"{about['scenario']} on {about['machine']}"
