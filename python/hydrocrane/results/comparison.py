"""A measured log compared with a run: differences, and a picture of both."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, cast

import numpy as np

from hydrocrane import _core
from hydrocrane.arrays import Array, brief, rms
from hydrocrane.asked import ask
from hydrocrane.errors import InputError, nearest
from hydrocrane.files.columns import TIME, Columns
from hydrocrane.logs import TIME_NAMES, Source, series_of, table_of
from hydrocrane.logs.columns import LogLike
from hydrocrane.logs.table import LogTable
from hydrocrane.notebook import card
from hydrocrane.result_warning import ResultWarning
from hydrocrane.results.record import Record

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Difference:
    """Run minus log for one quantity, at the log's times inside the run.

    Attributes
    ----------
    time, run, log : (k,) arrays
        s, and the two values in `unit`.
    left_out : int
        Samples of the log that are not compared: outside of the run, or without a value.
    rms, maximum : float
        Root mean square and largest absolute difference, in `unit`.
    maximum_time : float
        Time of the largest one, s.
    """

    name: str
    unit: str
    time: Array
    run: Array
    log: Array
    left_out: int = 0

    @property
    def compared(self) -> int:
        """Samples compared."""
        return int(self.time.size)

    __repr__ = brief

    @property
    def rms(self) -> float:
        return rms(self.run - self.log)

    @property
    def maximum(self) -> float:
        return float(np.abs(self.run - self.log).max())

    @property
    def maximum_time(self) -> float:
        return float(self.time[np.argmax(np.abs(self.run - self.log))])


# Share of the samples below which a comparison says little about the log.
LEAST_SHARE = 0.5


@dataclass(frozen=True)
class Comparison:
    """Differences by quantity; a mapping name -> ``Difference`` with shortcuts.

    Attributes
    ----------
    differences : dict
        ``Difference`` by name of the quantity, with both signals, their unit, where they differ most, and how many
        samples are compared and left out.

    Examples
    --------
    >>> run = hc.simulate("vertical-lift-open-loop", duration=1.0)
    >>> heavier = hc.simulate("vertical-lift-open-loop", duration=1.0, payload=20.0)
    >>> apart = run.compare({"time": heavier.columns.time, "tip.z": heavier.columns["tip.z"].values})
    >>> print(list(apart), apart["tip.z"].unit, apart.rms["tip.z"] < 0.01)
    ['tip.z'] m True
    """

    differences: dict[str, Difference]

    __repr__ = brief

    def __getitem__(self, name: str) -> Difference:
        return self.differences[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.differences)

    def __len__(self) -> int:
        return len(self.differences)

    @property
    def rms(self) -> dict[str, float]:
        """Root mean square of each difference, in its unit."""
        return {name: d.rms for name, d in self.differences.items()}

    @property
    def maximum(self) -> dict[str, float]:
        """Largest absolute value of each difference, in its unit."""
        return {name: d.maximum for name, d in self.differences.items()}

    @cached_property
    def figure(self) -> Figure:
        """Run and log in one chart per quantity."""
        return cast("Figure", ask("plots", "comparison", list(self.differences.values())))

    def _repr_html_(self) -> str:
        return card("Run and log", self.summary().splitlines(), "print(comparison.summary())")

    def summary(self) -> str:
        """A line per quantity: root mean square, largest difference, its time, samples compared and their times; then
        warnings.

        Examples
        --------
        >>> run = hc.simulate("vertical-lift-open-loop", duration=0.2)
        >>> log = {"time": run.columns.time, "tip.z": run.columns["tip.z"].values + 0.001}
        >>> print(run.compare(log).summary())
        tip.z  rms 0.001 m, largest 0.001 m at 0 s, 21 samples from 0 to 0.2 s compared, 0 left out
        """
        width = max(len(name) for name in self.differences)
        lines = [
            f"{d.name:<{width}}  rms {d.rms:.4g} {d.unit}, largest {d.maximum:.4g} {d.unit} at {d.maximum_time:.3g} s, "
            f"{d.compared} samples from {d.time[0]:.4g} to {d.time[-1]:.4g} s compared, {d.left_out} left out"
            for d in self.differences.values()
        ]
        return "\n".join([*lines, *(f"warning: {warning}" for warning in self.warnings)])

    @property
    def warnings(self) -> tuple[ResultWarning, ...]:
        """Quantities of which less than half of the log's samples are compared; see docs/reference/warnings.md."""
        few = [d for d in self.differences.values() if d.compared < LEAST_SHARE * (d.compared + d.left_out)]
        return tuple(
            ResultWarning(
                "little-compared",
                f"of `{d.name}` {d.compared} of {d.compared + d.left_out} samples are compared: the others are outside "
                "of the run or have no value",
                "check the unit and the zero of the log's time (s; `shift` moves it), or run longer",
            )
            for d in few
        )


def compare(run: Record, log: LogLike, columns: Mapping[str, str] | None = None, *, shift: float = 0.0) -> Comparison:
    """Compare a run with a log, at the log's samples that lie within the run.

    Parameters
    ----------
    run : Run
    log : xarray.Dataset, pandas.DataFrame, mapping, Run, or path of a CSV or NetCDF file
        With a time column (``time`` or ``t``); s and SI like the run unless it states other units. ``hc.Log.of(log,
        mapping)`` says which column is the clock, and units, signs and offsets.
    columns : mapping, optional
        Log column -> name in ``run.data``; by default columns of the same name, perhaps with a unit behind it, are
        compared.
    shift : float
        Added to the log's time, s.
    """
    table = table_of(log)
    ours = run.columns
    wanted = _pairs(ours, table, columns)
    units = {name: str(ours[name].attrs.get("units", "")) or "1" for name in wanted}
    found = series_of(table, wanted, units, every=columns is None)
    time = found["time"] + float(shift)
    start, end = float(ours.time[0]), float(ours.time[-1])
    inside = (time >= start) & (time <= end)
    if not inside.any():
        raise InputError(
            f"the log covers {time.min():.4g} .. {time.max():.4g} s and the run {start:.4g} .. {end:.4g} s: no overlap"
        )
    return Comparison({name: _difference(ours, name, time, found[name], inside) for name in wanted})


def _difference(ours: Columns, name: str, time: Array, column: Array, inside: np.ndarray) -> Difference:
    """Gaps of the log (NaN) are left out."""
    keep = inside & np.isfinite(column)
    left_out = int(keep.size - keep.sum())
    if not keep.any():
        raise InputError(f"the log has no finite value of `{name}` within the run")
    run = np.interp(time[keep], ours.time, ours[name].values)
    return Difference(name, str(ours[name].attrs.get("units", "")), time[keep], run, column[keep], left_out)


def _pairs(ours: Columns, table: LogTable, columns: Mapping[str, str] | None) -> dict[str, Source]:
    """Run variable -> log column, every name checked."""
    names = [name for name in ours if name != TIME]
    if columns is None:
        # `tip.z [m]` is the run's `tip.z`.
        short = {_core.split_name(column)[0] for column in table.columns}
        pairs = {name: Source(name) for name in names if name in short}
        if not pairs:
            given = ", ".join(n for n in table.columns if n.lower() not in TIME_NAMES)
            raise InputError(f"no column of the log ({given}) is a name of the run; state the pairs with columns=")
        return pairs
    for name in columns.values():
        if name not in names:
            raise InputError(f"the run has no `{name}`{nearest(name, names)}")
    return {name: Source(column) for column, name in columns.items()}
