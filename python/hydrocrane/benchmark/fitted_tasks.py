"""Straight lines that a machine can drive, found from its own limits; the tuning of an unknown crane needs them.

A line is followed at the highest speed that the pistons reach under the static load, with the redundancy resolution of
the controller ``tip``. It ends where the machine is slower than ``SLOWEST``, or near a keep-out region.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np

from hydrocrane import _core
from hydrocrane.arrays import Array
from hydrocrane.benchmark.cases import START, Case, quick_cases
from hydrocrane.benchmark.conditions import Condition
from hydrocrane.benchmark.tasks import LINE, SENSES, SPEEDS, straight
from hydrocrane.errors import InputError
from hydrocrane.machine.machine import Machine

# m along the line per step of a walk.
STEP = 0.01
# Speed at which a line ends, m/s.
SLOWEST = SPEEDS[0]
# Commanded speed above that of any crane, m/s; the redundancy resolution limits it to that of the pistons.
BEYOND = 20.0
# Range of each joint in which poses are tried, as shares, and the approximate number of poses.
INNER, POSES = (0.15, 0.85), 250
# Distance of a line from a keep-out region's margin, m, because gains do not affect the slow-down there.
ROOM = 0.1
# Least length of a line, m.
SHORTEST = 0.1
# Shares of the feasible speed: for slow lines, and for a line that is too fast.
SLOW_SHARE, FAST_SHARE = 0.5, 1.2
# Relative increase of the largest cylinder force by the payload that the controller does not know.
UNKNOWN_LOAD = 0.1
LATER = Condition(variant="valves 20 ms later")


@dataclass(frozen=True)
class ReachedLine:
    """A straight line up to where a machine can follow it.

    Attributes
    ----------
    poses : (m, n) array
        Joint coordinates at every ``STEP`` of the line.
    speeds : (m,) array
        Highest steady tip speed in each, m/s.
    """

    poses: Array
    speeds: Array

    @property
    def length(self) -> float:
        """m"""
        return STEP * (len(self.speeds) - 1)

    @property
    def feasible_speed(self) -> float:
        """Largest constant speed along the whole line, m/s; zero for a line without length."""
        return float(self.speeds.min()) if self.length > 0 else 0.0


def walk(machine: Machine, q: Array, direction: Array, length: float = LINE, slowest: float = SLOWEST) -> ReachedLine:
    """Line from pose `q` (n,) along the unit vector `direction` (2,), up to `length` (m), the limit of the machine, or
    where it is slower than `slowest` (m/s)."""
    gains = machine.tip_gains
    q = np.array(q, dtype=np.float64)
    start = machine.tip_in_plane(q)
    poses, speeds = [], []
    for i in range(round(length / STEP) + 1):
        lost = start + i * STEP * direction - machine.tip_in_plane(q)
        # No joint moves the tip in this direction.
        if np.hypot(*lost) > 0.5 * STEP:
            break
        rates, share = fastest_rates(machine, q, BEYOND * direction, gains["path-rate"] * lost, gains["limit-rate"])
        if share * BEYOND < slowest or machine.clearance(machine.tip(q)) < gains["keep-out-margin"] + ROOM:
            break
        poses.append(q.copy())
        speeds.append(share * BEYOND)
        q += rates * (STEP / speeds[-1])
    return ReachedLine(np.reshape(poses, (-1, q.size)), np.array(speeds))


def fastest_rates(
    machine: Machine, q: Array, velocity: Array, correction: Array, limit_rate: float
) -> tuple[Array, float]:
    """Joint rates (n,) for a tip velocity (2,) in the plane, and the share of it that they reach.

    The velocity may be reduced, the `correction` (2,) of the path, m/s, may not. Bounds and weights are those of
    :func:`rate_bounds` and :func:`rate_weights`. A crane that slews has its slewing joint at zero and keeps it there.
    """
    bounds = rate_bounds(machine, q, limit_rate)
    jacobian = machine.tip_jacobian(q)[[0, -1]]
    jacobian[:, : machine.first_in_plane] = 0.0
    rest = np.zeros(q.size)
    return _core.resolve_rates(jacobian, tuple(velocity), tuple(correction), rate_weights(machine, q), rest, bounds)


def rate_bounds(machine: Machine, q: Array, limit_rate: float) -> Array:
    """Lowest and highest joint rates (n, 2) in pose `q` (n,), due to the pistons and to the slow-down before limits.

    Limits are those of the joints, and of the pistons where an end stop begins to act.
    """
    slow_down = limit_rate * _room(q, machine.joint_limits)
    pistons = limit_rate * _room(machine.strokes(q), free_strokes(machine))
    return np.clip(_piston_rates(machine, q, pistons), slow_down[:, :1], slow_down[:, 1:])


def free_strokes(machine: Machine) -> Array:
    """Range of piston positions (n_cyl, 2), m, without contact with an end stop."""
    zones = [float(machine.value(f"cylinder.{c}.end-stop.zone").si) for c in machine.cylinder_names]
    return machine.stroke_limits + np.outer(zones, (1.0, -1.0))


def _room(x: Array, limits: Array) -> Array:
    """Distances (n, 2) of each of `x` (n,) to its lower limit, negative, and to its upper one; zero beyond a limit."""
    return np.clip(limits - x[:, np.newaxis], *np.array([[-np.inf, 0.0], [0.0, np.inf]]))


def rate_weights(machine: Machine, q: Array) -> Array:
    """Effort per squared joint rate (n,): inverse square of its largest rate, as in ``tip``."""
    return np.clip(np.ptp(_piston_rates(machine, q), axis=1), 1e-9, 1e9) ** -2.0


def _piston_rates(machine: Machine, q: Array, bounds: Array | None = None) -> Array:
    """Joint rates (n, 2) of pistons at full speed in pose `q` (n,); `bounds` (n_cyl, 2), m/s, limit them."""
    speeds = machine.piston_speeds(q)
    if bounds is not None:
        speeds = np.clip(speeds, bounds[:, :1], bounds[:, 1:])
    # At the dead centre a piston does not bound the rate of its joint; the joint's own limits do.
    gain = np.diagonal(machine.stroke_jacobian(q))[:, np.newaxis]
    return np.sort(speeds / np.where(gain == 0.0, np.finfo(float).tiny, gain), axis=1)


def start_pose(machine: Machine) -> Array:
    """The pose (n,) with the longest lines up, down, out and in; that of the benchmark if it fits.

    Among equal poses the one with the largest feasible speed is taken.
    """
    if fits_the_benchmark(machine):
        return np.array([START[joint] for joint in machine.joint_names])
    count = max(2, round(POSES ** (1.0 / len(machine.joint_names))))
    lower, upper = machine.joint_limits.T
    grid = itertools.product(*[np.linspace(*INNER, count)] * len(lower))
    best, most = lower, (-np.inf, -np.inf)
    senses = [np.array(sense) for sense in SENSES.values()]
    for shares in grid:
        q = lower + (upper - lower) * np.array(shares)
        found: list[ReachedLine] = []
        # After lines of full length, slower ones are of no use.
        slowest = max(SLOWEST, most[1]) if most[0] >= STEP * round(LINE / STEP) else SLOWEST
        for i, sense in enumerate(senses):
            found.append(walk(machine, q, sense, slowest=slowest))
            # Further walks can only lower what all of them have in common. What rules out this pose may well rule out
            # the next one.
            if _score(found) <= most:
                senses.insert(0, senses.pop(i))
                break
        else:
            best, most = q, _score(found)
    return best


def walks(machine: Machine, q: Array, length: float = LINE) -> dict[str, ReachedLine]:
    """Lines from pose `q` (n,) up, down, out and in."""
    return {name: walk(machine, q, np.array(sense), length) for name, sense in SENSES.items()}


def _score(found: list[ReachedLine]) -> tuple[float, float]:
    return min(w.length for w in found), min(w.feasible_speed for w in found)


def tuning_cases(machine: Machine) -> list[Case]:
    """Cases for the tuning of the gains of `machine`: the benchmark's quick cases, or lines that fit the machine.

    These are a slow line in each direction, a fast one outwards, and the slow line upwards with the machine's own
    sensors and a payload that the controller does not know. They are not faster than those of the benchmark. The last
    case is the first one with valves that answer 20 ms later than the controller knows.
    """
    machine.require_plane("tip control")
    cases = quick_cases() if fits_the_benchmark(machine) else _fitted_cases(machine)
    return [*cases, replace(cases[0], condition=LATER)]


def _fitted_cases(machine: Machine) -> list[Case]:
    q = start_pose(machine)
    found = walks(machine, q)
    length = min(w.length for w in found.values())
    if length < SHORTEST:
        raise InputError(
            f"{machine.name} has no pose from which its tip could go {SHORTEST * 1e3:g} mm up, down, out and in; "
            "tune it with cases of your own"
        )
    start = tuple(float(x) for x in q)

    def line(name: str, share: float, most: float) -> Case:
        speed = min(most, share * found[name].feasible_speed)
        return Case(straight(f"{name} {speed:.3g} m/s", [length * np.array(SENSES[name])], speed), start=start)

    slow = [line(name, SLOW_SHARE, SPEEDS[1]) for name in SENSES]
    heavy = Condition(payload=unknown_payload(machine, q), sensors="data-sheet")
    return [*slow, line("out", FAST_SHARE, SPEEDS[2]), Case(slow[0].task, heavy, start)]


def unknown_payload(machine: Machine, q: Array) -> float:
    """Payload, kg, that increases the largest cylinder force in pose `q` (n,) by the share ``UNKNOWN_LOAD``."""
    own = machine.payload()
    force = machine.static_cylinder_force(q)
    per_kilogram = machine.static_cylinder_force(q, payload=own + 1.0) - force
    hardest = int(np.argmax(np.abs(force)))
    added = UNKNOWN_LOAD * abs(force[hardest] / per_kilogram[hardest])
    return own + float(f"{added:.2g}")


def fits_the_benchmark(machine: Machine) -> bool:
    """Whether the joints are those of the laboratory crane, which the benchmark's tasks need."""
    return set(machine.joint_names) == set(START)
