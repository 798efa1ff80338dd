"""Gain, phase and modulus margin of a loop from its frequency response.

Sources: K. J. Åström, R. M. Murray, Feedback Systems, 2nd edition, section 10.3. A plant with resonances usually has
several crossings; the least margin counts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import Array


@dataclass(frozen=True)
class Margins:
    """Margins of a stable loop; infinite without a crossing.

    Attributes
    ----------
    gain : float
        Least factor above one at which the loop gain passes through -1.
    reduction : float
        Largest factor below one at which the loop gain passes through -1; 0 if there is none.
    phase : float
        Least phase change to -1 at magnitude one, rad, in -pi to pi.
    modulus : float
        Least distance of the loop gain from -1.
    gain_at, phase_at, modulus_at : float
        Their frequencies, rad/s; NaN if there is none.
    """

    gain: float
    reduction: float
    phase: float
    modulus: float
    gain_at: float
    phase_at: float
    modulus_at: float


def margins(omega: Array, gain: np.ndarray, function: Callable[[Array], np.ndarray]) -> Margins:
    """Margins of a loop `gain` (m,) at `omega` (m,), rad/s; `function` returns the gain between them."""
    turned = _crossings(omega, gain.imag, lambda w: function(w).imag)
    there = function(turned) if turned.size else np.zeros(0, complex)
    opposed = there.real < 0
    size = np.abs(there[opposed])
    below, above = size < 1, size >= 1
    unity = _crossings(omega, np.log(np.abs(gain)), lambda w: np.log(np.abs(function(w))))
    phase = np.angle(-function(unity)) if unity.size else np.zeros(0)
    closest = int(np.argmin(np.abs(1 + gain)))
    least = int(np.argmin(np.abs(phase))) if phase.size else -1
    at = turned[opposed][below][np.argmax(size[below])] if below.any() else np.nan
    return Margins(
        gain=float(1 / size[below].max()) if below.any() else np.inf,
        reduction=float(1 / size[above].min()) if above.any() else 0.0,
        phase=float(phase[least]) if phase.size else np.inf,
        modulus=float(np.abs(1 + gain[closest])),
        gain_at=float(at),
        phase_at=float(unity[least]) if phase.size else np.nan,
        modulus_at=float(omega[closest]),
    )


def _crossings(omega: Array, values: Array, function: Callable[[Array], Array]) -> Array:
    """Where `function` passes through zero between neighbours of opposite sign."""
    from scipy.optimize import brentq

    changes = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0)
    return np.array(
        [brentq(lambda w: float(function(np.array([w]))[0]), omega[i], omega[i + 1], xtol=1e-9) for i in changes]
    )
