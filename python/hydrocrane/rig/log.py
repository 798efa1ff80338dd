"""What a rig experiment leaves: the readings and the truth behind them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

    from hydrocrane.result import Run

# Signals of a log with their units; the load cell is optional.
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
        earlier: int | None = None,
    ) -> RigLog:
        """The same motion, read by other sensors: nothing is simulated again.

        Parameters
        ----------
        seed : int
            Draws the errors of the sensors.
        sensors, load_cell, calibration, earlier : optional
            As for :func:`hydrocrane.rig.run`; by default as in this log.
        bits : int, optional
        overrides : mapping, optional
            Keys of the machine's ``[sensor]`` blocks to change: ``{"sensor.p1.accuracy": "0.1 %"}``.
        """
        from hydrocrane.rig.reading import read_again

        return read_again(self, seed, sensors, bits, load_cell, calibration, overrides, earlier)

    def save(self, path: str | PathLike[str]) -> Path:
        """Write the readings; the suffix decides: ``.csv``, ``.mat``, ``.nc``, ``.h5`` or ``.mf4``."""
        from hydrocrane.logs.writers import write_log

        return write_log(self.data, Path(path))
