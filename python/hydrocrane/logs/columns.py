"""Logs as columns: whatever people have with a time column becomes names and values."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError
from hydrocrane.files.columns import is_dataset
from hydrocrane.logs.readers import read_table
from hydrocrane.logs.table import Table, as_column

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
    held = getattr(log, "data", None)
    data = held if is_dataset(held) else log
    columns: object = data
    if is_dataset(data):
        columns = {str(name): data[name].values for name in data.variables}
    elif hasattr(data, "columns") and hasattr(data, "iloc"):
        columns = _of_frame(cast("pd.DataFrame", data))
    if not isinstance(columns, Mapping):
        raise InputError(
            f"a log is an xarray Dataset, a pandas DataFrame, a mapping or a path; got {type(log).__name__}"
        )
    table = {str(name): as_column(values) for name, values in columns.items()}
    return {name: column for name, column in table.items() if column is not None and column.ndim == 1}


def _of_frame(frame: pd.DataFrame) -> dict[str, object]:
    """Columns of a table, with its index where that has a name or holds dates."""
    dates = getattr(frame.index, "dtype", np.dtype("O")).kind == "M"
    index = {str(frame.index.name or "time"): frame.index} if frame.index.name or dates else {}
    return index | {str(name): frame[name] for name in frame.columns}


def time_of(table: dict[str, Array]) -> Array:
    """The time column, s."""
    name = Table(table).time_column()
    if name is not None:
        return real_array(table[name], f"the log's `{name}`")
    raise InputError(
        f"the log has no time column; name it `time`, in seconds. It has {', '.join(table) or 'no columns'}"
    )
