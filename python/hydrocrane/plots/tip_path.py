"""Path of the crane tip, with deviation, payload and pump power."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrocrane.errors import InputError
from hydrocrane.plots.style import ACCENT, COLOURS, INK, MUTED, figure, shown, styled, title

if TYPE_CHECKING:
    from hydrocrane.results.record import Record

# Charts below the path, each against time if the run has it: variable, heading.
PANELS = (
    ("tip.deviation", "distance from the path of the set-point"),
    ("payload", "payload"),
    ("supply.power", "power drawn from the pump"),
)


@styled
def tip_charts(run: Record) -> Figure:
    """Path of the tip, in space also from above, and of its set-point; deviation, payload, pump power against time."""
    data = run.columns
    if data.rows < 2:
        raise InputError(f"this run recorded no motion to draw: {run.outcome.kind}, {run.outcome.message}")
    rows = [(name, heading) for name, heading in PANELS if name in data]
    # From the side, and of a machine in space from above.
    views = [("x", "z"), ("x", "y")] if "tip.y" in data else [("x", "z")]
    heights = [2.4] * len(views) + [1.0] * len(rows)
    fig, axes = figure(7.5, 4.0 * len(views) + 1.7 * len(rows), nrows=len(heights), height_ratios=heights)
    for panel, view in zip(axes, views, strict=False):
        _path(panel, run, view)
    for panel, (name, heading) in zip(axes[len(views) :], rows, strict=True):
        unit, factor = shown(str(data[name].attrs["units"]))
        drawstyle = "steps-pre" if name == "payload" else "default"
        panel.plot(data.time, data[name].values * factor, color=COLOURS[0], drawstyle=drawstyle)
        panel.set_title(heading, fontsize=9.5)
        panel.set_ylabel(f"[{unit}]")
        panel.margins(x=0)
        panel.sharex(axes[len(views)])
        mark_payload_changes(panel, run)
    axes[-1].set_xlabel("time [s]")
    title(fig, "Crane tip", f"{data.attrs['scenario']} on {data.attrs['machine']}")
    return fig


def mark_payload_changes(axes: Axes, run: Record) -> None:
    """A line at each time at which a load is picked up or released."""
    for change in run.payload_changes:
        axes.axvline(change.time, color=ACCENT if change.after > change.before else MUTED, lw=0.9, ls=":", zorder=1.5)


def _path(axes: Axes, run: Record, view: tuple[str, str]) -> None:
    data = run.columns
    time, x, z = (data[name].values for name in ("time", *(f"tip.{axis}" for axis in view)))
    if "set_point.x" in data and view == ("x", "z"):
        axes.plot(data["set_point.x"].values, data["set_point.z"].values, color=INK, lw=0.8, label="set-point")
    axes.plot(x, z, color=COLOURS[0], lw=1.2, label="tip")
    axes.plot(x[0], z[0], marker="o", ms=4, color=INK, ls="none", label="start")
    for change in run.payload_changes:
        load = change.after - change.before
        word, colour = ("picks up", ACCENT) if load > 0 else ("releases", MUTED)
        place = [np.interp(change.time, time, column) for column in (x, z)]
        axes.plot(*place, marker="v", ms=7, color=colour, ls="none", label=f"{word} {abs(load):g} kg")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"{view[0]} [m]")
    axes.set_ylabel(f"{view[1]} [m]")
    axes.legend(loc="best")
