"""Bessel low-pass filter, causal or without delay. Theory: docs/theory/signals/low_pass.md"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.signal import bessel, freqs_zpk, sosfilt, sosfilt_zi, sosfiltfilt

from hydrocrane.arrays import Array, real_array, whole_number
from hydrocrane.errors import InputError, check_known

NORMS = ("mag", "phase")
# Above this share of the sampling rate the digital filter no longer has the delay of the analogue one.
HIGHEST_CUTOFF = 0.4


def low_pass(
    values: ArrayLike, rate: float, cutoff: float, *, order: int = 4, zero_phase: bool = True, norm: str = "mag"
) -> Array:
    """Low-pass filter a uniformly sampled signal.

    Parameters
    ----------
    values : (n,) array_like
        Finite samples; the filter starts in steady state at the first one.
    rate : float
        Samples per second.
    cutoff : float
        Hz, below 0.4 of the rate.
    order : int
        1 to 10.
    zero_phase : bool
        Forward and backward, without delay, for complete logs. Otherwise causal, as in a controller.
    norm : {"mag", "phase"}
        Meaning of `cutoff`: the frequency at which the whole filter (both passes) has -3 dB; or, causal only, at which
        the phase is half of its final value, as in MATLAB and the thesis.

    Returns
    -------
    (n,) array
    """
    values = real_array(values, "values")
    if values.ndim != 1 or values.size < 2:
        raise InputError(f"values must be one series of at least two samples; got shape {values.shape}")
    _check(rate, cutoff, order, zero_phase, norm)
    design = cutoff * _widening(order) if zero_phase else cutoff
    sections = bessel(order, min(design, 0.49 * rate), fs=rate, norm=norm, output="sos")
    if zero_phase:
        padding = min(values.size - 1, int(3 * rate / cutoff))
        found = sosfiltfilt(sections, values, padtype="odd", padlen=padding)
    else:
        found, _ = sosfilt(sections, values, zi=sosfilt_zi(sections) * values[0])
    return np.asarray(found, dtype=np.float64)


def _check(rate: float, cutoff: float, order: int, zero_phase: bool, norm: str) -> None:
    check_known("norm", norm, NORMS)
    if zero_phase and norm == "phase":
        raise InputError("norm `phase` has no meaning without phase; choose norm `mag`, or zero_phase=False")
    whole_number("order", order, 1, 10)
    rate, cutoff = float(real_array(rate, "rate")), float(real_array(cutoff, "cutoff"))
    if not 0.0 < cutoff <= HIGHEST_CUTOFF * rate:
        raise InputError(
            f"cutoff must be above 0 and up to {HIGHEST_CUTOFF * rate:.4g} Hz (0.4 of the rate), got {cutoff}"
        )


def _widening(order: int) -> float:
    """Factor on the cut-off of one pass for -3 dB of both passes at the wanted cut-off."""
    zeros, poles, gain = bessel(order, 1.0, analog=True, norm="mag", output="zpk")

    def excess(w: float) -> float:
        return float(np.abs(freqs_zpk(zeros, poles, gain, [w])[1][0]) - 0.5**0.25)

    return float(1.0 / brentq(excess, 0.05, 1.0))
