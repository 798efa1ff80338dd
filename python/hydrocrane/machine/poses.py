"""Poses as people give them: checked against the ranges of the joints, and in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array, vectors
from hydrocrane.errors import InputError

# The unit that people read, with its SI value, by the SI unit; and the larger of the wrong ones that people give.
SHOWN = {"rad": ("deg", math.pi / 180.0), "m": ("mm", 1e-3)}
# A sliding coordinate may lie outside its range by so many ranges: what is to be found are factors of 100 and 1000.
_RANGES = 10.0
# Digits below the leading one of a joint's range that are printed at most.
_DIGITS = 5


class Jointed(Protocol):
    """What a pose is checked against, such as :class:`hydrocrane.Machine`."""

    @property
    def joint_names(self) -> Sequence[str]: ...

    @property
    def joint_units(self) -> Sequence[str]: ...

    @property
    def joint_limits(self) -> Array: ...


def poses(machine: Jointed, value: ArrayLike, name: str = "q") -> Array:
    """`value` as joint coordinates (..., n), rad or m, that may be meant so.

    Geometry and mechanics hold outside the joint ranges too, and what searches a pose may leave them. Refused is what
    no search reaches: an angle more than a full turn outside its range, or more than half a turn if it fits as
    degrees, since every pose has an angle nearer than that; a length outside its range by ten times the range.

    Raises
    ------
    InputError
        With joint, range and the likely unit.
    """
    q = vectors(value, name, machine.joint_names)
    low, high = machine.joint_limits.T
    outside = np.maximum(np.maximum(low - q, q - high), 0.0)
    turning = np.array([unit == "rad" for unit in machine.joint_units])
    smaller = np.array([SHOWN[unit][1] for unit in machine.joint_units])
    fits = (q * smaller >= low) & (q * smaller <= high)
    allowed = np.where(turning, np.where(fits, np.pi, 2.0 * np.pi), _RANGES * (high - low))
    far = np.argwhere(outside > allowed)
    if far.size:
        raise InputError(_far(machine, name, q, tuple(int(i) for i in far[0])))
    return q


def _far(machine: Jointed, name: str, q: Array, place: tuple[int, ...]) -> str:
    joint = place[-1]
    unit = machine.joint_units[joint]
    shown, size = SHOWN[unit]
    low, high = machine.joint_limits[joint]
    meant = {"deg": "degrees", "mm": "millimetres"}[shown]
    return (
        f"{name}: joint {machine.joint_names[joint]} is at {q[place]:g} {unit} and its range is {low:.4g} to "
        f"{high:.4g} {unit} ({low / size:.4g} to {high / size:.4g} {shown}); did you mean {meant}? {name} is in "
        f"{'radians: np.deg2rad(...)' if unit == 'rad' else 'metres'}"
    )


def in_words(machine: Jointed, q: ArrayLike) -> str:
    """A pose as ``boom 100 deg, extension 50 mm``; what is small against the range of its joint is rounding."""
    parts = []
    ranges = np.diff(machine.joint_limits)[:, 0]
    for joint, unit, value, width in zip(machine.joint_names, machine.joint_units, np.asarray(q), ranges, strict=True):
        shown, size = SHOWN[unit]
        digits = _DIGITS - math.floor(math.log10(width / size))
        parts.append(f"{joint} {round(float(value) / size, digits) + 0.0:.4g} {shown}")
    return ", ".join(parts)
