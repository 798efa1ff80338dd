"""Pictures of a fit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from hydrocrane.plots.style import COLOURS, INK, figure, shown, styled, title

if TYPE_CHECKING:
    from hydrocrane.fitting.result import Fit

# Most charts of one figure.
MOST = 24


@styled
def fit_charts(fit: Fit) -> Figure:
    """One chart per signal of each log: readings as dark thin lines, the model over them, held-out stretches shaded."""
    chosen = list(fit.differences.items())[:MOST]
    held = {model.record.name: model.record for model in fit.task.models}
    columns = 1 if len(chosen) == 1 else 2
    rows = -(-len(chosen) // columns)
    fig, axes = figure(5.0 * columns, 2.4 * rows + 0.7, nrows=rows, ncols=columns, squeeze=False)
    for panel, ((log, signal), d) in zip(axes.flat, chosen, strict=False):
        unit, factor = shown(d.unit)
        panel.plot(d.time, d.log * factor, color=INK, lw=1.0, label="log")
        panel.plot(d.time, d.run * factor, color=COLOURS[1], lw=1.6, alpha=0.9, label="model")
        record = held[log]
        out = record.time[record.held_out] + record.begin
        if out.size:
            panel.axvspan(out[0], out[-1], color=INK, alpha=0.08, lw=0, label="held out")
        panel.set_title(f"{signal}   rms {d.rms * factor:.3g} {unit}", fontsize=9)
        panel.set_ylabel(f"[{unit}]")
        panel.margins(x=0)
    for panel in axes.flat[len(chosen) :]:
        panel.set_visible(False)
    for panel in axes[-1]:
        panel.set_xlabel("time [s]")
    axes.flat[0].legend(loc="best")
    title(fig, "Model and log")
    return fig
