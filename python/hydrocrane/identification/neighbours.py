"""Test of the correlation of a fit's residuals along time and velocity, corrected for the effect of the fit itself.

Source: the ratio of quadratic forms of Durbin and Watson, Biometrika 37, 1950, with its exact mean and variance.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.stats import norm

from hydrocrane.arrays import Array
from hydrocrane.identification.least_squares import Problem, level_means, scatter
from hydrocrane.identification.points import EXTENDING, RETRACTING, FrictionPoints
from hydrocrane.identification.residual_analysis import Succession

# Least number of pairs of neighbours and of degrees of freedom for a test.
LEAST = 6


def successions(problem: Problem, x: Array) -> tuple[Succession, ...]:
    """Correlations of the residuals of a fit at its solution `x`, for each order with enough readings."""
    points = problem.points
    residuals, slopes = problem.residuals(x)
    stated = replace(problem, floor=0.0).standard_deviation(problem.theta(x))
    stated = np.maximum(stated, 1e-9 * float(np.abs(points.force).max()))
    weight, _, level = level_means(points, residuals, stated)
    width = np.sqrt(1.0 / weight + problem.floor**2)
    both = np.column_stack([residuals, slopes[:, : problem.unknowns + len(problem.sensors.offsets)]])
    means = np.stack([level_means(points, column, stated)[1] for column in both.T], axis=-1)
    found = []
    if points.time is not None:
        # The scatter of windows within their level differs from that of levels about the map.
        counts = np.bincount(level)
        total = scatter(points, residuals, stated, problem.unknowns)
        inner = stated * np.sqrt(np.nan_to_num(total.within, nan=1.0) or 1.0)
        outer = np.sqrt(counts) * width * _size(means[:, 0] / width, problem.unknowns)
        white = (both - means[level]) / inner[:, None] + (means / outer[:, None])[level]
        found.append(succession("time", white, _in_time(points)))
    found.append(succession("velocity", means / width[:, None], _by_speed(points, level)))
    return tuple(s for s in found if s is not None)


def _size(means: Array, unknowns: int) -> float:
    """Scatter of standardised means about a map; one without degrees of freedom."""
    spare = means.size - unknowns
    found = float(np.sqrt(np.sum(means**2) / spare)) if spare > 0 else 1.0
    return found if found > 1e-9 else 1.0


def _in_time(points: FrictionPoints) -> Iterator[NDArray[np.intp]]:
    """Indices of the points of each log, in order of time."""
    assert points.time is not None
    for log in range(points.logs):
        here = np.flatnonzero(points.log == log)
        yield here[np.argsort(points.time[here], kind="stable")]


def _by_speed(points: FrictionPoints, level: NDArray[np.intp]) -> Iterator[NDArray[np.intp]]:
    """Indices of the levels of each direction, the slowest first."""
    for side in (EXTENDING, RETRACTING):
        yield np.unique(level[points.direction == side])


def succession(order: str, white: Array, rows: Iterable[NDArray[np.intp]]) -> Succession | None:
    """The correlation of residuals along rows of neighbours; None if there are too few.

    Parameters
    ----------
    order : str
        One of :data:`~hydrocrane.identification.residual_analysis.ORDERS`.
    white : (n, 1 + k) array
        Residuals in standard deviations, then their derivatives by the k fitted unknowns.
    rows : iterable of int arrays
        Indices of residuals, in the order of neighbours.
    """
    pairs = [np.stack([row[:-1], row[1:]]) for row in rows]
    first, second = np.concatenate(pairs, axis=1) if pairs else np.zeros((2, 0), dtype=int)
    residuals, slopes = white[:, 0], white[:, 1:]
    size = np.linalg.norm(slopes, axis=0)
    u, s, _ = np.linalg.svd(slopes / np.where(size > 0.0, size, 1.0), full_matrices=False)
    basis = u[:, s > 1e-9 * s[0]]
    freedom = residuals.size - basis.shape[1]
    power = float(residuals @ residuals)
    if first.size < LEAST or freedom < LEAST or power == 0.0:
        return None
    half = np.full(first.size, 0.5)
    entries = np.concatenate([half, half]), (np.concatenate([first, second]), np.concatenate([second, first]))
    neighbours = coo_array(entries, shape=(residuals.size, residuals.size)).tocsr()
    # Traces of M A and (M A)^2 with A the matrix of neighbours and M = 1 - Q Q^T the projection that removes the fitted
    # part.
    moved = neighbours @ basis
    within = basis.T @ moved
    trace = -float(np.trace(within))
    square = float(np.sum(neighbours.data**2) - 2.0 * np.sum(moved**2) + np.sum(within**2))
    mean = trace / freedom
    variance = (2.0 * square + trace**2) / (freedom * (freedom + 2.0)) - mean**2
    excess = float(residuals @ (neighbours @ residuals)) / power - mean
    # A chain of n has n - 1 pairs: their sum is scaled to the n squares.
    count = residuals.size
    correlation = float(np.clip(excess * count / first.size, -1.0, (count - 1) / (count + 1)))
    return Succession(order, correlation, float(norm.sf(excess / np.sqrt(variance))), count)
