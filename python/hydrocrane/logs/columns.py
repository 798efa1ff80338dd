"""Logs as columns: names and values from any data with a time column."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError
from hydrocrane.files.columns import is_dataset
from hydrocrane.logs.readers import read_table, table_of_dataset
from hydrocrane.logs.table import Table, said_of
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


def columns_of(log: LogLike, *, every: bool = True) -> dict[str, Array]:
    """Any supported log as column name -> values; dates are seconds from the first.

    Columns of a file are converted to SI where the file states a unit that is known. A column that is no series of
    numbers is left out; a DoubtfulResult names it with the reason, and other faults of the file.

    Parameters
    ----------
    log : path, Dataset, DataFrame, mapping or anything that holds a Dataset as ``data``
    every : bool
        Whether all columns matter. With False there are no such warnings, because the caller selects columns by name.
    """
    if isinstance(log, str | PathLike):
        source, table = Path(log).name, read_table(Path(log))
        columns = table.in_si()
    else:
        source, table = "the log", table_of_log(log)
        columns = table.columns
    for text in (*(note.message for note in table.notes), *said_of(table.left_out)) if every else ():
        warnings.warn(f"{source}: {text}", DoubtfulResult, stacklevel=3)
    return columns


def table_of_log(log: LogLike) -> Table:
    """The columns of data in memory, and those that were left out."""
    held = getattr(log, "data", None)
    data = held if is_dataset(held) else log
    if is_dataset(data):
        return table_of_dataset(data)
    if hasattr(data, "columns") and hasattr(data, "iloc"):
        columns = _of_frame(cast("pd.DataFrame", data))
    elif isinstance(data, Mapping):
        columns = data.items()
    else:
        raise InputError(
            f"a log is an xarray Dataset, a pandas DataFrame, a mapping or a path; got {type(log).__name__}"
        )
    table = Table({})
    for name, values in columns:
        table.take(str(name), values)
    return table


def _of_frame(frame: pd.DataFrame) -> Iterable[tuple[object, object]]:
    """Columns of a table, with its index if that has a name or holds dates; names may repeat."""
    dates = getattr(frame.index, "dtype", np.dtype("O")).kind == "M"
    if frame.index.name or dates:
        yield frame.index.name or "time", frame.index
    for i, name in enumerate(frame.columns):
        yield name, frame.iloc[:, i]


def time_of(table: dict[str, Array]) -> Array:
    """The time column, s."""
    name = Table(table).time_column()
    if name is not None:
        return real_array(table[name], f"the log's `{name}`")
    raise InputError(
        f"the log has no time column; name it `time`, in seconds. It has {', '.join(table) or 'no columns'}"
    )
