"""Fit of the static friction map to steady points.   (119), (122)"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypedDict

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, check_known
from hydrocrane.identification.causes import residual_analysis
from hydrocrane.identification.covariance import invert
from hydrocrane.identification.form import EACH, HELD, LINEAR, SHARED, Exponents, Form, Wish
from hydrocrane.identification.least_squares import (
    Loss,
    Problem,
    SensorErrors,
    found_share,
    of_the_bulk,
    scale_of,
)
from hydrocrane.identification.leave_out import leave_out
from hydrocrane.identification.neighbours import successions
from hydrocrane.identification.points import FrictionPoints
from hydrocrane.identification.profile import Solved
from hydrocrane.identification.reach import BOUND
from hydrocrane.identification.result import LINEARITY, SPANS, RejectedPoint, Spread, StaticFit
from hydrocrane.identification.setup import RESOLVED, Bias, problem_of, sensor_errors, usable_points
from hydrocrane.identification.static_choice import Candidate, candidates_of
from hydrocrane.identification.static_map import LABELS, StaticMap
from hydrocrane.identification.static_warnings import warnings_of

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
        Wish.of(exponents, held),
        form,
        sensors,
        velocity_share=velocity_share,
        symmetric=symmetric,
        loss=loss,
        floor=floor,
    )
    told = replace(
        best,
        residual_analysis=residual_analysis(likeliest.problem, likeliest.x),
        held_out=leave_out(likeliest),
        successions=successions(likeliest.problem, likeliest.x),
    )
    return replace(told, warnings=warnings_of(told, bool(sensors.priors)))


def best_map(
    points: FrictionPoints,
    wish: Wish,
    form: Form | None,
    sensors: SensorErrors,
    *,
    velocity_share: float = 0.0,
    symmetric: bool = False,
    loss: Loss = "soft_l1",
    floor: float | None = None,
) -> tuple[StaticFit, Candidate]:
    """The fit of :func:`fit_static` before it is checked, which takes as long as the fit, and the likeliest form."""
    used, rejected = usable_points(points)

    def problem(of: Form, among: FrictionPoints) -> Problem:
        return problem_of(among, of, wish.held, sensors, symmetric, floor)

    forms = [form] if form else list(wish.forms(used, symmetric))
    kept, stray = _without_outliers(problem(_largest(forms), used), loss)
    rejected += _numbered(used, stray, points)
    candidates = candidates_of(
        forms, () if form else wish.freedoms["stribeck-exponent"][1:], lambda of: problem(of, kept)
    )
    best, *others = (_result(points, candidate, wish, rejected, velocity_share) for candidate in candidates)
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
    points: FrictionPoints, candidate: Candidate, wish: Wish, rejected: list[RejectedPoint], share: float
) -> StaticFit:
    """A candidate with its covariance, without warnings and alternatives."""
    problem, x, sigma = candidate.problem, candidate.x, candidate.sigma
    theta, slopes = problem.theta(x), problem.residuals(x)[1]
    scale, freedom = scale_of(problem, x, sigma)
    values = problem.coordinates.to_map(theta).values.reshape(-1, 2).copy()
    for side in (0, 1):
        if not (points.direction == side).any():
            values[:, side] = np.nan
    of_sensors = dict(zip(problem.priors, map(float, x[problem.unknowns :]), strict=True))
    return StaticFit(
        points=points,
        law=StaticMap(values.ravel(), candidate.form.lorentzian),
        form=candidate.form,
        form_text=candidate.form.text(wish.held),
        unknowns=problem.unknowns,
        aicc=candidate.aicc,
        offsets=tuple(map(float, x[problem.unknowns :][: len(problem.sensors.offsets)])),
        spans=(of_sensors.get(SPANS[0], 0.0), of_sensors.get(SPANS[1], 0.0)),
        linearity_error=of_sensors.get(LINEARITY, 0.0),
        spread=_spread(problem, theta, slopes / (sigma[:, None] * scale), scale, freedom, share),
        rejected=tuple(sorted(rejected, key=lambda r: r.index)),
        at_bounds=_at_bounds(problem, x),
        solved=Solved(problem, x, sigma * scale),
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
