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
# A pose may lie outside the range of a joint by this share of the range: for readings with a wrong zero, and for
# searches. An angle in degrees or a length in millimetres, unless it is small, lies further outside.
_BEYOND = 0.5
# In a motion without end stops a sliding coordinate may lie outside its range by so many ranges.
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

    @property
    def state_names(self) -> Sequence[str]: ...


def poses(machine: Jointed, value: ArrayLike, name: str = "q", *, units_stated: bool = False) -> Array:
    """`value` as poses (..., n), rad or m, of which each joint lies at most half its range outside it.

    Raises
    ------
    InputError
        With joint, range and, unless `units_stated`, the likely unit.
    """
    q = vectors(value, name, machine.joint_names)
    low, high = machine.joint_limits.T
    return _within(machine, q, name, np.broadcast_to(_BEYOND * (high - low), q.shape), hint=not units_stated)


def in_motion(machine: Jointed, value: ArrayLike, name: str = "q") -> Array:
    """`value` as joint coordinates (..., n), rad or m, to which a motion without end stops may lead.

    Refused is an angle more than a full turn outside its range, or more than half a turn if it fits as degrees, since
    every pose has an angle nearer than that; and a length outside its range by ten times the range.

    Raises
    ------
    InputError
        As :func:`poses`.
    """
    q = vectors(value, name, machine.joint_names)
    low, high = machine.joint_limits.T
    turning = np.array([unit == "rad" for unit in machine.joint_units])
    smaller = np.array([SHOWN[unit][1] for unit in machine.joint_units])
    fits = (q * smaller >= low) & (q * smaller <= high)
    return _within(
        machine, q, name, np.where(turning, np.where(fits, np.pi, 2.0 * np.pi), _RANGES * (high - low)), hint=True
    )


def states(machine: Jointed, value: ArrayLike, name: str = "state") -> Array:
    """`value` as states (..., n_states) with joint coordinates as those of :func:`in_motion`."""
    state = vectors(value, name, machine.state_names)
    in_motion(machine, state[..., : len(machine.joint_names)], name)
    return state


def _within(machine: Jointed, q: Array, name: str, allowed: Array, *, hint: bool) -> Array:
    """`q`, unless a joint lies outside its range by more than `allowed`."""
    low, high = machine.joint_limits.T
    far = np.argwhere(np.maximum(low - q, q - high) > allowed)
    if not far.size:
        return q
    place = tuple(int(i) for i in far[0])
    joint, value = place[-1], q[place]
    unit = machine.joint_units[joint]
    shown, size = SHOWN[unit]
    low, high = machine.joint_limits[joint]
    # Limits that are found by halving may be zero but for rounding.
    ends = [round(float(end), 9) for end in (low, high)]
    of_range = " to ".join(f"{end:.4g}" for end in ends)
    as_shown = " to ".join(f"{end / size:.4g}" for end in ends)
    text = (
        f"{name}: joint {machine.joint_names[joint]} is at {value:g} {unit} ({value / size:.4g} {shown}) and its range "
        f"is {of_range} {unit} ({as_shown} {shown})"
    )
    if hint:
        meant = {"deg": "degrees", "mm": "millimetres"}[shown]
        cure = "radians: np.deg2rad(...)" if unit == "rad" else "metres"
        cure = "radians, metres and pascals" if name == "state" else cure
        text = f"{text}; did you mean {meant}? {name} is in {cure}"
    else:
        text = f"{text}; choose a pose inside it"
    raise InputError(text)


def in_words(machine: Jointed, q: ArrayLike) -> str:
    """A pose as ``boom 100 deg, extension 50 mm``; what is small against the range of its joint is rounding."""
    parts = []
    ranges = np.diff(machine.joint_limits)[:, 0]
    for joint, unit, value, width in zip(machine.joint_names, machine.joint_units, np.asarray(q), ranges, strict=True):
        shown, size = SHOWN[unit]
        digits = _DIGITS - math.floor(math.log10(width / size))
        parts.append(f"{joint} {round(float(value) / size, digits) + 0.0:.4g} {shown}")
    return ", ".join(parts)
