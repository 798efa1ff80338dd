"""What a machine's sensors would have read of a run that is recorded already."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrocrane import _core
from hydrocrane.controllers import SENSORS, SensorFault
from hydrocrane.errors import InputError, translated, unknown

if TYPE_CHECKING:
    import xarray as xr

    from hydrocrane.machine import Machine


def measure(
    crane: Machine,
    recorded: Any,
    *,
    sensors: str = "data-sheet",
    seed: int = 0,
    faults: Sequence[SensorFault] = (),
    payload: float | None = None,
) -> xr.Dataset:
    """See :meth:`hydrocrane.machine.Machine.measure`."""
    import xarray as xr

    if sensors not in SENSORS:
        raise unknown("kind of sensors", sensors, SENSORS)
    data = getattr(recorded, "data", recorded)
    if not isinstance(data, xr.Dataset) or "time" not in data.coords:
        raise InputError(f"measure takes a run or its dataset over `time`, got {type(recorded).__name__}")
    missing = [name for name in crane.state_names if name not in data]
    if missing:
        raise InputError(
            f"the recorded data lack the state `{missing[0]}` of {crane.name}: they are of another machine"
        )
    time = np.ascontiguousarray(data.time.values, dtype=np.float64)
    states = np.stack([data[name].values for name in crane.state_names], axis=-1).astype(np.float64)
    if not (np.isfinite(time).all() and np.isfinite(states).all() and (np.diff(time) > 0).all()):
        raise InputError("the recorded times must grow, and times and states be finite")
    mass = crane.payload(data.attrs.get("payload") if payload is None else payload)
    entries = [fault.entry for fault in faults]
    with translated():
        signals, table = _core.measure(crane.core, time, states, mass, sensors, _checked_seed(seed), entries)
    about = {name: (unit, text) for name, unit, text in _described(crane)}
    readings = xr.Dataset(coords={"time": ("time", time, {"units": "s", "long_name": "time"})})
    for i, name in enumerate(signals):
        unit, text = about[name]
        readings[name] = ("time", np.asarray(table)[:, i].copy(), {"units": unit, "long_name": f"{text}, as read"})
    readings.attrs = {"machine": crane.name, "sensors": sensors, "seed": int(seed)}
    return readings


def _checked_seed(seed: Any) -> int:
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or not 0 <= seed < 2**63:
        raise InputError(f"seed must be a whole number, zero or more; got {seed!r}")
    return int(seed)


def _described(crane: Machine) -> list[tuple[str, str, str]]:
    states = zip(crane.state_names, crane.state_units, crane.core.state_long_names, strict=True)
    return [*states, *crane.core.output_info]
