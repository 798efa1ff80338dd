"""Logs as columns: whatever people have with a time column becomes names and values."""

from __future__ import annotations

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
from hydrocrane.logs.table import Table

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


class Holder(Protocol):
    """Anything that holds its data as a run or a log does."""

    @property
    def data(self) -> xr.Dataset: ...


# A path, or what people have in memory.
LogLike: TypeAlias = "str | PathLike[str] | xr.Dataset | pd.DataFrame | Mapping[str, ArrayLike] | Holder"


def columns_of(log: LogLike) -> dict[str, Array]:
    """Any supported log as column name -> values; text columns are left out, dates are seconds from the first.

    Columns of a file are converted to SI where the file states a unit that is known.
    """
    if isinstance(log, str | PathLike):
        return read_table(Path(log)).in_si()
    return table_of_log(log).columns


def table_of_log(log: LogLike) -> Table:
    """The columns of what people have in memory, and which were left out."""
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
    """Columns of a table, with its index where that has a name or holds dates; names may be equal."""
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
