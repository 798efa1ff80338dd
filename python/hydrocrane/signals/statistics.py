"""Errors of means and slopes of samples that are correlated in time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrocrane.arrays import Array


class Line(NamedTuple):
    """A straight line through samples: value in the middle, slope, their standard errors, and the residuals."""

    mean: float
    slope: float
    mean_error: float
    slope_error: float
    residual: Array
    effective: float


def correlation_samples(residual: Array) -> float:
    """Integrated correlation time of residuals (n,), in samples: 1 for white noise, larger for correlated neighbours.

    Sums of neighbouring pairs of the autocorrelation are added while they are positive (Geyer, Practical Markov Chain
    Monte Carlo, Statistical Science 7, 1992), at most over a third of the record, beyond which none can be estimated.
    """
    n = residual.size
    centred = residual - residual.mean()
    if n < 4 or not np.any(centred):
        return 1.0
    # The scale does not matter; squares of residuals of a log without noise could pass all numbers.
    centred /= np.abs(centred).max()
    spectrum = np.abs(np.fft.rfft(centred, 2 * n)) ** 2
    correlation = np.fft.irfft(spectrum)[: max(n // 3, 2)]
    correlation = correlation / correlation[0]
    pairs = correlation[: 2 * (correlation.size // 2)].reshape(-1, 2).sum(axis=1)
    negative = np.flatnonzero(pairs <= 0.0)
    kept = pairs[: negative[0]] if negative.size else pairs
    return float(np.clip(2.0 * kept.sum() - 1.0, 1.0, n / 2.0))


def fitted_line(time: Array, values: Array) -> Line:
    """Least-squares line through samples (n,), n >= 3; errors allow for the residuals' correlation in time."""
    centred = time - time.mean()
    spread = float(centred @ centred)
    slope = float(centred @ values) / spread
    mean = float(values.mean())
    residual = values - mean - slope * centred
    correlated = correlation_samples(residual)
    effective = max(values.size / correlated, 1.0)
    variance = float(residual @ residual) / max(values.size - 2 * correlated, 1.0)
    mean_error = float(np.sqrt(variance / effective))
    return Line(mean, slope, mean_error, float(np.sqrt(variance * correlated / spread)), residual, effective)
