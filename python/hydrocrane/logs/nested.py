"""From nested structures of MATLAB and HDF5 files to columns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

import numpy as np

from hydrocrane.logs.table import TIME_NAMES, LogColumn, LogTable, as_column, plain_facts, stated_unit
from hydrocrane.logs.units import tidy_unit


class Unread(NamedTuple):
    """Values that are not read, and why."""

    reason: str


# A possible column.
Leaf: TypeAlias = "np.ndarray | float | Unread"
OF_A_CLASS = Unread("an object of a MATLAB class; save it as a structure or an array")
SPARSE = Unread("a sparse matrix; save it as a full one, full(name)")
_CELLS = Unread("a cell array of single numbers; save it as an array, cell2mat(name)")


class Owner(NamedTuple):
    """What leaves belong to: a capture of dSPACE, or a group with times of its own; and the leaf with its times."""

    name: str = ""
    clock: str = ""


_NOBODY = Owner()


class Measured(NamedTuple):
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


def table_of(content: Mapping[str, object]) -> LogTable:
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
            column = LogColumn(values, tidy_unit(unit) if isinstance(unit, str) else "")
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
    elif isinstance(node, Measured):
        yield NestedLeaf(path, node.values, stated_unit(node.about), owner, node.about)
    elif hasattr(node, "toarray"):
        yield NestedLeaf(path, SPARSE, "", owner)
    elif isinstance(node, np.ndarray) and node.dtype.fields:
        yield NestedLeaf(path, OF_A_CLASS, "", owner)
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
    value = item.values if isinstance(item, Measured) else item
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
    times = [name for name in node if name.lower() in TIME_NAMES and name != "T" and _values(node[name]).size > 1]
    if capture:
        owner = Owner(path or "capture", "time")
    elif times:
        first = min(times, key=lambda name: (TIME_NAMES.index(name.lower()), name.lower() != name))
        owner = Owner(path, f"{path}.{first}" if path else first)
    for name, child in node.items():
        if capture and name == "X" and isinstance(child, Mapping):
            yield from _leaves({**child, "Name": "time"}, "time", owner)
        else:
            yield from _leaves(child, name if not path or capture else f"{path}.{name}", owner)


def _values(node: object) -> np.ndarray:
    return node.values if isinstance(node, Measured) else node if isinstance(node, np.ndarray) else np.zeros(0)


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
