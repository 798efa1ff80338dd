"""MATLAB and HDF5 files: version 5 through SciPy, version 7.3 and plain HDF5 through h5py; nested structures become
columns."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

import h5py
import numpy as np

from hydrocrane.errors import ResultFileError
from hydrocrane.files.hdf5 import Hdf5Walk, Node, attributes, refers
from hydrocrane.files.received import MOST_VALUES, SHORTER, check_values, plain, readable
from hydrocrane.logs.table import TIME_NAMES, LogColumn, LogTable, as_column, plain_facts, stated_unit

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
    if h5py.is_hdf5(path):
        return read_hdf5(path)
    from scipy.io import loadmat

    with readable(path, "a MATLAB file that can be read"):
        _check_elements(path)
        content = loadmat(path, squeeze_me=True, simplify_cells=True)
        return _table_of({plain(key): value for key, value in content.items() if not key.startswith("__")})


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


def read_hdf5(path: Path) -> LogTable:
    """Datasets of an HDF5 file, written by MATLAB (7.3) or another program; the attribute `units` or `unit` of a
    dataset, in any case, is its unit."""
    if not h5py.is_hdf5(path):
        raise ResultFileError(f"{path} is not an HDF5 file; is its suffix right?")
    with readable(path, "an HDF5 file that is whole"), h5py.File(path, "r", track_order=True) as stored:
        table = _table_of(_MatlabReader(path, stored).members(stored, 0))
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
            return _SPARSE
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
        return _Measured(np.squeeze(np.transpose(value) if kind else np.asarray(value)), about)

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


# --- nested structures -------------------------------------------------------------------------------------------


class Unread(NamedTuple):
    """Values that are not read, and why."""

    reason: str


# A possible column.
Leaf: TypeAlias = "np.ndarray | float | Unread"
_OF_A_CLASS = Unread("an object of a MATLAB class; save it as a structure or an array")
_SPARSE = Unread("a sparse matrix; save it as a full one, full(name)")
_CELLS = Unread("a cell array of single numbers; save it as an array, cell2mat(name)")


class Owner(NamedTuple):
    """What leaves belong to: a capture of dSPACE, or a group with times of its own; and the leaf with its times."""

    name: str = ""
    clock: str = ""


_NOBODY = Owner()


class _Measured(NamedTuple):
    """Values with what their file states of them: unit, marks of missing values, factor, offset."""

    values: np.ndarray
    about: Mapping[str, object]


class NestedLeaf(NamedTuple):
    """A leaf of a nested structure: its name, content, unit, what it belongs to, and its attributes."""

    name: str
    leaf: Leaf
    unit: str = ""
    owner: Owner = _NOBODY
    about: Mapping[str, object] = MappingProxyType({})


def _table_of(content: Mapping[str, object]) -> LogTable:
    """Columns of a nested mapping: member names are joined by dots, matrices are split along their longer axis.
    Those of a group with times have these as their clock.

    Three conventions are known: the `units` and `names` beside the vectors of this package's own files; captures of
    dSPACE (`X.Data` the time, `Y` a list of structures with `Name` and `Data`); and Simulink's structure with time.
    Single numbers are facts about the log, ``file_NAME`` in its attributes.
    """
    names, units = content.get("names"), content.get("units")
    full = names if isinstance(names, Mapping) else {}
    stated = units if isinstance(units, Mapping) else {}
    about = content.get("about")
    table = LogTable(about=plain_facts(about) if isinstance(about, Mapping) else {})
    own = ("names", "units", "about")
    clocks: dict[Owner, str] = {}
    members: dict[str, Owner] = {}
    for found in _leaves({k: v for k, v in content.items() if not (k in own and isinstance(v, Mapping))}):
        if isinstance(found.leaf, float | int) or (isinstance(found.leaf, np.ndarray) and found.leaf.size == 1):
            _add_fact(table, found)
            continue
        for name, values in _columns(table, found):
            unit = found.unit or stated.get(name, "")
            column = LogColumn(values, unit if isinstance(unit, str) else "")
            added = table.keep(str(full.get(name, name)), column, found.about, found.owner.name)
            if added and found.owner.clock:
                members[added] = found.owner
                if name == found.owner.clock:
                    clocks[found.owner] = added
    for name, owner in members.items():
        table.columns[name].clock = clocks.get(owner, "")
    return table


def _add_fact(table: LogTable, found: NestedLeaf) -> None:
    table.about |= plain_facts({"file_" + found.name.replace(".", "_"): found.leaf})


def _leaves(node: object, path: str = "", owner: Owner = _NOBODY) -> Iterator[NestedLeaf]:
    """All leaves that may be columns."""
    if isinstance(node, Mapping):
        yield from _structure(node, path, owner)
    elif isinstance(node, Unread):
        yield NestedLeaf(path, node, "", owner)
    elif isinstance(node, _Measured):
        yield NestedLeaf(path, node.values, stated_unit(node.about), owner, node.about)
    elif hasattr(node, "toarray"):
        yield NestedLeaf(path, _SPARSE, "", owner)
    elif isinstance(node, np.ndarray) and node.dtype.fields:
        yield NestedLeaf(path, _OF_A_CLASS, "", owner)
    elif isinstance(node, list) or (isinstance(node, np.ndarray) and node.dtype == object):
        items = node if isinstance(node, list) else list(node.ravel())
        if len(items) > 1 and any(map(_is_number, items)) and all(_is_number(i) or isinstance(i, str) for i in items):
            yield NestedLeaf(path, _CELLS, "", owner)
            return
        for i, item in enumerate(items):
            yield from _leaves(item, f"{path}[{i + 1}]", owner)
    elif isinstance(node, np.ndarray | np.generic | float | int):
        yield NestedLeaf(path, np.asarray(node), "", owner)


def _is_number(item: object) -> bool:
    """Whether an item is a single number."""
    value = item.values if isinstance(item, _Measured) else item
    return isinstance(value, np.ndarray | np.generic | float | int) and np.size(value) == 1


def _structure(node: Mapping[str, object], path: str, owner: Owner) -> Iterator[NestedLeaf]:
    if "Data" in node and isinstance(node.get("Name", ""), str) and not isinstance(node["Data"], Mapping):
        unit = node.get("Unit", "")
        where = node.get("Name") or path
        for found in _leaves(node["Data"], path):
            stated = found.unit or (unit if isinstance(unit, str) else "")
            yield NestedLeaf(str(where), found.leaf, stated, owner, found.about)
        return
    capture = isinstance(node.get("Y"), list | Mapping | np.ndarray) and isinstance(node.get("X"), Mapping)
    series = [name for name in node if name != "T" and _values(node[name]).size > 1]
    if capture:
        owner = Owner(path or "capture", "time")
    elif first := LogTable().first_of(TIME_NAMES, series):
        owner = Owner(path, f"{path}.{first}" if path else first)
    for name, child in node.items():
        if capture and name == "X" and isinstance(child, Mapping):
            yield from _leaves({**child, "Name": "time"}, "time", owner)
        else:
            yield from _leaves(child, name if not path or capture else f"{path}.{name}", owner)


def _values(node: object) -> np.ndarray:
    return node.values if isinstance(node, _Measured) else node if isinstance(node, np.ndarray) else np.zeros(0)


def _columns(table: LogTable, found: NestedLeaf) -> Iterator[tuple[str, np.ndarray]]:
    """Columns of a leaf by name; other leaves are left out of the table with the reason."""
    path = found.name
    if isinstance(found.leaf, Unread):
        table.leave(path, found.leaf.reason)
        return
    made = as_column(found.leaf)
    column = None if made is None else made.values
    if column is None or column.ndim > 2:
        values = np.asarray(found.leaf)
        # Texts and empty values are no columns.
        if column is not None:
            table.leave(path, f"{column.ndim} dimensions, where a signal has one")
        elif values.size and values.dtype.kind not in "SU":
            table.leave(path, "no real numbers")
        return
    column = np.atleast_1d(column)
    if column.ndim == 1:
        yield path, column
        return
    if column.shape[0] < column.shape[1]:
        column = column.T
    for i in range(column.shape[1]):
        yield (path if column.shape[1] == 1 else f"{path}[{i + 1}]"), column[:, i].copy()
