"""MATLAB and HDF5 files: version 5 through SciPy, version 7.3 and plain HDF5 through h5py."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import h5py
import numpy as np

from hydrocrane.errors import ResultFileError
from hydrocrane.logs.nested import Measured, table_of
from hydrocrane.logs.table import Table, plain_facts

_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
# MATLAB writes its own text header in front of the HDF5 part.
_SIGNATURE_PLACES = (0, 512, 1024, 2048)


def read_matlab(path: Path) -> Table:
    """Vectors of a MATLAB file of any version; names that ``Run.save`` had to shorten get their dots back."""
    if is_hdf5(path):
        return read_hdf5(path)
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        content = loadmat(path, squeeze_me=True, simplify_cells=True)
    except (MatReadError, ValueError, NotImplementedError, TypeError, OSError, EOFError, IndexError) as error:
        raise ResultFileError(
            f"{path} is not a MATLAB file that can be read: {error}; save it again, or as CSV"
        ) from None
    return table_of({key: value for key, value in content.items() if not key.startswith("__")})


def is_hdf5(path: Path) -> bool:
    with path.open("rb") as stream:
        start = stream.read(_SIGNATURE_PLACES[-1] + len(_HDF5_SIGNATURE))
    return any(start[i : i + len(_HDF5_SIGNATURE)] == _HDF5_SIGNATURE for i in _SIGNATURE_PLACES)


def read_hdf5(path: Path) -> Table:
    """Datasets of an HDF5 file, written by MATLAB (7.3) or another program; a dataset's attribute `units` or `unit` is
    its unit."""
    if not is_hdf5(path):
        raise ResultFileError(f"{path} is not an HDF5 file; is its suffix right?")
    try:
        with h5py.File(path, "r", track_order=True) as stored:
            table = table_of({name: _node(stored[name], stored) for name in stored if not name.startswith("#")})
            table.about |= plain_facts(stored.attrs)
            return table
    except (OSError, RuntimeError, KeyError) as error:
        raise ResultFileError(f"{path} is damaged or cut off: {error}; copy it again from the logger") from None


def _group(group: h5py.Group, root: h5py.File) -> dict[str, object] | list[dict[str, object]]:
    members = {name: _node(group[name], root) for name in group if not name.startswith("#")}
    # An array of structures is stored as a structure of arrays of references.
    referring = all(isinstance(child, h5py.Dataset) and child.dtype == h5py.ref_dtype for child in group.values())
    if members and referring:
        # A dataset of references is read as a list, see `_node`.
        lists = cast("list[list[object]]", list(members.values()))
        return [dict(zip(members, item)) for item in zip(*lists)]
    return members


def _node(node: h5py.Group | h5py.Dataset, root: h5py.File) -> object:
    if isinstance(node, h5py.Group):
        return _group(node, root)
    kind = _text(node.attrs.get("MATLAB_class", b""))
    if node.dtype == h5py.ref_dtype:
        return [_node(root[reference], root) for reference in np.ravel(node[()])]
    if "MATLAB_empty" in node.attrs:
        return "" if kind == "char" else np.zeros(0)
    value = node[()]
    if kind == "char":
        return "".join(map(chr, np.ravel(np.transpose(value))))
    if isinstance(value, bytes | str):
        return _text(value)
    if getattr(value, "dtype", None) is not None and value.dtype.names:
        return {name: np.asarray(value[name]) for name in value.dtype.names}
    unit = next((_text(node.attrs[key]) for key in ("units", "unit", "Unit") if key in node.attrs), "")
    # MATLAB stores arrays by columns.
    return Measured(np.squeeze(np.transpose(value) if kind else np.asarray(value)), unit)


def _text(value: object) -> str:
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.item()
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
