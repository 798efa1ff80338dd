"""Result of a rig experiment: the readings and the true signals."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hydrocrane.arrays import real_array
from hydrocrane.errors import InputError
from hydrocrane.machine.machine import Machine, MachineLike, as_machine
from hydrocrane.machine.overrides import Overrides, plain_overrides
from hydrocrane.notebook import card
from hydrocrane.results.run import Run

if TYPE_CHECKING:
    import xarray as xr

Rig = MachineLike

# Signals of a log with their units; the load cell is optional.
COLUMNS = {"time": "s", "x": "m", "p1": "Pa", "p2": "Pa", "force": "N", "command": "m"}


@dataclass(frozen=True)
class Segment:
    """A piece of an experiment: its name, begin and end (s), and the intended mean velocity (m/s)."""

    name: str
    start: float
    end: float
    velocity: float


class RigLog:
    """The log of one experiment.

    Attributes
    ----------
    data : xarray.Dataset
        Sensor readings over ``time``: ``x`` (piston from mid-stroke, m), ``p1``, ``p2`` (Pa), ``force`` (load
        cell, net force on the rod, N; optional); and ``command`` (spool, m). `attrs` describe the experiment.
    truth : xarray.Dataset
        True signals at the same times: ``x``, ``v``, ``p1``, ``p2``, ``force``, ``friction``, ``z``, ``spool``.
    run : Run
        The simulation, without the calibration.
    """

    def __init__(self, data: xr.Dataset, truth: xr.Dataset, run: Run) -> None:
        self.data, self.truth, self.run = data, truth, run

    def __repr__(self) -> str:
        about = self.data.attrs
        return (
            f"<RigLog {about['experiment']} on {about['machine']}: {about['payload']:g} kg,"
            f" {about['supply'] / 1e5:g} bar, {self.data.sizes['time']} samples>"
        )

    def _repr_html_(self) -> str:
        about, columns = self.data.attrs, ", ".join(map(str, self.data))
        pieces = [f"{s.name}  {s.start:.4g} to {s.end:.4g} s, {s.velocity * 1e3:.4g} mm/s" for s in self.segments]
        size = f"samples  {self.data.sizes['time']} of {columns}"
        made = f"rig  {about['machine']}, {about['payload']:g} kg, {about['supply'] / 1e5:g} bar"
        return card(f"Rig log: {about['experiment']}", [made, size, *pieces], "log.segments")

    @cached_property
    def segments(self) -> tuple[Segment, ...]:
        """The pieces of the experiment, in order."""
        return tuple(Segment(**piece) for piece in json.loads(self.data.attrs["segments"]))

    def part(self, segment: Segment, *, truth: bool = False) -> xr.Dataset:
        """The samples of one segment."""
        data = self.truth if truth else self.data
        return data.sel(time=slice(segment.start, segment.end))

    def reread(
        self,
        seed: int,
        *,
        sensors: str | None = None,
        bits: int | None = None,
        load_cell: bool | None = None,
        calibration: float | None = None,
        overrides: Overrides | None = None,
        earlier: int | None = None,
    ) -> RigLog:
        """The same motion with readings of other sensors, without a new simulation.

        Parameters
        ----------
        seed : int
            Seed of the errors of the sensors.
        sensors, load_cell, calibration, earlier : optional
            As for :func:`hydrocrane.rig.run`; by default as in this log.
        bits : int, optional
        overrides : mapping, optional
            Keys of the machine's ``[sensor]`` blocks to change: ``{"sensor.p1.accuracy": "0.1 %"}``.
        """
        return _read_again(self, seed, sensors, bits, load_cell, calibration, overrides, earlier)

    def save(self, path: str | PathLike[str]) -> Path:
        """Write the readings; the suffix decides: ``.csv``, ``.mat``, ``.nc``, ``.h5`` or ``.mf4``."""
        from hydrocrane.logs.formats.writers import write_log

        return write_log(self.data, Path(path))


def machine_of(rig: Rig, supply: float | str | None, overrides: Overrides | None, bits: int | None = None) -> Machine:
    """The rig with all changes of its file."""
    given = as_machine(rig)
    if len(given.joint_names) != 1 or given.joint_units[0] != "m":
        raise InputError(
            f"{given.name} is not a friction rig: a rig needs one cylinder on one sliding joint, as in rig-rottne"
        )
    changes = plain_overrides(overrides or {})
    if supply is not None:
        changes |= plain_overrides({"supply.pressure": supply})
    if bits is not None:
        sensors = {key.split(".")[1] for key, _, _ in given.provenance if key.startswith("sensor.")}
        changes |= {f"sensor.{sensor}.bits": bits for sensor in sorted(sensors)}
    return given.changed(changes)


def reading(
    machine: Machine,
    run: Run,
    segments: Sequence[Segment],
    about: dict[str, str | float],
    seed: int,
    sensors: str,
    load_cell: bool,
    calibration: float,
    earlier: int,
) -> RigLog:
    """The log of a run: `segments` count from its start, `about` becomes the log's attributes."""
    time = run.data.time.values
    step = float(time[1] - time[0]) if time.size > 1 else 1.0
    lead = _lead(calibration, step)
    recorded = _with_calibration(machine, run.data, lead, step)
    readings = machine.measure(recorded, sensors=sensors, seed=seed, earlier=earlier)
    data = _data(machine, recorded, readings, load_cell)
    later = [dataclasses.replace(s, start=s.start + lead, end=s.end + lead) for s in segments]
    data.attrs = about | {
        "seed": int(seed),
        "sensors": sensors,
        "calibration": lead,
        "earlier": int(earlier),
        "segments": json.dumps([dataclasses.asdict(segment) for segment in later]),
    }
    return RigLog(data, _truth(machine, recorded), run)


def _read_again(
    log: RigLog,
    seed: int,
    sensors: str | None,
    bits: int | None,
    load_cell: bool | None,
    calibration: float | None,
    overrides: Overrides | None,
    earlier: int | None,
) -> RigLog:
    about = log.data.attrs
    foreign = [key for key in overrides or {} if not key.startswith("sensor.")]
    if foreign:
        raise InputError(
            f"`{foreign[0]}` changes the motion, which is not run again; change keys of [sensor] only, or use"
            f" hydrocrane.rig.run"
        )
    machine = machine_of(log.run.machine, None, overrides, bits)
    lead = float(about["calibration"])
    segments = [dataclasses.replace(s, start=s.start - lead, end=s.end - lead) for s in log.segments]
    return reading(
        machine,
        log.run,
        segments,
        about | {"machine_overrides": json.dumps(machine.overrides)},
        seed,
        about["sensors"] if sensors is None else sensors,
        "force" in log.data if load_cell is None else load_cell,
        lead if calibration is None else calibration,
        about["earlier"] if earlier is None else earlier,
    )


def _lead(calibration: float, interval: float) -> float:
    """Duration of the calibration before the run, rounded to whole intervals, s."""
    duration = real_array(calibration, "calibration")
    if duration.ndim or duration < 0:
        raise InputError(f"calibration must be one time in s, zero or more; got {calibration!r}")
    return float(np.ceil(duration / interval * (1 - 1e-9)) * interval)


def _with_calibration(machine: Machine, data: xr.Dataset, lead: float, step: float) -> xr.Dataset:
    """The record with a preceding calibration of `lead` seconds: the load on a support, chambers open to the tank."""
    import xarray as xr

    later = data.assign_coords(time=data.time + lead)
    later.time.attrs = data.time.attrs
    if lead == 0.0 or not data.sizes["time"]:
        return later
    rest = xr.zeros_like(data.isel(time=np.zeros(round(lead / step), dtype=int)))
    joint = f"joint.{machine.joint_names[0]}.q"
    cylinder = f"cylinder.{machine.cylinder_names[0]}"
    rest[joint] = rest[joint] + data[joint].values[0]
    rest[f"{cylinder}.x"] = rest[joint]
    for name in ("p1", "p2"):
        rest[f"{cylinder}.{name}"] = rest[f"{cylinder}.{name}"] + float(machine.core.tank_pressure)
    rest = rest.assign_coords(time=np.arange(rest.sizes["time"]) * step)
    joined = xr.concat([rest, later], "time", combine_attrs="override")
    joined.attrs = data.attrs
    return joined


def _data(machine: Machine, recorded: xr.Dataset, readings: xr.Dataset, load_cell: bool) -> xr.Dataset:
    import xarray as xr

    cylinder = f"cylinder.{machine.cylinder_names[0]}"
    signals = {"x": f"joint.{machine.joint_names[0]}.q", "p1": f"{cylinder}.p1", "p2": f"{cylinder}.p2"}
    if load_cell:
        signals["force"] = f"{cylinder}.force"
        if signals["force"] not in readings:
            raise InputError(
                f"{machine.name} has no load cell; give load_cell=False, or a [sensor] that measures the force"
            )
    data = xr.Dataset(coords={"time": recorded.time})
    for name, signal in signals.items():
        data[name] = readings[signal]
    data["command"] = recorded[f"{cylinder}.command"]
    for column in data.data_vars:
        data[column].attrs["units"] = COLUMNS[str(column)]
    return data


def _truth(machine: Machine, recorded: xr.Dataset) -> xr.Dataset:
    import xarray as xr

    cylinder = f"cylinder.{machine.cylinder_names[0]}"
    names = {name: f"{cylinder}.{name}" for name in ("x", "v", "p1", "p2", "force", "friction", "z")}
    names["spool"] = f"{cylinder}.xs"
    kept = {name: recorded[signal] for name, signal in names.items() if signal in recorded}
    return xr.Dataset(kept, coords={"time": recorded.time}, attrs=recorded.attrs)
