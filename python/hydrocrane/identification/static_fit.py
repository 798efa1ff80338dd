"""Fit of the static friction map to steady points.   (119), (122)"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import OptimizeResult
from scipy.stats import f as fisher

from hydrocrane._moved import renamed_keyword
from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.identification.graphical import FAR
from hydrocrane.identification.least_squares import (
    Loss,
    Problem,
    Scatter,
    found_share,
    invert,
    of_the_bulk,
    scale_of,
    scatter,
    with_floor,
)
from hydrocrane.identification.points import DIRECTIONS, FrictionPoints
from hydrocrane.identification.profile import Solved
from hydrocrane.identification.reach import BOUND
from hydrocrane.identification.result import (
    LINEARITY,
    SPANS,
    Rejected,
    Spread,
    StaticFit,
    missing_directions,
    of_sensors,
)
from hydrocrane.identification.setup import RESOLVED, Bias, Exponents, problem_of, sensor_errors
from hydrocrane.identification.static_map import LABELS, StaticMap

# Points further off than this many standard deviations of the bulk are left out.
OUTLIER = 5.0
# The search starts at the Stribeck velocity that was read off, and at these multiples of it.
STARTS = (1.0, 0.4, 2.5)
ROUNDS = 4


@renamed_keyword("bow", "linearity_error")
def fit_static(
    points: FrictionPoints,
    *,
    exponents: Exponents = "fixed",
    bias: Bias = None,
    span: float = 0.0,
    linearity_error: float = 0.0,
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
    bias : OffsetPrior or float, or a list with one of these for each log, optional
        What is known of a constant error of the force; a number is its standard deviation, N. The points alone
        cannot tell it from Coulomb friction that differs between the directions: the prior decides, and widens the
        intervals. One for all logs is an error that they share, as that of sensors that were never calibrated. A
        list holds errors that are independent, as those of logs that were calibrated each by itself; logs are kept
        apart by :meth:`FrictionPoints.joined`. None: there is no such error.
    span : float
        Standard deviation of the relative error of each pressure transmitter's span, as 0.003/sqrt(3) for a bound of
        0.3 %: evenly likely within sqrt(3) times as much, as `linearity_error` and `velocity_share`. Levels at
        different pressures and equal friction distinguish the spans; logs at another supply pressure do so best. The
        points need `chambers`.
    linearity_error : float
        Standard deviation of the relative error of the velocity per metre of position, 1/m: the slope of a position
        sensor that reads along a parabola, as 16 linearity/(sqrt(3) range). The points need `position`.
    velocity_share : float
        Standard deviation of an error that all velocities share, relative: the span of a position sensor. It is not
        seen in the scatter; Stribeck velocity and viscous coefficient carry it.
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
    sensors = sensor_errors(points, bias, span, linearity_error)
    problem, rejected = problem_of(points, exponents, sensors, symmetric, loss, floor)
    robust, sigma = _robust(problem, loss)
    kept, stray = _without_outliers(problem, robust, sigma, loss)
    kept, solution, sigma = _refine(kept, robust.x)
    return _result(points, kept, solution, sigma, rejected + _numbered(problem, stray, points), velocity_share)


def _robust(problem: Problem, loss: Loss) -> tuple[OptimizeResult, Array]:
    """The best of several starts under a robust loss, and what a point of the bulk may be off, N."""
    best: OptimizeResult | None = None
    for multiple in STARTS:
        theta = problem.start.copy()
        theta[4:6] += np.log(multiple)
        sigma = problem.standard_deviation(theta)
        x = problem.begin(theta)
        for _ in range(2):
            found = problem.solve(x, sigma, loss=loss)
            x, sigma = found.x, of_the_bulk(problem, found.x)
        # Weighted alike for every start, or the start with the widest bulk would win.
        quality = float(np.sum(np.abs(problem.residuals(x)[0] / problem.standard_deviation(problem.theta(x)))))
        if best is None or quality < best.quality:
            best = found
            best.quality, best.sigma = quality, sigma
    assert best is not None
    return best, best.sigma


def _without_outliers(
    problem: Problem, found: OptimizeResult, sigma: Array, loss: Loss
) -> tuple[Problem, list[tuple[int, float]]]:
    """The problem without stray points; each of them with its distance in standard deviations."""
    distance = np.abs(problem.residuals(found.x)[0]) / sigma
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


def _refine(problem: Problem, x: Array) -> tuple[Problem, OptimizeResult, Array]:
    """Plain least squares with weights that follow the slope of the map and the scatter that was found."""
    scale = 1.0
    for _ in range(ROUNDS):
        problem = with_floor(problem, x)
        sigma = problem.standard_deviation(problem.theta(x))
        found = problem.solve(x, sigma * scale)
        x = found.x
        scale = scale_of(problem, x, sigma)[0]
    return problem, found, sigma


def _result(
    points: FrictionPoints,
    problem: Problem,
    found: OptimizeResult,
    sigma: Array,
    rejected: list[Rejected],
    share: float,
) -> StaticFit:
    theta = problem.theta(found.x)
    residuals, slopes = problem.residuals(found.x)
    of_levels = scatter(problem.points, residuals, sigma, problem.unknowns)
    scale, freedom = scale_of(problem, found.x, sigma)
    spread = _spread(problem, theta, slopes / (sigma[:, None] * scale), scale, freedom, share)
    values = problem.coordinates.to_map(theta).values.reshape(-1, 2).copy()
    for side in (0, 1):
        if not (points.direction == side).any():
            values[:, side] = np.nan
    of_sensors = dict(zip(problem.priors, map(float, found.x[problem.unknowns :]), strict=True))
    details: dict[str, Any] = {
        "law": StaticMap(values.ravel()),
        "offsets": tuple(map(float, found.x[problem.unknowns :][: len(problem.sensors.offsets)])),
        "spans": tuple(of_sensors.get(name, 0.0) for name in SPANS),
        "linearity_error": of_sensors.get(LINEARITY, 0.0),
        "spread": spread,
        "rejected": tuple(sorted(rejected, key=lambda r: r.index)),
        "at_bounds": _at_bounds(problem, found.x),
        "solved": Solved(problem, found.x, sigma * scale),
    }
    draft = StaticFit(points=points, **details)
    return StaticFit(points=points, warnings=_warnings(draft, of_levels, bool(problem.priors)), **details)


def _spread(problem: Problem, theta: Array, jacobian: Array, scale: float, freedom: float, share: float) -> Spread:
    """Covariance of the free parameters, by label."""
    inverse = invert(jacobian, np.array([prior.deviation for prior in problem.priors.values()]))
    size = problem.unknowns + len(problem.priors)
    over_theta = np.zeros((len(theta), size))
    for i in np.flatnonzero(problem.column >= 0):
        over_theta[i, problem.column[i]] = 1.0
    to_parameters = problem.coordinates.slopes(theta) @ over_theta
    free = (to_parameters != 0.0).any(axis=1)
    labels = [label for i, label in enumerate(LABELS) if free[i] or label in problem.not_identifiable]
    rows = to_parameters[[LABELS.index(label) for label in labels]]
    stretched = share * problem.coordinates.to_map(theta).stretched[[LABELS.index(label) for label in labels]]
    stretched = np.append(stretched, np.zeros(len(problem.priors)))
    labels += problem.priors
    rows = np.vstack([rows, np.eye(size)[problem.unknowns :]])
    data = rows @ inverse.from_data @ rows.T
    weighted = rows @ inverse.whole @ (jacobian.T * np.sqrt(found_share(problem, problem.standard_deviation(theta))))
    prior = rows @ inverse.from_prior @ rows.T + np.outer(stretched, stretched)
    even = [k for k, name in enumerate(problem.priors) if name in (*SPANS, LINEARITY)]
    bounds = BOUND * np.column_stack([rows @ inverse.over_prior[:, even], stretched])
    blind = (np.abs(rows[:, inverse.undetermined]) > 0.0).any(axis=1)
    unknown_rows = blind | np.isin(labels, problem.not_identifiable)
    data[unknown_rows, unknown_rows] = np.inf
    found = weighted @ weighted.T
    return Spread(tuple(labels), data, prior, found, bounds, freedom, scale, inverse.condition, problem.floor)


def _at_bounds(problem: Problem, x: Array) -> tuple[str, ...]:
    """Labels of unknowns that ended at an edge."""
    low, high = problem.bounds()
    out = []
    for k in range(problem.unknowns):
        near = 1e-6 * max(abs(x[k]), 1e-3)
        if x[k] - low[k] <= near or high[k] - x[k] <= near:
            out += [LABELS[i] for i in np.flatnonzero(problem.column == k)]
    return tuple(out)


# A parameter whose 95 % interval reaches further than this share of its value is called poorly known.
POOR = 0.5
# Above this condition number, columns scaled, parameters stand for each other.
ILL_CONDITIONED = 1e4
# A map that describes the levels scatters this much by chance in one of a hundred cases.
UNLIKELY = 0.01


def _warnings(fit: StaticFit, scatter: Scatter, with_prior: bool) -> tuple[str, ...]:
    """Warnings of a fit, the most fundamental first."""
    return (
        *(f"no points {name}: nothing is known of friction {name}" for name in missing_directions(fit)),
        *_levels(fit),
        *_bounds(fit),
        *_poorly_known(fit),
        *_badly_described(fit, scatter),
        *_of_sensors(fit, with_prior),
        *_rejection(fit),
    )


def _levels(fit: StaticFit) -> Iterator[str]:
    """Where velocities are missing."""
    used = fit.points.select(fit.accepted)
    not_identifiable = [label for label, (low, _) in fit.intervals(method="t").items() if not np.isfinite(low)]
    for side, name in enumerate(DIRECTIONS):
        here = used.levels.direction == side
        speed = np.abs(used.levels.velocity[here])
        if speed.size == 0:
            continue
        stribeck = fit.params["stribeck-velocity"][side]
        if speed.size == 1:
            yield (
                f"{name}: one velocity level only; Coulomb, Stribeck and viscous friction cannot be distinguished, "
                "and all is counted as Coulomb friction"
            )
            continue
        if f"stribeck-velocity.{name}" in not_identifiable:
            yield (
                f"{name}: friction is not seen to fall with speed (slowest level {speed.min() * 1e3:.3g} mm/s), so "
                "Stribeck friction was left out: break-away force and Stribeck velocity stand for nothing measured. "
                "Add slower levels or break-away readings"
            )
            stribeck = 0.0
        elif not (speed < stribeck).any():
            yield (
                f"{name}: no level slower than the Stribeck velocity ({stribeck * 1e3:.3g} mm/s); "
                "break-away force and Stribeck velocity stand for each other: add slower levels"
            )
        if (speed > FAR * stribeck).sum() < 2:
            yield (
                f"{name}: fewer than two levels beyond {FAR:g} Stribeck velocities ({FAR * stribeck * 1e3:.3g} mm/s); "
                "viscous and Coulomb friction cannot be distinguished: add faster levels"
            )


def _bounds(fit: StaticFit) -> Iterator[str]:
    for label in fit.at_bounds:
        name, direction = label.split(".")
        what = "Stribeck rise (break-away less Coulomb)" if name == "breakaway" else name
        yield f"{direction}: {what} ended at the edge of what is physical"


def _poorly_known(fit: StaticFit) -> Iterator[str]:
    for label, (low, high) in fit.intervals(0.95, method="t").items():
        value = fit.value(label)
        if of_sensors(label):
            continue
        if not np.isfinite(low):
            yield f"{label} is not identifiable from these points"
        elif max(high - value, value - low) > POOR * abs(value):
            yield f"{label} is poorly known: {value:.3g}, 95 % interval {low:.3g} to {high:.3g}"
    spread = fit.spread
    if spread is not None and spread.condition > ILL_CONDITIONED:
        yield f"parameters stand for each other: condition number {spread.condition:.2g}; see the correlation"


def _badly_described(fit: StaticFit, scatter: Scatter) -> Iterator[str]:
    if scatter.between_freedom <= 0:
        yield "as many parameters as levels or more: nothing is left to check the map against"
        return
    if scatter.within_freedom <= 0 or scatter.within == 0.0:
        return
    ratio = scatter.between / scatter.within
    chance = float(fisher.sf(ratio, scatter.between_freedom, scatter.within_freedom))
    if chance < UNLIKELY:
        yield (
            f"the levels lie {np.sqrt(ratio):.1f} times further off the map than the points within them scatter "
            f"(chance {chance:.1g}): the map does not describe these data, or something changed between levels"
        )


def _of_sensors(fit: StaticFit, with_prior: bool) -> Iterator[str]:
    """A constant error of the force shifts Coulomb friction of the directions against each other, spans do as well."""
    spread = fit.spread
    if not with_prior or spread is None:
        return
    for label in ("coulomb.extending", "coulomb.retracting"):
        if label in spread.labels:
            at = spread.labels.index(label)
            if spread.from_prior[at, at] > spread.from_data[at, at]:
                yield (
                    "the constant error of the force sensors decides how well Coulomb friction of a single direction "
                    "is known; its sum over both directions is known better. A zero calibration helps"
                    + (", logs at a second supply pressure tell the spans" if any(fit.spans) else "")
                )
                return


def _rejection(fit: StaticFit) -> Iterator[str]:
    if len(fit.rejected) > 0.1 * len(fit.points):
        yield f"{len(fit.rejected)} of {len(fit.points)} points were left out; look at them before trusting the rest"
