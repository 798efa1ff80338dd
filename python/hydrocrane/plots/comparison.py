"""A measured log over a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from hydrocrane.plots.style import COLOURS, INK, figure, shown, styled, title

if TYPE_CHECKING:
    from hydrocrane.results.difference import Difference


@styled
def comparison_charts(differences: Sequence[Difference]) -> Figure:
    """One chart per quantity: the log as a dark thin line, the run over it, and the size of the difference."""
    columns = 1 if len(differences) == 1 else 2
    rows = -(-len(differences) // columns)
    fig, axes = figure(5.0 * columns, 2.4 * rows + 0.7, nrows=rows, ncols=columns, sharex=True, squeeze=False)
    for panel, d in zip(axes.flat, differences, strict=False):
        unit, factor = shown(d.unit)
        panel.plot(d.time, d.log * factor, color=INK, lw=1.0, label="log")
        panel.plot(d.time, d.run * factor, color=COLOURS[1], lw=1.6, alpha=0.9, label="run")
        panel.set_title(f"{d.name}   rms {d.rms * factor:.3g}, largest {d.maximum * factor:.3g} {unit}", fontsize=9)
        panel.set_ylabel(f"[{unit}]")
        panel.margins(x=0)
    for panel in axes.flat[len(differences) :]:
        panel.set_visible(False)
    for panel in axes[-1]:
        panel.set_xlabel("time [s]")
    axes.flat[0].legend(loc="best")
    title(fig, "Run and log")
    return fig
