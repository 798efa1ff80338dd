"""Flow through a metering edge, as Figure 42."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrocrane.errors import check_known
from hydrocrane.machine.machine import MachineLike, as_machine
from hydrocrane.plots.style import FIELD, MUTED, figure, styled, title

if TYPE_CHECKING:
    from hydrocrane.machine.machine import Machine

OPENINGS = (0.25, 0.5, 0.75, 1.0)


@styled
def flow_law(machine: MachineLike, cylinder: str | None = None) -> Figure:
    """Flow over pressure drop at several openings: near zero with laminar flow, and over the whole range."""
    machine = as_machine(machine)
    name = machine.cylinder_names[0] if cylinder is None else cylinder
    check_known("cylinder", name, machine.cylinder_names)
    fig, (near, whole) = figure(10.0, 4.3, ncols=2)
    _family(near, machine, name, np.linspace(-10e5, 10e5, 801))
    _family(whole, machine, name, np.linspace(-1, 1, 801) * machine.supply_pressure)
    near.set_title("small pressure drop: laminar to turbulent")
    whole.set_title("up to supply pressure")
    near.legend(title="spool opening", loc="upper left")
    title(fig, "Flow through a metering edge", f"valve of cylinder {name}, {machine.name}")
    return fig


def _family(axes: Axes, machine: Machine, cylinder: str, dp: np.ndarray) -> None:
    import matplotlib as mpl

    full = machine.spool_strokes[machine.cylinder_names.index(cylinder)]
    shades = mpl.colormaps[FIELD](np.linspace(0.8, 0.1, len(OPENINGS)))
    for opening, shade in zip(OPENINGS, shades, strict=True):
        flow = machine.orifice_flow(opening * full, dp, cylinder)
        axes.plot(dp * 1e-5, flow * 6e4, color=shade, label=f"{opening:.0%}")
    axes.axhline(0.0, color=MUTED, lw=0.7, zorder=1)
    axes.axvline(0.0, color=MUTED, lw=0.7, zorder=1)
    axes.set_xlabel("pressure drop [bar]")
    axes.set_ylabel("flow [l/min]")
    axes.margins(x=0)
