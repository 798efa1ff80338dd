"""The unknowns of a fit to a rig's logs with their priors, and initial estimates of the bristle parameters from a ramp
and a step, without a simulation.                             theory: docs/theory/identification/dynamic.md

The bristle deflection is the part of the piston's displacement in which the seal does not slip,

    z(t) = z(0) + int (1 - sgn(v) F / g(v)) dx,                         thesis (124), (125) with the sign of E18

where F is the measured friction force. From rest with straight bristles, F = c t and g = alpha_0 + alpha_1, this is
x - c/(alpha_0 + alpha_1) (x t - int x dt), (125) as corrected. Then

    sigma_0: slope of F over z while the piston creeps                                  (123), (126)
    sigma_1: slope of F - sigma_0 z - F_v(v) over dz/dt just after a step               (127)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

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
from hydrocrane.rig.friction import most_damping as bound_of_damping
from hydrocrane.signals import RigParameters, friction_force

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
    return bound_of_damping(coulomb, number(rig, fading[0]) if fading else None)


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


# The spool counts as open beyond this share of its largest opening.
OPEN = 1e-3
# Number of samples before the opening of the spool that count to a motion.
RESTING_SAMPLES = 5


@dataclass(frozen=True)
class PistonMotion:
    """A piston's motion from rest.

    Attributes
    ----------
    name : str
        Log and time.
    time, position, velocity, friction : (n,) arrays
        s, m from the place of rest, m/s, N. Friction counts from its value at the beginning of the log, where the
        bristles are straight and the reading is the zero of the sensors. Later motions begin with bent bristles.
    """

    name: str
    time: Array
    position: Array
    velocity: Array
    friction: Array


def motions(log: Log, rig: Machine, payload: float | None) -> list[PistonMotion]:
    """All motions of a log of x, p1, p2 and command; empty if the spool never opens."""
    data = friction_force(log.usable("x", "p1", "p2", "command"), RigParameters.of(rig, payload=payload))
    time, velocity, friction = (np.asarray(data[name].values) for name in ("time", "velocity", "friction"))
    command = np.interp(time, log.time, log["command"])
    sense = np.where(np.abs(command) > OPEN * np.abs(command).max(), np.sign(command), 0.0)
    edges = np.flatnonzero(np.diff(sense)) + 1
    if not edges.size:
        return []
    datum = float(np.median(friction[: edges[0]]))
    x = np.interp(time, log.time, log["x"])
    found = []
    for begin, end in zip(edges, [*edges[1:], time.size], strict=True):
        if sense[begin] == 0.0:
            continue
        first = max(int(begin) - RESTING_SAMPLES, 0)
        pick = slice(first, int(end))
        rest = float(np.median(x[first : int(begin)]))
        name = f"{log.source}, {time[begin]:.2f} to {time[end - 1]:.2f} s"
        found.append(PistonMotion(name, time[pick], x[pick] - rest, velocity[pick], friction[pick] - datum))
    return found


# Multiple of the Stribeck velocity above which friction is that of the static map.
BEYOND = 2.0


def goes_beyond(log: Log, rig: Machine, law: StaticMap, payload: float | None) -> bool:
    """Whether a motion of a ramp continues after break-away to more than :data:`BEYOND` Stribeck velocities."""
    for motion in motions(log, rig, payload):
        sense = np.sign(np.mean(motion.velocity))
        if _smooth(sense * motion.velocity).max() > BEYOND * law.pairs["stribeck-velocity"][0 if sense > 0 else 1]:
            return True
    return False


# Range of friction in which a ramp is read, as a share of the static friction: from above the noise to below slip.
RESTING, SLIPPING = 0.05, 0.7
# A step is read while the bristles follow the piston: dz/dt is at least this share of the velocity and of its largest
# value.
FOLLOWING, LEAST_RATE = 0.3, 0.2
LEAST_SAMPLES = 8


@dataclass(frozen=True)
class BristleReading:
    """One parameter from one experiment.

    Attributes
    ----------
    value, error : float
        Value and its standard error from the scatter about the straight line, SI.
    abscissa, ordinate : (n,) arrays
        Points of the straight line: deflection (m) and friction (N), or dz/dt (m/s) and the damping force (N).
    start, end : float
        Start and end of the stretch that was used, s.
    """

    value: float
    error: float
    abscissa: Array
    ordinate: Array
    start: float
    end: float


def without_slip(law: StaticMap, motion: PistonMotion) -> Array:
    """Change of the bristle deflection (n,), m, along a motion."""
    seal = np.abs(dry(law).force(_moving(motion.velocity)))
    sense = np.sign(np.mean(motion.velocity))
    # After a reversal friction still acts along the motion, and the bristles straighten faster than the piston moves.
    held = 1.0 - np.clip(sense * (motion.friction - viscous(law, motion.velocity)) / seal, -1.0, 1.0)
    steps = np.diff(motion.position)
    return np.concatenate([[0.0], np.cumsum(0.5 * (held[1:] + held[:-1]) * steps)])


def stiffness(motion: PistonMotion, law: StaticMap) -> BristleReading:
    """sigma_0 (N/m) from one motion of a ramp.

    The line is fitted by total least squares, with noise in both quantities. Ordinary regression would give too small a
    slope, because of the position sensor's noise in the deflection.
    """
    _check(motion)
    sense = np.sign(np.mean(motion.velocity))
    limit = float(np.abs(dry(law).force(np.array([sense * 1e-8]))[0]))
    share = _smooth(sense * motion.friction) / limit
    above = np.flatnonzero(share > SLIPPING)
    last = int(above[0]) if above.size else share.size
    still = np.flatnonzero(share[:last] < share[0] + RESTING)
    first = int(still[-1]) + 1 if still.size else 0
    if last - first < LEAST_SAMPLES:
        raise InputError(
            f"the ramp holds {last - first} samples between rest and {SLIPPING:.0%} of the static friction; "
            "use a slower ramp or a higher sampling rate"
        )
    pick = slice(first, last)
    z, force = without_slip(law, motion)[pick], motion.friction[pick]
    value, error = _line(z, force, _noise(motion.position), _noise(motion.friction))
    return BristleReading(value, error, z, force, float(motion.time[first]), float(motion.time[last - 1]))


def damping(motion: PistonMotion, law: StaticMap, bristle_stiffness: float) -> BristleReading:
    """sigma_1 (N s/m) from one motion of a step.

    The deflection follows (116) with the measured velocity. Its initial value follows from the friction at rest.
    """
    _check(motion)
    z, rate = _deflection(motion, law, bristle_stiffness)
    fastest = np.max(np.abs(rate))
    follows = (np.abs(rate) > FOLLOWING * np.abs(motion.velocity)) & (np.abs(rate) > LEAST_RATE * fastest)
    if np.count_nonzero(follows) < LEAST_SAMPLES:
        raise InputError(
            f"the step holds {np.count_nonzero(follows)} samples in which the bristles follow the piston; "
            "use a higher sampling rate"
        )
    damped = motion.friction - bristle_stiffness * z - viscous(law, motion.velocity)
    x, y = rate[follows], damped[follows]
    value = float(x @ y / (x @ x))
    error = float(np.sqrt(np.mean((y - value * x) ** 2) / (x @ x)))
    moments = motion.time[follows]
    return BristleReading(value, error, x, y, float(moments[0]), float(moments[-1]))


def dry(law: StaticMap) -> StaticMap:
    """The map without its viscous part: sign(v) g(v), (117)."""
    return StaticMap.of({**law.pairs, "viscous": (0.0, 0.0)})


def viscous(law: StaticMap, velocity: Array) -> Array:
    """Viscous part of the map, N."""
    moving = _moving(velocity)
    return np.asarray(law.force(moving) - dry(law).force(moving), dtype=np.float64)


def _deflection(motion: PistonMotion, law: StaticMap, bristle_stiffness: float) -> tuple[Array, Array]:
    """z and dz/dt of (116) along a measured velocity; each interval is solved with constant velocity."""
    velocity, moving = motion.velocity, _moving(motion.velocity)
    rest = dry(law).force(moving) / bristle_stiffness
    decay = np.abs(velocity / rest)
    z = np.full_like(velocity, float(np.mean(motion.friction[:RESTING_SAMPLES])) / bristle_stiffness)
    for k, step in enumerate(np.diff(motion.time)):
        z[k + 1] = rest[k] + (z[k] - rest[k]) * np.exp(-decay[k] * step)
    return z, velocity - decay * z


def _line(x: Array, y: Array, sigma_x: float, sigma_y: float) -> tuple[float, float]:
    """Slope of a line with noise in both coordinates (Deming), and its standard error."""
    dx, dy = x - x.mean(), y - y.mean()
    sxx, syy, sxy = dx @ dx, dy @ dy, dx @ dy
    if sxy == 0.0 or sxx == 0.0:
        raise InputError("friction does not change with the piston's position: the ramp shows no bristles")
    ratio = (max(sigma_y, 1e-12) / max(sigma_x, 1e-15)) ** 2
    slope = (syy - ratio * sxx + np.hypot(syy - ratio * sxx, 2.0 * np.sqrt(ratio) * sxy)) / (2.0 * sxy)
    scatter = np.sum((dy - slope * dx) ** 2) / max(len(x) - 2, 1)
    return float(slope), float(np.sqrt(scatter / sxx))


def _noise(signal: Array) -> float:
    """Standard deviation of the noise of a slow signal, from its second differences."""
    return float(np.std(np.diff(signal, 2)) / np.sqrt(6.0))


def _smooth(signal: Array) -> Array:
    width = max(len(signal) // 100, 1)
    return np.asarray(np.convolve(signal, np.full(width, 1.0 / width), mode="same"), dtype=np.float64)


def _moving(velocity: Array) -> Array:
    """Velocities kept away from zero, where the sign of friction is undefined."""
    return np.where(np.abs(velocity) < 1e-9, np.copysign(1e-9, velocity), velocity)


def _check(motion: PistonMotion) -> None:
    if motion.time.size < LEAST_SAMPLES:
        raise InputError(f"the motion has {motion.time.size} samples; at least {LEAST_SAMPLES} are needed")
    if not all(np.isfinite(s).all() for s in (motion.position, motion.velocity, motion.friction)):
        raise InputError("a signal holds values that are not finite; cut the log to where every sensor reads")


Readings = dict[str, dict[str, BristleReading]]


def first_readings(
    ramps: Sequence[Log],
    steps: Sequence[Log],
    rig: Machine,
    law: StaticMap | None = None,
    *,
    payload: float | None = None,
) -> tuple[Readings, list[str]]:
    """Initial estimates: stiffness from the ramps, then damping from the steps.

    Parameters
    ----------
    ramps, steps : sequences of Log
        As for :func:`fit_dynamic`.
    rig : Machine
    law : StaticMap, optional
        Default is the rig's.
    payload : float, optional
        kg.

    Returns
    -------
    readings : dict
        ``bristle-stiffness`` and ``bristle-damping``, each by the name of a motion.
    warnings : list of str
        Estimates that failed, and why.
    """
    law = rig_map(rig) if law is None else law
    found: Readings = {name: {} for name in DYNAMIC}
    warnings = []
    for motion in (m for log in ramps for m in motions(log, rig, payload)):
        try:
            found["bristle-stiffness"][motion.name] = stiffness(motion, law)
        except InputError as error:
            warnings.append(f"{motion.name}: no initial estimate of the stiffness: {error}")
    known = [r.value for r in found["bristle-stiffness"].values()]
    taken = float(np.mean(known)) if known else number(rig, key_of(rig, "friction", "bristle-stiffness"))
    for motion in (m for log in steps for m in motions(log, rig, payload)):
        try:
            found["bristle-damping"][motion.name] = damping(motion, law, taken)
        except InputError as error:
            warnings.append(f"{motion.name}: no initial estimate of the damping: {error}")
    return found, warnings
