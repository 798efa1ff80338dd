"""A maker of friction logs that shares nothing with the laboratory: its own laws, integration and sensors.

Friction is Coulomb, Stribeck and viscous, of exponent 1 unless asked otherwise. The piston is moved along trapezoids
(`imposed`, no differential equation), by a position servo, or by a valve that is opened in steps (`driven`); small
motions within the bristles' reach come from the equations of :mod:`oracles.rig` (`bristled`). Sensors have noise,
quantisation, and errors of zero, span and linearity within the data sheets of ``rig-rottne``. Only
geometry, mass and data sheets are those of that rig.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from oracles.rig import Rig
from scipy.integrate import solve_ivp

import hydrocrane as hc

BAR = 1e5
BORE, ROD, MASS, GRAVITY = 0.05, 0.03, 5.173, 9.81
A1 = np.pi * BORE**2 / 4
A2 = A1 - np.pi * ROD**2 / 4
# Both chambers are open to the tank and the load is supported for so long, s.
REST = 1.0
# Data sheets: transmitters of 400 bar and 0.3 %, potentiometer of 1.25 m and 0.25 %.
RANGE, ACCURACY, PRESSURE_NOISE = 400 * BAR, 0.003, 0.04 * BAR
LENGTH, LINEARITY, POSITION_NOISE = 1.25, 0.0025, 5e-5
# Rise time of the transmitters from 10 to 90 %, s.
RISE = 4e-3
SPEEDS = tuple(np.geomspace(0.5e-3, 0.1, 10))
# Time over which the velocity changes, s.
RAMP = 0.1
# Valve and oil: flow at full opening over sqrt(Pa), m^3/s; bulk modulus, Pa; dead volume of each chamber, m^3.
VALVE, BULK, DEAD, HALF_STROKE = 1.2e-7, 1e9, 5e-5, 0.36
# Below this speed the sign of friction fades where the motion is not given, m/s.
FADING = 2e-5


@dataclass(frozen=True)
class Truth:
    """Friction of a cylinder, pairs (extending, retracting), SI.

    `by_position` and `by_time` are relative changes of all friction from one end of the travel, or of the log, to the
    other; `by_pressure` per 100 bar in the rod-side chamber, `by_load` per 100 kg.
    """

    coulomb: tuple[float, float] = (157.0, 210.0)
    rise: tuple[float, float] = (93.0, 120.0)
    stribeck_velocity: tuple[float, float] = (0.019, 0.012)
    viscous: tuple[float, float] = (11260.0, 9000.0)
    exponent: float = 1.0
    by_position: float = 0.0
    by_time: float = 0.0
    by_pressure: float = 0.0
    by_load: float = 0.0

    def size(self, v):
        """Magnitude of friction, N, at velocities v, m/s."""
        side = (np.asarray(v) < 0.0).astype(int)
        coulomb, rise, fall, viscous = (
            np.asarray(pair)[side] for pair in (self.coulomb, self.rise, self.stribeck_velocity, self.viscous)
        )
        speed = np.abs(v)
        return coulomb + rise * np.exp(-((speed / fall) ** 2)) + viscous * speed**self.exponent


def drawn(seed: int, **changes) -> Truth:
    """A cylinder at random."""
    rng = np.random.default_rng([seed, 77])
    coulomb = rng.uniform(100.0, 300.0, 2)
    found = {
        "coulomb": tuple(coulomb),
        "rise": tuple(coulomb * rng.uniform(0.3, 1.0, 2)),
        "stribeck_velocity": tuple(rng.uniform(0.003, 0.02, 2)),
        "viscous": tuple(rng.uniform(2e3, 12e3, 2)),
    }
    return Truth(**(found | changes))


@dataclass(frozen=True)
class Motion:
    """What really happened, arrays over time (n,), SI."""

    time: np.ndarray
    x: np.ndarray
    p1: np.ndarray
    p2: np.ndarray
    command: np.ndarray | None = None


def trapezoid(way: float, speed: float, rate: float) -> np.ndarray:
    """Velocities (n,) of a move over `way`, m, that starts and ends at rest."""
    hold = max(abs(way) / speed - RAMP, 0.0)
    t = np.arange(int(np.ceil((hold + 2 * RAMP) * rate))) / rate
    shape = np.clip(np.minimum(t / RAMP, (hold + 2 * RAMP - t) / RAMP), 0.0, 1.0)
    return way * rate * shape / shape.sum()


def course(
    rate: float, speeds=SPEEDS, seconds: float = 5.0, travel: float = 0.3, passes: int = 1, seed: int = 0, *,
    scattered: bool = True,
):  # fmt: skip
    """Velocities (n,) of the experiment: out and back at each speed, slower levels at places of their own, or all from
    one end of the travel if not `scattered`."""
    rng = np.random.default_rng([seed, 5])
    parts, at = [np.zeros(int(REST * rate))], -0.5 * travel
    for speed in np.tile(speeds, passes):
        way = min(travel, speed * seconds)
        start = rng.uniform(-0.5 * travel, 0.5 * travel - way) if scattered else -0.5 * travel
        parts += [trapezoid(start - at, 0.05, rate), trapezoid(way, speed, rate), trapezoid(-way, speed, rate)]
        at = start
    return np.concatenate(parts)


def imposed(truth: Truth, rate: float = 100.0, *, payload: float = 0.0, back: float = 5 * BAR, **plan) -> Motion:
    """The motion is given; the pressures follow from the balance of forces."""
    travel = plan.get("travel", 0.3)
    v = course(rate, **plan)
    time = np.arange(v.size) / rate
    x = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1])) / rate]) - 0.5 * travel
    p2 = back + np.where(v > 0.0, (v / 0.1) ** 2 * 10 * BAR, 0.0)
    size = truth.size(v) * (1.0 + truth.by_position * x / travel) * (1.0 + truth.by_time * time / time[-1])
    size *= (1.0 + truth.by_pressure * p2 / (100 * BAR)) * (1.0 + truth.by_load * payload / 100.0)
    mass = MASS + payload
    p1 = (p2 * A2 + np.sign(v) * size + mass * (np.gradient(v, 1.0 / rate) - GRAVITY)) / A1
    moved = time >= REST
    return Motion(time, x, p1 * moved, p2 * moved)


def driven(truth: Truth, rate: float = 100.0, *, servo: bool, supply: float = 140 * BAR, **plan) -> Motion:
    """A valve moves the piston: opened for each level (open loop), or by a servo that follows the positions."""
    v_asked = course(rate, **plan)
    time = np.arange(v_asked.size) / rate
    x_asked = np.concatenate([[0.0], np.cumsum(0.5 * (v_asked[1:] + v_asked[:-1])) / rate])
    x_asked -= 0.5 * plan.get("travel", 0.3)

    def edge(opening, fall):
        return VALVE * opening * fall / np.sqrt(np.abs(fall) + 1e3)

    def slopes(t, state):
        x, v, p1, p2 = state
        request = np.interp(t, time, v_asked)
        u = opening(truth, request, supply)
        if servo:
            u += 8.0 * (np.interp(t, time, x_asked) - x)
        flow1 = edge(u, supply - p1) if u > 0.0 else edge(u, p1)
        flow2 = edge(u, p2) if u > 0.0 else edge(u, supply - p2)
        volume1, volume2 = DEAD + A1 * (HALF_STROKE + x), DEAD + A2 * (HALF_STROKE - x)
        friction = truth.size(v) * np.tanh(v / FADING)
        return [
            v,
            (p1 * A1 - p2 * A2 - friction) / MASS + GRAVITY,
            BULK / volume1 * (flow1 - A1 * v),
            BULK / volume2 * (A2 * v - flow2),
        ]

    first = int(REST * rate)
    begin = [x_asked[0], 0.0, 30 * BAR, (30 * BAR * A1 + MASS * GRAVITY) / A2]
    found = solve_ivp(
        slopes, (REST, time[-1]), begin, method="LSODA", t_eval=time[first:], rtol=1e-6, atol=[1e-7, 1e-6, 1.0, 1.0],
        max_step=0.05,
    )  # fmt: skip
    assert found.success
    x, _, p1, p2 = np.concatenate([np.tile([[begin[0]], [0.0], [0.0], [0.0]], first), found.y], axis=1)
    return Motion(time, x, p1, p2)


def opening(truth: Truth, v: float, supply: float) -> float:
    """Opening of the valve at which the piston moves steadily at v, m/s, against its friction."""
    size, into, out = float(truth.size(v)), *((A1, A2) if v > 0.0 else (A2, A1))
    push = size + (-MASS if v > 0.0 else MASS) * GRAVITY
    return v / VALVE * np.sqrt((into**3 + out**3) / (supply * into - push))


# Spool commands of a slow ramp each way, and of short steps there and back, small ones first: (s, um).
RAMPS = ((0, 0), (0.5, 0), (4, 60), (4.005, 0), (4.5, 0), (8.5, -75), (8.505, 0), (9, 0))
PULSES = (180, -230, 180, -230, 300, -380)
PULSE = ((0.0, 0), (5e-3, 1), (0.1, 1), (0.105, 0))
STEPS = ((0, 0), *((round(0.5 + 1.4 * k + t, 3), u * on) for k, u in enumerate(PULSES) for t, on in PULSE), (9, 0))
# Of what the rig's file says of valve, oil and leakage a cylinder differs by this (standard deviation, share), at most
# by `MOST` of these, and of its bristles evenly within these factors.
SPREAD, MOST, BRISTLES = 0.2, 1.5, (0.7, 1.4)


def bristles_of(seed: int, truth: Truth) -> dict[str, float | list[float]]:
    """A rig at random with that friction, by the names of its file; exponents are those of the file."""
    rng, file = np.random.default_rng([seed, 11]), Rig()
    found = {
        "coulomb": list(truth.coulomb),
        "breakaway": [c + r for c, r in zip(truth.coulomb, truth.rise, strict=True)],
        "stribeck-velocity": list(truth.stribeck_velocity),
        "viscous": list(truth.viscous),
    }
    for name in ("bristle-stiffness", "bristle-damping"):
        found[name] = float(file.seal[name] * rng.uniform(*BRISTLES))
    about = {**file.valve, **file.oil, **file.body}
    for name in ("nominal-flow", "natural-frequency", "bulk-modulus-max", "leakage-gap"):
        found[name] = float(about[name] * (1.0 + SPREAD * np.clip(rng.normal(), -MOST, MOST)))
    return found


def bristled(
    cylinder: dict[str, float | list[float]], course, rate: float = 1000.0, *, friction: float = 0.0
) -> Motion:
    """A piston that hangs still, then is moved by spool commands `course`, (s, um), from :data:`REST` on.

    It rests with `friction`, N, positive against extension, in its bristles.
    """
    rig = Rig(**cylinder)
    times, spools = (np.array(column, dtype=float) for column in zip(*course, strict=True))
    time = np.arange(int((REST + times[-1]) * rate) + 1) / rate
    p1 = 22 * BAR
    held = (p1 * rig.a1 + rig.mass * rig.gravity - friction) / rig.a2
    begin = [0.0, 0.0, p1, held, 0.0, 0.0, friction / cylinder["bristle-stiffness"]]
    moved = time >= REST
    record = np.round(time[moved] - REST, 9)
    x, _, p1, p2, *_ = rig.integrate(begin, times, 1e-6 * spools, record, 1e-8).T
    columns = [
        np.concatenate([np.full(time.size - values.size, rest), values])
        for values, rest in ((x, 0.0), (p1, 0.0), (p2, 0.0))
    ]
    return Motion(time, *columns, np.interp(time - REST, times, 1e-6 * spools))


def lagged(time: np.ndarray, pressure: np.ndarray) -> np.ndarray:
    """What a transmitter with :data:`RISE`, first order, makes of a pressure that is straight between its samples.

    At the end of :data:`REST` it has settled.
    """
    lag, step = RISE / np.log(9.0), time[1] - time[0]
    keep = np.exp(-step / lag)
    found = pressure.copy()
    for k in range(int(np.searchsorted(time, REST)) + 1, time.size):
        slope = (pressure[k] - pressure[k - 1]) / step
        found[k] = pressure[k] - slope * lag + (found[k - 1] - pressure[k - 1] + slope * lag) * keep
    return found


@dataclass(frozen=True)
class Sensors:
    """Errors of one draw of the sensors: zeros, Pa; spans, shares; the parabola of the potentiometer, m."""

    zeros: np.ndarray
    spans: np.ndarray
    bow: float

    @classmethod
    def of(cls, seed: int, share: float = 1.0) -> Sensors:
        """Evenly likely within `share` of the data sheets."""
        rng = np.random.default_rng([seed, 99])
        zeros, spans = rng.uniform(-1.0, 1.0, (2, 2)) * share
        return cls(
            zeros * 0.5 * ACCURACY * RANGE, spans * ACCURACY, 2 * rng.uniform(-1.0, 1.0) * share * LINEARITY * LENGTH
        )


def read(
    motion: Motion, seed: int, *, share: float = 1.0, bits: int = 16, source: str = "foreign.csv", earlier: int = 0
) -> hc.Log:
    """The log of a motion: what sensors of draw `seed` with errors of `share` of their data sheets read.

    So many `earlier` logs were read by the same sensors, each with its own noise.
    """
    rng = np.random.default_rng([seed, 3, earlier] if earlier else [seed, 3])
    sensors = Sensors.of(seed, share)
    place = np.clip(0.5 + motion.x / LENGTH, 0.0, 1.0)
    signals = {"x": motion.x + sensors.bow * (4 * place * (1 - place) - 0.5)}
    for k, name in enumerate(("p1", "p2")):
        pressure = getattr(motion, name)
        seen = pressure if motion.command is None else lagged(motion.time, pressure)
        signals[name] = seen * (1 + sensors.spans[k]) + sensors.zeros[k]
    noise, full = {"x": POSITION_NOISE, "p1": PRESSURE_NOISE, "p2": PRESSURE_NOISE}, {"x": LENGTH}
    for name, values in signals.items():
        step = full.get(name, RANGE) / 2**bits
        signals[name] = np.round((values + noise[name] * rng.normal(size=values.size)) / step) * step
    if motion.command is not None:
        signals["command"] = motion.command
    return hc.Log.of({"time": motion.time, **signals}, source=source)


def bristles_identified(seed: int, friction: float = 0.0) -> tuple[hc.Identification, dict[str, float]]:
    """A cylinder at random identified from levels, a ramp and pulses in the default call, and its true values.

    The logs are read by the same sensors, and the map comes from the levels among them. Ramp and pulses begin with
    `friction`, N, at rest.
    """
    truth = drawn(seed, exponent=1.5)
    cylinder = bristles_of(seed, truth)
    levels = read(imposed(truth, seed=seed), seed, source="levels")
    ramp = read(bristled(cylinder, RAMPS, friction=friction), seed, source="ramp", earlier=1)
    step = read(bristled(cylinder, STEPS, friction=friction), seed, source="step", earlier=2)
    zero = (0.0, REST - 1e-4)
    found = hc.identify_friction(levels, "rig-rottne", ramps=ramp, steps=step, zero=zero)
    assert found.dynamic is not None, found.summary()
    return found, true_values(cylinder)


def true_values(cylinder: dict[str, float | list[float]]) -> dict[str, float]:
    """The values of a cylinder by the keys of the rig's file."""
    tables = {"nominal-flow": "valve.test", "natural-frequency": "valve.test", "bulk-modulus-max": "fluid"}
    tables["leakage-gap"] = "cylinder.test"
    found = {}
    for name, value in cylinder.items():
        key = f"{tables.get(name, 'friction.test')}.{name}"
        found |= {f"{key}[{i}]": v for i, v in enumerate(value)} if isinstance(value, list) else {key: value}
    return found


def bristles_held(found: hc.Identification, truth: dict[str, float]) -> dict[str, bool]:
    """Which 95 % intervals of the bristle fit hold the true value."""
    fitted = found.dynamic.fitted()
    return {name: bool(abs(fitted[name] - true) < 1.96 * fitted.deviation(name)) for name, true in truth.items()}
