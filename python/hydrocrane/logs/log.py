"""A log: signals over time in SI, with the flags of its checks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError, nearest
from hydrocrane.logs.assembly import signals_of
from hydrocrane.logs.checks import checked, clipped_at, readings, rechecked
from hydrocrane.logs.mapping import LogMapping, MappingLike, log_mapping
from hydrocrane.logs.signals import Flag
from hydrocrane.logs.table import LogForm

if TYPE_CHECKING:
    import xarray as xr

    from hydrocrane.logs.columns import LogLike


def stretch(name: str, given: ArrayLike) -> tuple[float, float]:
    """A part of a log by its ends, s; `name` is that of the argument."""
    ends = real_array(given, name)
    if ends.shape != (2,) or not ends[0] < ends[1]:
        raise InputError(f"{name} is (from, to) in s of the log's clock, the first before the second; got {given!r}")
    return float(ends[0]), float(ends[1])


@dataclass(frozen=True)
class Log:
    """Measured signals over time.

    Attributes
    ----------
    data : xarray.Dataset
        Over ``time``, s; each variable with `units` and `long_name`. The signals of a friction rig are ``x``, ``p1``,
        ``p2``, and if present ``v``, ``force`` and ``command``. `attrs` hold the facts that the file states;
        files of the virtual rig state ``experiment``, ``payload``, ``supply``, ``calibration`` and more.
    flags : tuple of Flag
        Results of the checks, fatal ones first.
    source : str
        Where it came from.

    Examples
    --------
    >>> t = np.linspace(0.0, 1.0, 101)
    >>> log = hc.Log.of({"time": t, "x": 0.1 * t, "p1": np.full(101, 50e5)}, source="by hand")
    >>> print(list(log.data), log.data["p1"].attrs["units"], log.flags)
    ['x', 'p1'] Pa ()
    """

    data: xr.Dataset
    flags: tuple[Flag, ...] = ()
    source: str = ""

    @classmethod
    def of(cls, data: LogLike, mapping: MappingLike = None, source: str = "") -> Log:
        """A checked log of a file, Dataset, DataFrame, mapping of arrays or run; in SI unless `mapping` or file says
        otherwise.

        Examples
        --------
        >>> t = np.linspace(0.0, 1.0, 101)
        >>> mapping = {"signal": {"x": {"column": "way", "unit": "mm"}}}
        >>> log = hc.Log.of({"time": t, "way": 100 * t}, mapping)
        >>> print(log.data["x"].values[-1])
        0.1
        """
        if isinstance(data, Log):
            return data if mapping is None else cls.of(data.data, mapping, data.source)
        if isinstance(data, str | PathLike):
            return read_log(data, mapping)
        return _log(data, log_mapping(mapping), source or type(data).__name__)

    @property
    def time(self) -> Array:
        """(n,) s."""
        return np.asarray(self.data["time"].values, dtype=np.float64)

    @property
    def fatal(self) -> tuple[Flag, ...]:
        """Flags that forbid any computation."""
        return tuple(flag for flag in self.flags if flag.fatal)

    def __contains__(self, name: str) -> bool:
        return name in self.data

    def __getitem__(self, name: str) -> Array:
        """(n,) values of a signal, SI; missing, infinite or absurdly large readings are NaN."""
        if name not in self.data:
            known = [str(n) for n in self.data.variables]
            lost = (flag.message for flag in self.flags if flag.kind == "left-out" and f"`{name}" in flag.message)
            cure = next(lost, f"name its column in a mapping, [signal.{name}]")
            raise InputError(f"{self.source}: the log has no signal `{name}`{nearest(name, known)}; {cure}")
        return readings(self.data[name].values)

    def usable(self, *signals: str) -> Log:
        """This log, if it has the `signals` and no fatal flag; else an error that says what is missing or wrong.

        Examples
        --------
        >>> t = np.linspace(0.0, 1.0, 101)
        >>> log = hc.Log.of({"time": t, "x": 0.1 * t, "p1": np.full(101, 50e5)})
        >>> print(log.usable("x") is log)
        True
        """
        for name in signals:
            self[name]
        if self.fatal:
            raise InputError(f"{self.source} cannot be used: " + "; ".join(flag.message for flag in self.fatal))
        return self

    def spoilt(self, *signals: str) -> np.ndarray:
        """(n,) True if one of the `signals` is missing, frozen or at the end of its range.

        Examples
        --------
        >>> t = np.linspace(0.0, 1.0, 101)
        >>> log = hc.Log.of({"time": t, "x": 0.1 * t, "p1": np.full(101, 50e5)})
        >>> print(log.spoilt("p1").any(), log.spoilt("x").any())
        False False
        """
        bad = self.stuck(*signals)
        for name in signals:
            bad |= ~np.isfinite(self[name])
        return bad

    def stuck(self, *signals: str) -> np.ndarray:
        """(n,) True if one of the `signals` is frozen or at the end of its range.

        Examples
        --------
        >>> t = np.linspace(0.0, 1.0, 101)
        >>> log = hc.Log.of({"time": t, "x": 0.1 * t, "p1": np.full(101, 50e5)})
        >>> print(log.stuck("x").sum())
        0
        """
        time = self.time
        bad = np.zeros(time.size, dtype=bool)
        for flag in self.flags:
            if flag.kind in ("frozen", "saturated") and flag.signal in signals:
                bad |= (time >= flag.start) & (time <= flag.end)
            elif flag.kind == "clipped" and flag.signal in signals:
                bad |= np.isin(self[flag.signal], clipped_at(self[flag.signal]))
        return bad

    def between(self, start: float, end: float) -> Log:
        """The part from `start` to `end`, s, checked again.

        Examples
        --------
        >>> t = np.linspace(0.0, 1.0, 101)
        >>> log = hc.Log.of({"time": t, "x": 0.1 * t, "p1": np.full(101, 50e5)})
        >>> print(log.between(0.2, 0.5).data.sizes["time"])
        31
        """
        inside = (self.time >= start) & (self.time <= end)
        if not inside.any():
            raise InputError(f"{self.source}: no sample between {start:.6g} and {end:.6g} s")
        part = self.data.isel(time=inside)
        return replace(self, data=part, flags=rechecked(part, self.flags))

    def summary(self) -> str:
        """Length, signals and flags, one line each.

        Examples
        --------
        >>> t = np.linspace(0.0, 1.0, 101)
        >>> log = hc.Log.of({"time": t, "x": 0.1 * t, "p1": np.full(101, 50e5)})
        >>> print(log.summary())
        dict: 101 samples over 1 s
          x          0 .. 0.1 m
          p1         5e+06 .. 5e+06 Pa
        """
        time = self.time
        lines = [f"{self.source}: {time.size} samples over {time[-1] - time[0] if time.size else 0.0:.6g} s"]
        for name in map(str, self.data.data_vars):
            values, unit = self[name], self.data[name].attrs.get("units", "")
            if np.isfinite(values).any():
                lost = int(np.count_nonzero(~np.isfinite(values)))
                missing = f", {lost} samples missing" if lost else ""
                lines.append(f"  {name:<10} {np.nanmin(values):.5g} .. {np.nanmax(values):.5g} {unit}{missing}")
            else:
                lines.append(f"  {name:<10} no finite value")
        return "\n".join(lines + [f"  {'FATAL ' if flag.fatal else ''}{flag}" for flag in self.flags])

    def save(self, path: str | PathLike[str]) -> Path:
        """Write the signals to ``.csv``, ``.mat``, ``.nc``, ``.h5`` or ``.mf4``; it reads back equal.

        Examples
        --------
        >>> t = np.linspace(0.0, 1.0, 101)
        >>> log = hc.Log.of({"time": t, "x": 0.1 * t, "p1": np.full(101, 50e5)})
        >>> path = log.save("drive.csv")
        >>> print(path.name, list(hc.Log.of(path).data))
        drive.csv ['x', 'p1']
        """
        from hydrocrane.logs.formats.writers import write_log

        return write_log(self.data, Path(path))


def read_log(path: str | PathLike[str], mapping: MappingLike = None, *, number_format: str | None = None) -> Log:
    """Read and check a log.

    Parameters
    ----------
    path : str or path
        ``.csv`` (also ``.txt``, ``.tsv``, ``.dat``, ``.log``, ``.exp``, each also with ``.gz``), ``.mat`` of any
        version, ``.h5``, ``.nc``, ``.parquet``, ``.xlsx`` (its first sheet), ``.mf4``, ``.mcap``, or a bag of ROS; with
        a mapping that names files, the folder of these.
    mapping : path, dict or LogMapping, optional
        Assigns columns to signals, see ``docs/reference/log-files.md``; without it every numeric column is kept
        under its own name.
    number_format : {"1,234.5", "1.234,5"}, optional
        How a text writes numbers; by default its cells say, and a column that may mean two things is left out. The same
        as ``number-format`` in the mapping.

    Raises
    ------
    ResultFileError
        If the file cannot be read.
    InputError
        If a column or unit does not match the mapping.

    Examples
    --------
    >>> path = hc.simulate("vertical-lift-open-loop", duration=1.0).save("drive.csv")
    >>> log = hc.read_log("drive.csv")
    >>> print("cylinder.lift.p1" in log.data, log.data.sizes["time"])
    True 101
    """
    chosen = log_mapping(mapping)
    if number_format is not None:
        chosen = chosen or LogMapping()
        chosen = replace(chosen, form=LogForm.of(number_format, chosen.form.dates, "read_log"))
    return _log(path, chosen, str(path))


def _log(log: LogLike, mapping: LogMapping | None, source: str) -> Log:
    from hydrocrane.logs.columns import joined, table_of

    if mapping is not None and mapping.files:
        table, mapping = joined(log, mapping)
    else:
        table = table_of(log, (mapping or LogMapping()).form)
    data, notes = signals_of(table, mapping, source)
    return Log(data, checked(data, notes), source)
