"""Energy sources and sinks of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from hydrocrane.plots.charts import subject
from hydrocrane.plots.style import COLOURS, INK, MUTED, one_chart, styled, title
from hydrocrane.results.energy import EnergyEntry, EnergyFlow, energy_flow

if TYPE_CHECKING:
    from hydrocrane.results.record import Record

# Smaller shares of the total are left out, because they would be printed as zero.
LEAST = 1e-6


@styled
def energy_chart(run: Record) -> Figure:
    """Bars of all energy sources and below them of all sinks, in kJ and as shares of the total input.

    Losses are those of the ledger, each with its name and in the colour of its cylinder. Elastic energy in the oil,
    transported and stored, is one bar. A crane that moves down is a source.

    Raises
    ------
    InputError
        If the run recorded no ledger.
    """
    flow = energy_flow(run)
    owners = {name: COLOURS[i % len(COLOURS)] for i, name in enumerate(run.cylinder_names)} | {"": MUTED}
    given, taken = (
        [entry for entry in entries if entry.total >= LEAST * flow.total] for entries in (flow.given, flow.taken)
    )
    fig, axes = one_chart(9.5, 1.6 + 0.32 * (len(given) + len(taken) + 1))
    places = _bars(axes, given, 0.0, owners, flow)
    places |= _bars(axes, taken, max(places) + 1.8, owners, flow)
    axes.set(yticks=list(places), yticklabels=list(places.values()), xlabel="energy [kJ]")
    axes.set_xlim(0.0, 1.22 * 1e-3 * flow.total)
    axes.set_ylim(max(places) + 0.7, -0.9)
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)
    named = [Patch(color=colour, label=name or "whole machine") for name, colour in owners.items()]
    axes.legend(handles=named, loc="lower right")
    title(fig, "Energy", subject(run))
    sums = f"given {_energy(flow.total)}, taken {_energy(flow.total - flow.gap)}"
    axes.set_title(f"{sums}; the ledger closes to {flow.residual:.1e} J", fontsize=9, fontweight="normal")
    return fig


def _bars(
    axes: Axes, entries: list[EnergyEntry], start: float, owners: dict[str, str], flow: EnergyFlow
) -> dict[float, str]:
    """Draw the entries from `start` downwards; their heights and names."""
    for i, entry in enumerate(entries):
        # A part of opposite sign begins left of zero, so that the bar ends at the total.
        end = 1e-3 * sum(part for part in entry.parts.values() if part < 0.0)
        for owner, colour in owners.items():
            part = 1e-3 * max(entry.parts.get(owner, 0.0), 0.0)
            axes.barh(start + i, part, left=end, height=0.72, color=colour)
            end += part
        words = f" {_energy(entry.total)}   {100 * entry.total / flow.total:.3g} %"
        axes.text(end, start + i, words, va="center", fontsize=8.5, color=INK)
    return {start + i: entry.name for i, entry in enumerate(entries)}


def _energy(joule: float) -> str:
    return f"{1e-3 * joule:.4g} kJ" if abs(joule) >= 100.0 else f"{joule:.3g} J"
