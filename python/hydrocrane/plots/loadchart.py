"""Static payload over the workspace and against reach."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrocrane.plots.field import paint
from hydrocrane.plots.style import COLOURS, INK, draw_crane, figure, styled, title
from hydrocrane.plots.workspace import draw_boundary, metres

if TYPE_CHECKING:
    from hydrocrane.linear import LoadChart
    from hydrocrane.machine import Machine


@styled
def load_chart(crane: Machine, chart: LoadChart) -> Figure:
    """Left, the largest payload at each tip position; right, at each reach, with the telescope in, half out, out."""
    fig, (area, curve) = figure(12.0, 5.4, ncols=2, width_ratios=[1.15, 1])
    # Next to the pillar a load hardly loads the crane: the colours stay with the useful range.
    top = float(np.nanpercentile(chart.payload, 90))
    sheet = paint(area, chart.tip, chart.payload, largest=True, limits=(0.0, top))
    fig.colorbar(sheet, ax=area, label="payload [kg]", extend="max", shrink=0.85)
    draw_boundary(area, crane, colour=INK)
    draw_crane(area, crane.drawing(crane.home), alpha=0.9)
    metres(area)
    area.set_title("largest payload at the tip")
    _against_reach(curve, crane, chart)
    title(fig, "Static load chart", f"{crane.name} at {chart.supply_pressure * 1e-5:.0f} bar")
    return fig


def _against_reach(axes: Axes, crane: Machine, chart: LoadChart) -> None:
    reach, best = chart.against_reach()
    axes.plot(reach, best, color=INK, lw=2.2, marker="o" if reach.size == 1 else None, label="any pose")
    if crane.joint_units[-1] == "m" and chart.payload.ndim > 1:
        count = chart.payload.shape[-1]
        positions = (("in", 0), ("half out", count // 2), ("out", count - 1))
        for (name, layer), colour in zip(positions, COLOURS, strict=False):
            axes.plot(*chart.against_reach(layer=layer), color=colour, lw=1.4, label=f"{crane.joint_names[-1]} {name}")
    outer = best[reach > reach.min() + 0.4 * np.ptp(reach)]
    if outer.size:
        axes.set_ylim(0, 1.15 * max(float(outer.max()), 1.0))
    axes.set_xlabel("reach x [m]")
    axes.set_ylabel("payload [kg]")
    axes.set_title("payload against reach, at the best height")
    if reach.size > 1:
        axes.margins(x=0)
    else:
        axes.set_xlim(reach[0] - 1, reach[0] + 1)
    axes.legend()
