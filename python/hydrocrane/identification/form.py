"""Forms of a static map: its terms and its free exponents; and the forms that a request admits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError, check_known, unknown
from hydrocrane.identification.points import DIRECTIONS, FrictionPoints
from hydrocrane.identification.static_map import EXPONENTS

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
class Wish:
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
    def of(cls, exponents: Exponents, held: Mapping[str, ArrayLike] | None = None) -> Wish:
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
