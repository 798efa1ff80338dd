"""Set-up of a fit from its arguments: free and held parameters, weights, start values over a grid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.identification.form import EACH, HELD, LINEAR, LORENTZIAN, SHARED, Form
from hydrocrane.identification.least_squares import OffsetPrior, Problem, SensorErrors
from hydrocrane.identification.points import DIRECTIONS, FrictionPoints
from hydrocrane.identification.result import RejectedPoint
from hydrocrane.identification.static_map import (
    EXPONENTS,
    LABELS,
    PARAMETERS,
    STRIBECK,
    VISCOUS,
    Coordinates,
    stribeck_share,
)

# Stribeck velocities tried, from below the slowest to above the fastest level by this factor; exponents tried.
VELOCITIES, OUTSIDE = 16, 2.0
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
    velocities = np.geomspace(slowest / OUTSIDE, fastest * OUTSIDE, VELOCITIES if form.stribeck[side] else 1)
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
