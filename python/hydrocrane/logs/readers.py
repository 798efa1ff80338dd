"""One table from a file of any supported format, chosen by its suffix."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hydrocrane.errors import ResultFileError, nearest
from hydrocrane.files.mdf import mdf_class
from hydrocrane.files.netcdf import read_netcdf
from hydrocrane.files.received import readable, received
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
    received(path)
    suffix = path.suffix.lower()
    if suffix == ".gz":
        suffix = Path(path.stem).suffix.lower()
        if _READERS.get(suffix) not in (None, _text):
            raise ResultFileError(f"{path} is a packed `{suffix}`, and only texts are read packed; unpack it first")
    if suffix not in _READERS:
        raise ResultFileError(f"cannot read `{path.name}`: unknown suffix `{suffix}`{nearest(suffix, _READERS)}")
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
    return table_of_dataset(read_netcdf(path))


def _mdf(path: Path) -> Table:
    """Measurement data format 4 (ASAM); channels of other rates are interpolated at the times of the fastest one."""
    reader = mdf_class()
    with readable(path, "an MDF file that can be read"), reader(path) as stored:
        about = _header_facts(stored.header.description)
        signals = list(stored.iter_channels())
    plain = [s for s in signals if s.samples.dtype.kind in "buif" and s.samples.ndim == 1 and len(s.timestamps)]
    if not plain:
        return Table({})
    time = max((signal.timestamps for signal in plain), key=len).astype(np.float64)
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
    except (ValueError, RecursionError):
        return {}
    return plain_facts(facts) if isinstance(facts, dict) else {}


_READERS = {
    **dict.fromkeys((".csv", ".txt", ".tsv", ".dat", ".log", ".exp"), _text),
    **dict.fromkeys((".h5", ".hdf5"), _hdf5),
    ".mat": _matlab,
    ".nc": _netcdf,
    ".mf4": _mdf,
}
