"""Characteristic charts of the cylinders, as Figures 86-88."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, unknown
from hydrocrane.plots.style import COLOURS, MUTED, RC, figure, shown, styled, title, write
from hydrocrane.plots.tip_path import mark_payload_changes

if TYPE_CHECKING:
    from hydrocrane.results.record import Record

# From here on matplotlib writes a power of ten above an axis.
LARGE = 1e6

__all__ = ["cylinder_charts", "overview", "write"]


def _quantities(run: Record, cylinder: str) -> list[tuple[str, str]]:
    """The six variables of a cylinder's charts, with their headings."""
    joint = run.joint_names[run.cylinder_names.index(cylinder)]
    return [
        (f"joint.{joint}.q", f"joint {joint}"),
        (f"joint.{joint}.qd", f"rate of joint {joint}"),
        (f"cylinder.{cylinder}.p1", "pressure p1, piston side"),
        (f"cylinder.{cylinder}.p2", "pressure p2, rod side"),
        (f"cylinder.{cylinder}.x", "piston position"),
        (f"cylinder.{cylinder}.v", "piston velocity"),
    ]


@styled
def cylinder_charts(run: Record, cylinder: str) -> Figure:
    """Joint coordinate and rate, both pressures, piston position and velocity of one cylinder against time."""
    if cylinder not in run.cylinder_names:
        raise unknown("cylinder", cylinder, run.cylinder_names)
    _check_recorded(run)
    fig, axes = figure(9.5, 7.5, nrows=3, ncols=2, sharex=True)
    colour = COLOURS[run.cylinder_names.index(cylinder) % len(COLOURS)]
    for panel, (name, heading) in zip(axes.flat, _quantities(run, cylinder), strict=True):
        _curve(panel, run, name, colour, heading)
    for panel in axes[-1]:
        panel.set_xlabel("time [s]")
    title(fig, f"Cylinder {cylinder}", _subject(run))
    return fig


@styled
def overview(run: Record) -> Figure:
    """The charts of all cylinders, one column each."""
    _check_recorded(run)
    cylinders = run.cylinder_names
    fig, axes = figure(4.2 * max(len(cylinders), 1.6), 11.5, nrows=6, ncols=len(cylinders), sharex=True, squeeze=False)
    for column, cylinder in enumerate(cylinders):
        for row, (name, heading) in enumerate(_quantities(run, cylinder)):
            heading = f"{cylinder}: {heading}" if row > 1 else heading
            _curve(axes[row, column], run, name, COLOURS[column % len(COLOURS)], heading, size=9.5)
        axes[-1, column].set_xlabel("time [s]")
    title(fig, "Cylinders", _subject(run))
    return fig


def _check_recorded(run: Record) -> None:
    if not run.columns.rows:
        raise InputError(f"this run recorded nothing to draw: {run.outcome.kind}, {run.outcome.message}")


def _curve(axes: Axes, run: Record, name: str, colour: str, heading: str, size: float = RC["axes.titlesize"]) -> None:
    variable = run.columns[name]
    unit, factor = shown(str(variable.attrs.get("units", "")))
    values = variable.values * factor
    axes.plot(run.columns.time, values, color=colour)
    # Above an axis with a power of ten a heading must make way; to find out costs a fifth of the picture.
    axes.set_title(heading, fontsize=size, y=1.0 if np.abs(values).max() < LARGE else None)
    axes.set_ylabel(f"[{unit}]")
    axes.margins(x=0)
    mark_payload_changes(axes, run)
    _keep_flat(axes, values)
    if values.min() < 0 < values.max():
        axes.axhline(0.0, color=MUTED, lw=0.7, zorder=1)


def _keep_flat(axes: Axes, values: Array) -> None:
    """Do not blow a constant's rounding up to the height of the chart."""
    middle, spread = 0.5 * (values.max() + values.min()), values.max() - values.min()
    least = 1e-2 * max(abs(middle), 1.0)
    if spread < least:
        axes.set_ylim(middle - least, middle + least)


def _subject(run: Record) -> str:
    about = run.columns.attrs
    return f"{about['scenario']} on {about['machine']}"
