"""A measured log over a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from hydrocrane.arrays import Array
from hydrocrane.plots.style import COLOURS, INK, figure, shown, styled, title

if TYPE_CHECKING:
    from hydrocrane.results.difference import Difference


@styled
def comparison_charts(differences: Sequence[Difference]) -> Figure:
    """One chart per quantity: the log as a dark thin line, the run over it, and the size of the difference."""
    return over_logs(differences, "run", largest=True, sharex=True)


def over_logs(
    differences: Sequence[Difference],
    label: str,
    *,
    largest: bool = False,
    sharex: bool = False,
    held_out: Sequence[Array] = (),
) -> Figure:
    """One chart per quantity, a run called `label` over its log; the times `held_out` of each are shaded."""
    columns = 1 if len(differences) == 1 else 2
    rows = -(-len(differences) // columns)
    fig, axes = figure(5.0 * columns, 2.4 * rows + 0.7, nrows=rows, ncols=columns, sharex=sharex, squeeze=False)
    for i, (panel, d) in enumerate(zip(axes.flat, differences, strict=False)):
        unit, factor = shown(d.unit)
        panel.plot(d.time, d.log * factor, color=INK, lw=1.0, label="log")
        panel.plot(d.time, d.run * factor, color=COLOURS[1], lw=1.6, alpha=0.9, label=label)
        if held_out and held_out[i].size:
            panel.axvspan(held_out[i][0], held_out[i][-1], color=INK, alpha=0.08, lw=0, label="held out")
        size = f", largest {d.maximum * factor:.3g}" if largest else ""
        panel.set_title(f"{d.name}   rms {d.rms * factor:.3g}{size} {unit}", fontsize=9)
        panel.set_ylabel(f"[{unit}]")
        panel.margins(x=0)
    for panel in axes.flat[len(differences) :]:
        panel.set_visible(False)
    for panel in axes[-1]:
        panel.set_xlabel("time [s]")
    axes.flat[0].legend(loc="best")
    title(fig, f"{label.capitalize()} and log")
    return fig
