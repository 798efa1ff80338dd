"""One interval of several forms of a map, each weighted by its likelihood."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.stats import norm

from hydrocrane.arrays import Array

Ends = tuple[float, float]


def akaike_weights(aicc: ArrayLike) -> Array:
    """Weights (n,) of models by their criteria (n,); they add up to one (Burnham and Anderson 2002, section 2.9)."""
    behind = np.asarray(aicc, dtype=float) - np.min(aicc)
    weights = np.exp(-0.5 * behind)
    return np.asarray(weights / weights.sum())


def averaged(weights: ArrayLike, values: Sequence[float], intervals: Sequence[Ends], level: float) -> Ends:
    """The interval outside of which the weighted tails of all models hold (1 - level)/2 each.

    Turek and Fletcher, Computational Statistics and Data Analysis 56, 2012. A model's tails are those of a normal
    distribution about its value that has its interval, with a width of its own to either side. The interval of one
    model alone is its own.

    Parameters
    ----------
    weights : (n,) array_like
        Add up to one.
    values, intervals : sequences of n
        Of each model, finite; the intervals at the confidence `level`.
    """
    outside = 0.5 * (1.0 - level)
    far = float(norm.isf(outside))

    def excess(x: float, of: float) -> float:
        below = [
            norm.cdf(far * (x - value) / max(value - low if x < value else high - value, 1e-12 * (1.0 + abs(value))))
            for value, (low, high) in zip(values, intervals, strict=True)
        ]
        return float(np.dot(np.asarray(weights, dtype=float), below)) - of

    return _between([low for low, _ in intervals], excess, outside), _between(
        [high for _, high in intervals], excess, 1.0 - outside
    )


def _between(ends: Sequence[float], excess: Callable[[float, float], float], of: float) -> float:
    """Where the weighted share reaches its aim: between the ends of all models."""
    first, last = min(ends), max(ends)
    if last - first <= 1e-9 * max(abs(first), abs(last)):
        return first
    room = 1e-3 * (last - first)
    return float(brentq(excess, first - room, last + room, args=(of,), xtol=1e-6 * room))
