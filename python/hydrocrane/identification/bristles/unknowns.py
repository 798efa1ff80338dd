"""The unknowns of a fit to a rig's logs, and their priors.
theory: docs/theory/identification/dynamic.md"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.identification.sensors import NUISANCES, OF_A_LOG, RigSensors
from hydrocrane.identification.solve import JointPrior, Unknown
from hydrocrane.identification.static.maps import PARAMETERS, StaticMap
from hydrocrane.identification.static.points import DIRECTIONS
from hydrocrane.identification.static.result import StaticFit
from hydrocrane.logs import Log
from hydrocrane.machine.machine import Machine
from hydrocrane.rig import damping

DYNAMIC = ("bristle-stiffness", "bristle-damping")
# Parameters of the static map that are always free; its exponents are free if they were fitted or if the logs identify
# them.
STATIC = ("coulomb", "breakaway", "stribeck-velocity", "viscous")
# Standard deviation of the static map without a fit, as a share.
UNFITTED = 0.1
# The same with free exponents: viscous friction is between linear and quadratic, and its coefficient, the force at 1
# m/s, depends on the exponent.
UNFITTED_WITH_EXPONENTS = {"viscous-exponent": 0.2, "stribeck-exponent": 0.2, "viscous": 1.0}
# Least standard deviation of a fitted parameter of the map, as a share: the law itself is not more accurate.
BEST_FITTED = 1e-3
# Other parameters of the rig that affect the pressures, with their standard deviations as shares. The lag of a spool
# has a similar effect to bristle damping, and the flow to a shorter displacement.
DOUBTS = {
    ("valve", "nominal-flow"): 0.2,
    ("valve", "natural-frequency"): 0.2,
    ("fluid", "bulk-modulus-max"): 0.2,
    ("cylinder", "leakage-gap"): 0.2,
}
# Keys that take the place of another in some files: oil has a constant bulk modulus, or one that rises to a maximum.
ELSE = {"bulk-modulus-max": "bulk-modulus"}
# Bound of a nuisance: a longer delay, s, is a fault of the recording and not its tolerance.
BOUNDS = {"delay": (-0.01, 0.01)}
# Bounds of a positive quantity: this share of its prior mean, and the mean over this share.
FURTHEST = 0.1


def key_of(rig: Machine, section: str, name: str) -> str:
    """The full key of a rig's only valve, friction or cylinder, or of its fluid."""
    found = [key for key in rig.keys if key.startswith(f"{section}.") and key.endswith(f".{name}")]
    if not found and name in ELSE:
        return key_of(rig, section, ELSE[name])
    if not found:
        raise InputError(
            f"{rig.name} has no `{section}.<name>.{name}`, which a dynamic fit needs; add it as in rig-rottne"
        )
    return found[0]


def check_bristles(rig: Machine) -> None:
    """Checks that a rig has one cylinder with bristle friction."""
    if len(rig.cylinder_names) != 1 or f"cylinder.{rig.cylinder_names[0]}.z" not in rig.state_names:
        raise InputError(
            f"{rig.name} is not a rig with one cylinder and bristle friction; a dynamic fit needs one, with "
            'model = "lugre" and a guess of each parameter in its file, as in rig-rottne'
        )


def number(rig: Machine, key: str) -> float:
    """A value of the machine file, SI."""
    return float(rig.value(key).si)


def rig_map(rig: Machine) -> StaticMap:
    """The static map in a rig's file."""
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
    fitted: JointPrior | None,
    *,
    exponents: bool = False,
) -> tuple[list[Unknown], list[Unknown]]:
    """Keys of the machine, then nuisances of the readings.

    `read` has initial estimates of :data:`DYNAMIC`, `fitted` is the result of :func:`map_prior`. With `exponents` those
    of the static map are free too.
    """
    keys = [_bristle(rig, name, read[name]) for name in DYNAMIC]
    known = {} if fitted is None else dict(zip(fitted.names, fitted.deviations.tolist(), strict=True))
    keys += [
        _static(rig, name, side, known.get(key), UNFITTED_WITH_EXPONENTS.get(name, UNFITTED) if exponents else UNFITTED)
        for (name, side), key in _map_keys(rig, logs).items()
        if name in STATIC or exponents or key in known
    ]
    for (section, name), share in DOUBTS.items():
        key = key_of(rig, section, name)
        keys.append(_about(key, number(rig, key), share * number(rig, key)))
    readings = [
        Unknown(name, 0.0, deviation, (0.0, deviation), BOUNDS.get(name, (-np.inf, np.inf)))
        for name, deviation in zip(NUISANCES, sensors.deviations, strict=True)
    ]
    most = float(np.max(_pair(rig, "breakaway")))
    limits = {"rest.friction": (-most, most)}
    readings += [
        Unknown(f"{name} {k}", 0.0, deviation, (0.0, deviation), limits.get(name, (-np.inf, np.inf)))
        for k in range(len(logs))
        for name, deviation in zip(OF_A_LOG, sensors.of_a_log(rig.supply_pressure, most), strict=True)
    ]
    return keys, readings


def most_damping(rig: Machine) -> float:
    """Largest sigma_1 of a rig, N s/m, with which friction dissipates, with and without fading of the damping."""
    coulomb = float(np.min(rig.value(key_of(rig, "friction", "coulomb")).si))
    fading = [key for key in rig.keys if key.endswith(".bristle-damping-velocity")]
    return damping.most_damping(coulomb, number(rig, fading[0]) if fading else None)


def _about(key: str, value: float, deviation: float) -> Unknown:
    """A positive quantity with the standard deviation of its prior."""
    return Unknown(key, value, deviation, (value, deviation), (FURTHEST * value, value / FURTHEST))


def _bristle(rig: Machine, name: str, read: Sequence[float]) -> Unknown:
    """A bristle parameter without prior; it starts from the initial estimates if these are plausible, else from the
    file."""
    key = key_of(rig, "friction", name)
    own = number(rig, key)
    plausible = [value for value in read if FURTHEST * own < value < own / FURTHEST]
    start = float(np.median(plausible)) if plausible else own
    highest = most_damping(rig) if name == "bristle-damping" else np.inf
    start = min(start, 0.9 * highest)
    return Unknown(key, start, 0.1 * start, bounds=(0.0, highest))


def map_prior(rig: Machine, logs: Sequence[Log], static: StaticFit | None) -> JointPrior | None:
    """Joint prior of the rig's static map from its fit; None without a fit.

    The force at low speed is known far better than Coulomb force, rise and Stribeck velocity alone.
    """
    if static is None or static.spread is None:
        return None
    labels, covariance = list(static.spread.labels), static.covariance.values
    found = {
        (name, side): labels.index(f"{name}.{DIRECTIONS[side]}")
        for name, side in _map_keys(rig, logs)
        if f"{name}.{DIRECTIONS[side]}" in labels
    }
    # A parameter that the fit could not identify has an infinite variance.
    found = {place: i for place, i in found.items() if 0.0 < covariance[i, i] < np.inf}
    if not found:
        return None
    keys = _map_keys(rig, logs)
    mean = np.array([_pair(rig, name)[side] for name, side in found])
    chosen = covariance[np.ix_(list(found.values()), list(found.values()))]
    # The standard deviation is limited to the value of the parameter, and from below by BEST_FITTED.
    less = np.minimum(1.0, mean / np.sqrt(np.diag(chosen)))
    chosen = chosen * np.outer(less, less) + np.diag((BEST_FITTED * mean) ** 2)
    return JointPrior(tuple(keys[place] for place in found), mean, chosen)


def _map_keys(rig: Machine, logs: Sequence[Log]) -> dict[tuple[str, int], str]:
    """Keys of the static map by parameter and side, for the directions in the logs."""
    return {
        (name, side): f"{key_of(rig, 'friction', name)}[{side}]" for name in PARAMETERS for side in _directions(logs)
    }


def _static(rig: Machine, name: str, side: int, deviation: float | None, share: float) -> Unknown:
    """A parameter of the static map; with the `deviation` of a joint prior that includes it, else with a prior of
    relative deviation `share`."""
    value = float(_pair(rig, name)[side])
    found = _about(f"{key_of(rig, 'friction', name)}[{side}]", value, deviation or share * value)
    # Coulomb and break-away force stay on their sides of their mean.
    middle = 0.5 * float(_pair(rig, "coulomb")[side] + _pair(rig, "breakaway")[side])
    bounds = {"coulomb": (0.0, middle), "breakaway": (middle, np.inf)}.get(name, found.bounds)
    return Unknown(found.name, value, found.scale, found.prior if deviation is None else None, bounds)


def _pair(rig: Machine, name: str) -> Array:
    return np.broadcast_to(rig.value(key_of(rig, "friction", name)).si, (2,))


def _directions(logs: Sequence[Log]) -> list[int]:
    """Directions in which the spool is opened, 0 extending, 1 retracting; the logs do not identify friction of the
    other."""
    opened = np.concatenate([log["command"] for log in logs])
    return [side for side, sign in enumerate((1.0, -1.0)) if (sign * opened > 0.0).any()]
