"""Frequency responses of linear models and of the cylinders' loops."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError
from hydrocrane.machine.machine import MachineLike, as_machine
from hydrocrane.plots.style import ACCENT, MUTED, figure, styled, title
from hydrocrane.state_space.model import LinearModel

if TYPE_CHECKING:
    from hydrocrane.linear.loops import Loop

# What is shown of a machine by default.
OUTPUT = "tip.z"
# Most curves of one picture that can be distinguished.
_MOST = 12
_POINTS = 1500
# Range of the picture of loops below the slowest crossover, as a factor.
_SHOWN_BELOW = 0.1
# Range of the picture below the slowest and above the fastest oscillation, as factors.
_BELOW, _ABOVE = 0.05, 5.0


@styled
def bode(models: LinearModel | MachineLike | Mapping[str, LinearModel], omega: ArrayLike | None = None) -> Figure:
    """Magnitude and phase of every output by every input.

    Parameters
    ----------
    models : LinearModel, machine, or a mapping of names to linear models
        One model, or several in one picture. ``model.select(inputs, outputs)`` selects the curves. A machine, its name
        or path, stands for its linear model in mid-range without friction: the height of the tip by every command.
    omega : (m,) array_like, optional
        rad/s; by default from a twentieth of the slowest oscillation to five times the fastest.

    Returns
    -------
    Figure
        Magnitude in dB of output per input, both in SI; phase in degrees; frequency in Hz.

    Examples
    --------
    >>> crane = hc.load_machine("rottne-f9-lab")
    >>> model = crane.linearise([1.9, 2.0, 0.0], outputs="tip.z", friction="released")
    >>> figure = hc.bode(model.select("cylinder.lift.command", "tip.z"))
    >>> figure.savefig("bode.png")
    >>> [curve.get_label() for curve in hc.bode("single-cylinder").axes[0].lines[:1]]
    ['tip.z by cylinder.test.command']
    """
    named = dict(models) if isinstance(models, Mapping) else {"": _model(models)}
    pairs = [(label, m, o, i) for label, m in named.items() for o in m.output_names for i in m.input_names]
    if not 0 < len(pairs) <= _MOST:
        raise InputError(f"a Bode picture takes 1 to {_MOST} curves, got {len(pairs)}; pick some with model.select")
    at = _frequencies(list(named.values())) if omega is None else np.sort(real_array(omega, "omega").ravel())
    if not at.size or at[0] <= 0:
        raise InputError("omega of a Bode picture must be greater than zero, rad/s")
    fig, (upper, lower) = figure(8.0, 6.0, nrows=2, sharex=True)
    responses = {label: m.frequency_response(at) for label, m in named.items()}
    for label, model, output, name in pairs:
        gain = responses[label][:, model.output_names.index(output), model.input_names.index(name)]
        what = f"{output} by {name}"
        _curve(upper, lower, at, gain, f"{label}: {what}" if label else what)
    _axes(upper, lower, "magnitude [dB, SI]")
    machines = ", ".join(dict.fromkeys(model.machine for model in named.values()))
    title(fig, "Frequency response", machines)
    return fig


def _model(given: LinearModel | MachineLike) -> LinearModel:
    if isinstance(given, LinearModel):
        return given
    machine = as_machine(given)
    return machine.linearise(machine.home, outputs=OUTPUT, friction="released")


@styled
def loop_gains(loops: Sequence[Loop]) -> Figure:
    """Bode picture of the loop gains, each with its margins in the legend if the loops are stable."""
    if not loops:
        raise InputError("loop_gains takes at least one loop, as hc.linear.cylinder_loops returns them")
    fig, (upper, lower) = figure(8.0, 6.0, nrows=2, sharex=True)
    slowest = [loop.margins.phase_at for loop in loops if np.isfinite(loop.margins.phase_at)]
    low = min([_SHOWN_BELOW * min(slowest), 1e-2]) if slowest else 1e-2
    for loop in loops:
        found, kept = loop.margins, loop.omega >= low
        words = f": gain x{found.gain:.3g}, phase {np.degrees(found.phase):.3g} deg" if loop.stable else ""
        _curve(upper, lower, loop.omega[kept], loop.gain[kept], f"{loop.cylinder}{words}", highest=0.0)
    upper.axhline(0.0, color=ACCENT, lw=0.8)
    lower.axhline(-180.0, color=ACCENT, lw=0.8)
    _axes(upper, lower, "magnitude [dB]")
    state = "closed together: stable" if loops[0].stable else "closed together: unstable"
    title(fig, "Loop gain of each cylinder, the others closed", state)
    if loops[0].advice:
        fig.supxlabel(fill(loops[0].advice, 110), fontsize=8.5, color=ACCENT)
    return fig


def _curve(upper: Axes, lower: Axes, omega: Array, gain: np.ndarray, label: str, highest: float = 180.0) -> None:
    """Adds a curve; its phase begins within one turn below `highest`, deg."""
    size = np.abs(gain)
    shown = size > 0
    hertz = omega[shown] / (2 * np.pi)
    upper.semilogx(hertz, 20 * np.log10(size[shown]), label=label)
    phase = np.degrees(np.unwrap(np.angle(gain[shown])))
    lower.semilogx(hertz, phase - 360.0 * np.ceil((phase[:1] - highest) / 360.0), label=label)


def _axes(upper: Axes, lower: Axes, magnitude: str) -> None:
    upper.set_ylabel(magnitude)
    lower.set_ylabel("phase [deg]")
    lower.set_xlabel("frequency [Hz]")
    for panel in (upper, lower):
        panel.grid(visible=True, which="both", lw=0.4)
        panel.axhline(0.0, color=MUTED, lw=0.6)
    upper.legend(loc="best")


def _frequencies(models: list[LinearModel]) -> Array:
    """rad/s: the range of the oscillations, with points at the resonances."""
    peaks = np.concatenate([2 * np.pi * model.oscillations.frequency for model in models])
    low, high = (_BELOW * peaks.min(), _ABOVE * peaks.max()) if peaks.size else (0.1, 1e3)
    near = np.geomspace(1e-4, 0.1, 60)
    close = (peaks[:, None, None] * (1 + np.array([-1.0, 1.0])[:, None] * near)).ravel()
    return np.unique(np.concatenate([np.geomspace(low, high, _POINTS), close, peaks]))
