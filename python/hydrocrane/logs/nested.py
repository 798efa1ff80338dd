"""From nested structures, as MATLAB and HDF5 files hold them, to columns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple, TypeAlias

import numpy as np

from hydrocrane.logs.table import Table, as_column, plain_facts

Leaf: TypeAlias = "np.ndarray | float"


class Measured(NamedTuple):
    """Values with the unit that their file states beside them."""

    values: np.ndarray
    unit: str


def table_of(content: Mapping[str, object]) -> Table:
    """Columns of a nested mapping: members joined by dots, matrices cut along their longer axis.

    Three habits are known: the `units` and `names` beside the vectors of this package's own files; captures of dSPACE
    (`X.Data` the time, `Y` a list of structures with `Name` and `Data`); and Simulink's structure with time.
    """
    names, units = content.get("names"), content.get("units")
    full = names if isinstance(names, Mapping) else {}
    stated = units if isinstance(units, Mapping) else {}
    about = content.get("about")
    table = Table({}, about=plain_facts(about) if isinstance(about, Mapping) else {})
    own = ("names", "units", "about")
    for path, leaf, unit in _leaves({k: v for k, v in content.items() if not (k in own and isinstance(v, Mapping))}):
        for name, column in _columns(path, leaf):
            long_name = str(full.get(name, name))
            table.columns[long_name] = column
            unit_text = unit or stated.get(name, "")
            if isinstance(unit_text, str) and unit_text:
                table.units[long_name] = unit_text
    return table


def _leaves(node: object, path: str = "") -> Iterator[tuple[str, Leaf, str]]:
    """(dotted path, array, unit) of everything that may be a column."""
    if isinstance(node, Mapping):
        yield from _structure(node, path)
    elif isinstance(node, list):
        for i, item in enumerate(node):
            yield from _leaves(item, f"{path}[{i + 1}]")
    elif isinstance(node, Measured):
        yield path, node.values, node.unit
    elif isinstance(node, np.ndarray) and node.dtype == object:
        yield from _leaves(list(node.ravel()), path)
    elif isinstance(node, np.ndarray | float | int):
        yield path, node, ""


def _structure(node: Mapping[str, object], path: str) -> Iterator[tuple[str, Leaf, str]]:
    if "Data" in node and isinstance(node.get("Name", ""), str) and not isinstance(node["Data"], Mapping):
        unit = node.get("Unit", "")
        where = node.get("Name") or path
        for _, leaf, stated in _leaves(node["Data"], path):
            yield str(where), leaf, stated or (unit if isinstance(unit, str) else "")
        return
    capture = isinstance(node.get("Y"), list | Mapping | np.ndarray) and isinstance(node.get("X"), Mapping)
    for name, child in node.items():
        if capture and name == "X" and isinstance(child, Mapping):
            yield from _leaves({**child, "Name": "time"}, "time")
        else:
            yield from _leaves(child, name if not path or capture else f"{path}.{name}")


def _columns(path: str, leaf: Leaf) -> Iterator[tuple[str, np.ndarray]]:
    column = as_column(leaf)
    if column is None or column.ndim > 2:
        return
    column = np.atleast_1d(column)
    if column.ndim == 1:
        yield path, column
        return
    if column.shape[0] < column.shape[1]:
        column = column.T
    for i in range(column.shape[1]):
        yield (path if column.shape[1] == 1 else f"{path}[{i + 1}]"), column[:, i].copy()
