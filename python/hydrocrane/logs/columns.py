"""Any data with a time column as chosen signals in SI: for sticks, commands, supply pressures and comparisons."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.files.columns import is_dataset
from hydrocrane.logs.assembly import signals_of
from hydrocrane.logs.mapping import LogMapping, Source
from hydrocrane.logs.readers import read_table, table_of_columns, table_of_dataset, table_of_frame
from hydrocrane.logs.table import AS_FOUND, Form, Table, said_of
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


def table_of(log: LogLike, form: Form = AS_FOUND) -> Table:
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


def series_of(
    table: Table,
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
    table : Table
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
