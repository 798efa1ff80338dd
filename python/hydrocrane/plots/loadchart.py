"""Static payload over the workspace and against reach."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hydrocrane.analysis.capacity import Height, at_height
from hydrocrane.machine.machine import MachineLike, as_machine
from hydrocrane.plots.field import hatch, paint
from hydrocrane.plots.style import COLOURS, INK, draw_crane, figure, styled, title
from hydrocrane.plots.workspace import draw_boundary, metres

if TYPE_CHECKING:
    from hydrocrane.analysis.capacity import LoadChart


# Most lines of equal payload.
_LINES = 6


@styled
def load_chart(machine: MachineLike, chart: LoadChart, *, height: Height | None = None) -> Figure:
    """Left, the largest payload at each tip position; right, against reach: at the best and the worst height.

    Lines join positions of equal payload; forbidden positions are hatched. With `height`, as in
    ``LoadChart.against_reach``, only that curve.
    """
    machine = as_machine(machine)
    fig, (area, curve) = figure(12.0, 5.4, ncols=2, width_ratios=[1.15, 1])
    # Near the pillar the payload is very large; the colours show the useful range.
    top = float(np.nanpercentile(chart.payload, 90))
    sheet = paint(area, chart.tip, chart.payload, largest=True, limits=(0.0, top))
    hatch(area, chart.tip, chart.forbidden)
    _iso_loads(area, chart, top)
    fig.colorbar(sheet, ax=area, label="payload [kg]", extend="max", shrink=0.85)
    draw_boundary(area, machine, colour=INK)
    draw_crane(area, machine.drawing(machine.home), alpha=0.9)
    metres(area)
    area.set_title("payload at the tip, in the pose with the highest payload")
    _against_reach(curve, chart, height)
    title(fig, "Static load chart", f"{machine.name} at {chart.supply_pressure * 1e-5:.0f} bar")
    return fig


def _iso_loads(axes: Axes, chart: LoadChart, top: float) -> None:
    """Lines of equal payload, at round values up to the top of the colours."""
    x, z, payload = chart.over_places()
    if x.size < 2 or not np.isfinite(top):
        return
    levels = [level for level in MaxNLocator(_LINES).tick_values(0.0, top) if 0.0 < level <= top]
    lines = axes.contour(x, z, np.minimum(payload, 2 * top), levels=levels, colors=INK, linewidths=0.8, zorder=1.3)
    axes.clabel(lines, fontsize=7, fmt=lambda level: f"{level:g} kg")


def _against_reach(axes: Axes, chart: LoadChart, height: Height | None) -> None:
    shown: tuple[Height, ...] = ("best", "worst") if height is None else (height,)
    for which, colour in zip(shown, COLOURS):
        reach, payload = chart.against_reach(which)
        axes.plot(reach, payload, color=colour, lw=2.0, marker="o" if reach.size == 1 else None, label=at_height(which))
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("reach x [m]")
    axes.set_ylabel("payload [kg]")
    axes.set_title("payload against reach")
    if reach.size > 1:
        axes.margins(x=0)
    else:
        axes.set_xlim(reach[0] - 1, reach[0] + 1)
    axes.legend()
