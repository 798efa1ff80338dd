"""Sensor readings for a recorded run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from hydrocrane import _core
from hydrocrane.arrays import Array, seed_number, whole_number
from hydrocrane.errors import InputError, check_known, translated
from hydrocrane.machine.sensors import SENSORS, SensorFault

if TYPE_CHECKING:
    import xarray as xr


class Recorded(Protocol):
    """An object with the data of a run, such as :class:`hydrocrane.Run`."""

    @property
    def data(self) -> xr.Dataset: ...


def recorded_data(recorded: Recorded | xr.Dataset) -> xr.Dataset:
    """The data of a run; an error if `recorded` has none."""
    import xarray as xr

    data = recorded if isinstance(recorded, xr.Dataset) else getattr(recorded, "data", None)
    if not isinstance(data, xr.Dataset) or "time" not in data.coords:
        raise InputError(f"measure takes a run or its dataset over `time`, got {type(recorded).__name__}")
    return data


def sensor_readings(
    core: _core.Machine,
    data: xr.Dataset,
    payload: float,
    *,
    sensors: str,
    seed: int,
    faults: Sequence[SensorFault],
    earlier: int,
) -> xr.Dataset:
    """See :meth:`hydrocrane.Machine.measure`."""
    import xarray as xr

    check_known("kind of sensors", sensors, SENSORS)
    missing = [name for name in core.state_names if name not in data]
    if missing:
        raise InputError(f"the recorded data lack the state `{missing[0]}` of {core.name}: they are of another machine")
    time = np.ascontiguousarray(data.time.values, dtype=np.float64)
    states = np.stack([data[name].values for name in core.state_names], axis=-1).astype(np.float64)
    if not (np.isfinite(time).all() and np.isfinite(states).all() and (np.diff(time) > 0).all()):
        raise InputError("the recorded times must increase, and times and states must be finite")
    before, rest = _rest(time, states, earlier)
    entries = [fault.entry for fault in faults]
    with translated():
        signals, table = _core.measure(
            core, np.append(before, time), np.vstack([rest, states]), payload, sensors, seed_number(seed), entries
        )
    about = {name: (unit, text) for name, unit, text in _described(core)}
    readings = xr.Dataset(coords={"time": ("time", time, {"units": "s", "long_name": "time"})})
    for i, name in enumerate(signals):
        unit, text = about[name]
        column = np.asarray(table)[before.size :, i].copy()
        readings[name] = ("time", column, {"units": unit, "long_name": f"{text}, as read"})
    readings.attrs = {"machine": core.name, "sensors": sensors, "seed": int(seed)}
    return readings


def _rest(time: Array, states: Array, earlier: int) -> tuple[Array, Array]:
    """Times before the record with the crane at rest in its first state, (k,) and (k, n)."""
    count = whole_number("earlier", earlier, 0) if time.size else 0
    step = float(time[1] - time[0]) if time.size > 1 else 1.0
    return time[:1] - step * np.arange(count, 0, -1), np.repeat(states[:1], count, axis=0)


def _described(core: _core.Machine) -> list[tuple[str, str, str]]:
    states = zip(core.state_names, core.state_units, core.state_long_names, strict=True)
    return [*states, *core.output_info]
