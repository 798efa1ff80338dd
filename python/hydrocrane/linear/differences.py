"""Derivatives of outputs that the core does not differentiate: central differences of order four, with their error.

D(h) = [8 (y(+h) - y(-h)) - (y(+2h) - y(-2h))] / 12 h has the error h^4 y^(5) / 30. The error of D(2h) is 16 times
larger, so D(2h) - D(h) is 15 times the error of D(h) and estimates it. A kink at the point is visible in the second
difference: [y(+h) - 2 y(0) + y(-h)] / h is halved with h if y is smooth, and constant if its slope jumps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import Array

# Relative difference of the slopes on both sides above which there is a kink.
_KINK = 0.05
_OFFSETS = np.array([0.0, 1.0, -1.0, 2.0, -2.0, 4.0, -4.0])


@dataclass(frozen=True)
class Differences:
    """Derivatives (n_outputs, n_variables), the estimate of their error, and where the slope jumps."""

    value: Array
    error: Array
    kinks: np.ndarray


def central(function: Callable[[Array], Array], point: Array, steps: Array) -> Differences:
    """Derivatives of `function` at `point` (n,) with a step (n,) for each variable.

    `function` maps (..., n) to (..., n_outputs).
    """
    moves = _OFFSETS[:, None, None] * np.diag(steps)
    y = function(point + moves)

    def order_four(near: int, far: int, factor: float) -> Array:
        inner, outer = y[near] - y[near + 1], y[far] - y[far + 1]
        return (8 * inner - outer) / (12 * factor * steps[:, None])

    value, coarse = order_four(1, 3, 1.0), order_four(3, 5, 2.0)
    jumps = [np.abs(y[k] - 2 * y[0] + y[k + 1]) / (factor * steps[:, None]) for k, factor in ((1, 1.0), (3, 2.0))]
    sides = np.maximum(np.abs(y[1] - y[0]), np.abs(y[2] - y[0])) / steps[:, None]
    # Rounding also causes second differences.
    floor = 1e-12 * np.abs(y[0]) / steps[:, None]
    kinks = (jumps[0] > _KINK * sides + floor) & (jumps[0] > 0.75 * jumps[1])
    return Differences(value.T, np.abs(coarse - value).T, kinks.T)
