"""Logs as columns: whatever people have with a time column becomes names and values."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError, ResultFileError

TIME_NAMES = ("time", "t", "time [s]", "time_s")


def columns_of(log: Any) -> dict[str, Array]:
    """Any supported log as column name -> values; text columns are left out."""
    if isinstance(log, str | PathLike):
        log = _read(Path(log))
    if hasattr(log, "data") and isinstance(log.data, xr.Dataset):
        log = log.data
    if isinstance(log, xr.Dataset):
        log = {str(name): log[name].values for name in log.variables}
    elif hasattr(log, "columns") and hasattr(log, "iloc"):
        named_index = {str(log.index.name): log.index} if log.index.name else {}
        log = named_index | {str(name): log[name] for name in log.columns}
    if not isinstance(log, Mapping):
        raise InputError(
            f"a log is an xarray Dataset, a pandas DataFrame, a mapping or a path; got {type(log).__name__}"
        )
    table = {str(name): np.asarray(values) for name, values in log.items()}
    return {name: v.astype(np.float64) for name, v in table.items() if v.dtype.kind in "buif" and v.ndim == 1}


def _read(path: Path) -> Any:
    if not path.is_file():
        raise ResultFileError(f"no such file: {path}")
    if path.suffix.lower() == ".nc":
        with xr.open_dataset(path, engine="h5netcdf", decode_times=False) as stored:
            return stored.load()
    if path.suffix.lower() == ".mat":
        return _read_matlab(path)
    import pandas as pd

    try:
        return pd.read_csv(path)
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
        raise ResultFileError(f"{path} is not a CSV table: {error}") from None


def _read_matlab(path: Path) -> dict[str, np.ndarray]:
    """Vectors of a MATLAB file; names that :meth:`Run.save` had to shorten get their dots back."""
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        content = loadmat(path, squeeze_me=True, simplify_cells=True)
    except (MatReadError, ValueError, NotImplementedError) as error:
        raise ResultFileError(f"{path} is not a MATLAB file that can be read: {error}") from None
    names = content.get("names")
    full = names if isinstance(names, dict) else {}
    return {full.get(key, key): np.atleast_1d(v) for key, v in content.items() if isinstance(v, np.ndarray | float)}


def time_of(table: dict[str, Array]) -> Array:
    """The time column, s."""
    for name in TIME_NAMES:
        if name in table:
            return real_array(table[name], f"the log's `{name}`")
    raise InputError(
        f"the log has no time column; name it `time`, in seconds. It has {', '.join(table) or 'no columns'}"
    )
