"""A rig's log with its windows of steady motion, and friction over velocity."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrocrane.plots.style import ACCENT, COLOURS, INK, MUTED, styled, title
from hydrocrane.signals.friction import steady_friction

if TYPE_CHECKING:
    from hydrocrane.signals.windows import SteadyWindows


@styled
def steady_windows_chart(found: SteadyWindows) -> Figure:
    """Position, pressures, friction over time with accepted (green) and rejected stretches; friction over velocity."""
    fig = plt.figure(figsize=(11.0, 6.4), layout="constrained")
    left, right = np.ravel(np.asarray(fig.subfigures(1, 2, width_ratios=(1.7, 1.0))))
    axes = left.subplots(3, 1, sharex=True)
    log, time = found.log, found.log.time
    axes[0].plot(time, log["x"] * 1e3, color=INK, lw=1.2)
    axes[0].set_ylabel("position [mm]")
    for name, colour in (("p1", COLOURS[0]), ("p2", COLOURS[1])):
        axes[1].plot(time, log[name] * 1e-5, color=colour, lw=0.9, label=name)
    axes[1].set_ylabel("pressure [bar]")
    axes[1].legend(loc="best")
    axes[2].plot(time, steady_friction(log, found.rig, load_cell=found.load_cell), color=MUTED, lw=0.6)
    axes[2].set_ylabel("friction [N]")
    axes[2].set_xlabel("time [s]")
    for panel in axes:
        _stretches(panel, found)
        panel.margins(x=0)
    for w in found:
        axes[2].plot([w.start, w.end], [w.force, w.force], color=ACCENT, lw=2.0)
    _limits(axes[2], found)
    _map(right.subplots(), found)
    title(fig, "Windows of steady motion", f"{len(found)} accepted, {len(found.rejected)} left out")
    return fig


def _stretches(panel: Axes, found: SteadyWindows) -> None:
    for w in found:
        panel.axvspan(w.start, w.end, color=COLOURS[3], alpha=0.25, lw=0)
    for r in found.rejected:
        panel.axvspan(r.start, r.end, color=MUTED, alpha=0.10, lw=0)


def _limits(panel: Axes, found: SteadyWindows) -> None:
    """Limits from the windows, because inertia forces at the starts are much larger."""
    if len(found):
        forces = np.array([w.force for w in found])
        reach = max(float(np.ptp(forces)), float(np.abs(forces).max()))
        panel.set_ylim(float(forces.min()) - 0.5 * reach, float(forces.max()) + 0.5 * reach)


def _map(panel: Axes, found: SteadyWindows) -> None:
    bars: dict[str, Any] = {"fmt": "o", "ms": 4.5, "capsize": 2.5, "lw": 1.0}
    for direction, colour, label in ((1, COLOURS[0], "extending"), (-1, COLOURS[4], "retracting")):
        chosen = [w for w in found if w.direction == direction]
        if chosen:
            panel.errorbar(
                [w.velocity * 1e3 for w in chosen], [w.force for w in chosen], yerr=[2 * w.force_error for w in chosen],
                xerr=[2 * w.velocity_error * 1e3 for w in chosen], color=colour, label=label, **bars,
            )  # fmt: skip
    panel.axhline(0.0, color=MUTED, lw=0.8)
    panel.axvline(0.0, color=MUTED, lw=0.8)
    panel.set_xlabel("velocity [mm/s]")
    panel.set_ylabel("friction [N], bars of two standard errors")
    panel.set_title("Friction over velocity")
    if len(found):
        panel.legend(loc="best")
