"""Write logs; reading gives the same numbers."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import h5py

from hydrocrane.files.columns import Columns
from hydrocrane.files.datasets import writable, write_matlab
from hydrocrane.files.mdf import write_mdf
from hydrocrane.files.netcdf import write_netcdf
from hydrocrane.files.text_rows import csv_line, csv_rows
from hydrocrane.files.toml_file import toml_key
from hydrocrane.files.whole_file import written_whole
from hydrocrane.logs.table import plain_facts

if TYPE_CHECKING:
    import xarray as xr


def write_log(data: xr.Dataset, path: Path) -> Path:
    """Write a log's signals and attributes in the format of the suffix, whole or not at all; folders are made."""
    writer = _WRITERS[checked_suffix(path)]
    with written_whole(path) as beside:
        writer(data.assign_attrs(plain_facts(data.attrs)), beside)
    return path


def checked_suffix(path: Path) -> str:
    """The suffix of a log's file, or an error that names those that can be written."""
    return writable(path, _WRITERS)


def _csv(data: xr.Dataset, path: Path) -> None:
    """Comment lines about the log, a row of names, a row of units, then the shortest text that reads back as the same
    double."""
    columns = Columns.of(data)
    table = columns.over_time()
    units = [str(columns[name].attrs.get("units", "")) or "-" for name in table]
    with path.open("wb") as stream:
        facts = ((toml_key(str(name)), json.dumps(value, ensure_ascii=False)) for name, value in data.attrs.items())
        stream.writelines(f"# {name} = {value}\n".encode() for name, value in facts)
        stream.writelines(csv_line([" ".join(cell.split()) for cell in cells]) for cells in (list(table), units))
        stream.writelines(csv_rows(list(table.values())))


def _hdf5(data: xr.Dataset, path: Path) -> None:
    """Written into memory first, as in ``hydrocrane.files.datasets``."""
    content = io.BytesIO()
    with h5py.File(content, "w", track_order=True) as stored:
        for name in ["time", *map(str, data.data_vars)]:
            column = stored.create_dataset(name, data=data[name].values)
            column.attrs["units"] = str(data[name].attrs.get("units", ""))
        stored.attrs.update(data.attrs)
    path.write_bytes(content.getbuffer())


_WRITERS: dict[str, Callable[[xr.Dataset, Path], None]] = {
    ".csv": _csv,
    ".mat": write_matlab,
    ".nc": write_netcdf,
    ".h5": _hdf5,
    ".mf4": write_mdf,
}
