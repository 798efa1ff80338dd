"""Data sets from NetCDF files, and as NetCDF-4 files, which are HDF5 files with conventions.

xarray encodes the values of a data set; columns of a run need only the mark for missing numbers. The writer of xarray,
h5netcdf, looks up each variable about thirty times: a run with 94 variables takes 0.7 s, and a tenth of that here.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np

from hydrocrane.files.columns import Column, Columns
from hydrocrane.files.hdf5 import check_content
from hydrocrane.files.received import check_values, plain, readable, received

if TYPE_CHECKING:
    import xarray as xr

# The name that netCDF gives a dimension without values; its length follows.
_NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable."


def read_netcdf(path: Path) -> xr.Dataset:
    """The data set of a file of version 3 or 4, in memory, without links and texts of no fixed length.

    Raises
    ------
    ResultFileError
        If there is none, or its values are in other files or too many.
    """
    import xarray as xr

    with received(path).open("rb") as stream:
        classic = stream.read(3) == b"CDF"
    with readable(path, "a NetCDF file"):
        # For files that this cannot open, the message of xarray is misleading.
        unread = [] if classic else check_content(path)
        engine = "scipy" if classic else "h5netcdf"
        with xr.open_dataset(path, engine=engine, decode_times=False, drop_variables=unread) as stored:
            check_values(path, sum(variable.size for variable in stored.variables.values()))
            data = stored.load()
        for about in (data.attrs, *(variable.attrs for variable in data.variables.values())):
            about |= {name: plain(text) for name, text in about.items() if isinstance(text, str)}
        return data.rename({name: plain(str(name)) for name in data.variables if plain(str(name)) != name})


def write_netcdf(data: xr.Dataset | Columns, path: Path) -> None:
    """Writes into memory first: HDF5 aborts the whole process if it cannot finish a file on a full disk."""
    content = io.BytesIO()
    variables, about = _of_columns(data) if isinstance(data, Columns) else _of_dataset(data)
    sizes = {dim: size for entry in variables.values() for dim, size in zip(entry.dims, entry.values.shape)}
    with h5py.File(content, "w", track_order=True) as stored:
        _write_attributes(stored.attrs, about)
        made = {name: _dataset(stored, name, variable) for name, variable in variables.items()}
        scales = {}
        for index, (name, size) in enumerate(sizes.items()):
            own = made.get(name)
            scale = _bare_dimension(stored, name, size) if own is None else own
            scale.make_scale(name if own is not None else f"{_NO_VARIABLE}{size:10d}")
            scale.attrs.create("_Netcdf4Dimid", np.int32(index))
            scales[name] = scale
        for name, variable in variables.items():
            for axis, dimension in enumerate(variable.dims):
                if variable.dims != (name,):
                    made[name].dims[axis].attach_scale(scales[dimension])
    path.write_bytes(content.getbuffer())


def _of_dataset(data: xr.Dataset) -> tuple[dict[str, Column], Mapping[str, object]]:
    """Encoded variables, and the attributes of the set."""
    from xarray.conventions import cf_encoder

    encoded, about = cf_encoder(dict(data.variables), dict(data.attrs))
    variables = {
        str(name): Column(np.asarray(variable.values), variable.attrs, tuple(map(str, variable.dims)))
        for name, variable in encoded.items()
    }
    return variables, about


def _of_columns(data: Columns) -> tuple[dict[str, Column], Mapping[str, object]]:
    """Columns of real numbers as xarray encodes them; missing values are NaN."""
    variables = {name: Column(c.values, c.attrs | {"_FillValue": np.nan}, c.dims) for name, c in data.items()}
    return variables, data.attrs


def _dataset(stored: h5py.File, name: str, variable: Column) -> h5py.Dataset:
    values, about = variable.values, variable.attrs
    texts = values.dtype.kind in "OUS"
    made = stored.create_dataset(
        name,
        data=values.astype(object) if texts else values,
        dtype=h5py.string_dtype() if texts else values.dtype,
        fillvalue=None if texts else about.get("_FillValue"),
        track_order=True,
    )
    _write_attributes(made.attrs, about)
    return made


def _bare_dimension(stored: h5py.File, name: str, size: int) -> h5py.Dataset:
    return stored.create_dataset(name, (size,), dtype=">f4", track_order=True)


def _write_attributes(stored: h5py.AttributeManager, about: Mapping[str, object]) -> None:
    """Writes texts as such and numbers as lists, as netCDF requires."""
    for name, value in about.items():
        values = np.asarray(value)
        if values.dtype.kind in "OUS":
            stored.create(name, value, dtype=h5py.string_dtype())
        else:
            stored.create(name, np.atleast_1d(values))
