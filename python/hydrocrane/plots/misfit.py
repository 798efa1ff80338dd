"""What a static map leaves over, against everything that friction may depend on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from hydrocrane.plots.style import ACCENT, COLOURS, INK, MUTED, figure, styled, title

if TYPE_CHECKING:
    from hydrocrane.identification.misfit import Misfit

# Factor and label of each axis.
AXES = {
    "velocity": (1e3, "speed [mm/s]"),
    "position": (1e3, "position [mm]"),
    "time": (1.0, "time in the log [s]"),
    "pressure": (1e-3, "force of both chambers [kN]"),
    "load": (1.0, "load [kg]"),
}


@styled
def residual_causes(misfit: Misfit) -> Figure:
    """One chart per cause: points by direction, the fitted dependence; red where it shows."""
    fig, axes = figure(12.0, 3.2, ncols=len(misfit.causes), sharey=True, squeeze=False)
    for chart, cause in zip(axes[0], misfit.causes, strict=True):
        factor, label = AXES[cause.name]
        for side, name in enumerate(("extending", "retracting")):
            here = misfit.direction == side
            x = cause.values[here] * factor
            chart.plot(
                x, 100 * misfit.shares[here], "o", ms=3.5, mec="none", alpha=0.7, color=COLOURS[side], label=name
            )
            order = np.argsort(x)
            colour = ACCENT if cause.shows else INK
            chart.plot(x[order], 100 * cause.fitted[here][order], color=colour, lw=1.0)
        chart.axhline(0.0, color=MUTED, lw=0.7, zorder=1)
        chart.set(xlabel=label, title=cause.name, xscale="log" if cause.name == "velocity" else "linear")
    axes[0, 0].set_ylabel("measured - fitted [%]")
    axes[0, 0].legend(loc="best")
    title(fig, "Residuals", "lines: fitted dependences, red where they show")
    return fig
