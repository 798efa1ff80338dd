"""Identified bristle parameters: logs, predictions of the fitted rig, and residuals; as Figures 71 and 73."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from hydrocrane.errors import InputError
from hydrocrane.plots.style import ACCENT, COLOURS, MUTED, figure, shown, styled, title

if TYPE_CHECKING:
    from hydrocrane.identification.dynamic_result import DynamicFit

# x, p1, p2.
UNITS = ("m", "Pa", "Pa")
NAMES = ("position", "pressure", "pressure")


@styled
def dynamic_fit(fit: DynamicFit) -> Figure:
    """A column per log: position, both pressures, and the residuals of each in standard deviations."""
    if fit.rig_residuals is None or fit.estimate is None:
        raise InputError("there is no fit to draw, only initial estimates: " + "; ".join(fit.warnings))
    models = fit.rig_residuals.models
    fig, axes = figure(5.5 * len(models) + 1.0, 7.6, nrows=3, ncols=len(models), sharex="col", squeeze=False)
    for k, model in enumerate(models):
        found = fit.predicted(k)
        for i, (name, colour) in enumerate(zip(("x", "p1", "p2"), COLOURS, strict=False)):
            row = axes[min(i, 1), k]
            unit, factor = shown(UNITS[i])
            row.plot(model.time, model.measured[:, i] * factor, ".", color=colour, ms=3, alpha=0.5, label=f"{name} log")
            row.plot(model.time, found[:, i] * factor, color=colour, lw=1.1, label=f"{name} fitted")
            row.set(ylabel=f"{NAMES[i]} [{unit}]")
            left = model.weighted(found - model.measured)[i]
            axes[2, k].plot(model.time[model.counted], left, ".", color=colour, ms=3, alpha=0.6, label=name)
        axes[0, k].set(title=model.source or f"log {k + 1}")
        axes[2, k].axhline(0.0, color=MUTED, lw=0.7)
        for edge in (-1.96, 1.96):
            axes[2, k].axhline(edge, color=ACCENT, lw=0.7, ls="--")
        axes[2, k].set(xlabel="time [s]", ylabel="residual [standard deviations]")
    for row in axes[:, 0]:
        row.legend(loc="best")
    values = ", ".join(f"{name} {value:.4g}" for name, value in fit.params.items())
    title(fig, "Bristles", f"{values}; residuals {np.sqrt(fit.estimate.variance):.2f} times the stated noise")
    return fig
