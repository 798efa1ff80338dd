"""Fitted values as a part of a machine file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hydrocrane.identification.block import comment, fitted_key, interval, signature
from hydrocrane.machine.machine import Machine


def block(
    machine: Machine,
    known: Mapping[str, tuple[float, float]],
    logs: Sequence[str],
    motion: str,
    warnings: Sequence[str],
    date: str = "",
) -> str:
    """Tables of the keys in `known`, with their values in `machine`, class ``fitted``, source and intervals, SI."""
    names = ", ".join(dict.fromkeys(logs))
    source = f"{names}; fit of a {motion} motion, {signature(date)}"
    lines = [comment(f"Fitted to {names}; put it beside the machine file and add it to `include`.")]
    lines += [comment(f"warning: {warning}") for warning in warnings]
    tables: dict[str, list[str]] = {}
    for path in dict.fromkeys(key.partition("[")[0] for key in known):
        table, _, name = path.rpartition(".")
        mine = [key for key in known if key.partition("[")[0] == path]
        ends = " and ".join(f"{key.removeprefix(path)} {interval(*known[key])}".strip() for key in mine)
        tables.setdefault(table, []).append(fitted_key(name, _written(machine, path), source, ends))
    for table, rows in tables.items():
        lines += ["", f"[{table}]", *rows]
    return "\n".join(lines) + "\n"


def _written(machine: Machine, path: str) -> str:
    """A value, or both values of a pair, in the notation of a machine file."""
    stated = machine.value(path)
    texts = [f'"{v:.6g} {stated.unit}"' if stated.unit else f"{v:.6g}" for v in np.atleast_1d(stated.si).tolist()]
    return f"[{', '.join(texts)}]" if len(texts) > 1 else texts[0]
