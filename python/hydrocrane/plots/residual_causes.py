"""Residuals of a static map over the possible causes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from hydrocrane.plots.style import ACCENT, COLOURS, INK, MUTED, figure, styled, title

if TYPE_CHECKING:
    from hydrocrane.identification.residual_analysis import ResidualAnalysis

# Factor and label of each axis.
AXES = {
    "velocity": (1e3, "speed [mm/s]"),
    "position": (1e3, "position [mm]"),
    "time": (1.0, "time in the log [s]"),
    "pressure": (1e-3, "force of both chambers [kN]"),
    "load": (1.0, "load [kg]"),
}


@styled
def residual_causes(analysis: ResidualAnalysis) -> Figure:
    """One chart per cause: points by direction and the fitted dependence, red if it is significant."""
    fig, axes = figure(12.0, 3.2, ncols=len(analysis.causes), sharey=True, squeeze=False)
    for chart, cause in zip(axes[0], analysis.causes, strict=True):
        factor, label = AXES[cause.name]
        for side, name in enumerate(("extending", "retracting")):
            here = analysis.direction == side
            x = cause.values[here] * factor
            chart.plot(
                x, 100 * analysis.shares[here], "o", ms=3.5, mec="none", alpha=0.7, color=COLOURS[side], label=name
            )
            order = np.argsort(x)
            colour = ACCENT if cause.shows else INK
            chart.plot(x[order], 100 * cause.fitted[here][order], color=colour, lw=1.0)
        chart.axhline(0.0, color=MUTED, lw=0.7, zorder=1)
        chart.set(xlabel=label, title=cause.name, xscale="log" if cause.name == "velocity" else "linear")
    axes[0, 0].set_ylabel("measured - fitted [%]")
    axes[0, 0].legend(loc="best")
    title(fig, "Residuals", "lines: fitted dependences, red if significant")
    return fig
