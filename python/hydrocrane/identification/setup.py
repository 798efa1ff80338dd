"""What is fitted, from what is asked for: free and held parameters, weights, a place to start."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, unknown
from hydrocrane.identification.graphical import graphical
from hydrocrane.identification.least_squares import OffsetPrior, Problem, SensorErrors
from hydrocrane.identification.points import DIRECTIONS, FrictionPoints
from hydrocrane.identification.result import Rejected
from hydrocrane.identification.static_map import (
    EXPONENTS,
    LABELS,
    PARAMETERS,
    STRIBECK,
    VISCOUS,
    Coordinates,
    StaticMap,
)

# What is known of the constant error of the force: of all logs together, or of each.
Bias = OffsetPrior | float | Sequence[OffsetPrior | float] | None
Exponents = Literal["fixed", "free"] | Mapping[str, float | str]
LOSSES = ("soft_l1", "huber", "cauchy", "arctan", "linear")
# A level is not expected to lie closer to any map than this share of the median force.
FLOOR_SHARE = 0.01
# Standard deviation of the constant error of a log that has none, N.
EXACT = 1e-6
# A direction of motion must stand out of the error of its velocity.
RESOLVED = 3.0
# A fall of friction with speed must stand out of the errors of its levels.
SEEN = 3.0


def problem_of(
    points: FrictionPoints,
    exponents: Exponents,
    sensors: SensorErrors,
    symmetric: bool,
    loss: str,
    floor: float | None,
) -> tuple[Problem, list[Rejected]]:
    """The fit to be solved, and the points that cannot take part."""
    if loss not in LOSSES:
        raise unknown("loss", loss, LOSSES)
    held = _held(exponents)
    usable = (points.velocity == 0.0) | (points.speed > RESOLVED * points.velocity_error)
    if not usable.any():
        raise InputError("no point has a velocity that stands out of its error; take longer windows or faster motion")
    rejected = [
        Rejected(int(i), "velocity within its error of zero, direction unknown") for i in np.flatnonzero(~usable)
    ]
    used = points.select(usable)
    if (used.force == 0.0).all():
        raise InputError("every force is zero: nothing was measured, or the force column is the wrong one")
    if (used.velocity == 0.0).all():
        raise InputError("only break-away readings (velocity 0): a map needs the piston to move")
    coordinates = Coordinates(float(used.speed.max()))
    start = _start(used, held, coordinates)
    if floor is not None and not (np.isfinite(floor) and floor >= 0.0):
        raise InputError(f"floor must be a force of zero or more, N, got {floor}")
    smallest = 1e-9 * float(np.abs(used.force).max())
    chosen = FLOOR_SHARE * float(np.median(np.abs(used.force))) if floor is None else floor
    if symmetric and np.unique(used.direction).size < 2:
        raise InputError(f"symmetric needs points in both directions, but all are {DIRECTIONS[used.direction[0]]}")
    can = identifiable(used, symmetric)
    # Rise and viscous force that are not identifiable are none.
    for row in (PARAMETERS.index("breakaway"), PARAMETERS.index("viscous")):
        start.reshape(6, 2)[row, ~can[row]] = 0.0
    column = _columns(can, held, symmetric)
    not_identifiable = _not_identifiable(used, can)
    return Problem(
        used, coordinates, start, column, max(chosen, smallest), sensors, not_identifiable, floor is None
    ), rejected


def sensor_errors(points: FrictionPoints, bias: Bias, span: float, linearity_error: float) -> SensorErrors:
    """What is known of the sensors, checked: the points must hold what it works on."""
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


def _held(exponents: Exponents) -> dict[str, float | None]:
    """The value at which each exponent is held; None where it is free."""
    if isinstance(exponents, str):
        if exponents not in ("fixed", "free"):
            raise unknown("choice of exponents", exponents, ("fixed", "free"))
        return {name: value if exponents == "fixed" else None for name, value in EXPONENTS.items()}
    held: dict[str, float | None] = dict(EXPONENTS)
    for name, value in exponents.items():
        if name not in EXPONENTS:
            raise unknown("exponent", name, EXPONENTS)
        if isinstance(value, str):
            if value != "free":
                raise unknown(f"value of {name}", value, ("free", "a number"))
            held[name] = None
        elif not 0.0 < value <= 10.0:
            raise InputError(f"{name} must lie between 0 and 10, got {value:g}")
        else:
            held[name] = float(value)
    return held


def _prior(bias: OffsetPrior | float | None) -> OffsetPrior | None:
    prior = bias if isinstance(bias, OffsetPrior) or bias is None else OffsetPrior(float(bias))
    if prior is None or (prior.deviation == 0.0 and prior.mean == 0.0):
        return None
    if not (np.isfinite(prior.deviation) and prior.deviation > 0.0 and np.isfinite(prior.mean)):
        raise InputError(f"bias needs a standard deviation above zero, N, got {prior.deviation:g}; None for no error")
    return prior


def _start(points: FrictionPoints, held: Mapping[str, float | None], coordinates: Coordinates) -> Array:
    """Coordinates read off the curve; a direction without points takes those of the other and is never moved."""
    taken = {name: EXPONENTS[name] if value is None else value for name, value in held.items()}
    pairs = graphical(points, exponents=taken).law.values.reshape(-1, 2).copy()
    empty = np.isnan(pairs[0])
    if empty.any():
        pairs[:, empty] = pairs[:, ~empty]
    return coordinates.of_map(StaticMap(pairs.ravel()))


def stribeck_seen(points: FrictionPoints) -> tuple[bool, bool]:
    """Whether friction is seen to fall with speed, (extending, retracting).

    Where it is not, the Stribeck terms would be free to imitate the bend of the viscous ones.
    """
    levels = points.levels
    error = np.fmax(levels.error, levels.scatter) / np.sqrt(levels.count)
    seen = []
    for side in (0, 1):
        here = np.flatnonzero(levels.direction == side)
        if here.size == 0:
            seen.append(False)
            continue
        force = np.abs(levels.force[here])
        lowest = int(np.argmin(force))
        slower = np.abs(levels.velocity[here]) < abs(levels.velocity[here[lowest]])
        clear = force - force[lowest] > SEEN * np.hypot(error[here], error[here[lowest]])
        seen.append(bool((slower & clear).any()))
    return seen[0], seen[1]


def identifiable(points: FrictionPoints, symmetric: bool) -> NDArray[np.bool_]:
    """Which parameters, (6, 2), are identifiable from the points; the others are held, and said to be unknown."""
    seen = stribeck_seen(points)
    out = np.ones((len(PARAMETERS), 2), dtype=bool)
    for side in (0, 1):
        moving = (points.levels.direction == side) & (points.levels.velocity != 0.0)
        out[[PARAMETERS.index(name) for name in STRIBECK], side] = seen[side]
        out[[PARAMETERS.index(name) for name in VISCOUS], side] = moving.sum() > 1
        out[:, side] &= moving.any()
    if symmetric:
        out[PARAMETERS.index("breakaway")] = any(seen)
    return out


def _columns(can: NDArray[np.bool_], held: Mapping[str, float | None], symmetric: bool) -> NDArray[np.int_]:
    """Number of the unknown behind each coordinate, -1 for those that are held."""
    column = np.full((len(PARAMETERS), 2), -1)
    count = 0
    for row, name in enumerate(PARAMETERS):
        if held.get(name) is not None:
            continue
        shared = symmetric and name in ("coulomb", "breakaway")
        for side in np.flatnonzero(can[row]):
            column[row, side] = count
            count += not shared
        count += bool(shared and can[row].any())
    return column.ravel()


def _not_identifiable(points: FrictionPoints, can: NDArray[np.bool_]) -> tuple[str, ...]:
    """Labels of the parameters that are not identifiable in a measured direction; exponents do not matter then.

    At one level all friction is fitted as Coulomb friction, of which it is the sum with the others.
    """
    measured = [bool((points.direction == side).any()) for side in (0, 1)]
    lost = ~can & measured
    lost[PARAMETERS.index("coulomb")] |= lost[PARAMETERS.index("viscous")]
    return tuple(LABELS[i] for i in np.flatnonzero(lost.ravel()) if "exponent" not in LABELS[i])
