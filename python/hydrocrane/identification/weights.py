"""How far points may lie off a map: errors as stated, and what the scatter of the levels asks for beyond them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from hydrocrane.arrays import Array
from hydrocrane.identification.least_squares import Problem, scatter

# With fewer levels to spare than this the floor is not found, and the scatter within the levels helps to scale.
FEW = 3


def floor_is_found(problem: Problem) -> bool:
    """Whether the scatter of the levels tells the floor; else it stays, and all errors are scaled alike."""
    return problem.free_floor and _freedom(problem) >= FEW


def of_the_bulk(problem: Problem, x: Array) -> Array:
    """Standard deviation of each point, N, at which the median residual is as large as it should be.

    A floor that is found grows until it is. It is never less than none: a point within its stated errors is not stray,
    however close the others lie by chance.
    """
    theta, misfit = problem.theta(x), problem.misfit(x)[0]
    sigma = problem.standard_deviation(theta)
    if not floor_is_found(problem):
        return sigma * _bulk(misfit / sigma, problem.unknowns)

    def excess(floor: float) -> float:
        return _bulk(misfit / replace(problem, floor=floor).standard_deviation(theta), problem.unknowns) - 1.0

    return replace(problem, floor=_without(excess, problem, misfit)).standard_deviation(theta)


def with_floor(problem: Problem, x: Array) -> Problem:
    """The problem with the floor at which the levels scatter about the map as expected; none where errors explain it.

    Mandel and Paule, Analytical Chemistry 42, 1970: levels that are known to different precision neither weigh all the
    same nor rule by the precision of their noise alone.
    """
    if not floor_is_found(problem):
        return problem
    misfit, theta = problem.misfit(x)[0], problem.theta(x)

    def excess(floor: float) -> float:
        sigma = replace(problem, floor=floor).standard_deviation(theta)
        return scatter(problem.points, misfit, sigma, problem.unknowns).between - 1.0

    return replace(problem, floor=_without(excess, problem, misfit))


def scale_of(problem: Problem, x: Array, sigma: Array) -> tuple[float, float]:
    """Factor of all errors, and the degrees of freedom of what was found in the scatter: this factor or the floor.

    A floor that is found explains the scatter, and errors as stated are never made smaller. Else the levels about the
    map count, because what is common to the points of a level does not average out within it. With few levels to spare
    the points within the levels are taken in; they say nothing of a floor that is guessed, so that it is not made
    smaller either. Without any points to spare, the errors handed in are trusted.
    """
    found = scatter(problem.points, problem.misfit(x)[0], sigma, problem.unknowns)
    if floor_is_found(problem):
        return 1.0, float(found.between_freedom)
    if found.between_freedom >= FEW:
        return max(float(np.sqrt(found.between)), 1e-6), float(found.between_freedom)
    freedom = max(found.between_freedom, 0) + found.within_freedom
    if freedom == 0:
        return 1.0, np.inf
    total = np.nan_to_num(found.between) * max(found.between_freedom, 0)
    total += np.nan_to_num(found.within) * found.within_freedom
    return max(float(np.sqrt(total / freedom)), 1.0 if problem.free_floor else 1e-6), float(freedom)


def found_share(problem: Problem, sigma: Array) -> Array:
    """(n,) share of each point's variance that was found in the scatter instead of stated."""
    if not floor_is_found(problem):
        return np.ones(sigma.size)
    return problem.points.levels.count[problem.points.level] * (problem.floor / sigma) ** 2


def _freedom(problem: Problem) -> int:
    """Levels to spare."""
    return int(problem.points.levels.count.size) - problem.unknowns


def _bulk(standardised: Array, unknowns: int) -> float:
    """Standard deviation of the bulk of the residuals, from their median, corrected for the unknowns."""
    n = standardised.size
    freedom = max(n - unknowns, 1)
    scale = 1.4826 * float(np.median(np.abs(standardised))) * np.sqrt(n / freedom)
    return scale if scale > 1e-6 else 1e-6


def _without(excess: Callable[[float], float], problem: Problem, misfit: Array) -> float:
    """Floor at which nothing is left in excess, N; next to none where there is no excess at all."""
    smallest = 1e-9 * float(np.abs(problem.points.force).max())
    # With the whole misfit as the floor nothing is left in excess.
    largest = 10.0 * float(np.abs(misfit).max()) + smallest
    return float(brentq(excess, smallest, largest)) if excess(smallest) > 0.0 else smallest
