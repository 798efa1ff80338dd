"""Half width of the interval of an error with several sources: scatter, and errors within bounds of data sheets."""

from __future__ import annotations

import numpy as np
from scipy.stats import t as student

from hydrocrane.arrays import Array

# Points of the grid for the convolution of distributions, and its extent in standard deviations of the scatter.
GRID, FARTHEST = 4001, 12.0
# Bound of a uniform distribution in standard deviations.
BOUND = np.sqrt(3.0)


def reach(level: float, deviation: float, freedom: float, bounds: Array) -> float:
    """Largest error at a confidence `level`, in standard deviations of the sum.

    Parameters
    ----------
    level : float
        As 0.95.
    deviation, freedom : float
        Standard deviation of the part that follows Student's t, and its degrees of freedom; infinite for a normal
        distribution.
    bounds : ndarray, shape (k,)
        Bounds of further errors, each uniformly distributed within them. Such an error never exceeds the bound of a
        data sheet; a normal error of the same deviation exceeds it in one of twelve cases.
    """
    bounds = np.abs(bounds)
    whole = float(np.sqrt(deviation**2 + np.sum(bounds**2) / BOUND**2))
    if whole == 0.0 or not np.isfinite(whole):
        return float(student.ppf(0.5 + level / 2, freedom))
    # The grid does not resolve narrow distributions.
    width = max(deviation / whole, 1e-3)
    bounds = bounds[bounds > 0.02 * whole] / whole
    if not bounds.size:
        return float(student.ppf(0.5 + level / 2, freedom))
    x = np.linspace(0.0, FARTHEST * width + float(bounds.sum()), GRID)
    x = np.concatenate([-x[:0:-1], x])
    below = student.cdf(x / width, freedom)
    for bound in bounds:
        below = _averaged(x, below, bound)
    return float(np.interp(0.5 + level / 2, below, x))


def _averaged(x: Array, below: Array, bound: float) -> Array:
    """A distribution function over x (n,) after the addition of a uniform error within +-`bound`."""
    step = x[1] - x[0]
    area = np.concatenate([[0.0], np.cumsum(0.5 * step * (below[1:] + below[:-1]))])
    # Beyond the grid the function is zero to the left and one to the right.
    upper = np.interp(x + bound, x, area) + np.maximum(x + bound - x[-1], 0.0)
    return np.asarray((upper - np.interp(x - bound, x, area)) / (2.0 * bound))
