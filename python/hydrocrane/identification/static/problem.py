"""Weighted least squares of one friction map, in coordinates that a search can handle (122), and its set-up from the
arguments of a fit: free and held parameters, weights, start values over a grid."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, brentq, nnls

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.identification.solve import minimise
from hydrocrane.identification.static.maps import (
    EACH,
    EXPONENTS,
    HELD,
    LABELS,
    LINEAR,
    LINEARITY,
    LORENTZIAN,
    OFFSET,
    PARAMETERS,
    SHARED,
    SPANS,
    STRIBECK,
    VISCOUS,
    Coordinates,
    Form,
    fitted_velocity,
    stribeck_share,
)
from hydrocrane.identification.static.points import DIRECTIONS, FrictionPoints, RejectedPoint
from hydrocrane.logs.noise import BY_MEDIAN

Loss = Literal["soft_l1", "huber", "cauchy", "arctan", "linear"]
# A further residual and its derivatives by the unknowns.
Row = Callable[[Array], tuple[float, Array]]
# Bounds of the exponents; Coulomb force, rise and viscous force are not negative.
STRIBECK_EXPONENT = (0.3, 6.0)
VISCOUS_EXPONENT = (0.3, 3.0)
# The Stribeck velocity may lie outside the measured speeds by this factor.
OUTSIDE = 10.0
# A robust loss departs from the square at this many standard deviations.
BEND = 1.5


@dataclass(frozen=True)
class OffsetPrior:
    """Prior of a constant error of the measured force, N.

    Attributes
    ----------
    deviation : float
        Standard deviation, N.
    mean : float
        Expected error, N; subtract it from the forces beforehand or state it here.
    """

    deviation: float
    mean: float = 0.0

    @classmethod
    def of_pressures(cls, areas: tuple[float, float], deviations: tuple[float, float]) -> OffsetPrior:
        """From the zero errors of two pressure transmitters: A1 b1 - A2 b2.

        Parameters
        ----------
        areas : (float, float)
            Piston-side and rod-side area, m^2.
        deviations : (float, float)
            Standard deviations of the zero errors of p1 and p2, Pa. A data sheet states limits; a uniform distribution
            within them has a standard deviation of limit/sqrt(3). After a zero calibration it is the standard error of
            the mean reading at zero pressure.
        """
        return cls(float(np.hypot(areas[0] * deviations[0], areas[1] * deviations[1])))


@dataclass(frozen=True)
class SensorErrors:
    """Priors of the errors that all readings of a sensor share.

    Attributes
    ----------
    offsets : tuple of OffsetPrior
        Constant force error: one for all logs, or one for each; empty if there is none.
    span : float
        Standard deviation of the relative error of each transmitter's span; zero if there is none.
    linearity_error : float
        Standard deviation of the relative error of the velocity per metre of position, 1/m; zero if there is none.
    """

    offsets: tuple[OffsetPrior, ...] = ()
    span: float = 0.0
    linearity_error: float = 0.0

    @cached_property
    def priors(self) -> dict[str, OffsetPrior]:
        """Mean and standard deviation of each error, in the order of the unknowns."""
        several = len(self.offsets) > 1
        known = {f"{OFFSET}.{k}" if several else OFFSET: prior for k, prior in enumerate(self.offsets, 1)}
        known |= dict.fromkeys(SPANS, OffsetPrior(self.span)) if self.span else {}
        return known | ({LINEARITY: OffsetPrior(self.linearity_error)} if self.linearity_error else {})


@dataclass(frozen=True)
class Problem:
    """Points, which coordinates are free, and how the points are weighted.

    Attributes
    ----------
    points : FrictionPoints
    start : ndarray, shape (12,)
        Start values of the coordinates; held ones keep them.
    column : ndarray of int, shape (12,)
        Number of the unknown of each coordinate, -1 if it is held; two coordinates may share one.
    floor : float
        Standard deviation of a whole level about the map, N. It keeps a level of many points from outweighing others.
    sensors : SensorErrors
        Priors of the sensor errors, which are the last unknowns: offsets, both spans, linearity.
    not_identifiable : tuple of str
        Labels of parameters that were held because they are not identifiable from these points.
    free_floor : bool
        Whether the floor is to be found; `floor` is then a guess.
    """

    points: FrictionPoints
    coordinates: Coordinates
    start: Array
    column: NDArray[np.int_]
    floor: float
    sensors: SensorErrors = SensorErrors()
    not_identifiable: tuple[str, ...] = ()
    free_floor: bool = False

    @property
    def unknowns(self) -> int:
        """Number of free coordinates, without the sensor errors."""
        return int(self.column.max()) + 1

    @property
    def priors(self) -> dict[str, OffsetPrior]:
        """Priors of the sensor errors, in the order of the unknowns."""
        return self.sensors.priors

    @cached_property
    def of_force(self) -> Array:
        """(n, k) force, N, that a unit of each sensor error adds to each point."""
        count = len(self.sensors.offsets)
        columns = [self.points.log == k for k in range(count)] if count > 1 else [np.ones(len(self.points))] * count
        if self.sensors.span and self.points.chambers is not None:
            columns += [self.points.chambers[:, 0], -self.points.chambers[:, 1]]
        return np.stack(columns, axis=-1).astype(float) if columns else np.zeros((len(self.points), 0))

    def theta(self, x: Array) -> Array:
        """All coordinates at the unknowns `x`."""
        free = self.column >= 0
        theta = self.start.copy()
        theta[free] = x[self.column[free]]
        return theta

    def begin(self, theta: Array) -> Array:
        """Unknowns at the coordinates `theta`; the mean where two coordinates share one."""
        x = [float(np.mean(theta[self.column == k])) for k in range(self.unknowns)]
        return np.array(x + [prior.mean for prior in self.priors.values()])

    def bounds(self) -> tuple[Array, Array]:
        """Bounds of the unknowns."""
        moving = self.points.speed[self.points.speed > 0.0]
        ends = (moving.min() / OUTSIDE, moving.max() * OUTSIDE) if moving.size else (1e-6, 1.0)
        low = np.repeat([0.0, 0.0, np.log(ends[0]), np.log(STRIBECK_EXPONENT[0]), 0.0, VISCOUS_EXPONENT[0]], 2)
        high = np.repeat(
            [np.inf, np.inf, np.log(ends[1]), np.log(STRIBECK_EXPONENT[1]), np.inf, VISCOUS_EXPONENT[1]], 2
        )
        first = [int(np.flatnonzero(self.column == k)[0]) for k in range(self.unknowns)]
        extra = np.full(len(self.priors), np.inf)
        return np.concatenate([low[first], -extra]), np.concatenate([high[first], extra])

    def standard_deviation(self, theta: Array) -> Array:
        """Standard deviation of a point, N: force error, velocity error times the slope of the map, its share of the
        floor.

        A level of n points then has the variance floor^2 + sigma^2/n. With a floor far above the errors all levels
        weigh the same, whatever their number of points.
        """
        points = self.points
        slope = self.coordinates.to_map(theta).evaluate(fitted_velocity(points))[1]
        levels = points.levels
        force = np.maximum(points.force_error, levels.error[points.level])
        velocity = np.where(points.velocity == 0.0, 0.0, slope * points.velocity_error)
        return np.sqrt(force**2 + velocity**2 + levels.count[points.level] * self.floor**2)

    def residuals(self, x: Array) -> tuple[Array, Array]:
        """Fitted less measured force (n,), N, and its derivatives by the unknowns."""
        theta, points, of_force = self.theta(x), self.points, self.of_force
        velocity = fitted_velocity(points, float(x[-1]) if self.sensors.linearity_error else 0.0)
        force, over_velocity, over_parameters = self.coordinates.to_map(theta).evaluate(velocity)
        over_theta = over_parameters @ self.coordinates.slopes(theta)
        slopes = np.zeros((len(points), x.size))
        for i in np.flatnonzero(self.column >= 0):
            slopes[:, self.column[i]] += over_theta[:, i]
        shared = slice(self.unknowns, self.unknowns + of_force.shape[1])
        slopes[:, shared] = of_force
        if self.sensors.linearity_error and points.position is not None:
            slopes[:, -1] = -over_velocity * points.velocity * points.position
        return force + of_force @ x[shared] - points.force, slopes

    def solve(self, x: Array, sigma: Array, *, loss: Loss = "linear", extra: Row | None = None) -> OptimizeResult:
        """Minimise from `x`, with points of standard deviation `sigma`, and the residual `extra` if given."""
        low, high = self.bounds()
        inside = np.where(np.isfinite(high), np.clip(x, low, high), np.maximum(x, low))
        return minimise(
            lambda u: self.weighted_residuals(u, sigma, extra),
            inside,
            (low, high),
            x_scale="jac",
            loss=loss,
            f_scale=BEND,
            xtol=1e-10,
            ftol=1e-10,
            gtol=1e-10,
            max_nfev=300,
        )

    def weighted_residuals(self, x: Array, sigma: Array, extra: Row | None = None) -> tuple[Array, Array]:
        """Residuals in standard deviations and their derivatives; the extra one and the sensor priors come last."""
        residuals, slopes = self.residuals(x)
        r, jac = residuals / sigma, slopes / sigma[:, None]
        rows = [extra(x)] if extra else []
        for k, prior in enumerate(self.priors.values(), self.unknowns):
            slope = np.zeros(x.size)
            slope[k] = 1.0 / prior.deviation
            rows.append(((x[k] - prior.mean) / prior.deviation, slope))
        if not rows:
            return r, jac
        values, over_x = zip(*rows, strict=True)
        return np.append(r, values), np.vstack([jac, *over_x])


@dataclass(frozen=True)
class Scatter:
    """Scatter of the levels about a map, relative to the expected one.

    Attributes
    ----------
    between, within : float
        Mean square of the level means about the map and of the points about their level; NaN without degrees of
        freedom.
    between_freedom, within_freedom : int
    """

    between: float
    within: float
    between_freedom: int
    within_freedom: int


def level_means(points: FrictionPoints, residuals: Array, sigma: Array) -> tuple[Array, Array, NDArray[np.intp]]:
    """Weight and weighted mean of the residuals of each level, (n_levels,), and the level of each point, (n,)."""
    weight = sigma**-2
    _, level = np.unique(points.level, return_inverse=True)
    total = np.asarray(np.bincount(level, weight), dtype=np.float64)
    return total, np.asarray(np.bincount(level, weight * residuals) / total), level


def scatter(points: FrictionPoints, residuals: Array, sigma: Array, unknowns: int) -> Scatter:
    """Variances of levels about the map and of points within levels; with independent errors both are equal."""
    total, mean, level = level_means(points, residuals, sigma)
    between_freedom = int(total.size) - unknowns
    within_freedom = len(points) - int(total.size)
    between = float(np.sum(total * mean**2))
    within = float(np.sum(sigma**-2 * (residuals - mean[level]) ** 2))
    return Scatter(
        between / between_freedom if between_freedom > 0 else np.nan,
        within / within_freedom if within_freedom > 0 else np.nan,
        between_freedom,
        within_freedom,
    )


# Least degrees of freedom of the levels for an estimate of the floor; with fewer the scatter within levels is used too.
FEW = 3


def floor_is_found(problem: Problem) -> bool:
    """Whether the scatter of the levels identifies the floor; else the floor is kept and all errors are scaled."""
    return problem.free_floor and _freedom(problem) >= FEW


def of_the_bulk(problem: Problem, x: Array) -> Array:
    """Standard deviation of each point, N, for which the median residual has its expected size.

    A free floor is increased until this holds. It is never negative: a point within its stated errors is no outlier,
    even if the other points happen to lie closer to the map.
    """
    theta, residuals = problem.theta(x), problem.residuals(x)[0]
    sigma = problem.standard_deviation(theta)
    if not floor_is_found(problem):
        return sigma * _bulk(residuals / sigma, problem.unknowns)

    def excess(floor: float) -> float:
        return _bulk(residuals / replace(problem, floor=floor).standard_deviation(theta), problem.unknowns) - 1.0

    return replace(problem, floor=_without(excess, problem, residuals)).standard_deviation(theta)


def with_floor(problem: Problem, x: Array) -> Problem:
    """The problem with the floor for which the levels scatter about the map as expected; zero if the stated errors
    explain the scatter.

    Mandel and Paule, Analytical Chemistry 42, 1970: the weights of levels of different precision follow from their
    stated errors and from a common variance between levels.
    """
    if not floor_is_found(problem):
        return problem
    residuals, theta = problem.residuals(x)[0], problem.theta(x)

    def excess(floor: float) -> float:
        sigma = replace(problem, floor=floor).standard_deviation(theta)
        return scatter(problem.points, residuals, sigma, problem.unknowns).between - 1.0

    return replace(problem, floor=_without(excess, problem, residuals))


def scale_of(problem: Problem, x: Array, sigma: Array) -> tuple[float, float]:
    """Factor on all errors, and degrees of freedom of the quantity estimated from the scatter: this factor or the
    floor.

    If the floor is estimated, it explains the scatter, and the factor is at least one. Else the scatter of the levels
    about the map counts, because errors common to the points of a level do not average out within it. With few degrees
    of freedom of the levels the scatter within the levels is used too. That scatter contains no information on a
    guessed floor, so the factor is then at least one too. Without degrees of freedom the stated errors are used.
    """
    found = scatter(problem.points, problem.residuals(x)[0], sigma, problem.unknowns)
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
    """(n,) share of each point's variance that was estimated from the scatter and not stated."""
    if not floor_is_found(problem):
        return np.ones(sigma.size)
    return problem.points.levels.count[problem.points.level] * (problem.floor / sigma) ** 2


def _freedom(problem: Problem) -> int:
    """Degrees of freedom of the levels."""
    return int(problem.points.levels.count.size) - problem.unknowns


def _bulk(standardised: Array, unknowns: int) -> float:
    """Standard deviation of the bulk of the residuals, from their median, corrected for the unknowns."""
    n = standardised.size
    freedom = max(n - unknowns, 1)
    scale = BY_MEDIAN * float(np.median(np.abs(standardised))) * np.sqrt(n / freedom)
    return scale if scale > 1e-6 else 1e-6


def _without(excess: Callable[[float], float], problem: Problem, residuals: Array) -> float:
    """Floor at which the excess vanishes, N; nearly zero if there is no excess."""
    smallest = 1e-9 * float(np.abs(problem.points.force).max())
    # A floor as large as the largest residual leaves no excess.
    largest = 10.0 * float(np.abs(residuals).max()) + smallest
    return float(brentq(excess, smallest, largest)) if excess(smallest) > 0.0 else smallest


# Stribeck velocities tried, from below the slowest to above the fastest level by this factor; exponents tried.
VELOCITIES, WIDER = 16, 2.0
TRIED = {"stribeck-exponent": (0.7, 1.0, 2.0, 4.0), "viscous-exponent": (0.5, 0.75, 1.0, 1.25, 1.5, 2.0)}
# Least error of a level, as a share of the median force.
SHARE = 0.01


def start(points: FrictionPoints, form: Form, held: Mapping[str, Array], reference: float) -> Array:
    """Start values of the coordinates (12,); a direction without points has those of the other.

    Friction is linear in Coulomb force, Stribeck rise and viscous force. Non-negative least squares over the levels
    finds them for each Stribeck velocity and exponent of the grid.
    """
    tried = {name: _tried(form, name, held[name]) for name in TRIED}
    measured = [side for side in (0, 1) if (points.direction == side).any()]
    grid = list(product(*(range(len(values)) for values in tried.values())))
    found = [[_side(points, side, form, tried, at, reference) for at in grid] for side in measured]
    costs = np.array([[cost for cost, _ in row] for row in found])
    shared = EACH not in (form.stribeck_exponent, form.viscous_exponent)
    best = np.full(len(measured), costs.sum(axis=0).argmin()) if shared else costs.argmin(axis=1)
    theta = np.zeros((6, 2))
    for row, side, k in zip(found, measured, best, strict=True):
        theta[:, side] = row[int(k)][1]
    if len(measured) == 1:
        theta[:, 1 - measured[0]] = theta[:, measured[0]]
    return theta.ravel()


def _tried(form: Form, name: str, held: Array) -> list[Array]:
    """Values of an exponent to try, as pairs."""
    alone = {HELD: held, LORENTZIAN: held, LINEAR: np.ones(2)}.get(form.freedom(name))
    return [np.full(2, value) for value in TRIED[name]] if alone is None else [alone]


def _side(
    points: FrictionPoints,
    side: int,
    form: Form,
    tried: Mapping[str, list[Array]],
    at: tuple[int, ...],
    reference: float,
) -> tuple[float, Array]:
    """Least sum of squares of one direction at given exponents, and its coordinates (6,)."""
    levels = points.levels
    here = levels.direction == side
    speed, force = np.abs(levels.velocity[here]), np.abs(levels.force[here])
    floor = SHARE * float(np.median(np.abs(points.force)))
    weight = 1.0 / np.hypot(levels.error[here] / np.sqrt(levels.count[here]), max(floor, 1e-12))
    fall, power = (float(values[k][side]) for values, k in zip(tried.values(), at, strict=True))
    moving = speed[speed > 0.0]
    slowest, fastest = (float(moving.min()), float(moving.max())) if moving.size else (1e-4, 1e-2)
    velocities = np.geomspace(slowest / WIDER, fastest * WIDER, VELOCITIES if form.stribeck[side] else 1)
    viscous = (speed / reference) ** power
    best, theta = np.inf, np.zeros(6)
    for velocity in velocities:
        rise = stribeck_share(speed / velocity, None if form.lorentzian else fall) * form.stribeck[side]
        columns = np.stack([np.ones_like(speed), rise, viscous], axis=-1)
        sizes, distance = nnls(columns * weight[:, None], force * weight)
        if distance < best:
            best = distance
            theta = np.array([sizes[0], sizes[1], np.log(velocity), np.log(fall), sizes[2], power])
    return best**2, theta


# Prior of the constant error of the force: one for all logs, or one for each.
Bias = OffsetPrior | float | Sequence[OffsetPrior | float] | None
# Least expected deviation of a level from a map, as a share of the median force.
FLOOR_SHARE = 0.01
# Standard deviation, N, that stands for a log without a constant error.
EXACT = 1e-6
# A velocity must exceed its error by this factor for the direction to be known.
RESOLVED = 3.0


def usable_points(points: FrictionPoints) -> tuple[FrictionPoints, list[RejectedPoint]]:
    """The usable points, and the rejected ones."""
    usable = (points.velocity == 0.0) | (points.speed > RESOLVED * points.velocity_error)
    if not usable.any():
        raise InputError("no point has a velocity larger than its error; take longer windows or faster motion")
    rejected = [
        RejectedPoint(int(i), "velocity within its error of zero, direction unknown") for i in np.flatnonzero(~usable)
    ]
    used = points.select(usable)
    if (used.force == 0.0).all():
        raise InputError("every force is zero: nothing was measured, or the force column is the wrong one")
    if (used.velocity == 0.0).all():
        raise InputError("only break-away readings (velocity 0): a map needs the piston to move")
    return used, rejected


def problem_of(
    points: FrictionPoints,
    form: Form,
    held: Mapping[str, Array],
    sensors: SensorErrors,
    symmetric: bool,
    floor: float | None,
) -> Problem:
    """The fit of one form to usable points, with start values."""
    if floor is not None and not (np.isfinite(floor) and floor >= 0.0):
        raise InputError(f"floor must be a force of zero or more, N, got {floor}")
    if symmetric and np.unique(points.direction).size < 2:
        raise InputError(f"symmetric needs points in both directions, but all are {DIRECTIONS[points.direction[0]]}")
    coordinates = Coordinates(float(points.speed.max()), form.lorentzian)
    begin = start(points, form, held, coordinates.reference_speed)
    smallest = 1e-9 * float(np.abs(points.force).max())
    chosen = FLOOR_SHARE * float(np.median(np.abs(points.force))) if floor is None else floor
    can = identifiable(points, form, symmetric)
    # Rise and viscous force are zero if they are not identifiable.
    for row in (PARAMETERS.index("breakaway"), PARAMETERS.index("viscous")):
        begin.reshape(6, 2)[row, ~can[row]] = 0.0
    column = _columns(can, form, symmetric)
    not_identifiable = _not_identifiable(points, can)
    return Problem(points, coordinates, begin, column, max(chosen, smallest), sensors, not_identifiable, floor is None)


def sensor_errors(points: FrictionPoints, bias: Bias, span: float, linearity_error: float) -> SensorErrors:
    """Checked priors of the sensor errors; the points must have the data that they act on."""
    for name, value, unit in (("span", span, "as a share of the reading"), ("linearity_error", linearity_error, "1/m")):
        if not (np.isfinite(value) and value >= 0.0):
            raise InputError(f"{name} needs a standard deviation of zero or more, {unit}, got {value}")
    if span and points.chambers is None:
        raise InputError(
            "span needs the forces of both chambers: take windows of steady_windows, or give FrictionPoints.of chambers"
        )
    if linearity_error and points.position is None:
        raise InputError(
            "linearity_error needs the position of each point: take windows of steady_windows, or give "
            "FrictionPoints.of position"
        )
    if not isinstance(bias, Sequence):
        prior = _prior(bias)
        return SensorErrors(() if prior is None else (prior,), span, linearity_error)
    if len(bias) != points.logs:
        raise InputError(
            f"bias has {len(bias)} entries for points of {points.logs} logs; FrictionPoints.joined keeps logs apart, "
            "and one number stands for a constant error that they share"
        )
    return SensorErrors(tuple(_prior(each) or OffsetPrior(EXACT) for each in bias), span, linearity_error)


def _prior(bias: OffsetPrior | float | None) -> OffsetPrior | None:
    prior = bias if isinstance(bias, OffsetPrior) or bias is None else OffsetPrior(float(bias))
    if prior is None or (prior.deviation == 0.0 and prior.mean == 0.0):
        return None
    if not (np.isfinite(prior.deviation) and prior.deviation > 0.0 and np.isfinite(prior.mean)):
        raise InputError(f"bias needs a standard deviation above zero, N, got {prior.deviation:g}; None for no error")
    return prior


def identifiable(points: FrictionPoints, form: Form, symmetric: bool) -> NDArray[np.bool_]:
    """Which parameters (6, 2) belong to a form and are identifiable from the points; the others are held and
    reported."""
    out = np.ones((len(PARAMETERS), 2), dtype=bool)
    for side in (0, 1):
        moving = (points.levels.direction == side) & (points.levels.velocity != 0.0)
        out[[PARAMETERS.index(name) for name in STRIBECK], side] = form.stribeck[side]
        out[[PARAMETERS.index(name) for name in VISCOUS], side] = moving.sum() > 1
        out[:, side] &= moving.any()
    if symmetric:
        out[PARAMETERS.index("breakaway")] = any(form.stribeck)
    return out


def _columns(can: NDArray[np.bool_], form: Form, symmetric: bool) -> NDArray[np.int_]:
    """Number of the unknown of each coordinate, -1 if it is held."""
    column = np.full((len(PARAMETERS), 2), -1)
    count = 0
    for row, name in enumerate(PARAMETERS):
        freedom = form.freedom(name) if name in EXPONENTS else EACH
        if freedom not in (SHARED, EACH):
            continue
        shared = freedom == SHARED or (symmetric and name in ("coulomb", "breakaway"))
        for side in np.flatnonzero(can[row]):
            column[row, side] = count
            count += not shared
        count += bool(shared and can[row].any())
    return column.ravel()


def _not_identifiable(points: FrictionPoints, can: NDArray[np.bool_]) -> tuple[str, ...]:
    """Labels of the parameters that are not identifiable in a measured direction; exponents do not matter then.

    At one level all friction is fitted as Coulomb friction, which then contains the other terms.
    """
    measured = [bool((points.direction == side).any()) for side in (0, 1)]
    lost = ~can & measured
    lost[PARAMETERS.index("coulomb")] |= lost[PARAMETERS.index("viscous")]
    return tuple(LABELS[i] for i in np.flatnonzero(lost.ravel()) if "exponent" not in LABELS[i])
