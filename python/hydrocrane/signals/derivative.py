"""Derivatives of a noisy, rounded signal, with their uncertainty. Theory: docs/theory/signals/derivative.md"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.signal import oaconvolve

from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError
from hydrocrane.logs.noise import Noise, noise_of

# Ratio of the widths of successive windows; and the widest one as a share of the record.
GROWTH, WIDEST_SHARE = 1.35, 0.5
# Half-width of the confidence intervals that must overlap, in standard deviations; wide, because many are compared.
CONFIDENCE = 3.5
# When the intervals no longer overlap, the bias has their size. This many windows earlier it is small against the
# noise: the bias grows with the square of the width, while the noise decreases with its power 3/2.
BACK = 3


class Derivative(NamedTuple):
    """Derivative (n,), its standard uncertainty (n,), and the half-width (n,) of its window in samples."""

    value: Array
    error: Array
    half_width: Array


def derivative(
    values: ArrayLike, rate: float, order: int = 1, *, noise: Noise | None = None, longest: float | None = None
) -> Derivative:
    """First or second derivative of a uniformly sampled signal.

    A polynomial of one degree more than the derivative is fitted around each sample. Its window grows while the
    estimates of all smaller windows agree within their uncertainty. Steady motion is thus averaged over a long time,
    and a jerk is not smeared.

    Parameters
    ----------
    values : (n,) array_like
        Finite samples.
    rate : float
        Samples per second.
    order : {1, 2}
    noise : Noise, optional
        Noise of the sensor; by default estimated from `values`.
    longest : float, optional
        Longest window, s; by default half of the record.
    """
    values = real_array(values, "values")
    if order not in (1, 2):
        raise InputError(f"order must be 1 or 2, got {order!r}")
    rate = float(real_array(rate, "rate"))
    if rate <= 0:
        raise InputError(f"rate must be positive, got {rate}")
    if values.ndim != 1 or values.size < 2 * order + 5:
        raise InputError(f"values must be one series of at least {2 * order + 5} samples; got shape {values.shape}")
    noise = noise or noise_of(values)
    return _grown(values, rate, order, noise, longest)


def _grown(values: Array, rate: float, order: int, noise: Noise, longest: float | None) -> Derivative:
    """Intersection of confidence intervals (Katkovnik, IEEE Trans. Signal Processing 47, 1999) from small to wide."""
    n = values.size
    low, high = np.full(n, -np.inf), np.full(n, np.inf)
    growing = np.ones(n, dtype=bool)
    tried: list[tuple[Array, Array, Array]] = []
    chosen = [np.zeros(n), np.full(n, np.inf), np.zeros(n)]
    for m in _half_widths(n, rate, order, longest):
        estimate = _fitted(values, m, rate, order)
        uncertainty = _uncertainty(estimate, m, rate, order, noise)
        low = np.maximum(low, estimate - CONFIDENCE * uncertainty)
        high = np.minimum(high, estimate + CONFIDENCE * uncertainty)
        stopped = growing & (low > high)
        growing &= ~stopped
        tried = [*tried[-1 - BACK :], (estimate, uncertainty, np.full(n, float(m)))]
        _take(chosen, tried[max(len(tried) - 2 - BACK, 0)], stopped)
        # Samples whose window still grows take the widest window so far.
        _take(chosen, tried[-1], growing)
        if not growing.any():
            break
    return Derivative(*chosen)


def _take(chosen: list[Array], found: tuple[Array, Array, Array], where: np.ndarray) -> None:
    for column, values in zip(chosen, found):
        column[where] = values[where]


def _half_widths(n: int, rate: float, order: int, longest: float | None) -> list[int]:
    widest = int(WIDEST_SHARE * n / 2) if longest is None else int(longest * rate / 2)
    widest = max(min(widest, (n - 1) // 2), order + 1)
    widths = [order + 1]
    while widths[-1] < widest:
        widths.append(min(max(widths[-1] + 1, int(widths[-1] * GROWTH)), widest))
    return widths


def _powers(m: int, order: int) -> Array:
    """(2 m + 1, order + 2) powers of the position in the window, from -1 to 1."""
    return np.vander(np.arange(-m, m + 1) / m, order + 2, increasing=True)


def _rows(at: Array, m: int, rate: float, order: int) -> Array:
    """(k, order + 2) factors from a window's coefficients to its derivative `at` (k,) samples off the middle."""
    rows = np.zeros((at.size, order + 2))
    rows[:, order] = 1.0 if order == 1 else 2.0
    rows[:, order + 1] = (2.0 if order == 1 else 6.0) * at / m
    return np.asarray(rows * (rate / m) ** order)


def _fitted(values: Array, m: int, rate: float, order: int) -> Array:
    """Derivative of the polynomials fitted around every sample; by Fourier transform, since windows may be long."""
    powers = _powers(m, order)
    solver = np.linalg.solve(powers.T @ powers, powers.T)
    middle, off = np.zeros(1), np.arange(1, m + 1, dtype=np.float64)
    kernel = (_rows(middle, m, rate, order) @ solver)[0]
    level = values - values.mean()
    found = oaconvolve(level, kernel[::-1], mode="same")
    found[:m] = _rows(-off[::-1], m, rate, order) @ (solver @ level[: 2 * m + 1])
    found[-m:] = _rows(off, m, rate, order) @ (solver @ level[-2 * m - 1 :])
    return np.asarray(found, dtype=np.float64)


def _uncertainty(estimate: Array, m: int, rate: float, order: int, noise: Noise) -> Array:
    """Standard deviation of the fit's derivative at every sample, from noise and rounding."""
    powers = _powers(m, order)
    covariance = np.linalg.inv(powers.T @ powers)
    # Position in the window at which the derivative is evaluated: its middle, or off it within m samples of the
    # record's ends.
    n = estimate.size
    at = np.clip(np.arange(n), 0, m) - np.clip(np.arange(n)[::-1], 0, m)
    rows = _rows(at.astype(np.float64), m, rate, order)
    gain = np.sqrt(np.einsum("ni,ij,nj->n", rows, covariance, rows))
    span = 2.0 * m / rate
    # The rounding error is periodic in the steps, so it averages over the number of crossed steps and not of samples.
    crossed = np.abs(estimate) * span / noise.step if noise.step and order == 1 else np.zeros(n)
    dither = np.exp(-2.0 * (np.pi * noise.sigma / noise.step) ** 2) if noise.step else 0.0
    rounding = 0.5 * noise.step * dither * order * (2.0 / span) ** order / 2.0 / np.maximum(crossed, 1.0)
    averaged = gain * (noise.total if noise.step else noise.sigma)
    tiny = np.finfo(np.float64).tiny
    return np.asarray(np.sqrt(averaged**2 + rounding**2) + tiny, dtype=np.float64)
