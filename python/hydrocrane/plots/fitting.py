"""Pictures of a fit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from hydrocrane.plots.comparison import over_logs
from hydrocrane.plots.style import styled

if TYPE_CHECKING:
    from hydrocrane.fitting.result import Fit

# Most charts of one figure.
MOST = 24


@styled
def fit_charts(fit: Fit) -> Figure:
    """One chart per signal of each log: readings as dark thin lines, the model over them, held-out stretches shaded."""
    chosen = list(fit.differences.items())[:MOST]
    records = {model.record.name: model.record for model in fit.task.models}
    held_out = [records[log].time[records[log].held_out] + records[log].begin for (log, _), _ in chosen]
    return over_logs([d for _, d in chosen], "model", held_out=held_out)
