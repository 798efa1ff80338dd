"""The graphical construction of Figure 67 on a friction curve, as code.   (121)"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from hydrocrane import InputError
from hydrocrane.arrays import Array
from hydrocrane.identification import FrictionPoints, StaticMap
from hydrocrane.identification.static.maps import EXPONENTS, FAR, PARAMETERS, stribeck_share
from hydrocrane.identification.static.points import DIRECTIONS


class Reading(NamedTuple):
    """A map that was read, and what limits each of its numbers."""

    law: StaticMap
    limits: tuple[str, ...]


def graphical(points: FrictionPoints, *, exponents: Mapping[str, float] | None = None) -> Reading:
    """Read the parameters from the averaged curve, without optimisation.

    Per direction: a straight line of force over \\|v\\|^delta_v through the fast levels gives Coulomb force (where it
    meets zero velocity) and viscous coefficient (its slope); the slowest level, taken for v -> 0, gives the
    break-away force; the Stribeck velocity is where the force without its viscous part has fallen to
    alpha_0 + alpha_1/e   (121). The exponents are taken as given.

    Returns
    -------
    Reading
    """
    taken = {**EXPONENTS, **(exponents or {})}
    pairs = np.full((len(PARAMETERS), 2), np.nan)
    pairs[PARAMETERS.index("stribeck-exponent")] = taken["stribeck-exponent"]
    pairs[PARAMETERS.index("viscous-exponent")] = taken["viscous-exponent"]
    limits: list[str] = []
    for side, name in enumerate(DIRECTIONS):
        here = points.levels.direction == side
        if not here.any():
            limits.append(f"{name}: no points")
            continue
        speed = np.abs(points.levels.velocity[here])
        force = np.abs(points.levels.force[here])
        read, said = _read(speed, force, float(taken["viscous-exponent"]))
        pairs[[0, 1, 2, 4], side] = read
        limits += [f"{name}: {text}" for text in said]
    if np.isnan(pairs[0]).all():
        raise InputError("no friction points to read")
    return Reading(StaticMap(pairs.ravel()), tuple(limits))


def _read(speed: Array, force: Array, exponent: float) -> tuple[list[float], list[str]]:
    """Coulomb, break-away, Stribeck velocity, viscous coefficient of one direction, with warnings."""
    said = []
    if speed.size < 3:
        said.append(f"{speed.size} velocity level(s): Coulomb, Stribeck and viscous friction cannot be distinguished")
    lowest = int(np.argmin(force))
    coulomb, viscous = _line(speed[lowest:], force[lowest:], exponent)
    stribeck = _stribeck_velocity(speed, force - viscous * speed**exponent, coulomb)
    beyond = speed > FAR * stribeck
    if beyond.sum() >= 2:
        coulomb, viscous = _line(speed[beyond], force[beyond], exponent)
        stribeck = _stribeck_velocity(speed, force - viscous * speed**exponent, coulomb)
    else:
        said.append(
            f"fewer than two levels beyond {FAR:g} Stribeck velocities: Coulomb force and viscous coefficient mixed"
        )
    slowest = int(np.argmin(speed))
    breakaway = max(float(force[slowest]), coulomb)
    if speed[slowest] > 0.0:
        lost = 1.0 - stribeck_share(speed[slowest] / stribeck, 2.0)
        said.append(
            f"break-away force read at the slowest level, {speed[slowest] * 1e3:.3g} mm/s, where about "
            f"{100 * lost:.1f} % of the Stribeck rise is gone"
        )
    gap = _gap(speed, stribeck)
    said.append(f"Stribeck velocity read between levels {gap[0] * 1e3:.3g} and {gap[1] * 1e3:.3g} mm/s")
    return [coulomb, breakaway, stribeck, viscous], said


def _line(speed: Array, force: Array, exponent: float) -> tuple[float, float]:
    """Coulomb force and viscous coefficient of a straight line over |v|^exponent; neither below zero."""
    power = speed**exponent
    if speed.size < 2:
        return float(force.min()), 0.0
    slope, start = np.polyfit(power / power.max(), force, 1)
    slope /= power.max()
    if slope < 0.0:
        return float(force.min()), 0.0
    return (float(start), float(slope)) if start > 0.0 else (0.0, float(force @ power / (power @ power)))


def _stribeck_velocity(speed: Array, dry: Array, coulomb: float) -> float:
    """Speed at which `dry` friction falls below coulomb + rise/e, interpolated in the logarithm of the speed
    (121)."""
    order = np.argsort(speed)
    speed, dry = speed[order], dry[order]
    target = coulomb + (dry[0] - coulomb) / np.e
    below = np.flatnonzero(dry <= target)
    moving = speed[speed > 0.0]
    if below.size == 0 or below[0] == 0 or moving.size < 2:
        return float(np.sqrt(moving[0] * moving[-1])) if moving.size else 1e-3
    k = int(below[0])
    if speed[k - 1] == 0.0:
        return float(speed[k])
    share = (dry[k - 1] - target) / (dry[k - 1] - dry[k])
    return float(speed[k - 1] * (speed[k] / speed[k - 1]) ** share)


def _gap(speed: Array, velocity: float) -> tuple[float, float]:
    """The neighbouring levels of a velocity, m/s."""
    slower, faster = speed[speed <= velocity], speed[speed >= velocity]
    return float(slower.max(initial=0.0)), float(faster.min(initial=np.inf))
