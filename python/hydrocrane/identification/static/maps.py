"""The static friction map as a function of its parameters; the coordinates of its fit; the forms that it may have.
(119)

The law itself is the core's, `crates/physics/src/friction/static_map.rs`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane import _core
from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError, check_known, unknown
from hydrocrane.identification.static.points import DIRECTIONS, FrictionPoints

# In the order of the core; each is a pair (extending, retracting).
PARAMETERS = ("coulomb", "breakaway", "stribeck-velocity", "stribeck-exponent", "viscous", "viscous-exponent")
LABELS = tuple(f"{name}.{direction}" for name in PARAMETERS for direction in DIRECTIONS)
# Default exponents: the choice of the thesis, section 5.1.1.
EXPONENTS = {"stribeck-exponent": 2.0, "viscous-exponent": 1.5}
# Identifiable only if friction decreases with speed.
STRIBECK = ("breakaway", "stribeck-velocity", "stribeck-exponent")
# Identifiable only from more than one speed.
VISCOUS = ("viscous", "viscous-exponent")
# Positive scales, fitted by their logarithms, in which their errors are symmetric.
LOGARITHMIC = ("stribeck-velocity", "stribeck-exponent")
# Stands for the limit v -> 0 of a break-away reading, m/s.
BREAKAWAY_SPEED = 1e-8
# Beyond this many Stribeck velocities the Stribeck effect is negligible (0.2 % with exponent 2).
FAR = 2.5
OFFSET, SPANS, LINEARITY = "offset", ("span.p1", "span.p2"), "linearity"
# Sensor errors that a fit may include; with one offset per log these are offset.1, offset.2 ...
OF_SENSORS = (OFFSET, *SPANS, LINEARITY)


def unit_of(label: str, exponent: float | None = None) -> str:
    """SI unit of a parameter; that of the viscous coefficient depends on its exponent."""
    name = label.split(".")[0]
    if name == "viscous":
        power = "delta" if exponent is None else f"{exponent:g}"
        return "N s/m" if exponent == 1.0 else f"N s^{power}/m^{power}"
    return {"stribeck-velocity": "m/s", "stribeck-exponent": "1", "viscous-exponent": "1"}.get(name, "N")


def stribeck_share(ratio: Array, exponent: float | None) -> Array:
    """Share of the Stribeck rise that is left at this ratio of speed to Stribeck velocity; a Lorentzian has no
    exponent."""
    return 1.0 / (1.0 + ratio**2) if exponent is None else np.exp(-(ratio**exponent))


@dataclass(frozen=True)
class StaticMap:
    """A static friction map.

    Attributes
    ----------
    values : ndarray, shape (12,)
        In the order of :data:`LABELS`, SI.
    lorentzian : bool
        Whether friction falls as 1/(1 + (v/v_s)^2) and not exponentially. Machine files have no such map.
    """

    values: Array
    lorentzian: bool = False

    @classmethod
    def of(cls, pairs: Mapping[str, ArrayLike]) -> StaticMap:
        """From the keys of a machine file, SI; one number stands for both directions. Exponents may be left out."""
        for name in pairs:
            check_known("friction parameter", name, PARAMETERS)
        given = {**EXPONENTS, **pairs}
        missing = [name for name in PARAMETERS if name not in given]
        if missing:
            raise InputError(f"a static friction map needs {', '.join(f'`{name}`' for name in missing)}")
        rows = [np.broadcast_to(real_array(given[name], name), (2,)) for name in PARAMETERS]
        return cls(np.concatenate(rows).astype(float))

    @property
    def pairs(self) -> dict[str, tuple[float, float]]:
        """Keys of a machine file, each (extending, retracting), SI."""
        table = self.values.reshape(-1, 2)
        return {name: (float(a), float(b)) for name, (a, b) in zip(PARAMETERS, table, strict=True)}

    def force(self, v: ArrayLike) -> Array:
        """Friction, N, at steady piston velocity v (...), m/s; positive against positive velocity."""
        velocity = real_array(v, "v")
        return self.evaluate(velocity.ravel())[0].reshape(velocity.shape)

    def evaluate(self, v: Array) -> tuple[Array, Array, Array]:
        """Force (n,) and its derivatives by velocity (n,) and by the parameters (n, 12), at velocities (n,)."""
        table, v = self.values.reshape(6, 2), np.ascontiguousarray(v)
        if not self.lorentzian:
            return _core.friction_map(np.ascontiguousarray(self.values), v)
        # The core's law without a fall, and the fall on top of it.
        force, over_v, over = _core.friction_map(np.concatenate([table[0], table[0], *table[2:]]), v)
        place, side, sign = np.arange(v.size), (v < 0.0).astype(int), np.where(v < 0.0, -1.0, 1.0)
        rise, ratio = (table[1] - table[0])[side], np.abs(v) / table[2, side]
        share = stribeck_share(ratio, None)
        over_speed = 2.0 * rise * ratio * share**2 / table[2, side]
        over[:, :6] = 0.0
        for column, slope in zip((0, 2, 4), (1.0 - share, share, over_speed * ratio), strict=True):
            over[place, column + side] = sign * slope
        return force + sign * rise * share, over_v - over_speed, over

    @property
    def stretched(self) -> Array:
        """(12,) change of each parameter per relative error of all velocities."""
        _, _, speed, _, viscous, power = self.values.reshape(6, 2)
        none = np.zeros(2)
        return np.concatenate([none, none, speed, none, -power * viscous, none])


@dataclass(frozen=True)
class Coordinates:
    """The coordinates of a fit, six per direction, chosen for a well-conditioned search.

    Coulomb force; Stribeck rise (break-away less Coulomb); logarithms of Stribeck velocity and exponent; viscous
    force at the reference speed; viscous exponent. The viscous coefficient itself is a force at 1 m/s, far outside the
    measured range, and correlated with its exponent.

    Attributes
    ----------
    reference_speed : float
        Speed at which the viscous force is stated, m/s: the fastest point.
    lorentzian : bool
        As of the map.
    """

    reference_speed: float
    lorentzian: bool = False

    def to_map(self, theta: Array) -> StaticMap:
        """The map at coordinates (12,)."""
        coulomb, rise, log_speed, log_exponent, top, power = theta.reshape(6, 2)
        viscous = top * self.reference_speed**-power
        values = [coulomb, coulomb + rise, np.exp(log_speed), np.exp(log_exponent), viscous, power]
        return StaticMap(np.concatenate(values), self.lorentzian)

    def of_map(self, law: StaticMap) -> Array:
        """Coordinates (12,) of a map."""
        coulomb, breakaway, speed, exponent, viscous, power = law.values.reshape(6, 2)
        top = viscous * self.reference_speed**power
        return np.concatenate([coulomb, breakaway - coulomb, np.log(speed), np.log(exponent), top, power])

    def slopes(self, theta: Array) -> Array:
        """d(parameters)/d(coordinates), (12, 12)."""
        p = self.to_map(theta).values
        out = np.diag([1.0] * 4 + [*p[4:6], *p[6:8]] + [0.0] * 2 + [1.0] * 2)
        for side in (0, 1):
            top, power = theta[8 + side], theta[10 + side]
            out[2 + side, side] = 1.0
            out[8 + side, 8 + side] = self.reference_speed**-power
            out[8 + side, 10 + side] = -np.log(self.reference_speed) * top * self.reference_speed**-power
        return out


def synthetic_points(
    law: StaticMap,
    *,
    speeds: ArrayLike | None = None,
    windows: ArrayLike = 3,
    force_error: float = 4.0,
    velocity_error: float = 0.005,
    level_error: float = 0.0,
    offset: float = 0.0,
    seed: int = 0,
) -> FrictionPoints:
    """Steady points of both directions with normal errors.

    Parameters
    ----------
    speeds : array_like, optional
        Speed of each level, m/s; by default twelve from 0.1 mm/s to 0.1 m/s, as in the thesis's experiments.
    windows : int or array_like of int
        Windows per level; their speeds lie within 1 % of the level's.
    force_error : float
        Standard error of the force of one window, N.
    velocity_error : float
        Standard error of the velocity, as a share of the velocity.
    level_error : float
        Standard deviation, N, of an error common to all windows of a level; the stated errors of the points do not
        include it.
    offset : float
        Constant error of the force, N.
    """
    chosen = np.atleast_1d(np.geomspace(1e-4, 0.1, 12) if speeds is None else real_array(speeds, "speeds"))
    if (chosen <= 0.0).any():
        raise InputError("speeds must be positive; both directions are made from them")
    count = np.broadcast_to(np.asarray(windows, dtype=int), chosen.shape)
    if (count < 1).any():
        raise InputError("every level needs one window or more")
    rng = np.random.default_rng(seed)
    level = np.repeat(np.arange(2 * chosen.size), np.tile(count, 2))
    true = np.concatenate([chosen, -chosen])[level] * (1.0 + 0.01 * rng.uniform(-1.0, 1.0, level.size))
    shared = level_error * rng.normal(size=2 * chosen.size)[level]
    force = law.force(true) + shared + offset + force_error * rng.normal(size=level.size)
    error = velocity_error * np.abs(true)
    measured = true + error * rng.normal(size=level.size)
    return FrictionPoints.of(measured, force, velocity_error=error, force_error=force_error, source=(f"seed {seed}",))


def of_sensors(label: str) -> bool:
    """Whether a label is that of a sensor error."""
    return label in OF_SENSORS or label.startswith(f"{OFFSET}.")


def fitted_velocity(points: FrictionPoints, linearity_error: float = 0.0) -> Array:
    """Velocities at which a map is compared with points, (n,); break-away readings count as v -> 0.

    A position sensor with a parabolic characteristic has a slope error of `linearity_error` per metre from the middle
    of its range.
    """
    straight = (
        points.velocity if points.position is None else points.velocity * (1.0 - linearity_error * points.position)
    )
    return np.where(points.velocity == 0.0, points.sign * BREAKAWAY_SPEED, straight)


Exponents = Literal["chosen", "fixed", "free"] | Mapping[str, ArrayLike | str]
# An exponent is held, free with one value for both directions, or free in each direction; a viscous one may be held at
# 1, and friction may fall by a Lorentzian, which has no exponent.
HELD, SHARED, EACH = "held", "shared", "each"
LINEAR, LORENTZIAN = "linear", "lorentzian"
CHOICES = ("chosen", "fixed", "free")
# Least number of levels in a direction for Coulomb, break-away, Stribeck velocity and viscous coefficient.
LEAST_LEVELS = 4
# A decrease of friction with speed must exceed the errors of its levels by this factor.
SEEN = 3.0


@dataclass(frozen=True)
class Form:
    """Terms of a static map beside Coulomb and viscous friction.

    Attributes
    ----------
    stribeck : (bool, bool)
        Whether there is a Stribeck term, (extending, retracting).
    stribeck_exponent : {"held", "shared", "each", "lorentzian"}
        Held, free and the same in both directions, or free in each; or no exponential but 1/(1 + (v/v_s)^2).
    viscous_exponent : {"linear", "held", "shared", "each"}
        Held at 1, held at another value, or free.
    """

    stribeck: tuple[bool, bool] = (True, True)
    stribeck_exponent: str = HELD
    viscous_exponent: str = HELD

    @property
    def lorentzian(self) -> bool:
        """Whether friction falls by a Lorentzian; machine files have no such map."""
        return self.stribeck_exponent == LORENTZIAN

    def freedom(self, name: str) -> str:
        """That of an exponent by its key."""
        return {"stribeck-exponent": self.stribeck_exponent, "viscous-exponent": self.viscous_exponent}[name]

    def text(self, held: Mapping[str, Array]) -> str:
        """The form in words, with the values of `held` exponents."""
        sides = [name for name, has in zip(DIRECTIONS, self.stribeck, strict=True) if has]
        stribeck = {0: "no Stribeck term", 1: f"Stribeck term {''.join(sides)} only", 2: "Stribeck term"}[len(sides)]
        stribeck = f"Lorentzian {stribeck}" if self.lorentzian else stribeck
        exponents = ["viscous-exponent", *(["stribeck-exponent"] if sides and not self.lorentzian else [])]
        return ", ".join([stribeck, *(self._exponent(name, held[name]) for name in exponents)])

    def _exponent(self, name: str, value: Array) -> str:
        words = name.replace("-", " ")
        values = " and ".join(f"{v:g}" for v in dict.fromkeys(value))
        held = {LINEAR: f"{words} 1", HELD: f"{words} {values}"}
        return {**held, SHARED: f"{words} free", EACH: f"{words} free in each direction"}[self.freedom(name)]


@dataclass(frozen=True)
class FormRequest:
    """The request for the exponents.

    Attributes
    ----------
    held : dict of (2,) arrays
        Value of each exponent if it is held, (extending, retracting).
    freedoms : dict of tuple of str
        Which freedoms each exponent may have.
    """

    held: dict[str, Array]
    freedoms: dict[str, tuple[str, ...]]

    @classmethod
    def of(cls, exponents: Exponents, held: Mapping[str, ArrayLike] | None = None) -> FormRequest:
        """Checked from the arguments of :func:`~hydrocrane.identification.fit_static`."""
        values = {name: _value(name, value) for name, value in {**EXPONENTS, **(held or {})}.items()}
        if isinstance(exponents, str):
            check_known("choice of exponents", exponents, CHOICES)
            linear = () if (values["viscous-exponent"] == 1.0).all() else (LINEAR,)
            chosen: dict[str, tuple[str, ...]] = {"stribeck-exponent": (HELD, SHARED, LORENTZIAN)}
            chosen["viscous-exponent"] = (*linear, HELD, SHARED, EACH)
            other = (HELD,) if exponents == "fixed" else (EACH,)
            return cls(values, chosen if exponents == "chosen" else dict.fromkeys(EXPONENTS, other))
        if not isinstance(exponents, Mapping):
            raise InputError(
                f"exponents is {', '.join(f'`{name}`' for name in CHOICES)}, or a dict such as "
                f"{{'viscous-exponent': 1}}; got {exponents!r}"
            )
        freedoms: dict[str, tuple[str, ...]] = dict.fromkeys(EXPONENTS, (HELD,))
        for name, value in exponents.items():
            if isinstance(value, str):
                if value != "free":
                    raise unknown(f"value of {name}", value, ("free", "a number"))
                freedoms[_name(name)] = (EACH,)
            else:
                values[name] = _value(name, value)
        return cls(values, freedoms)

    def forms(self, points: FrictionPoints, symmetric: bool) -> Iterator[Form]:
        """All forms that the points may identify, with the fewest free Stribeck exponents that are admitted."""
        measured = [bool((points.direction == side).any()) for side in (0, 1)]
        sides = stribeck_possible(points)
        for pattern in product((False, True), repeat=2):
            if any(has and not can for has, can in zip(pattern, sides, strict=True)):
                continue
            if symmetric and any(sides) and pattern[0] != pattern[1] and all(sides):
                continue
            for viscous in self.freedoms["viscous-exponent"]:
                if viscous != SHARED or all(measured):
                    yield Form((pattern[0], pattern[1]), self.freedoms["stribeck-exponent"][0], viscous)


def stribeck_possible(points: FrictionPoints) -> tuple[bool, bool]:
    """Whether the levels can identify a Stribeck term, (extending, retracting)."""
    enough = [int((points.levels.direction == side).sum()) >= LEAST_LEVELS for side in (0, 1)]
    falls = _falls(points)
    return enough[0] or falls[0], enough[1] or falls[1]


def _falls(points: FrictionPoints) -> tuple[bool, bool]:
    """Whether friction decreases with speed, (extending, retracting)."""
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


def _name(name: str) -> str:
    check_known("exponent", name, EXPONENTS)
    return name


def _value(name: str, value: ArrayLike) -> Array:
    """The value of a held exponent, (2,)."""
    found = real_array(value, _name(name))
    if found.shape not in ((), (1,), (2,)) or not ((found > 0.0) & (found <= 10.0)).all():
        raise InputError(f"{name} must lie between 0 and 10, one number or one per direction, got {found}")
    return np.broadcast_to(found, (2,)).astype(float)
