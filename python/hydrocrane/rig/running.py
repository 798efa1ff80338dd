"""Running an experiment: scenario, simulation, calibration, readings."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrocrane.arrays import real_array
from hydrocrane.errors import InputError
from hydrocrane.machine import Machine, load_machine, plain_overrides
from hydrocrane.rig.course import Course, seal_of
from hydrocrane.rig.experiments import course_of, experiment
from hydrocrane.rig.log import COLUMNS, RigLog
from hydrocrane.rig.steady import SteadyValve
from hydrocrane.scenario import Command, Scenario, Solver

if TYPE_CHECKING:
    import xarray as xr

Rig = str | PathLike[str] | Machine
# Intervals of a log, s; one is taken that gives at most as many samples.
INTERVALS = (1e-3, 2e-3, 5e-3, 1e-2)
MOST_SAMPLES = 20_000


def scenario(
    rig: Rig,
    name: str,
    *,
    payload: float | None = None,
    supply: float | str | None = None,
    overrides: Mapping[str, Any] | None = None,
    interval: float | None = None,
    **options: Any,
) -> Scenario:
    """The experiment `name` on `rig` as an open-loop scenario; parameters as for :func:`run`."""
    crane = _machine(rig, supply, overrides)
    return _plan(crane, name, payload, interval, course_of(name, seal_of(crane), options))


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
    interval: float | None = None,
    overrides: Mapping[str, Any] | None = None,
    **options: Any,
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
        Draws the errors of the sensors. They alone depend on it: the motion is the same.
    sensors : {"data-sheet", "ideal"}
    bits : int, optional
        Resolution of all converters in place of the machine's.
    load_cell : bool
        Log the force on the rod.
    calibration : float
        Seconds logged before, with the load supported and both chambers open to the tank: what the pressure sensors and
        the load cell then read is their zero.
    interval : float, optional
        Time between samples, s.
    overrides : mapping, optional
        Machine keys to change.
    **options
        Of the experiment: see :mod:`hydrocrane.rig.experiments`.
    """
    from hydrocrane.simulation import simulate

    crane = _machine(rig, supply, overrides, bits)
    course = course_of(name, seal_of(crane), options)
    plan = _plan(crane, name, payload, interval, course)
    lead = _lead(calibration, plan.record_interval)
    done = simulate(plan, ledger=False)
    recorded = _with_calibration(crane, done.data, lead, plan.record_interval)
    readings = crane.measure(recorded, sensors=sensors, seed=seed)
    data = _data(crane, recorded, readings, load_cell)
    data.attrs = _about(crane, name, plan, recorded, {"seed": int(seed), "sensors": sensors, "calibration": lead}) | {
        "segments": json.dumps([dataclasses.asdict(segment) for segment in course.segments(lead)])
    }
    return RigLog(data, _truth(crane, recorded), done)


def series(name: str, rig: Rig = "rig-rottne", **settings: Any) -> list[RigLog]:
    """All runs of an experiment that varies the load or the supply pressure; one run of any other.

    `settings` are those of :func:`run`; what is varied may not be among them. Loads are 0, 20 and 115 kg, pressures the
    rig's own and 5/7 of it: 140 and 100 bar on ``rig-rottne`` (Figures 74, 75).
    """
    members = experiment(name).series
    varied = {key for member in members for key in member}
    for key in sorted(varied & {k for k, value in settings.items() if value is not None}):
        raise InputError(f"{name} varies `{key}` itself; leave it out, or run one of them with hydrocrane.rig.run")
    rest = {key: value for key, value in settings.items() if key not in varied}
    if "supply" in varied:
        own = _machine(rig, None, settings.get("overrides")).supply_pressure
        largest = max(member["supply"] for member in members)
        members = tuple({"supply": own * member["supply"] / largest} for member in members)
    return [run(name, rig, **rest, **member) for member in members]


def _machine(
    rig: Rig, supply: float | str | None, overrides: Mapping[str, Any] | None, bits: int | None = None
) -> Machine:
    """The rig with everything that its file is to be changed in."""
    given = rig if isinstance(rig, Machine) else load_machine(rig)
    if len(given.joint_names) != 1 or given.joint_units[0] != "m":
        raise InputError(
            f"{given.name} is no friction rig: it takes one cylinder on one sliding joint, as rig-rottne has"
        )
    changes = plain_overrides(overrides or {})
    if supply is not None:
        changes |= plain_overrides({"supply.pressure": supply})
    if bits is not None:
        sensors = {key.split(".")[1] for key, _, _ in given.provenance if key.startswith("sensor.")}
        changes |= {f"sensor.{sensor}.bits": bits for sensor in sorted(sensors)}
    return load_machine(given.source, {**given.overrides, **changes}) if changes else given


def _plan(crane: Machine, name: str, payload: float | None, interval: float | None, course: Course) -> Scenario:
    mass = crane.payload(payload)
    valve = SteadyValve(crane, course.fastest, mass)
    time, cylinder, duration = np.array(course.time), crane.cylinder_names[0], course.time[-1]
    if interval is None:
        interval = next((dt for dt in INTERVALS if duration / dt <= MOST_SAMPLES), INTERVALS[-1])
    return Scenario(
        machine=crane,
        joints={crane.joint_names[0]: course.start(crane)},
        commands={cylinder: Command(time, valve.spool(np.array(course.velocity)), "linear")},
        pressures={cylinder: _relaxed(crane, valve, course, mass)},
        duration=duration,
        record_interval=interval,
        payload=payload,
        solver=Solver(rtol=1e-6),
        name=f"rig-{name}",
        title=experiment(name).title,
    )


def _relaxed(crane: Machine, valve: SteadyValve, course: Course, payload: float) -> tuple[float, float]:
    """Pressures (Pa) at rest without friction, at the level of the motion that comes first."""
    first = int(np.sign(next(v for v in course.velocity if v)))
    p1, p2 = valve.pressures(first)
    a1, a2 = crane.piston_areas[0]
    weight = float(crane.static_cylinder_force([0.0], payload=payload)[0])
    return float((p2 * a2 + weight) / a1), p2


def _lead(calibration: float, interval: float) -> float:
    """Whole intervals of calibration before the run, s."""
    duration = real_array(calibration, "calibration")
    if duration.ndim or duration < 0:
        raise InputError(f"calibration must be one time in s, zero or more; got {calibration!r}")
    return float(np.ceil(duration / interval * (1 - 1e-9)) * interval)


def _with_calibration(crane: Machine, data: xr.Dataset, lead: float, step: float) -> xr.Dataset:
    """The record with `lead` seconds before it in which the rig rests on a support, open to the tank."""
    import xarray as xr

    later = data.assign_coords(time=data.time + lead)
    later.time.attrs = data.time.attrs
    if lead == 0.0 or not data.sizes["time"]:
        return later
    rest = xr.zeros_like(data.isel(time=np.zeros(round(lead / step), dtype=int)))
    joint = f"joint.{crane.joint_names[0]}.q"
    cylinder = f"cylinder.{crane.cylinder_names[0]}"
    rest[joint] = rest[joint] + data[joint].values[0]
    rest[f"{cylinder}.x"] = rest[joint]
    for name in ("p1", "p2"):
        rest[f"{cylinder}.{name}"] = rest[f"{cylinder}.{name}"] + float(crane.core.tank_pressure)
    rest = rest.assign_coords(time=np.arange(rest.sizes["time"]) * step)
    joined = xr.concat([rest, later], "time", combine_attrs="override")
    joined.attrs = data.attrs
    return joined


def _data(crane: Machine, recorded: xr.Dataset, readings: xr.Dataset, load_cell: bool) -> xr.Dataset:
    import xarray as xr

    cylinder = f"cylinder.{crane.cylinder_names[0]}"
    signals = {"x": f"joint.{crane.joint_names[0]}.q", "p1": f"{cylinder}.p1", "p2": f"{cylinder}.p2"}
    if load_cell:
        signals["force"] = f"{cylinder}.force"
        if signals["force"] not in readings:
            raise InputError(
                f"{crane.name} has no load cell; give load_cell=False, or a [sensor] that measures the force"
            )
    data = xr.Dataset(coords={"time": recorded.time})
    for name, signal in signals.items():
        data[name] = readings[signal]
    data["command"] = recorded[f"{cylinder}.command"]
    for column in data.data_vars:
        data[column].attrs["units"] = COLUMNS[str(column)]
    return data


def _truth(crane: Machine, recorded: xr.Dataset) -> xr.Dataset:
    import xarray as xr

    cylinder = f"cylinder.{crane.cylinder_names[0]}"
    names = {name: f"{cylinder}.{name}" for name in ("x", "v", "p1", "p2", "force", "friction", "z")}
    names["spool"] = f"{cylinder}.xs"
    kept = {name: recorded[signal] for name, signal in names.items() if signal in recorded}
    return xr.Dataset(kept, coords={"time": recorded.time}, attrs=recorded.attrs)


def _about(crane: Machine, name: str, plan: Scenario, recorded: xr.Dataset, reading: dict[str, Any]) -> dict[str, Any]:
    """What was run: plain strings and numbers, so that every file format keeps them."""
    kept = ("machine", "machine_source", "machine_overrides", "outcome", "outcome_time", "outcome_message", "source")
    about = {key: recorded.attrs[key] for key in kept}
    own = {"experiment": name, "payload": crane.payload(plan.payload), "supply": crane.supply_pressure}
    return {
        "title": f"{crane.title}: {plan.title}",
        **own,
        **reading,
        **about,
        "Conventions": "SI units, gauge pressures",
    }
