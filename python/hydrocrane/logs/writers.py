"""Writing logs such that reading gives the same numbers back."""

from __future__ import annotations

from pathlib import Path

import h5py
import xarray as xr

from hydrocrane.errors import ResultFileError, nearest
from hydrocrane.files import frame, save
from hydrocrane.logs.readers import mdf_reader


def write_log(data: xr.Dataset, path: Path) -> Path:
    """Write a log's signals in the format of the suffix; missing folders are made."""
    suffix = path.suffix.lower()
    writers = {".csv": _csv, ".h5": _hdf5, ".mf4": _mdf, ".mat": save, ".nc": save}
    if suffix not in writers:
        raise ResultFileError(f"cannot write `{path.name}`: unknown suffix `{suffix}`{nearest(suffix, writers)}")
    path.parent.mkdir(parents=True, exist_ok=True)
    writers[suffix](data, path)
    return path


def _csv(data: xr.Dataset, path: Path) -> None:
    """A row of names, a row of units, then the shortest text that reads back as the same double."""
    table = frame(data)
    units = [table.attrs["units"][name] or "-" for name in table.columns]
    with path.open("w", encoding="utf-8", newline="\n") as stream:
        stream.write(",".join(map(str, table.columns)) + "\n" + ",".join(units) + "\n")
        table.to_csv(stream, index=False, header=False, lineterminator="\n")


def _hdf5(data: xr.Dataset, path: Path) -> None:
    with h5py.File(path, "w", track_order=True) as stored:
        for name in ["time", *map(str, data.data_vars)]:
            column = stored.create_dataset(name, data=data[name].values)
            column.attrs["units"] = str(data[name].attrs.get("units", ""))


def _mdf(data: xr.Dataset, path: Path) -> None:
    mdf_class = mdf_reader()
    from asammdf import Signal

    time = data["time"].values
    with mdf_class(version="4.10") as stored:
        stored.append(
            [
                Signal(data[name].values, time, unit=str(data[name].attrs.get("units", "")), name=str(name))
                for name in data.data_vars
            ]
        )
        stored.save(path, overwrite=True)
