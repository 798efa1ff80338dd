"""Data sets as NetCDF-4 files, which are HDF5 files in a certain order.

xarray encodes the values. Its writer, h5netcdf, looks each variable up some thirty times: a run with 94 of them takes
it 0.7 s, and a tenth of that here.
"""

from __future__ import annotations

import io
from collections.abc import Hashable, Mapping
from pathlib import Path

import h5py
import numpy as np
import xarray as xr
from xarray.conventions import cf_encoder

# As netCDF calls a dimension without values of its own; its length follows.
_NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable."


def write_netcdf(data: xr.Dataset, path: Path) -> None:
    """HDF5 that cannot finish a file on a full disk takes the whole process down: it writes into memory."""
    content = io.BytesIO()
    variables, about = cf_encoder(dict(data.variables), dict(data.attrs))
    with h5py.File(content, "w", track_order=True) as stored:
        _write_attributes(stored.attrs, about)
        made = {str(name): _dataset(stored, str(name), variable) for name, variable in variables.items()}
        scales = {}
        for index, (name, size) in enumerate(data.sizes.items()):
            own = made.get(str(name))
            scale = _bare_dimension(stored, str(name), size) if own is None else own
            scale.make_scale(str(name) if own is not None else f"{_NO_VARIABLE}{size:10d}")
            scale.attrs.create("_Netcdf4Dimid", np.int32(index))
            scales[name] = scale
        for name, variable in variables.items():
            for axis, dimension in enumerate(variable.dims):
                if variable.dims != (name,):
                    made[str(name)].dims[axis].attach_scale(scales[dimension])
    path.write_bytes(content.getbuffer())


def _dataset(stored: h5py.File, name: str, variable: xr.Variable) -> h5py.Dataset:
    values = np.asarray(variable.values)
    about = dict(variable.attrs)
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


def _write_attributes(stored: h5py.AttributeManager, about: Mapping[Hashable, object]) -> None:
    """Texts as such, numbers as lists, as netCDF has them."""
    for name, value in about.items():
        values = np.asarray(value)
        if values.dtype.kind in "OUS":
            stored.create(str(name), value, dtype=h5py.string_dtype())
        else:
            stored.create(str(name), np.atleast_1d(values))
