"""Any data with a time column as chosen signals in SI: for sticks, commands, supply pressures and comparisons."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace
from os import PathLike
from os.path import isdir, isfile
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, nearest
from hydrocrane.files.columns import is_dataset
from hydrocrane.logs.assembly import clock_seconds, no_column, signals_of
from hydrocrane.logs.formats.readers import read_table, table_of_columns, table_of_dataset, table_of_frame
from hydrocrane.logs.mapping import LogMapping, Source
from hydrocrane.logs.table import AS_FOUND, MOST_NAMED, Clocked, LogColumn, LogForm, LogTable, said_of
from hydrocrane.result_warning import DoubtfulResult

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


class Holder(Protocol):
    """An object with its data in the same attribute as a run or a log."""

    @property
    def data(self) -> xr.Dataset: ...


# A path, or data in memory.
LogLike: TypeAlias = "str | PathLike[str] | xr.Dataset | pd.DataFrame | Mapping[str, ArrayLike] | Holder"


def table_of(log: LogLike, form: LogForm = AS_FOUND) -> LogTable:
    """The columns of a file or of data in memory, and those that were left out."""
    if isinstance(log, str | PathLike):
        table = read_table(Path(log), form)
        table.source = Path(log).name
        return table
    held = getattr(log, "data", None)
    data = held if is_dataset(held) else log
    if is_dataset(data):
        table = table_of_dataset(data)
    elif hasattr(data, "columns") and hasattr(data, "dtypes"):
        table = table_of_frame(cast("pd.DataFrame", data), form)
    elif isinstance(data, Mapping):
        table = table_of_columns(data.items(), {}, form)
    else:
        raise InputError(
            f"a log is an xarray Dataset, a pandas DataFrame, a mapping or a path; got {type(log).__name__}"
        )
    table.in_memory = True
    return table


def joined(log: LogLike, mapping: LogMapping) -> tuple[LogTable, LogMapping]:
    """Columns of the files that a mapping names, each with the clock of its file, and the mapping to these columns."""
    if not isinstance(log, str | PathLike):
        raise InputError(f"{mapping.origin} names files, which are looked for beside a log; give the path of the log")
    log = Path(log)
    joint = LogTable(source=log.name, clock_key="file")
    parts: dict[Path, LogTable] = {}
    groups: dict[tuple[Path, str], dict[str, LogColumn]] = {}
    signals = {}
    for name, entry in mapping.signals.items():
        where = f"{mapping.origin}: [signal.{name}]"
        path = _file(log, entry.file, where)
        part = parts.get(path) or parts.setdefault(path, read_table(path, mapping.form))
        column, clock = part.find(entry.column), _clock_of(part, entry, mapping.time)
        for wanted, found in ((entry.column, column), (entry.time or "time", clock)):
            if found is None:
                raise InputError(f"{where}: {path.name} {no_column(part, wanted)}")
        full = f"{path.name}: {column}"
        groups.setdefault((path, str(clock)), {})[full] = part.columns[str(column)]
        signals[name] = replace(entry, column=full, time=None, file=None)
    for part in parts.values():
        joint.notes += part.notes
        joint.about |= part.about
    joint.add_clocked(_on_one_clock(groups, parts, mapping))
    if mapping.time and mapping.time.file is not None:
        chosen = _file(log, mapping.time.file, f"{mapping.origin}: [time]")
        if chosen not in parts:
            raise InputError(f"{mapping.origin}: [time] file: no signal is in {chosen.name}, so it needs no clock")
        joint.clock = chosen.name
    return joint, replace(mapping, signals=signals, time=None)


def _file(log: Path, wanted: str | None, where: str) -> Path:
    """The file of a log, or the one beside it or in its folder that has a name or a pattern."""
    folder = log if isdir(log) else log.parent
    if wanted is None and folder == log:
        raise InputError(f"{where} needs a `file`, because {log} is a folder")
    if wanted is None or isfile(folder / wanted):
        return folder / wanted if wanted else log
    found = [] if Path(wanted).is_absolute() or not wanted.strip() else sorted(folder.glob(wanted))
    if len(found) != 1:
        names = [path.name for path in found or sorted(folder.iterdir())]
        how = f"fits {', '.join(names[:MOST_NAMED])}; name one" if found else f"is no file in {folder}"
        raise InputError(f"{where} file: `{wanted}` {how}{'' if found else nearest(wanted, names)}")
    return found[0]


def _clock_of(part: LogTable, entry: Source, time: Source | None) -> str | None:
    if entry.time:
        return part.find(entry.time)
    own = part.columns[column].clock if (column := part.find(entry.column)) else ""
    chosen = part.find(time.column) if time and time.column else None
    if chosen and part.columns[chosen].clock == own:
        return chosen
    return own or chosen or part.time_column()


def _on_one_clock(
    groups: Mapping[tuple[Path, str], dict[str, LogColumn]], parts: Mapping[Path, LogTable], mapping: LogMapping
) -> list[Clocked]:
    """Columns with their times, s, from one zero: the earliest date, or that of the numbers."""
    starts = {(path, clock): parts[path].columns[clock].start for path, clock in groups}
    dated = [path.name for (path, _), start in starts.items() if start is not None]
    if dated and len(dated) < len(starts):
        others = [path.name for (path, _), start in starts.items() if start is None]
        text = f"{dated[0]} has dates, and {others[0]} only seconds, whose zero is not known"
        raise InputError(f"{mapping.origin}: {text}")
    zero = min((start for start in starts.values() if start is not None), default=0.0)
    clocked = []
    for (path, clock), columns in groups.items():
        entry = mapping.time if mapping.time and mapping.time.unit else None
        times = clock_seconds(parts[path], clock, entry, f"{path.name}: time column `{clock}`")
        times = times + ((starts[path, clock] or 0.0) - zero)
        clocked.append(Clocked(path.name, times, list(columns.items())))
    return clocked


def series_of(
    table: LogTable,
    wanted: Mapping[str, Source],
    units: Mapping[str, str],
    *,
    time: str | None = None,
    every: bool = False,
    complete: bool = False,
) -> dict[str, Array]:
    """Columns of a table as signals (n,) in SI by name, with their ``time``, s; a DoubtfulResult says what is doubtful.

    Parameters
    ----------
    table : LogTable
    wanted : mapping
        Signal -> column.
    units : mapping
        Signal -> its SI unit; a column of another dimension is an error.
    time : str, optional
        Column of the times; default is one with a usual name, or the only one with dates.
    every : bool
        Whether columns that were left out matter.
    complete : bool
        Whether a missing value is an error.
    """
    source = table.source
    mapping = LogMapping(wanted, None if time is None else Source(time), origin=source)
    data, flags = signals_of(table, mapping, source, units)
    texts = [flag.message for flag in flags if flag.kind != "assumed-unit"]
    for text in (*texts, *(said_of(table.left_out) if every else ())):
        warnings.warn(f"{source}: {text}", DoubtfulResult, stacklevel=3)
    found = {str(name): np.asarray(data[name].values, np.float64) for name in data.variables}
    for name in found if complete else ("time",):
        missing = np.flatnonzero(~np.isfinite(found[name]))
        if missing.size:
            where = "" if name == "time" else f", column `{wanted[name].column}`,"
            at = f"sample {missing[0] + 1}; fill the gap, or cut the log there"
            raise InputError(f"{source} has no value of `{name}`{where} at {at}")
    steps = np.diff(found["time"])
    back = np.flatnonzero(steps < 0.0)
    if back.size:
        last = int(back[0])
        ends = " to ".join(f"{value:.4g}" for value in found["time"][last : last + 2])
        raise InputError(
            f"the time of {source} goes back from {ends} s at sample {last + 1}: it holds more than one drive, or its "
            "clock restarts; take one part"
        )
    return found
