"""One interval of several forms of a map, each weighted by its likelihood."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri

from hydrocrane.arrays import Array

Ends = tuple[float, float]


def akaike_weights(aicc: ArrayLike) -> Array:
    """Weights (n,) of models by their criteria (n,); they add up to one (Burnham and Anderson 2002, section 2.9)."""
    behind = np.asarray(aicc, dtype=float) - np.min(aicc)
    weights = np.exp(-0.5 * behind)
    return np.asarray(weights / weights.sum())


def averaged(weights: ArrayLike, values: Sequence[float], intervals: Sequence[Ends], level: float) -> Ends:
    """The interval with probability (1 - level)/2 on either side, averaged over all models by their weights.

    Turek and Fletcher, Computational Statistics and Data Analysis 56, 2012. Each model's distribution is taken as two
    half normal distributions about its value, whose widths follow from both ends of its interval. A single model keeps
    its own interval.

    Parameters
    ----------
    weights : (n,) array_like
        Add up to one.
    values, intervals : sequences of n
        Of each model, finite; the intervals at the confidence `level`.
    """
    outside = 0.5 * (1.0 - level)
    far = -float(ndtri(outside))

    def below(x: float) -> float:
        """Weighted share of all models below x."""
        shares = [
            ndtr(far * (x - value) / max(value - low if x < value else high - value, 1e-12 * (1.0 + abs(value))))
            for value, (low, high) in zip(values, intervals, strict=True)
        ]
        return float(np.dot(np.asarray(weights, dtype=float), shares))

    low, high = min(intervals, key=lambda ends: ends[1] - ends[0])
    lows, highs = [ends[0] for ends in intervals], [ends[1] for ends in intervals]
    width = high - low
    return (
        _between(lows, low, width, lambda x: below(x) - outside),
        _between(highs, high, width, lambda x: below(x) - (1.0 - outside)),
    )


def _between(ends: Sequence[float], near: float, width: float, excess: Callable[[float], float]) -> float:
    """The zero of the excess, between the least and the greatest of the ends.

    Ends may lie many orders of magnitude apart. The search therefore uses the logarithm of the distance from the end
    `near` of the narrowest interval, in units of its `width`.
    """
    target = min(ends) if excess(near) >= 0.0 else max(ends)
    sign = 1.0 if target > near else -1.0
    # At the last end the excess has its final sign for every model; only rounding can hide this.
    if width <= 0.0 or target == near or sign * excess(target) <= 0.0:
        return target

    def place(u: float) -> float:
        return near + sign * width * float(np.expm1(u))

    distance = float(np.log1p(abs(target - near) / width))
    return place(float(brentq(lambda u: sign * excess(place(u)), 0.0, distance, xtol=1e-12)))
