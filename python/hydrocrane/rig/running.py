"""Running an experiment: scenario and simulation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.errors import InputError
from hydrocrane.machine.machine import Machine
from hydrocrane.machine.overrides import Overrides, plain_overrides
from hydrocrane.rig.course import Course, seal_of
from hydrocrane.rig.experiments import course_of, experiment
from hydrocrane.rig.log import Rig, RigLog, machine_of, reading
from hydrocrane.rig.steady import SteadyValve
from hydrocrane.scenario.changes import check_equal
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.scenario.series import Command
from hydrocrane.scenario.solver import Solver

if TYPE_CHECKING:
    import xarray as xr

# Possible intervals of a log, s, and the most samples; the shortest allowed interval is taken.
INTERVALS = (1e-3, 2e-3, 5e-3, 1e-2)
MOST_SAMPLES = 20_000
# A fixed method, so that logs and the results identified from them are those of reproductions and validation.
SOLVER = Solver(method="rodas5p", rtol=1e-6)


def scenario(
    rig: Rig,
    name: str,
    *,
    payload: float | None = None,
    supply: float | str | None = None,
    overrides: Overrides | None = None,
    interval: float | None = None,
    **options: ArrayLike,
) -> Scenario:
    """The experiment `name` on `rig` as an open-loop scenario; parameters as for :func:`run`."""
    machine = machine_of(rig, supply, overrides)
    return _plan(machine, name, payload, interval, course_of(name, seal_of(machine), options))


def run(
    name: str,
    rig: Rig = "rig-rottne",
    *,
    payload: float | None = None,
    supply: float | str | None = None,
    seed: int = 0,
    sensors: str = "data-sheet",
    bits: int | None = None,
    load_cell: bool = True,
    calibration: float = 0.0,
    earlier: int = 0,
    interval: float | None = None,
    overrides: Overrides | None = None,
    **options: ArrayLike,
) -> RigLog:
    """Run an experiment on a rig and read its sensors.

    Parameters
    ----------
    name : str
        One of :func:`experiments`.
    rig : str, path or Machine
        A machine with one hanging cylinder: ``rig-rottne``, ``rig-kalmar``, or one that extends them.
    payload : float, optional
        Load on the rod, kg.
    supply : float or str, optional
        Supply pressure, Pa or with its unit.
    seed : int
        Seed of the errors of the sensors. The motion does not depend on it.
    sensors : {"data-sheet", "ideal"}
    bits : int, optional
        Resolution of all converters in place of the machine's.
    load_cell : bool
        Log the force on the rod.
    calibration : float
        Seconds logged before the run, with the load supported and both chambers open to the tank. The readings of the
        pressure sensors and the load cell are then their zero.
    earlier : int
        Number of samples that the same sensors, those of `seed`, logged in earlier runs, so that no two runs have the
        same noise.
    interval : float, optional
        Time between samples, s.
    overrides : mapping, optional
        Machine keys to change; `payload` and `supply` state two of them, and may not differ from these.
    **options
        Options of the experiment, see :mod:`hydrocrane.rig.experiments`.
    """
    from hydrocrane.simulation.running import simulate

    given = plain_overrides(overrides or {})
    check_equal("payload", payload, "kg", "payload.mass", given)
    check_equal("supply", supply, "Pa", "supply.pressure", given)
    machine = machine_of(rig, supply, overrides, bits)
    course = course_of(name, seal_of(machine), options)
    plan = _plan(machine, name, payload, interval, course)
    done = simulate(plan, ledger=False)
    about = _about(machine, name, plan, done.data)
    return reading(machine, done, course.segments(0.0), about, seed, sensors, load_cell, calibration, earlier)


class RunSettings(TypedDict, total=False):
    """Settings of :func:`run`, without the options of an experiment."""

    payload: float | None
    supply: float | str | None
    seed: int
    sensors: str
    bits: int | None
    load_cell: bool
    calibration: float
    earlier: int
    interval: float | None
    overrides: Overrides | None
    slips: float
    levels: Sequence[float]


def series(name: str, rig: Rig = "rig-rottne", **settings: Unpack[RunSettings]) -> list[RigLog]:
    """All runs of an experiment that varies the load or the supply pressure; one run of any other experiment.

    `settings` are those of :func:`run` without the varied one. Loads are 0, 20 and 115 kg, pressures the
    rig's own and 5/7 of it: 140 and 100 bar on ``rig-rottne`` (Figures 74, 75).
    """
    members = experiment(name).series
    varied = {key for member in members for key in member}
    for key in sorted(varied & {k for k, value in settings.items() if value is not None}):
        raise InputError(f"{name} varies `{key}` itself; omit it, or run one of them with hydrocrane.rig.run")
    rest: dict[str, Any] = {key: value for key, value in settings.items() if key not in varied}
    if "supply" in varied:
        own = machine_of(rig, None, settings.get("overrides")).supply_pressure
        largest = max(member["supply"] for member in members)
        members = tuple({"supply": own * member["supply"] / largest} for member in members)
    logs: list[RigLog] = []
    earlier = rest.pop("earlier", 0)
    for member in members:
        logs.append(run(name, rig, **rest | member, earlier=earlier))
        earlier += logs[-1].data.sizes["time"]
    return logs


def _plan(machine: Machine, name: str, payload: float | None, interval: float | None, course: Course) -> Scenario:
    mass = machine.payload(payload)
    valve = SteadyValve(machine, course.fastest, mass)
    time, cylinder, duration = np.array(course.time), machine.cylinder_names[0], course.time[-1]
    if interval is None:
        interval = next((dt for dt in INTERVALS if duration / dt <= MOST_SAMPLES), INTERVALS[-1])
    return Scenario(
        machine=machine,
        joints={machine.joint_names[0]: course.start(machine)},
        commands={cylinder: Command(time, valve.spool(np.array(course.velocity)), "linear")},
        pressures={cylinder: _relaxed(machine, valve, course, mass)},
        duration=duration,
        record_interval=interval,
        payload=payload,
        solver=SOLVER,
        name=f"rig-{name}",
        title=experiment(name).title,
    )


def _relaxed(machine: Machine, valve: SteadyValve, course: Course, payload: float) -> tuple[float, float]:
    """Pressures (Pa) at rest without friction, at the level of the first motion."""
    first = int(np.sign(next(v for v in course.velocity if v)))
    p1, p2 = valve.pressures(first)
    a1, a2 = machine.piston_areas[0]
    weight = float(machine.static_cylinder_force([0.0], payload=payload)[0])
    return float((p2 * a2 + weight) / a1), p2


def _about(machine: Machine, name: str, plan: Scenario, recorded: xr.Dataset) -> dict[str, str | float]:
    """Description of the experiment as plain strings and numbers, which every file format can store."""
    kept = ("machine", "machine_overrides", "outcome", "outcome_time", "outcome_message", "source")
    return {
        "title": f"{machine.title}: {plan.title}",
        "experiment": name,
        "payload": machine.payload(plan.payload),
        "supply": machine.supply_pressure,
        **{key: recorded.attrs[key] for key in kept},
        "Conventions": "SI units, gauge pressures",
    }
