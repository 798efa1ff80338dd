"""Fit of the static friction map to steady points.   (119), (122)"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import OptimizeResult, brentq

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.identification import advice
from hydrocrane.identification.least_squares import Loss, OffsetPrior, Problem, Scatter, invert, scatter
from hydrocrane.identification.points import FrictionPoints
from hydrocrane.identification.profile import Solved
from hydrocrane.identification.result import OFFSET, SPANS, Rejected, Spread, StaticFit
from hydrocrane.identification.setup import RESOLVED, Exponents, problem_of
from hydrocrane.identification.static_map import LABELS, StaticMap

# Points further off than this many standard deviations of the bulk are left out.
OUTLIER = 5.0
# With fewer levels to spare than this the scatter within the levels helps to state the spread.
FEW = 3
# The search starts at the Stribeck velocity that was read off, and at these multiples of it.
STARTS = (1.0, 0.4, 2.5)
ROUNDS = 4


def fit_static(
    points: FrictionPoints,
    *,
    exponents: Exponents = "fixed",
    bias: OffsetPrior | float | None = None,
    span: float = 0.0,
    velocity_share: float = 0.0,
    symmetric: bool = False,
    loss: Loss = "soft_l1",
    floor: float | None = None,
) -> StaticFit:
    """Least-squares fit of both directions at once, safe against uneven levels and stray points.

    Parameters
    ----------
    exponents : {"fixed", "free"} or dict
        Exponents held at 2 (Stribeck) and 1.5 (viscous), or free; or each by name: a number holds it, ``"free"``
        frees it.
    bias : OffsetPrior or float, optional
        What is known of a constant error of the force; a number is its standard deviation, N. The points alone
        cannot tell it from Coulomb friction that differs between the directions: the prior decides, and widens the
        intervals. None: there is no such error.
    span : float
        Standard deviation of the relative error of each pressure transmitter's span, as 0.003/sqrt(3) for a bound of
        0.3 %. Levels at different pressures and equal friction tell the spans apart; logs at another supply pressure
        do so best. The points need `chambers`.
    velocity_share : float
        Standard deviation of an error that all velocities share, relative: the slope of a position sensor that is not
        quite linear. It is not seen in the scatter; Stribeck velocity and viscous coefficient carry it.
    symmetric : bool
        Coulomb and break-away force are the same in both directions. Then, and only then, the points tell the offset.
    loss : str
        Loss of the first, robust fit; what it shows to be stray is left out of the second. ``"linear"`` keeps all.
    floor : float, optional
        Standard deviation of a whole level about the map, N, beyond the errors of its points. Far above these it makes
        all levels weigh the same; 0 weighs by the errors alone. By default it is as large as the scatter of the
        levels asks for (Mandel and Paule), or 1 % of the median force where there are too few levels to say.

    Returns
    -------
    StaticFit
    """
    if not (np.isfinite(velocity_share) and velocity_share >= 0.0):
        raise InputError(f"velocity_share needs a standard deviation of zero or more, relative, got {velocity_share}")
    problem, rejected = problem_of(points, exponents, bias, span, symmetric, loss, floor)
    robust, scale = _robust(problem, loss)
    sigma = problem.standard_deviation(problem.theta(robust.x))
    kept, stray = _without_outliers(problem, robust, sigma * scale, loss)
    kept, solution, sigma = _refine(kept, robust.x, floor is None)
    return _result(points, kept, solution, sigma, rejected + _numbered(problem, stray, points), velocity_share)


def _robust(problem: Problem, loss: Loss) -> tuple[OptimizeResult, float]:
    """The best of several starts under a robust loss, and the scale of the bulk of the residuals."""
    best: OptimizeResult | None = None
    for multiple in STARTS:
        theta = problem.start.copy()
        theta[4:6] += np.log(multiple)
        sigma, scale = problem.standard_deviation(theta), 1.0
        x = problem.begin(theta)
        for _ in range(2):
            found = problem.solve(x, sigma * scale, loss=loss)
            x, sigma = found.x, problem.standard_deviation(problem.theta(found.x))
            scale = _bulk(problem.misfit(x)[0] / sigma, problem.unknowns)
        quality = float(np.sum(np.abs(problem.misfit(x)[0] / sigma)))
        if best is None or quality < best.quality:
            best = found
            best.quality, best.bulk = quality, scale
    assert best is not None
    return best, best.bulk


def _bulk(standardised: Array, unknowns: int) -> float:
    """Standard deviation of the bulk of the residuals, from their median, corrected for the unknowns."""
    n = standardised.size
    freedom = max(n - unknowns, 1)
    scale = 1.4826 * float(np.median(np.abs(standardised))) * np.sqrt(n / freedom)
    return scale if scale > 1e-6 else 1e-6


def _without_outliers(
    problem: Problem, found: OptimizeResult, sigma: Array, loss: Loss
) -> tuple[Problem, list[tuple[int, float]]]:
    """The problem without stray points; each of them with its distance in standard deviations."""
    distance = np.abs(problem.misfit(found.x)[0]) / sigma
    stray = distance > OUTLIER
    # With as many unknowns as levels the map follows any point, so that distance says nothing.
    if loss == "linear" or problem.points.levels.count.size <= problem.unknowns or not stray.any():
        return problem, []
    smaller = replace(problem, points=problem.points.select(~stray))
    return smaller, [(int(i), float(distance[i])) for i in np.flatnonzero(stray)]


def _numbered(problem: Problem, stray: list[tuple[int, float]], points: FrictionPoints) -> list[Rejected]:
    """Stray points by their place among all points."""
    place = np.flatnonzero((points.velocity == 0.0) | (points.speed > RESOLVED * points.velocity_error))
    return [Rejected(int(place[i]), f"{d:.1f} standard deviations off the map of the others") for i, d in stray]


def _refine(problem: Problem, x: Array, free_floor: bool) -> tuple[Problem, OptimizeResult, Array]:
    """Plain least squares with weights that follow the slope of the map and the scatter that was found."""
    scale = 1.0
    for _ in range(ROUNDS):
        if free_floor:
            problem = replace(problem, floor=_floor(problem, x))
        sigma = problem.standard_deviation(problem.theta(x))
        found = problem.solve(x, sigma * scale)
        x = found.x
        scale = max(_scale(scatter(problem.points, problem.misfit(x)[0], sigma, problem.unknowns))[0], 1e-6)
    return problem, found, sigma


def _floor(problem: Problem, x: Array) -> float:
    """Floor at which the levels scatter about the map as expected, N; none where their errors explain it.

    Mandel and Paule, Analytical Chemistry 42, 1970: levels that are known to different precision neither weigh all the
    same nor rule by the precision of their noise alone.
    """
    misfit, theta = problem.misfit(x)[0], problem.theta(x)

    def excess(floor: float) -> float:
        sigma = replace(problem, floor=floor).standard_deviation(theta)
        return scatter(problem.points, misfit, sigma, problem.unknowns).between - 1.0

    if scatter(problem.points, misfit, np.ones(len(problem.points)), problem.unknowns).between_freedom < FEW:
        return problem.floor
    smallest = 1e-9 * float(np.abs(problem.points.force).max())
    # With the whole misfit as the floor nothing is left in excess.
    largest = 10.0 * float(np.abs(misfit).max()) + smallest
    return float(brentq(excess, smallest, largest)) if excess(smallest) > 0.0 else smallest


def _scale(found: Scatter) -> tuple[float, float]:
    """Scatter over expectation, and its degrees of freedom.

    The levels about the map count, because what is common to the points of a level does not average out within it.
    With few levels to spare the points within the levels are taken in; without any, the errors handed in are trusted.
    """
    if found.between_freedom >= FEW:
        return float(np.sqrt(found.between)), float(found.between_freedom)
    freedom = max(found.between_freedom, 0) + found.within_freedom
    if freedom == 0:
        return 1.0, np.inf
    total = np.nan_to_num(found.between) * max(found.between_freedom, 0)
    total += np.nan_to_num(found.within) * found.within_freedom
    return float(np.sqrt(total / freedom)), float(freedom)


def _result(
    points: FrictionPoints,
    problem: Problem,
    found: OptimizeResult,
    sigma: Array,
    rejected: list[Rejected],
    share: float,
) -> StaticFit:
    theta = problem.theta(found.x)
    misfit, slopes = problem.misfit(found.x)
    of_levels = scatter(problem.points, misfit, sigma, problem.unknowns)
    scale, freedom = _scale(of_levels)
    spread = _spread(problem, theta, slopes / (sigma[:, None] * max(scale, 1e-9)), scale, freedom, share)
    values = problem.coordinates.to_map(theta).values.reshape(-1, 2).copy()
    for side in (0, 1):
        if not (points.direction == side).any():
            values[:, side] = np.nan
    of_sensors = dict(zip(problem.priors, map(float, found.x[problem.unknowns :]), strict=True))
    details: dict[str, Any] = {
        "law": StaticMap(values.ravel()),
        "offset": of_sensors.get(OFFSET, 0.0),
        "spans": tuple(of_sensors.get(name, 0.0) for name in SPANS),
        "spread": spread,
        "rejected": tuple(sorted(rejected, key=lambda r: r.index)),
        "at_bounds": _at_bounds(problem, found.x),
        "solved": Solved(problem, found.x, sigma * max(scale, 1e-9)),
    }
    draft = StaticFit(points=points, **details)
    return StaticFit(points=points, warnings=advice.on_fit(draft, of_levels, bool(problem.priors)), **details)


def _spread(problem: Problem, theta: Array, jacobian: Array, scale: float, freedom: float, share: float) -> Spread:
    """Covariance of the free parameters, by label."""
    inverse = invert(jacobian, np.array([prior.deviation for prior in problem.priors.values()]))
    size = problem.unknowns + len(problem.priors)
    over_theta = np.zeros((len(theta), size))
    for i in np.flatnonzero(problem.column >= 0):
        over_theta[i, problem.column[i]] = 1.0
    to_parameters = problem.coordinates.slopes(theta) @ over_theta
    free = (to_parameters != 0.0).any(axis=1)
    labels = [label for i, label in enumerate(LABELS) if free[i] or label in problem.untold]
    rows = to_parameters[[LABELS.index(label) for label in labels]]
    stretched = share * problem.coordinates.to_map(theta).stretched[[LABELS.index(label) for label in labels]]
    stretched = np.append(stretched, np.zeros(len(problem.priors)))
    labels += problem.priors
    rows = np.vstack([rows, np.eye(size)[problem.unknowns :]])
    data = rows @ inverse.from_data @ rows.T
    prior = rows @ inverse.from_prior @ rows.T + np.outer(stretched, stretched)
    blind = (np.abs(rows[:, inverse.undetermined]) > 0.0).any(axis=1)
    unknown_rows = blind | np.isin(labels, problem.untold)
    data[unknown_rows, unknown_rows] = np.inf
    return Spread(tuple(labels), data, prior, freedom, scale, inverse.condition, problem.floor)


def _at_bounds(problem: Problem, x: Array) -> tuple[str, ...]:
    """Labels of unknowns that ended at an edge."""
    low, high = problem.bounds()
    out = []
    for k in range(problem.unknowns):
        near = 1e-6 * max(abs(x[k]), 1e-3)
        if x[k] - low[k] <= near or high[k] - x[k] <= near:
            out += [LABELS[i] for i in np.flatnonzero(problem.column == k)]
    return tuple(out)
