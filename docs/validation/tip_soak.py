"""Soak test: random sticks for a long time under ``tip``, and how near machine and controller come to their bounds.

The sticks are held for ``HELD`` s each: with probability 3/5 at the ends of their ranges, 1/5 anywhere, and 1/5
centred. The seed determines them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import Array, seed_number
from hydrocrane.benchmark.metrics import spool_travel
from hydrocrane.control.joystick import Joystick
from hydrocrane.errors import InputError
from hydrocrane.machine.machine import Machine
from hydrocrane.machine.overrides import Override
from hydrocrane.results.run import Run
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.simulation.running import simulate

HELD = (0.3, 4.0)
# Probabilities that both axes are at an end, and that they are anywhere.
FULL, ANYWHERE = 0.6, 0.2


@dataclass(frozen=True)
class Soak:
    """Result of a soak test, SI.

    Attributes
    ----------
    outcome : str
        Kind of the run's outcome, ``completed`` if it reached its end.
    warnings : tuple of str
        Texts of the run's warnings.
    alarms : tuple of str
        Events other than warnings and those that explain a tip at rest.
    tip_speed : float
        Largest speed of the tip.
    pressure : float
        Highest pressure of a chamber, as a share of the supply pressure.
    beyond_limits : float
        Largest excess of a joint over its limits, as a share of its range; zero at least.
    lag : float
        Largest distance of the tip from the set-point.
    clearance : float
        Least distance of the tip from the keep-out regions; infinite without regions.
    travel : float
        Travel of the spool commands per second, strokes, mean over the cylinders.
    spool_rate : float
        Largest speed of a spool, strokes per second.
    """

    outcome: str
    warnings: tuple[str, ...]
    alarms: tuple[str, ...]
    tip_speed: float
    pressure: float
    beyond_limits: float
    lag: float
    clearance: float
    travel: float
    spool_rate: float


def worst_of(found: Sequence[Soak]) -> Soak:
    """The worst figures of several soak tests; `travel` is their mean."""
    ended = [one.outcome for one in found if one.outcome != "completed"]
    return Soak(
        outcome=ended[0] if ended else "completed",
        warnings=tuple(text for one in found for text in one.warnings),
        alarms=tuple(text for one in found for text in one.alarms),
        tip_speed=max(one.tip_speed for one in found),
        pressure=max(one.pressure for one in found),
        beyond_limits=max(one.beyond_limits for one in found),
        lag=max(one.lag for one in found),
        clearance=min(one.clearance for one in found),
        travel=float(np.mean([one.travel for one in found])),
        spool_rate=max(one.spool_rate for one in found),
    )


def alarms(run: Run) -> tuple[str, ...]:
    """Events of a run other than warnings and those that explain a tip at rest."""
    return tuple(
        event.text for event in run.events if not event.warning and not event.text.startswith("the tip stands")
    )


def random_sticks(
    seed: int, duration: float, *, towards: tuple[float, float] = (0.0, 0.0), full_speed: float | None = None
) -> Joystick:
    """Random sticks for `duration` s; an axis of `towards` (-1 or 1) has this sign with probability 3/4."""
    rng = np.random.default_rng(seed_number(seed))
    time = np.cumsum(np.concatenate([[0.0], rng.uniform(*HELD, int(duration / HELD[0]) + 1)]))
    time = time[time < duration]
    kind, way = rng.uniform(size=time.size), rng.uniform(-1.0, 1.0, (time.size, 2))
    way = np.where((kind < FULL)[:, np.newaxis], np.sign(way), way)
    way[kind >= FULL + ANYWHERE] = 0.0
    turned = (rng.uniform(size=way.shape) < 0.5) & (np.asarray(towards) != 0.0)
    way = np.where(turned, np.abs(way) * np.asarray(towards), way)
    return Joystick(time, {"x": way[:, 0], "z": way[:, 1]}, full_speed=full_speed)


def soak(
    machine: Machine,
    seed: int,
    duration: float,
    *,
    payload: float = 0.0,
    sensors: str = "ideal",
    towards: tuple[float, float] = (0.0, 0.0),
    full_speed: float | None = None,
    overrides: Mapping[str, Override] | None = None,
) -> Soak:
    """A soak test of `duration` s from :attr:`Machine.home` with a `payload` in kg.

    A full deflection commands `full_speed`, m/s, by default that of the machine.
    """
    if not duration > HELD[1]:
        raise InputError(f"a soak takes more than {HELD[1]:g} s; got {duration!r}")
    plan = Scenario(
        machine=machine.source,
        overrides={**machine.overrides, **(overrides or {})},
        joints=dict(zip(machine.joint_names, machine.home.tolist(), strict=True)),
        payload=payload,
        duration=duration,
        joystick=random_sticks(seed, duration, towards=towards, full_speed=full_speed),
        sensors=sensors,
        seed=seed,
    )
    run = simulate(plan, ledger=False, on_error="stop")
    driven, data = run.machine, run.data
    cylinders = [f"cylinder.{name}" for name in driven.cylinder_names]
    joints = [f"joint.{name}" for name in driven.joint_names]

    def of(places: list[str], *kinds: str) -> Array:
        return np.column_stack([data[f"{place}.{kind}"].values for place in places for kind in kinds])

    q, tip, set_point = of(joints, "q"), of(["tip"], "x", "z"), of(["set_point"], "x", "z")
    low, high = driven.joint_limits.T
    return Soak(
        outcome=run.outcome.kind,
        warnings=tuple(warning.text for warning in run.warnings),
        alarms=alarms(run),
        tip_speed=float(np.hypot(*np.einsum("tij,tj->it", driven.tip_jacobian(q), of(joints, "qd"))).max()),
        pressure=float(of(cylinders, "p1", "p2").max()) / driven.supply_pressure,
        beyond_limits=float(max(0.0, (np.maximum(low - q, q - high) / (high - low)).max())),
        lag=float(np.nanmax(np.hypot(*(tip - set_point).T))),
        clearance=float(driven.clearance(tip).min()) if driven.keep_out else float("inf"),
        travel=spool_travel(data["time"].values, of(cylinders, "command") / driven.spool_strokes),
        spool_rate=float(np.abs(of(cylinders, "vs") / driven.spool_strokes).max()),
    )
