"""Cross-validation: levels are left out of a fit and predicted by the same form from the other levels.

Source: cross-validation, Stone, Journal of the Royal Statistical Society B 36, 1974.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hydrocrane.arrays import Array
from hydrocrane.identification.covariance import Inverse, invert
from hydrocrane.identification.held_out import HeldOut
from hydrocrane.identification.least_squares import Problem, level_means, scale_of
from hydrocrane.identification.static_choice import Candidate

# Up to this many levels are left out one by one; more are left out in this many groups.
PARTS = 24


def leave_out(fitted: Candidate) -> HeldOut | None:
    """Predictions of all levels by a form that was fitted to them; None for a single level.

    Weights and floor are those of the fit to all levels.
    """
    problem, x = fitted.problem, fitted.x
    sigma = fitted.sigma * scale_of(problem, x, fitted.sigma)[0]
    points = problem.points
    levels = points.levels
    count = levels.count.size
    if count < 2:
        return None
    fits = min(count, PARTS)
    left = problem.residuals(x)[0]
    _, within, level = level_means(points, left, sigma)
    error, promised = np.full(count, np.nan), np.full(count, np.nan)
    # Levels are numbered by speed, so the levels of a group are not neighbours.
    for part in range(fits):
        out = level % fits == part
        for k, found in _predicted(problem, x, sigma, level, out).items():
            error[k], promised[k] = found
    return HeldOut(
        velocity=levels.velocity,
        direction=levels.direction,
        error=error,
        promised=promised,
        within=-within,
        force=float(np.median(np.abs(points.force))),
        reach=float(np.ptp(levels.force)),
        fits=fits,
    )


def _predicted(
    problem: Problem, x: Array, sigma: Array, level: NDArray[np.intp], out: NDArray[np.bool_]
) -> dict[int, tuple[float, float]]:
    """Measured less predicted force and its standard deviation, N, of each level in `out` that can be predicted."""
    points = problem.points
    rest = replace(problem, points=points.select(~out))
    moved = rest.solve(x, sigma[~out]).x
    residuals = problem.residuals(moved)[0]
    # Derivatives at one point may not show a Stribeck term between two levels.
    places = [_Place.of(problem, at, sigma, out) for at in (moved, x)]
    found = {}
    for k in np.unique(level[out]):
        here = level == k
        if _spare(rest, int(points.direction[here][0])) < 1:
            continue
        weight = sigma[here] ** -2
        weight /= weight.sum()
        own = float(np.sum((weight * sigma[here]) ** 2))
        promised = float(np.sqrt(own + max(place.variance(here, weight) for place in places)))
        if promised < abs(float(weight @ points.force[here])):
            found[int(k)] = -float(weight @ residuals[here]), promised
    return found


@dataclass(frozen=True)
class _Place:
    """Derivatives of all points at given unknowns, and the information of the remaining points on these."""

    slopes: Array
    inverse: Inverse

    @classmethod
    def of(cls, problem: Problem, x: Array, sigma: Array, out: NDArray[np.bool_]) -> _Place:
        slopes = problem.residuals(x)[1]
        deviations = np.array([prior.deviation for prior in problem.priors.values()])
        return cls(slopes, invert(slopes[~out] / sigma[~out, None], deviations))

    def variance(self, here: NDArray[np.bool_], weight: Array) -> float:
        """Variance of the predicted mean of a level, N^2; infinite if it is not determined."""
        slope = weight @ self.slopes[here]
        if (slope[self.inverse.undetermined] != 0.0).any():
            return np.inf
        return float(slope @ self.inverse.whole @ slope)


def _spare(problem: Problem, side: int) -> int:
    """Levels of a direction less the parameters that only this direction has.

    If the difference is zero, a Stribeck term may lie between two levels, and the derivatives at the solution do not
    show it.
    """
    own, other = problem.column[side::2], problem.column[1 - side :: 2]
    levels = np.unique(problem.points.level[problem.points.direction == side])
    return levels.size - np.setdiff1d(own[own >= 0], other).size
