"""What a rig experiment leaves: the readings, the truth behind them, and files of the readings."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrocrane.errors import ResultFileError, nearest

if TYPE_CHECKING:
    import xarray as xr

    from hydrocrane.result import Run

# Columns of a log with their units, in the order of its files; the load cell is optional.
COLUMNS = {"time": "s", "x": "m", "p1": "Pa", "p2": "Pa", "force": "N", "command": "m"}


@dataclass(frozen=True)
class Segment:
    """A piece of an experiment: its name, from when to when (s), and the mean velocity aimed at (m/s)."""

    name: str
    start: float
    end: float
    velocity: float


class RigLog:
    """The log of one experiment.

    Attributes
    ----------
    data : xarray.Dataset
        Over ``time``, as the sensors read them: ``x`` (piston from mid-stroke, m), ``p1``, ``p2`` (Pa), ``force`` (load
        cell, net force on the rod, N; optional); and ``command`` (spool, m). `attrs` say what was run.
    truth : xarray.Dataset
        At the same times, without any sensor: ``x``, ``v``, ``p1``, ``p2``, ``force``, ``friction``, ``z``, ``spool``.
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
        overrides: Mapping[str, Any] | None = None,
    ) -> RigLog:
        """The same motion, read by other sensors: nothing is simulated again.

        Parameters
        ----------
        seed : int
            Draws the errors of the sensors.
        sensors, load_cell, calibration : optional
            As for :func:`hydrocrane.rig.run`; by default as in this log.
        bits : int, optional
        overrides : mapping, optional
            Keys of the machine's ``[sensor]`` blocks to change: ``{"sensor.p1.accuracy": "0.1 %"}``.
        """
        from hydrocrane.rig.reading import read_again

        return read_again(self, seed, sensors, bits, load_cell, calibration, overrides)

    def save(self, path: str | PathLike[str]) -> Path:
        """Write the readings; the suffix decides: ``.csv``, ``.mat``, ``.nc`` or ``.h5``."""
        return save(self.data, Path(path))


def checked_suffix(path: Path) -> str:
    """The suffix of a log's file, or an error that names those that can be written."""
    suffix = path.suffix.lower()
    if suffix not in _WRITERS:
        raise ResultFileError(f"cannot write `{path.name}`: unknown suffix `{suffix}`{nearest(suffix, _WRITERS)}")
    return suffix


def save(data: xr.Dataset, path: Path) -> Path:
    """Write a log's readings in the format of the suffix; missing folders are made."""
    suffix = checked_suffix(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    _WRITERS[suffix](data, path)
    return path


def _columns(data: xr.Dataset) -> dict[str, np.ndarray]:
    return {name: data[name].values for name in COLUMNS if name in data.variables}


def _csv(data: xr.Dataset, path: Path) -> None:
    """Names in the first row, units in the second, SI numbers below."""
    columns = _columns(data)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerows([columns, [COLUMNS[name] for name in columns]])
        np.savetxt(file, np.stack(list(columns.values()), axis=-1), fmt="%.9g", delimiter=",", newline="\r\n")


def _matlab(data: xr.Dataset, path: Path) -> None:
    """One column vector per column; `units` and `about` are structs beside them."""
    from scipy.io import savemat

    columns: dict[str, Any] = dict(_columns(data))
    columns["units"] = {name: COLUMNS[name] for name in _columns(data)}
    columns["about"] = {str(key): value for key, value in data.attrs.items()}
    savemat(path, columns, oned_as="column", long_field_names=True)


def _hdf5(data: xr.Dataset, path: Path) -> None:
    data.to_netcdf(path, engine="h5netcdf")


_WRITERS: dict[str, Callable[[xr.Dataset, Path], None]] = {
    ".csv": _csv,
    ".mat": _matlab,
    ".nc": _hdf5,
    ".h5": _hdf5,
}
