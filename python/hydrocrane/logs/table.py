"""Content of a log file as a reader returns it, before columns are assigned to signals."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.errors import ResultFileError
from hydrocrane.files.received import plain
from hydrocrane.logs.clock import seconds_of_dates
from hydrocrane.logs.flags import Flag
from hydrocrane.logs.units import known_unit, log_unit, tidy_unit

TIME_NAMES = (
    "time", "t", "time [s]", "time_s", "t_s", "timestamp", "time stamp", "time_stamp", "datetime", "date time",
    "date_time",
)  # fmt: skip
# A name with its unit after it: "x [mm]", "p1 (bar)".
# A number in brackets counts the columns of a matrix.
_NAME_AND_UNIT = re.compile(
    r"^(?P<name>.*\S)\s*(?!\[\d+\]$)(?:\[(?P<unit>[^\]]*)\]|\((?P<round>[^()]*(?:\([^()]*\))?)\))$"
)
# Least SI value of one unit of a log; its inverse is the greatest. Beyond these bounds its numbers lose precision.
LEAST_UNIT = 1e-30
# Most columns that are named per reason when they are left out.
MOST_NAMED = 8
# Why a column was left out.
NO_NUMBERS = "no numbers"
# Most columns of a log, because checks and summaries process each of them.
MOST_COLUMNS = 2000


@dataclass
class Table:
    """Columns of a file.

    Attributes
    ----------
    columns : dict of (n,) arrays
        By their full names in the file.
    units : dict of str
        Unit of a column, if the file states one.
    notes : list of Flag
        Faults of the file itself.
    in_memory : bool
        Whether it comes from a program, which passes SI values unless it states otherwise.
    about : dict
        Statements on the whole log, for example ``payload``: texts and numbers.
    clocks : list of str
        Columns that hold dates or times of day; their values are seconds from the first.
    words : dict of str
        Columns that were left out because they hold no numbers, with their first text.
    left_out : dict of str
        Every column that was left out, with the reason.
    times : dict of str
        Full name of the time column that a column belongs to, where the file holds several recordings.
    """

    columns: dict[str, Array]
    units: dict[str, str] = field(default_factory=dict)
    notes: list[Flag] = field(default_factory=list)
    in_memory: bool = False
    about: dict[str, str | float | int] = field(default_factory=dict)
    clocks: list[str] = field(default_factory=list)
    words: dict[str, str] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)
    times: dict[str, str] = field(default_factory=dict)

    def add(self, name: str, values: Array, unit: str = "", owner: str = "") -> str:
        """Add a column and return its full name; a repeated name gets its `owner` as prefix, or a number as suffix."""
        full = self._free(name, owner)
        if full != name:
            message = f"a second column is called `{name}`; it is read as `{full}`"
            self.notes.append(Flag("renamed", full, np.nan, np.nan, message))
        self.columns[full] = values
        if unit:
            self.units[full] = unit
        return full

    def _free(self, name: str, owner: str) -> str:
        taken = self.columns.keys() | self.left_out.keys()
        owned = f"{owner}.{name}" if owner else name
        if name not in taken or owned not in taken:
            return name if name not in taken else owned
        found = _NAME_AND_UNIT.match(name.strip())
        short = found["name"] if found else name
        return next(n for i in count(2) if (n := f"{short}.{i}{name[len(short) :]}") not in taken)

    def take(self, name: str, values: object, unit: str = "") -> None:
        """Add a column, or leave it out if it is no series of numbers."""
        column = as_column(values)
        if column is None:
            self.leave(name, NO_NUMBERS)
        elif column.ndim != 1:
            self.leave(name, f"{column.ndim} dimensions, where a signal has one")
        else:
            self.add(name, column, unit)

    def leave(self, name: str, reason: str, word: str = "") -> None:
        """Leave out a column, and note the reason."""
        name = self._free(name, "")
        self.left_out[name] = reason
        if word:
            self.words[name] = word

    def find(self, wanted: str | int) -> str | None:
        """Full name of a column by its name, its name without the unit, or its number counted from 1."""
        if isinstance(wanted, int):
            return list(self.columns)[wanted - 1] if 1 <= wanted <= len(self.columns) else None
        if wanted in self.columns:
            return wanted
        return next((name for name in self.columns if split_name(name)[0] == wanted), None)

    def time_column(self) -> str | None:
        """Full name of the time column: the one with such a name, or the only one with dates."""
        names = {name.lower(): name for name in reversed(self.columns)}
        plain = {split_name(name)[0].lower(): name for name in reversed(self.columns)}
        named = next((found[known] for known in TIME_NAMES for found in (names, plain) if known in found), None)
        return named or (self.clocks[0] if len(self.clocks) == 1 else None)

    def unit_of(self, column: str) -> str:
        """The unit that the file states for a column; empty if it states none."""
        return self.units.get(column) or split_name(column)[1]

    def in_si(self) -> dict[str, Array]:
        """All columns; those with a known unit are converted to SI."""
        return {name: converted(values, self.unit_of(name)) for name, values in self.columns.items()}


def check_width(path: Path, columns: int) -> None:
    """Refuse a file of more than `MOST_COLUMNS` columns.

    Raises
    ------
    ResultFileError
        With both numbers and the cure.
    """
    if columns > MOST_COLUMNS:
        raise ResultFileError(
            f"{path} has {columns} columns, more than {MOST_COLUMNS}; keep those that are needed, or turn a table that "
            "has its signals in rows"
        )


def said_of(left_out: Mapping[str, str]) -> list[str]:
    """Messages on columns that were left out, one per reason."""
    reasons: dict[str, list[str]] = {}
    for column, reason in left_out.items():
        reasons.setdefault(reason, []).append(column)
    texts = []
    for reason, columns in reasons.items():
        shown = ", ".join(f"`{column}`" for column in columns[:MOST_NAMED])
        more = f" and {len(columns) - MOST_NAMED} more" if len(columns) > MOST_NAMED else ""
        texts.append(f"{'column' if len(columns) == 1 else 'columns'} {shown}{more} left out: {reason}")
    return texts


def split_name(text: str) -> tuple[str, str]:
    """``"x [mm]"`` as name and unit; the unit is empty if there is none."""
    found = _NAME_AND_UNIT.match(text.strip())
    return (found["name"], tidy_unit(found["unit"] or found["round"] or "")) if found else (text.strip(), "")


def converted(values: Array, unit: str) -> Array:
    """`values` of `unit` in SI; unchanged if the unit is not known."""
    if not unit or not known_unit(unit):
        return values
    found = log_unit(unit)
    return scaled(values, found.factor) + found.zero


def scaled(values: Array, factor: float) -> Array:
    """`values` times `factor`. If its inverse is a whole number, they are divided by it, which rounds once, as for
    machine files."""
    inverse = round(1.0 / factor) if LEAST_UNIT <= factor < 1.0 else 0
    return values / inverse if inverse and 1.0 / inverse == factor else values * factor


def plain_facts(content: Mapping[str, object]) -> dict[str, str | float | int]:
    """The texts and numbers among the attributes of a file, as Python objects; others are left out."""
    facts: dict[str, str | float | int] = {}
    for name, value in content.items():
        if isinstance(value, np.ndarray):
            # MATLAB writes an empty text as an empty array.
            value = value.item() if value.size == 1 else "" if not value.size else None
        if isinstance(value, np.generic):
            value = value.item()
        if isinstance(value, bytes):
            value = value.decode("utf-8", "replace")
        if isinstance(value, str | float | int) and not isinstance(value, bool):
            facts[plain(str(name))] = plain(value) if isinstance(value, str) else value
    return facts


def as_column(values: object) -> Array | None:
    """Values of a file as a float64 column, or None if they are no numbers."""
    array = np.asarray(values)
    if array.dtype.kind == "M" and array.size:
        return seconds_of_dates(array)
    if array.dtype.kind not in "buif" or not array.size:
        return None
    return array.astype(np.float64)
