"""Fit of the static friction map to steady points: choice of the form, levels left out.   (119), (122)

Source of the levels left out: cross-validation, Stone, Journal of the Royal Statistical Society B 36, 1974.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize_scalar

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, check_known
from hydrocrane.identification.solve import Inverse, invert
from hydrocrane.identification.static.intervals import BOUND, Solved
from hydrocrane.identification.static.maps import (
    EACH,
    HELD,
    LABELS,
    LINEAR,
    LINEARITY,
    SHARED,
    SPANS,
    Exponents,
    Form,
    FormRequest,
    StaticMap,
)
from hydrocrane.identification.static.points import FrictionPoints, RejectedPoint
from hydrocrane.identification.static.problem import (
    RESOLVED,
    Bias,
    Loss,
    Problem,
    SensorErrors,
    found_share,
    level_means,
    of_the_bulk,
    problem_of,
    scale_of,
    sensor_errors,
    usable_points,
    with_floor,
)
from hydrocrane.identification.static.residuals import HeldOut, residual_analysis, successions
from hydrocrane.identification.static.result import Spread, StaticFit
from hydrocrane.identification.static.warnings import warnings_of

# Iterations of the weights, which depend on the slope of the map and on the estimated scatter.
ROUNDS = 4
# Difference of AICc up to which a form has substantial support (Burnham and Anderson 2002, section 2.6).
SUPPORTED = 2.0
# Relative change of the weights at convergence.
SETTLED = 1e-5


def candidates_of(
    forms: Sequence[Form], stribeck_exponents: Sequence[str], problem: Callable[[Form], Problem]
) -> list[Solved]:
    """Fits of all forms, the best first; the best ones also with the further freedoms of the Stribeck exponent.

    Forms with more unknowns than levels are left out if others have fewer.
    """
    found = _fitted(forms, problem)
    best = min(found, key=lambda candidate: candidate.aicc).form
    if any(best.stribeck):
        alike = [form for form in forms if form.stribeck == best.stribeck]
        more = [replace(form, stribeck_exponent=freedom) for form in alike for freedom in stribeck_exponents]
        found += [c for c in _fitted(more, problem) if c.problem.unknowns <= c.problem.points.levels.count.size]
    found.sort(key=lambda candidate: candidate.aicc)
    # Speeds that do not tell a viscous exponent of 1 from another one are no evidence for the other one.
    near = (c for c in found if c.aicc < found[0].aicc + SUPPORTED and c.form.viscous_exponent == LINEAR)
    first = next(near, found[0])
    return [first, *(c for c in found if c is not first)]


def _fitted(forms: Sequence[Form], problem: Callable[[Form], Problem]) -> list[Solved]:
    problems = [(form, problem(form)) for form in forms]
    least = min((p.unknowns for _, p in problems), default=0)
    return [refined(form, p) for form, p in problems if p.unknowns <= max(p.points.levels.count.size, least)]


def refined(form: Form, problem: Problem) -> Solved:
    """Linear-loss least squares with weights from the slope of the map and the estimated scatter."""
    x, scale, before = problem.begin(problem.start), 1.0, np.zeros(len(problem.points))
    for _ in range(ROUNDS):
        problem = with_floor(problem, x)
        sigma = problem.standard_deviation(problem.theta(x))
        if np.allclose(sigma * scale, before, rtol=SETTLED, atol=0.0):
            break
        before = sigma * scale
        x = problem.solve(x, before).x
        scale = scale_of(problem, x, sigma)[0]
    scale, freedom = scale_of(problem, x, sigma)
    return Solved(problem, x, sigma * scale, form, aicc(problem, x), scale, freedom)


def aicc(problem: Problem, x: Array) -> float:
    """Akaike's information criterion of a fit, of the means of the levels.

    If the levels scatter by their stated errors, the variances are known, and -2 log L + 2 k is unbiased for any number
    of levels. If they scatter more, one variance is estimated, and the correction for few levels applies (Hurvich and
    Tsai, Biometrika 76, 1989). The likelier case counts. The priors of the sensors are part of the likelihood.
    """
    stated = replace(problem, floor=0.0) if problem.free_floor else problem
    sigma = np.maximum(stated.standard_deviation(problem.theta(x)), 1e-9 * float(np.abs(problem.points.force).max()))
    weight, mean, _ = level_means(problem.points, problem.residuals(x)[0], sigma)
    variance = 1.0 / weight
    prior = sum(((x[i] - p.mean) / p.deviation) ** 2 for i, p in enumerate(problem.priors.values(), problem.unknowns))

    def deviance(more: float) -> float:
        total = variance + more
        return float(np.sum(np.log(total) + mean**2 / total) + prior)

    levels, k = mean.size, problem.unknowns
    known = deviance(0.0) + 2.0 * k
    spare = levels - k - 2
    if spare <= 0:
        return known
    largest = np.log(float(np.max(mean**2)) + float(variance.min()))
    found = minimize_scalar(lambda u: deviance(np.exp(u)), bounds=(largest - 25.0, largest + 1.0), method="bounded")
    return min(known, float(found.fun) + 2.0 * (k + 1) * levels / spare)


# Up to this many levels are left out one by one; more are left out in this many groups.
PARTS = 24


def leave_out(fitted: Solved) -> HeldOut | None:
    """Predictions of all levels by a form that was fitted to them; None for a single level.

    Weights and floor are those of the fit to all levels.
    """
    problem, x, sigma = fitted.problem, fitted.x, fitted.sigma
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


# Points with residuals above this many standard deviations of the bulk are left out.
OUTLIER = 5.0
LOSSES = ("soft_l1", "huber", "cauchy", "arctan", "linear")


class MapOptions(TypedDict, total=False):
    """Options of :func:`fit_static` that its callers hand through."""

    exponents: Exponents
    held: Mapping[str, ArrayLike] | None
    bias: Bias
    span: float
    linearity_error: float
    velocity_share: float
    symmetric: bool
    loss: Loss


def fit_static(
    points: FrictionPoints,
    *,
    exponents: Exponents = "chosen",
    held: Mapping[str, ArrayLike] | None = None,
    form: Form | None = None,
    bias: Bias = None,
    span: float = 0.0,
    linearity_error: float = 0.0,
    velocity_share: float = 0.0,
    symmetric: bool = False,
    loss: Loss = "soft_l1",
    floor: float | None = None,
) -> StaticFit:
    """Least-squares fit of both directions at once, robust against uneven levels and outliers.

    The least AICc decides whether a direction has a Stribeck term, how friction falls, and which exponents are free if
    they are not stated. A viscous exponent of 1 is preferred if no other form is better by 2 AICc.
    Intervals are averaged over all forms within 4 AICc of the best; `alternatives` holds the others.

    Parameters
    ----------
    exponents : {"chosen", "fixed", "free"} or dict
        ``"chosen"``: held or free, by the likelihood. ``"fixed"``: held. ``"free"``: both free in each direction. Or a
        dict by key: a number (or one per direction) is the value of a held exponent, ``"free"`` frees it; exponents
        that are not named are held.
    held : dict, optional
        Values, one or one per direction, at which exponents are held by ``"chosen"`` and ``"fixed"``, such as those of
        the rig's file; by default 2 (Stribeck) and 1.5 (viscous).
    form : Form, optional
        Terms to fit without a choice, such as those of another fit (`StaticFit.form`); `exponents` then only gives the
        values of held exponents.
    bias : OffsetPrior or float, or a list with one of these for each log, optional
        Prior of a constant error of the force; a number is its standard deviation, N. The points alone cannot
        distinguish it from Coulomb friction that differs between the directions: the prior determines it and widens the
        intervals. A single prior is an error common to all logs, such as that of sensors that were never calibrated. A
        list holds independent errors, such as those of logs that were calibrated separately;
        :meth:`FrictionPoints.joined` keeps logs apart. None: there is no such error.
    span : float
        Standard deviation of the relative error of each pressure transmitter's span, such as 0.003/sqrt(3) for a bound
        of 0.3 %. The error is uniformly distributed within sqrt(3) times this value, as are `linearity_error` and
        `velocity_share`. Levels at different pressures and equal friction identify the spans; logs at another supply
        pressure do so best. The points need `chambers`.
    linearity_error : float
        Standard deviation of the relative error of the velocity per metre of position, 1/m: the slope of a position
        sensor that reads along a parabola, as 16 linearity/(sqrt(3) range). The points need `position`.
    velocity_share : float
        Standard deviation of a relative error common to all velocities: the span of a position sensor. The scatter does
        not show it; it widens the intervals of Stribeck velocity and viscous coefficient.
    symmetric : bool
        Whether Coulomb and break-away force are the same in both directions. Only then the points identify the offset.
    loss : str
        Loss of the first, robust fit; its outliers are left out of the second fit. ``"linear"`` keeps all points.
    floor : float, optional
        Standard deviation of a whole level about the map, N, beyond the errors of its points. If it is far above these,
        all levels weigh the same; with 0 the weights follow from the errors alone. By default it is estimated from the
        scatter of the levels (Mandel and Paule), or 1 % of the median force with too few levels.

    Returns
    -------
    StaticFit

    Raises
    ------
    InputError
        If an argument is invalid or no point is usable.

    Examples
    --------
    >>> from hydrocrane.identification import StaticMap, fit_static, synthetic_points
    >>> law = StaticMap.of({"coulomb": 157, "breakaway": 250, "stribeck-velocity": 0.019, "viscous": 11260,
    ...                     "viscous-exponent": 1})
    >>> fit_static(synthetic_points(law, seed=1), exponents={"viscous-exponent": 1}).form.stribeck
    (True, True)
    """
    check_known("loss", loss, LOSSES)
    if not (np.isfinite(velocity_share) and velocity_share >= 0.0):
        raise InputError(f"velocity_share needs a standard deviation of zero or more, relative, got {velocity_share}")
    sensors = sensor_errors(points, bias, span, linearity_error)
    best, likeliest = best_map(
        points,
        FormRequest.of(exponents, held),
        form,
        sensors,
        velocity_share=velocity_share,
        symmetric=symmetric,
        loss=loss,
        floor=floor,
    )
    judged = replace(
        best,
        residual_analysis=residual_analysis(likeliest.problem, likeliest.x),
        held_out=leave_out(likeliest),
        successions=successions(likeliest.problem, likeliest.x),
    )
    return replace(judged, warnings=warnings_of(judged, bool(sensors.priors)))


def best_map(
    points: FrictionPoints,
    request: FormRequest,
    form: Form | None,
    sensors: SensorErrors,
    *,
    velocity_share: float = 0.0,
    symmetric: bool = False,
    loss: Loss = "soft_l1",
    floor: float | None = None,
) -> tuple[StaticFit, Solved]:
    """The fit of :func:`fit_static` before it is checked, which takes as long as the fit, and the likeliest form."""
    used, rejected = usable_points(points)

    def problem(of: Form, among: FrictionPoints) -> Problem:
        return problem_of(among, of, request.held, sensors, symmetric, floor)

    forms = [form] if form else list(request.forms(used, symmetric))
    kept, stray = _without_outliers(problem(_largest(forms), used), loss)
    rejected += _numbered(used, stray, points)
    candidates = candidates_of(
        forms, () if form else request.freedoms["stribeck-exponent"][1:], lambda of: problem(of, kept)
    )
    best, *others = (_result(points, candidate, request, rejected, velocity_share) for candidate in candidates)
    return replace(best, alternatives=tuple(others)), candidates[0]


def _largest(forms: Sequence[Form]) -> Form:
    """The form with the most parameters; it decides which points are outliers."""
    return max(forms, key=lambda form: (sum(form.stribeck), (LINEAR, HELD, SHARED, EACH).index(form.viscous_exponent)))


def _without_outliers(problem: Problem, loss: Loss) -> tuple[FrictionPoints, list[tuple[int, float]]]:
    """The points without outliers, and the outliers with their distance in standard deviations of the bulk."""
    points = problem.points
    # With as many unknowns as levels the map follows any point, and the distance has no meaning.
    if loss == "linear" or points.levels.count.size <= problem.unknowns:
        return points, []
    x, sigma = problem.begin(problem.start), problem.standard_deviation(problem.start)
    for _ in range(2):
        x = problem.solve(x, sigma, loss=loss).x
        sigma = of_the_bulk(problem, x)
    distance = np.abs(problem.residuals(x)[0]) / sigma
    stray = distance > OUTLIER
    return points.select(~stray), [(int(i), float(distance[i])) for i in np.flatnonzero(stray)]


def _numbered(used: FrictionPoints, stray: list[tuple[int, float]], points: FrictionPoints) -> list[RejectedPoint]:
    """Outliers by their index among all points."""
    place = np.flatnonzero((points.velocity == 0.0) | (points.speed > RESOLVED * points.velocity_error))
    assert place.size == len(used)
    return [RejectedPoint(int(place[i]), f"{d:.1f} standard deviations off the map of the others") for i, d in stray]


def _result(
    points: FrictionPoints, candidate: Solved, request: FormRequest, rejected: list[RejectedPoint], share: float
) -> StaticFit:
    """A candidate with its covariance, without warnings and alternatives."""
    problem, x, sigma = candidate.problem, candidate.x, candidate.sigma
    theta, slopes = problem.theta(x), problem.residuals(x)[1]
    values = problem.coordinates.to_map(theta).values.reshape(-1, 2).copy()
    for side in (0, 1):
        if not (points.direction == side).any():
            values[:, side] = np.nan
    of_sensors = dict(zip(problem.priors, map(float, x[problem.unknowns :]), strict=True))
    return StaticFit(
        points=points,
        law=StaticMap(values.ravel(), candidate.form.lorentzian),
        form=candidate.form,
        form_text=candidate.form.text(request.held),
        unknowns=problem.unknowns,
        aicc=candidate.aicc,
        offsets=tuple(map(float, x[problem.unknowns :][: len(problem.sensors.offsets)])),
        spans=(of_sensors.get(SPANS[0], 0.0), of_sensors.get(SPANS[1], 0.0)),
        linearity_error=of_sensors.get(LINEARITY, 0.0),
        spread=_spread(problem, theta, slopes / sigma[:, None], candidate.scale, candidate.freedom, share),
        rejected=tuple(sorted(rejected, key=lambda r: r.index)),
        at_bounds=_at_bounds(problem, x),
        solved=candidate,
    )


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
    """Labels of unknowns that ended at a bound."""
    low, high = problem.bounds()
    out = []
    for k in range(problem.unknowns):
        near = 1e-6 * max(abs(x[k]), 1e-3)
        if x[k] - low[k] <= near or high[k] - x[k] <= near:
            out += [LABELS[i] for i in np.flatnonzero(problem.column == k)]
    return tuple(out)
