"""One table from a file of any supported format, chosen by its suffix."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np

from hydrocrane.errors import ResultFileError, nearest
from hydrocrane.files.mdf import mdf_class
from hydrocrane.logs.flags import Flag
from hydrocrane.logs.table import NO_NUMBERS, Table, check_width, plain_facts
from hydrocrane.logs.units import tidy_unit

if TYPE_CHECKING:
    import xarray as xr
    from asammdf import Signal

    from hydrocrane.arrays import Array


def read_table(path: Path) -> Table:
    """Columns of the file at `path`, unchanged.

    Raises
    ------
    ResultFileError
        If there is no such file, or its content does not match its suffix.
    """
    if path.is_dir():
        raise ResultFileError(f"{path} is a folder; name a log in it")
    suffix = path.suffix.lower()
    if suffix == ".gz":
        suffix = Path(path.stem).suffix.lower()
        if _READERS.get(suffix) not in (None, _text):
            raise ResultFileError(f"{path} is a packed `{suffix}`, and only texts are read packed; unpack it first")
    if suffix not in _READERS:
        raise ResultFileError(f"cannot read `{path.name}`: unknown suffix `{suffix}`{nearest(suffix, _READERS)}")
    if not path.is_file():
        raise ResultFileError(f"no such file: {path}")
    if not path.stat().st_size:
        raise ResultFileError(f"{path} is empty; copy it again from the logger")
    table = _READERS[suffix](path)
    check_width(path, len(table.columns))
    if not table.columns:
        raise ResultFileError(
            f"{path} holds no column of numbers; objects of MATLAB classes must be saved as structures or arrays"
        )
    return table


def table_of_dataset(data: xr.Dataset) -> Table:
    """Columns of a dataset: its one-dimensional numeric variables, with their `units`."""
    table = Table({})
    for name in data.variables:
        table.take(str(name), data[name].values, tidy_unit(str(data[name].attrs.get("units", ""))))
    table.about = plain_facts(data.attrs)
    return table


def _text(path: Path) -> Table:
    from hydrocrane.logs.text import read_text

    return read_text(path)


def _matlab(path: Path) -> Table:
    from hydrocrane.logs.matlab import read_matlab

    return read_matlab(path)


def _hdf5(path: Path) -> Table:
    from hydrocrane.logs.matlab import read_hdf5

    return read_hdf5(path)


def _netcdf(path: Path) -> Table:
    import xarray as xr

    with path.open("rb") as stream:
        classic = stream.read(3) == b"CDF"
    try:
        if not classic:
            # For files that this cannot open, the message of xarray is misleading.
            h5py.File(path, "r").close()
        with xr.open_dataset(path, engine="scipy" if classic else "h5netcdf", decode_times=False) as stored:
            return table_of_dataset(stored.load())
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ResultFileError(f"{path} is not a NetCDF file: {error}; copy it again, or check its suffix") from None


def _mdf(path: Path) -> Table:
    """Measurement data format 4 (ASAM); channels of other rates are interpolated at the times of the fastest one."""
    reader = mdf_class()
    try:
        with reader(path) as stored:
            about = _header_facts(stored.header.description)
            signals = list(stored.iter_channels())
    except Exception as error:  # For damaged files the library raises its own and many built-in exceptions.
        raise ResultFileError(f"{path} is not an MDF file that can be read: {error}") from None
    readable = [s for s in signals if s.samples.dtype.kind in "buif" and s.samples.ndim == 1 and len(s.timestamps)]
    if not readable:
        return Table({})
    time = max((signal.timestamps for signal in readable), key=len).astype(np.float64)
    table = Table({"time": time}, {"time": "s"}, about=about)
    for signal in signals:
        if not len(signal.timestamps):
            table.leave(signal.name, "no samples")
        elif signal.samples.dtype.kind not in "buif" or signal.samples.ndim != 1:
            table.leave(signal.name, NO_NUMBERS)
        else:
            _add_channel(table, signal, time)
    return table


def _add_channel(table: Table, signal: Signal, time: Array) -> None:
    values = signal.samples.astype(np.float64)
    if not np.array_equal(signal.timestamps, time):
        values = np.interp(time, signal.timestamps, values, left=np.nan, right=np.nan)
    name = table.add(signal.name, values, tidy_unit(str(signal.unit or "")))
    if not np.array_equal(signal.timestamps, time):
        message = f"`{name}` has other times than the rest and is interpolated at theirs"
        table.notes.append(Flag("resampled", name, float(time[0]), float(time[-1]), message))


def _header_facts(text: str) -> dict[str, str | float | int]:
    """Facts from the text of an MDF header, which is JSON in files of this package and arbitrary in others."""
    try:
        facts = json.loads(text)
    except ValueError:
        return {}
    return plain_facts(facts) if isinstance(facts, dict) else {}


_READERS = {
    **dict.fromkeys((".csv", ".txt", ".tsv", ".dat", ".log", ".exp"), _text),
    **dict.fromkeys((".h5", ".hdf5"), _hdf5),
    ".mat": _matlab,
    ".nc": _netcdf,
    ".mf4": _mdf,
}
