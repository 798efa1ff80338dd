"""Static payload over the workspace and against reach."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from hydrocrane.plots.field import cells
from hydrocrane.plots.style import COLOURS, INK, draw_crane, figure, styled, title
from hydrocrane.plots.workspace import draw_boundary, metres

if TYPE_CHECKING:
    from hydrocrane.linear import LoadChart
    from hydrocrane.machine import Machine


@styled
def load_chart(crane: Machine, chart: LoadChart) -> Figure:
    """Left, the largest payload at each tip position; right, the best and the worst one at each reach."""
    fig, (area, curve) = figure(12.0, 5.4, ncols=2, width_ratios=[1.15, 1])
    # Next to the pillar a load hardly loads the crane: the colours stay with the useful range.
    top = float(np.nanpercentile(chart.payload, 90))
    mesh = cells(area, chart.tip, np.minimum(chart.payload, top), largest=True, size=90)
    fig.colorbar(mesh, ax=area, label="payload [kg]", extend="max", shrink=0.85)
    draw_boundary(area, crane, colour=INK)
    draw_crane(area, crane.drawing(crane.home), alpha=0.9)
    metres(area)
    area.set_title("largest payload at the tip")

    reach, best, worst = chart.against_reach()
    curve.fill_between(reach, worst, best, color=COLOURS[0], alpha=0.15, lw=0)
    curve.plot(reach, best, color=COLOURS[0], lw=2.2, label="best pose")
    curve.plot(reach, worst, color=COLOURS[1], lw=1.6, label="worst pose")
    outer = best[reach > reach.min() + 0.4 * np.ptp(reach)]
    curve.set_ylim(0, 1.1 * max(float(outer.max()), 1.0))
    curve.set_xlim(reach.min(), reach.max())
    curve.set_xlabel("reach x [m]")
    curve.set_ylabel("payload [kg]")
    curve.set_title("payload against reach")
    curve.legend()
    title(fig, "Static load chart", f"{crane.name} at {chart.supply_pressure * 1e-5:.0f} bar")
    return fig
