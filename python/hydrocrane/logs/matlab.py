"""MATLAB and HDF5 files: version 5 through SciPy, version 7.3 and plain HDF5 through h5py."""

from __future__ import annotations

import math
import struct
import zlib
from pathlib import Path

import h5py
import numpy as np

from hydrocrane.errors import ResultFileError
from hydrocrane.files.hdf5 import Hdf5Walk, Node, attributes, refers
from hydrocrane.files.received import MOST_VALUES, SHORTER, check_values, plain, readable
from hydrocrane.logs.nested import SPARSE, Measured, Unread, table_of
from hydrocrane.logs.table import LogTable, plain_facts

_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
# MATLAB writes its own text header in front of the HDF5 part.
_SIGNATURE_PLACES = (0, 512, 1024, 2048)
# SciPy looks up kinds and classes in tables without a look at their length.
_KINDS = {*range(1, 8), 9, *range(12, 19)}
# Of version 5: length of the header, kinds of elements, and most of them: SciPy takes some seconds for a million. Then
# classes of arrays with others in them, and bytes of a number by kind.
_HEADER, _MATRIX, _PACKED, MOST_ELEMENTS = 128, 14, 15, 2**20
_NESTING = (1, 2, 3)
_WIDTHS = {3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8}
# Most bytes that a variable may unpack to.
_LARGEST = 8 * MOST_VALUES + 1
# Most letters of a text, such as a name or a unit.
_LONGEST = 2**16
# In place of values without a fixed length.
_NO_NUMBERS = np.zeros(2, "V1")


def read_matlab(path: Path) -> LogTable:
    """Vectors of a MATLAB file of any version; names that ``Run.save`` had to shorten get their dots back."""
    if is_hdf5(path):
        return read_hdf5(path)
    from scipy.io import loadmat

    with readable(path, "a MATLAB file that can be read"):
        _check_elements(path)
        content = loadmat(path, squeeze_me=True, simplify_cells=True)
        return table_of({plain(key): value for key, value in content.items() if not key.startswith("__")})


def _check_elements(path: Path) -> None:
    """Refuse a file of version 5 that unpacks to more than is read, or has too many elements."""
    with path.open("rb") as stream:
        order = {b"IM": "<II", b"MI": ">II"}.get(stream.read(_HEADER)[-2:])
        raw = memoryview(stream.read()) if order else memoryview(b"")
    at = elements = numbers = 0
    while order and at + 8 <= len(raw):
        kind, size = struct.unpack_from(order, raw, at)
        content = raw[at : at + 8 + size]
        if kind == _PACKED:
            content = memoryview(zlib.decompressobj().decompress(content[8:], _LARGEST))
        counted = _count(content, order)
        elements, numbers, at = elements + counted[0], numbers + counted[1], at + 8 + size
        check_values(path, numbers)
        if elements > MOST_ELEMENTS:
            raise ResultFileError(f"{path} has more than {MOST_ELEMENTS} arrays, texts and parts of them. {SHORTER}")


def _count(raw: memoryview, order: str) -> tuple[int, int]:
    """Elements and numbers, as far as they matter: an array is a row of elements, arrays in it among them."""
    at = elements = numbers = 0
    while at + 8 <= len(raw) and elements <= MOST_ELEMENTS:
        kind, size = struct.unpack_from(order, raw, at)
        elements += 1
        if kind & 0xFFFF not in _KINDS:
            raise ValueError(f"elements of the kind {kind & 0xFFFF}, which there is not")
        if kind == _MATRIX:
            elements += _stated_elements(raw[at + 8 : at + 8 + size], order)
            at += 8
        elif kind >> 16:  # Short elements have their content in place of a size.
            at += 8
        else:
            at += 8 + -(-size // 8) * 8
            numbers += size // _WIDTHS.get(kind, 1)
    return elements, numbers


def _stated_elements(raw: memoryview, order: str) -> int:
    """The size that a cell array, structure or object states, for which SciPy makes room before it reads one."""
    if len(raw) < 24:
        return 0
    kind = struct.unpack_from(order, raw, 8)[0] & 0xFF
    if not 0 < kind < 20:
        raise ValueError(f"an array of the class {kind}, which there is not")
    if kind not in _NESTING:
        return 0
    size = min(struct.unpack_from(order, raw, 16)[1], len(raw) - 24)
    return max(math.prod(struct.unpack_from(f"{order[0]}{size // 4}i", raw, 24)), 0)


def is_hdf5(path: Path) -> bool:
    with path.open("rb") as stream:
        start = stream.read(_SIGNATURE_PLACES[-1] + len(_HDF5_SIGNATURE))
    return any(start[i : i + len(_HDF5_SIGNATURE)] == _HDF5_SIGNATURE for i in _SIGNATURE_PLACES)


def read_hdf5(path: Path) -> LogTable:
    """Datasets of an HDF5 file, written by MATLAB (7.3) or another program; the attribute `units` or `unit` of a
    dataset, in any case, is its unit."""
    if not is_hdf5(path):
        raise ResultFileError(f"{path} is not an HDF5 file; is its suffix right?")
    with readable(path, "an HDF5 file that is whole"), h5py.File(path, "r", track_order=True) as stored:
        table = table_of(_MatlabReader(path, stored).members(stored, 0))
        table.about |= plain_facts(attributes(stored))
        return table


class _MatlabReader:
    def __init__(self, path: Path, root: h5py.File) -> None:
        self._walk, self._root = Hdf5Walk(path), root

    def members(self, group: h5py.Group, level: int) -> dict[str, object]:
        found = self._walk.members(group, level)
        return {name: self._node(node, level + 1) for name, node in found if not name.startswith("#")}

    def _group(self, group: h5py.Group, level: int) -> dict[str, object] | list[dict[str, object]] | Unread:
        if "MATLAB_sparse" in group.attrs:
            return SPARSE
        members = self.members(group, level)
        # An array of structures is stored as a structure of arrays of references, each of which is read as a list.
        if members and all(isinstance(group[name], h5py.Dataset) for name in members):
            lists = [value for value in members.values() if isinstance(value, list)]
            if len(lists) == len(members):
                return [dict(zip(members, item)) for item in zip(*lists)]
        return members

    def _node(self, node: Node, level: int) -> object:
        if isinstance(node, h5py.Group):
            return self._group(node, level)
        about = attributes(node)
        kind = _text(about.get("MATLAB_class", b""))
        if not self._walk.fixed(node):
            return _NO_NUMBERS
        if refers(node.dtype):
            return self._referred(node, level)
        if "MATLAB_empty" in about:
            return "" if kind == "char" else np.zeros(0)
        if kind == "char" and (node.dtype.kind != "u" or node.size > _LONGEST):
            raise ResultFileError(
                f"{self._walk.path} is damaged: `{node.name}` states that it is a text and has {node.size} {node.dtype}"
            )
        value = node[()]
        if kind == "char":
            return plain("".join(map(chr, np.ravel(np.transpose(value)))))
        if isinstance(value, bytes | str):
            return _text(value)
        if getattr(value, "dtype", None) is not None and value.dtype.names:
            return {name: np.asarray(value[name]) for name in value.dtype.names}
        # MATLAB stores arrays by columns.
        return Measured(np.squeeze(np.transpose(value) if kind else np.asarray(value)), about)

    def _referred(self, node: h5py.Dataset, level: int) -> list[object]:
        found = []
        for reference in np.ravel(node[()]):
            self._walk.count(level)
            found.append(self._node(self._root[reference], level + 1))
        return found


def _text(value: object) -> str:
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.item()
    return plain(value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value))
