"""Logs as columns: whatever people have with a time column becomes names and values."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError
from hydrocrane.logs.readers import read_table
from hydrocrane.logs.table import Table, as_column


def columns_of(log: Any) -> dict[str, Array]:
    """Any supported log as column name -> values; text columns are left out, dates are seconds from the first.

    Columns of a file are converted to SI where the file states a unit that is known.
    """
    if isinstance(log, str | PathLike):
        return read_table(Path(log)).in_si()
    if hasattr(log, "data") and isinstance(log.data, xr.Dataset):
        log = log.data
    if isinstance(log, xr.Dataset):
        log = {str(name): log[name].values for name in log.variables}
    elif hasattr(log, "columns") and hasattr(log, "iloc"):
        dates = getattr(log.index, "dtype", np.dtype("O")).kind == "M"
        named_index = {str(log.index.name or "time"): log.index} if log.index.name or dates else {}
        log = named_index | {str(name): log[name] for name in log.columns}
    if not isinstance(log, Mapping):
        raise InputError(
            f"a log is an xarray Dataset, a pandas DataFrame, a mapping or a path; got {type(log).__name__}"
        )
    table = {str(name): as_column(values) for name, values in log.items()}
    return {name: column for name, column in table.items() if column is not None and column.ndim == 1}


def time_of(table: dict[str, Array]) -> Array:
    """The time column, s."""
    name = Table(table).time_column()
    if name is not None:
        return real_array(table[name], f"the log's `{name}`")
    raise InputError(
        f"the log has no time column; name it `time`, in seconds. It has {', '.join(table) or 'no columns'}"
    )
