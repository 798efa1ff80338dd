"""From nested structures of MATLAB and HDF5 files to columns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

import numpy as np

from hydrocrane.logs.table import LogColumn, LogTable, as_column, plain_facts, unpack
from hydrocrane.logs.units import tidy_unit

# A possible column: values, or None for an object of a MATLAB class, whose values cannot be read.
Leaf: TypeAlias = "np.ndarray | float | None"


class Measured(NamedTuple):
    """Values with what their file states of them: unit, marks of missing values, factor, offset."""

    values: np.ndarray
    about: Mapping[str, object]


class NestedLeaf(NamedTuple):
    """A leaf of a nested structure: its name, content, unit, the dSPACE capture it belongs to, and its attributes."""

    name: str
    leaf: Leaf
    unit: str = ""
    capture: str = ""
    about: Mapping[str, object] = MappingProxyType({})


def table_of(content: Mapping[str, object]) -> LogTable:
    """Columns of a nested mapping: member names are joined by dots, matrices are split along their longer axis.

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
    clocks: dict[str, str] = {}
    members: dict[str, str] = {}
    for found in _leaves({k: v for k, v in content.items() if not (k in own and isinstance(v, Mapping))}):
        if isinstance(found.leaf, float | int) or (isinstance(found.leaf, np.ndarray) and found.leaf.size == 1):
            _add_fact(table, found)
            continue
        for name, values in _columns(table, found):
            unit = found.unit or stated.get(name, "")
            column = LogColumn(values, tidy_unit(unit) if isinstance(unit, str) else "")
            unpack(column, found.about)
            added = table.add(str(full.get(name, name)), column, found.capture)
            if found.capture:
                members[added] = found.capture
                if name == "time":
                    clocks[found.capture] = added
    for name, capture in members.items():
        table.columns[name].clock = clocks.get(capture, "")
    return table


def _add_fact(table: LogTable, found: NestedLeaf) -> None:
    table.about |= plain_facts({"file_" + found.name.replace(".", "_"): found.leaf})


def _leaves(node: object, path: str = "", capture: str = "") -> Iterator[NestedLeaf]:
    """All leaves that may be columns."""
    if isinstance(node, Mapping):
        yield from _structure(node, path, capture)
    elif isinstance(node, list):
        for i, item in enumerate(node):
            yield from _leaves(item, f"{path}[{i + 1}]", capture)
    elif isinstance(node, Measured):
        yield NestedLeaf(path, node.values, str(node.about.get("unit", "")), capture, node.about)
    elif isinstance(node, np.ndarray) and node.dtype.fields:
        yield NestedLeaf(path, None, "", capture)
    elif isinstance(node, np.ndarray) and node.dtype == object:
        yield from _leaves(list(node.ravel()), path, capture)
    elif isinstance(node, np.ndarray | np.generic | float | int):
        yield NestedLeaf(path, np.asarray(node), "", capture)


def _structure(node: Mapping[str, object], path: str, owner: str) -> Iterator[NestedLeaf]:
    if "Data" in node and isinstance(node.get("Name", ""), str) and not isinstance(node["Data"], Mapping):
        unit = node.get("Unit", "")
        where = node.get("Name") or path
        for found in _leaves(node["Data"], path):
            stated = found.unit or (unit if isinstance(unit, str) else "")
            yield NestedLeaf(str(where), found.leaf, stated, owner, found.about)
        return
    capture = isinstance(node.get("Y"), list | Mapping | np.ndarray) and isinstance(node.get("X"), Mapping)
    owner = (path or "capture") if capture else owner
    for name, child in node.items():
        if capture and name == "X" and isinstance(child, Mapping):
            yield from _leaves({**child, "Name": "time"}, "time", owner)
        else:
            yield from _leaves(child, name if not path or capture else f"{path}.{name}", owner)


def _columns(table: LogTable, found: NestedLeaf) -> Iterator[tuple[str, np.ndarray]]:
    """Columns of a leaf by name; other leaves are left out of the table with the reason."""
    path = found.name
    made = as_column(found.leaf) if found.leaf is not None else None
    column = None if made is None else made.values
    if column is None or column.ndim > 2:
        values = np.asarray(found.leaf)
        # Texts and empty values are no columns.
        if found.leaf is None:
            table.leave(path, "an object of a MATLAB class; save it as a structure or an array")
        elif column is not None:
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
