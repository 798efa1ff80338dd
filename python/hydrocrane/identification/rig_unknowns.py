"""What a fit of a rig's logs leaves free, and what is known of it beforehand.
theory: docs/theory/identification/dynamic.md"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.identification.output_error import Unknown
from hydrocrane.identification.points import DIRECTIONS
from hydrocrane.identification.result import StaticFit
from hydrocrane.identification.sensors import NUISANCES, OF_A_LOG, RigSensors
from hydrocrane.identification.static_map import PARAMETERS, StaticMap
from hydrocrane.logs import Log
from hydrocrane.machine.machine import Machine
from hydrocrane.rig import damping

DYNAMIC = ("bristle-stiffness", "bristle-damping")
# Parameters of the static map that go along; its exponents stay as they are.
STATIC = ("coulomb", "breakaway", "stribeck-velocity", "viscous")
# How far the static map may be off where no fit of it is given, as a share.
UNFITTED = 0.1
# How well a fitted parameter of it may be known at best, as a share: the law itself is no better.
BEST_FITTED = 1e-3
# What else of the rig moves the pressures, and how far each may be off its file, as shares. A spool's own lag looks
# like bristle damping, and the flow like a shorter way.
DOUBTS = {
    ("valve", "nominal-flow"): 0.2,
    ("valve", "natural-frequency"): 0.2,
    ("fluid", "bulk-modulus-max"): 0.2,
    ("cylinder", "leakage-gap"): 0.2,
}
# The prior of a positive quantity ends at this share of it; above, at its inverse.
FURTHEST = 0.1


def key_of(rig: Machine, section: str, name: str) -> str:
    """The full key of a rig's only valve, friction or cylinder."""
    found = [key for key in rig.keys if key.startswith(f"{section}.") and key.endswith(f".{name}")]
    if not found:
        raise InputError(
            f"{rig.name} has no `{section}.<name>.{name}`, which a dynamic fit needs; add it as in rig-rottne"
        )
    return found[0]


def check_bristles(rig: Machine) -> None:
    """A rig that can be fitted has one cylinder, and bristles at it."""
    if len(rig.cylinder_names) != 1 or f"cylinder.{rig.cylinder_names[0]}.z" not in rig.state_names:
        raise InputError(
            f"{rig.name} is no rig with one cylinder and bristle friction; a dynamic fit needs one, with "
            'model = "lugre" and a guess of each parameter in its file, as in rig-rottne'
        )


def number(rig: Machine, key: str) -> float:
    """A value of the machine file, SI."""
    return float(rig.value(key).si)


def rig_map(rig: Machine) -> StaticMap:
    """The static map that a rig's file has."""
    return StaticMap.of({name: rig.value(key_of(rig, "friction", name)).si for name in PARAMETERS})


def with_map(rig: Machine, law: StaticMap) -> Machine:
    """The rig with another static map."""
    if not np.isfinite(law.values).all():
        raise InputError(
            "the static map lacks a direction; fit it to logs of the piston extending and retracting first"
        )
    return rig.changed({key_of(rig, "friction", name): list(pair) for name, pair in law.pairs.items()})


def with_values(rig: Machine, keys: Sequence[str], values: Array) -> Machine:
    """The rig with other values of some keys, SI; ``[0]`` and ``[1]`` are the sides of a pair."""
    return rig.changed(rig.overrides_at(keys, values))


def unknowns_of(
    rig: Machine,
    logs: Sequence[Log],
    sensors: RigSensors,
    read: Mapping[str, Sequence[float]],
    static: StaticFit | None,
) -> tuple[list[Unknown], list[Unknown]]:
    """Keys of the machine, then nuisances of the readings; `read` has first readings of :data:`DYNAMIC`."""
    keys = [_bristle(rig, name, read[name]) for name in DYNAMIC]
    keys += [_static(rig, name, side, static) for name in STATIC for side in _directions(logs)]
    for (section, name), share in DOUBTS.items():
        key = "fluid." + name if section == "fluid" else key_of(rig, section, name)
        keys.append(_about(key, number(rig, key), share * number(rig, key)))
    readings = [
        Unknown(name, 0.0, deviation, (0.0, deviation))
        for name, deviation in zip(NUISANCES, sensors.deviations, strict=True)
    ]
    readings += [
        Unknown(f"{name} {k}", 0.0, deviation, (0.0, deviation))
        for k in range(len(logs))
        for name, deviation in zip(OF_A_LOG, sensors.of_a_log(rig.supply_pressure), strict=True)
    ]
    return keys, readings


def most_damping(rig: Machine) -> float:
    """Largest sigma_1 of a rig, N s/m, with which friction dissipates, whether or not its damping fades."""
    coulomb = float(np.min(rig.value(key_of(rig, "friction", "coulomb")).si))
    fading = [key for key in rig.keys if key.endswith(".bristle-damping-velocity")]
    return damping.most_damping(coulomb, number(rig, fading[0]) if fading else None)


def _about(key: str, value: float, deviation: float) -> Unknown:
    """A positive quantity known within a deviation."""
    return Unknown(key, value, deviation, (value, deviation), (FURTHEST * value, value / FURTHEST))


def _bristle(rig: Machine, name: str, read: Sequence[float]) -> Unknown:
    """Without prior; from the readings where these are plausible, else from the file."""
    key = key_of(rig, "friction", name)
    own = number(rig, key)
    plausible = [value for value in read if FURTHEST * own < value < own / FURTHEST]
    start = float(np.median(plausible)) if plausible else own
    highest = most_damping(rig) if name == "bristle-damping" else np.inf
    start = min(start, 0.9 * highest)
    return Unknown(key, start, 0.1 * start, bounds=(0.0, highest))


def _static(rig: Machine, name: str, side: int, static: StaticFit | None) -> Unknown:
    key = key_of(rig, "friction", name)
    value = float(_pair(rig, name)[side])
    found = _about(f"{key}[{side}]", value, _deviation(static, f"{name}.{DIRECTIONS[side]}", value))
    # Coulomb and break-away force stay on their sides of the middle between them.
    middle = 0.5 * float(_pair(rig, "coulomb")[side] + _pair(rig, "breakaway")[side])
    bounds = {"coulomb": (0.0, middle), "breakaway": (middle, np.inf)}.get(name, found.bounds)
    return Unknown(found.name, value, found.scale, found.prior, bounds)


def _pair(rig: Machine, name: str) -> Array:
    return np.broadcast_to(rig.value(key_of(rig, "friction", name)).si, (2,))


def _directions(logs: Sequence[Log]) -> list[int]:
    """Directions in which the spool is opened, 0 extending, 1 retracting: of the other's friction nothing is seen."""
    opened = np.concatenate([log["command"] for log in logs])
    return [side for side, sign in enumerate((1.0, -1.0)) if (sign * opened > 0.0).any()]


def _deviation(static: StaticFit | None, label: str, value: float) -> float:
    """Standard deviation of a parameter of the static map."""
    if static is not None and static.spread is not None and label in static.spread.labels:
        i = static.spread.labels.index(label)
        variance = float(static.covariance.values[i, i])
        if np.isfinite(variance) and variance > 0.0:
            return float(np.clip(np.sqrt(variance), BEST_FITTED * value, value))
    return UNFITTED * value
