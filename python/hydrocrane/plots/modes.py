"""Natural frequency and damping over the workspace."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from hydrocrane.analysis.linear import FRICTION_WORDS
from hydrocrane.errors import InputError
from hydrocrane.machine.machine import MachineLike, as_machine
from hydrocrane.plots.field import hatch, paint
from hydrocrane.plots.style import INK, MUTED, draw_crane, figure, styled, title
from hydrocrane.plots.workspace import draw_boundary, metres

if TYPE_CHECKING:
    from hydrocrane.analysis.linear import ModeMap


@styled
def mode_map(machine: MachineLike, modes: ModeMap) -> Figure:
    """Slowest oscillation at each tip position (slowest over the poses that reach it), and the least damping.

    Forbidden positions are hatched.
    """
    machine = as_machine(machine)
    if not np.isfinite(modes.frequency).any():
        raise InputError("the map has no pose in which the crane holds its load and swings: carry less, or draw no map")
    fig, (left, right) = figure(12.0, 5.0, ncols=2)
    for panel, value, label in (
        (left, modes.frequency, "natural frequency [Hz]"),
        (right, 100 * modes.damping, "damping ratio [%]"),
    ):
        # The scale leaves out rare extremes near the limits.
        limits = np.nanpercentile(value, (2, 95))
        sheet = paint(panel, modes.tip, value, largest=False, limits=(float(limits[0]), float(limits[1])))
        hatch(panel, modes.tip, modes.forbidden)
        fig.colorbar(sheet, ax=panel, label=label, extend="both", shrink=0.9)
        draw_boundary(panel, machine, colour=INK)
        draw_crane(panel, machine.drawing(machine.home), alpha=0.9)
        metres(panel)
        panel.set_title(f"slowest mode: {label.split(' [')[0]}")
    title(fig, "Small motions about rest, valves closed", machine.name)
    notes = [FRICTION_WORDS[modes.friction], *(warning.text for warning in modes.warnings)]
    fig.supxlabel("\n".join(textwrap.fill(note, 170) for note in notes), fontsize=8, color=MUTED)
    return fig
