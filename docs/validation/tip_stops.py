"""Random stops: settling of the tip after the stick is released at speed, its vibration and its drift at rest.

A stop begins in a random pose with a motion in a random direction at ``SPEED`` for ``MOVED`` s. The seed determines
both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import seed_number
from hydrocrane.benchmark.fitted_tasks import INNER
from hydrocrane.benchmark.metrics import AT_REST
from hydrocrane.control.joystick import Joystick
from hydrocrane.errors import HydrocraneError, InputError
from hydrocrane.machine.machine import Machine
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.simulation.running import simulate

# Speed, m/s, and the times of the release of the stick, the begin of rest, and the end of the run, s.
SPEED, MOVED, REST, END = 0.3, 1.0, 6.0, 16.0
# Shortest rest that is judged, s.
SHORTEST = 0.1


@dataclass(frozen=True)
class Stop:
    """Result of a stop.

    Attributes
    ----------
    settling : float
        Time from the centred stick until the tip stays below 5 mm/s, s.
    quiet : float
        RMS speed of the tip from ``REST`` to the end, m/s.
    drift : float
        Largest distance of the tip from its position at ``REST``, m.
    """

    settling: float
    quiet: float
    drift: float


def random_stop(
    machine: Machine, seed: int, *, payload: float = 0.0, sensors: str = "ideal", end: float = END
) -> Stop | None:
    """A stop of `machine` with `payload` (kg) under ``tip``, recorded until `end` (s).

    ``None`` if it cannot hold or lift the load there: the controller says so. A stop that swings, or that ends because
    of a sensor, counts. Raises `InputError` unless `end` is more than ``SHORTEST`` after ``REST``.
    """
    if not (np.isfinite(end) and end > REST + SHORTEST):
        raise InputError(
            f"end must be more than {REST + SHORTEST:g} s, so that the rest after the stop can be judged; got {end!r}"
        )
    rng = np.random.default_rng(seed_number(seed))
    low, high = machine.joint_limits.T
    q = low + (high - low) * rng.uniform(*INNER, len(low))
    angle = rng.uniform(0.0, 2.0 * np.pi)
    axes = {"x": [np.cos(angle), 0.0], "z": [np.sin(angle), 0.0]}
    plan = Scenario(
        machine=machine.source,
        overrides=machine.overrides,
        joints=dict(zip(machine.joint_names, q.tolist(), strict=True)),
        payload=payload,
        duration=end,
        record_interval=5e-3,
        joystick=Joystick([0.0, MOVED], axes, full_speed=SPEED),
        sensors=sensors,
        seed=seed,
    )
    try:
        run = simulate(plan, ledger=False)
    except HydrocraneError:
        return None
    # What a controller says that is no warning is of loads; closed spools hold one that the supply could not lift.
    if any(not event.warning for event in run.events):
        return None
    if not run.outcome.completed:
        return Stop(np.inf, np.inf, np.inf)
    time = run.data["time"].values
    tip = np.column_stack([run.data["tip.x"].values, run.data["tip.z"].values])
    speed = np.hypot(*np.gradient(tip, time, axis=0).T)
    fast = time[(time > MOVED) & (speed > AT_REST)]
    rest = time > REST
    away = np.hypot(*(tip[rest] - tip[rest][0]).T)
    settling = float(fast.max() - MOVED) if fast.size else 0.0
    return Stop(settling, float(np.sqrt(np.mean(speed[rest] ** 2))), float(away.max()))
