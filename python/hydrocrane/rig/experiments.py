"""The experiments of section 5.2 of the thesis; each is a course of piston velocities, scaled by the rig's seal.

There is no feedback: as on the real rig the spool follows a table, computed in advance from the valve's steady law.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError, check_known, nearest
from hydrocrane.rig.course import Course, Seal

# Velocities of section 5.2.2, m/s.
LEVELS = (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 1e-1)
FEWER_LEVELS = (5e-4, 1e-3, 2e-3, 5e-3, 2e-2, 5e-2, 1e-1)
# Length of a level in bristle slips, and the largest share of the stroke for the levels; ramps between them need the
# rest.
MOST_SLIPS = (10.0, 9.0, 8.0, 7.0, 6.0, 5.0)
ROOM = 1.05
# Linear pieces per period of a sinusoid.
POINTS_PER_PERIOD = 40
# Pause between two motions, s, and velocity of a return motion without measurement, m/s.
REST = 1.0
RETURN = 0.03


def _small_sine(seal: Seal, *, frequency: float = 0.2, cycles: int = 5, travel: float = 3.0) -> Course:
    """Figures 61, 62: a sinusoid that just breaks away; `travel` forth and back in bristle slips."""
    peak = np.pi * frequency * travel * seal.slip
    course = Course()
    course.rest(REST)
    course.follow("sine", _sine(0.0, peak, frequency), cycles / frequency, points=round(POINTS_PER_PERIOD * cycles) + 1)
    course.rest(REST)
    return course


def _constant_velocity(
    seal: Seal,
    *,
    levels: Sequence[float] = LEVELS,
    slips: float | None = None,
    least: float = 8e-3,
    seconds: float = 1.5,
) -> Course:
    """Section 5.2.2: levels from fast to slow, extending, then retracting.

    With levels from fast to slow the chamber pressures are nearly right when a slow level begins; at low speed they
    would need minutes to build up. Each level lasts for at least `slips` bristle slips, `least` m and `seconds`;
    without `slips` it is ten, or as many above five as the stroke allows.
    """
    speeds = _increasing("levels", np.sort(levels))[::-1]

    def travels(slips: float) -> Array:
        return np.maximum(np.maximum(slips * seal.slip, least), seconds * speeds)

    if slips is None:
        slips = next((most for most in MOST_SLIPS if ROOM * travels(most).sum() <= seal.room), MOST_SLIPS[-1])
    course = Course()
    course.rest(REST)
    for direction in (1, -1):
        for speed, travel in zip(speeds, travels(slips), strict=True):
            course.hold(f"{direction * speed:g} m/s", direction * speed, travel / speed)
        course.rest(REST)
    return course


def _ramp(seal: Seal, *, speed: float = 0.25, last: float = 1.0) -> Course:
    """Figures 57, 71: the spool opens at a steady rate from rest, extending, then retracting.

    The bristles slip at about `speed` Stribeck velocities, so their deflection before is visible; it ends at `last`.
    """
    course = Course()
    course.rest(REST)
    rate = _ramp_rate(seal, speed)
    duration = last * seal.velocity / rate
    for direction, name in ((1, "extending"), (-1, "retracting")):
        course.follow(name, _line(direction * rate), duration, points=2)
        course.rest(REST)
    return course


def _step(seal: Seal, *, shares: Sequence[float] = (0.3, 0.5), seconds: float = 0.1, pulses: int = 2) -> Course:
    """Figure 73: spool steps that bend the bristles by `shares` of their slip within `seconds`, and back,
    `pulses` times.

    The velocity of bristles before slip shows the damping. Short steps identify it better than long ones, down to the
    time constant of the spool (docs/validation/dynamic-friction.md).
    """
    if pulses < 1:
        raise InputError(f"pulses must be 1 or more, got {pulses!r}")
    course = Course()
    course.rest(REST)
    for share in _increasing("shares", shares):
        for direction in (1, -1) * pulses:
            course.hold(f"{direction * share:g} of slip", direction * share * seal.slip / seconds, seconds)
            course.rest(2 * REST)
    return course


def _break_away(seal: Seal, *, speeds: Sequence[float] = (0.1, 0.3, 1.0, 3.0)) -> Course:
    """Figure 54: ramps with increasing force rate on the seal; they slip at `speeds` Stribeck velocities."""
    course = Course()
    course.rest(REST)
    for speed in _increasing("speeds", speeds):
        rate = _ramp_rate(seal, speed)
        duration = np.sqrt(8 * seal.slip / rate)
        for direction in (1, -1):
            course.follow(f"{direction * rate:.3g} m/s^2", _line(direction * rate), duration, points=2)
            course.rest(REST)
    return course


def _frictional_lag(seal: Seal, *, shares: Sequence[float] = (0.025, 0.05, 0.1), cycles: int = 2) -> Course:
    """Figure 55: velocity that oscillates about 1.5 Stribeck velocities without reversal, at increasing frequency.

    Frequencies are `shares` of the Stribeck velocity per bristle slip, which is the bandwidth of the bristles, limited
    to that of the valve. Between two frequencies the piston returns to its start.
    """
    follow = min(seal.velocity / seal.slip, 6.0)
    course = Course()
    course.rest(REST)
    for share in _increasing("shares", shares):
        frequency = share * follow
        wave = _sine(1.5 * seal.velocity, 1.4 * seal.velocity, frequency)
        course.follow(f"{frequency:.3g} Hz", wave, cycles / frequency, points=round(POINTS_PER_PERIOD * cycles) + 1)
        course.rest(REST)
        course.hold("", -RETURN, 1.5 * seal.velocity * cycles / frequency / RETURN)
        course.rest(REST)
    return course


def _variation(seal: Seal, *, levels: Sequence[float] = FEWER_LEVELS) -> Course:
    """Figures 74, 75: constant velocities, fewer of them, at each load or supply pressure."""
    return _constant_velocity(seal, levels=levels)


def _sine(mean: float, amplitude: float, frequency: float) -> Callable[[Array], Array]:
    return lambda t: mean + amplitude * np.sin(2 * np.pi * frequency * t)


def _line(rate: float) -> Callable[[Array], Array]:
    return lambda t: rate * t


def _ramp_rate(seal: Seal, speed: float) -> float:
    """Acceleration (m/s^2) at which `speed` Stribeck velocities are reached after two slips."""
    return (speed * seal.velocity) ** 2 / (4 * seal.slip)


def _increasing(name: str, values: ArrayLike) -> Array:
    found = real_array(values, name)
    if (np.diff(found) <= 0).any():
        raise InputError(f"{name} must each be given once, in rising order; got {np.asarray(values).tolist()}")
    return found


@dataclass(frozen=True)
class RigExperiment:
    """A course with its purpose, and the parameter that varies over several runs."""

    course: Callable[..., Course]
    title: str
    series: tuple[dict[str, float], ...] = field(default=({},))


EXPERIMENTS = {
    "small-sine": RigExperiment(_small_sine, "small sinusoid that just breaks away"),
    "constant-velocity": RigExperiment(_constant_velocity, "levels of constant velocity in both directions"),
    "ramp": RigExperiment(_ramp, "slow ramps of the spool from rest"),
    "step": RigExperiment(_step, "small steps within the bristles' reach"),
    "break-away": RigExperiment(_break_away, "ramps with increasing rates of force"),
    "frictional-lag": RigExperiment(
        _frictional_lag, "velocity oscillating without reversal, at increasing frequencies"
    ),
    "load-variation": RigExperiment(
        _variation, "constant velocities under several loads", tuple({"payload": m} for m in (0.0, 20.0, 115.0))
    ),
    "pressure-variation": RigExperiment(
        _variation, "constant velocities at several supply pressures", tuple({"supply": p} for p in (140e5, 100e5))
    ),
}


def experiments() -> tuple[str, ...]:
    """Names of the experiments."""
    return tuple(EXPERIMENTS)


def experiment(name: str) -> RigExperiment:
    """The experiment of a name."""
    check_known("experiment", name, EXPERIMENTS)
    return EXPERIMENTS[name]


def course_of(name: str, seal: Seal, options: Mapping[str, ArrayLike]) -> Course:
    """The course of an experiment with its `options`."""
    make = experiment(name).course
    known = make.__kwdefaults__ or {}
    for option, value in options.items():
        if option not in known:
            raise InputError(f"the experiment {name} has no option `{option}`{nearest(option, known)}")
        given = real_array(value, option)
        if given.ndim != np.ndim(known[option]) or not given.size or (given <= 0).any():
            kind = "numbers" if np.ndim(known[option]) else "one number"
            raise InputError(f"{option} must be {kind} greater than zero, for example {known[option]}; got {value!r}")
    return make(seal, **options)
