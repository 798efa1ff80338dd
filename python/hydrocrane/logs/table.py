"""The columns of a log, whatever it came from, before they are assigned to signals."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hydrocrane import _core
from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, ResultFileError
from hydrocrane.files.received import plain
from hydrocrane.logs.signals import Flag

TIME_NAMES = tuple(_core.TIME_NAMES)
# Most columns that are named per reason when they are left out.
MOST_NAMED = 8
# Why a column was left out.
NO_NUMBERS = "no numbers"
# Most columns of a log, because checks and summaries process each of them.
MOST_COLUMNS = 2000
# Least length of the clock of a log, as a share of the longest.
LONG = 0.9
# Bounds of packed values, as they are packed.
BOUNDS = ("valid_min", "valid_max", "valid_range")
# How numbers and dates may be written in texts.
NUMBER_FORMATS = ("1,234.5", "1.234,5")
DATE_ORDERS = ("day-month", "month-day")


class LogForm(NamedTuple):
    """How a text writes numbers, one of `NUMBER_FORMATS`, and dates, one of `DATE_ORDERS`; None where its cells say."""

    numbers: str | None = None
    dates: str | None = None

    @classmethod
    def of(cls, numbers: object, dates: object, where: str) -> LogForm:
        """Both, or an error of the one that is none of its choices."""
        for name, given, known in (("number-format", numbers, NUMBER_FORMATS), ("date-order", dates, DATE_ORDERS)):
            if given is not None and given not in known:
                raise InputError(f"{where}: {name} is one of {' or '.join(map(repr, known))}; got {given!r}")
        return cls(*(None if given is None else str(given) for given in (numbers, dates)))


AS_FOUND = LogForm()


@dataclass
class LogColumn:
    """One column.

    Attributes
    ----------
    values : (n,) array
        In `unit`; NaN where there is no valid value.
    unit : str
        As its source states it; empty if it states none.
    clock : str
        Full name of the column with its times; empty for the time of the log.
    start : float, optional
        Of dates or times of day, whose values are seconds: when these are zero, s since 1970 or since midnight.
    notes : list of (str, str)
        What was decided and what is missing: kind of flag, and message without the name.
    """

    values: Array
    unit: str = ""
    clock: str = ""
    start: float | None = None
    notes: list[tuple[str, str]] = field(default_factory=list)

    def mask(self, valid: np.ndarray) -> None:
        """Makes samples missing that their source marks as invalid, and notes how many."""
        lost = int(valid.size - np.count_nonzero(valid))
        if lost:
            self.values = np.where(valid, self.values, np.nan)
            text = f"has {lost} of {valid.size} samples that its source marks as invalid; they count as missing"
            self.notes.append(("masked", text))


class Clocked(NamedTuple):
    """Columns (n,) of one clock, with their names, its times (n,), s, and their zero, s since 1970, if known."""

    name: str
    times: Array
    columns: Sequence[tuple[str, LogColumn]]
    start: float | None = None


@dataclass
class LogTable:
    """Columns of a log.

    Attributes
    ----------
    columns : dict of LogColumn
        By their full names.
    notes : list of Flag
        Faults of the file itself.
    source : str
        What errors call it.
    in_memory : bool
        Whether it comes from a program, which passes SI values unless it states otherwise.
    clock : str
        Full name of the times of the log, if all clocks have one zero: columns with others are interpolated at these.
    clock_key : str
        Key of ``[time]`` in a mapping that chooses another clock by its name.
    about : dict
        Statements on the whole log, for example ``payload``: texts and numbers.
    words : dict of str
        Columns that were left out because they hold no numbers, with their first text.
    left_out : dict of str
        Every column that was left out, with the reason.
    names : list of str
        The columns of the source in their order, also those that were left out; empty for one without a name.
    """

    columns: dict[str, LogColumn] = field(default_factory=dict)
    notes: list[Flag] = field(default_factory=list)
    source: str = "the log"
    in_memory: bool = False
    clock: str = ""
    clock_key: str = "column"
    about: dict[str, str | float | int] = field(default_factory=dict)
    words: dict[str, str] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)
    names: list[str] = field(default_factory=list)

    def add(self, name: str, column: LogColumn, owner: str = "") -> str:
        """Add a column and return its full name; a repeated name gets its `owner` as prefix, or a number as suffix."""
        full = self._free(name, owner)
        if full != name:
            column.notes.append(("renamed", f"is a second column called `{name}`"))
        self.columns[full] = column
        self.names.append(full)
        return full

    def add_clocked(self, groups: Sequence[Clocked]) -> None:
        """Add columns with clocks of one zero; that of most samples, among those that are `LONG`, is the log's."""
        least = LONG * max((float(np.ptp(group.times)) for group in groups), default=0.0)
        for group in sorted(groups, key=lambda group: (np.ptp(group.times) < least, -group.times.size)):
            clock = self._free(group.name, "")
            self.columns[clock] = LogColumn(group.times, "s", clock, group.start)
            self.clock = self.clock or clock
            for name, column in group.columns:
                column.clock = clock
                self.add(name, column)

    def _free(self, name: str, owner: str) -> str:
        taken = self.columns.keys() | self.left_out.keys()
        owned = f"{owner}.{name}" if owner else name
        if name not in taken or owned not in taken:
            return name if name not in taken else owned
        short = _core.split_name(name)[0]
        return next(n for i in count(2) if (n := f"{short}.{i}{name[len(short) :]}") not in taken)

    def take(self, name: str, values: object, unit: str = "", attributes: Mapping[str, object] | None = None) -> None:
        """Add a column, or leave it out if it is no series of numbers; `attributes` may say how it is packed."""
        column = as_column(values, unit)
        if column is None:
            self.leave(name, NO_NUMBERS)
        elif column.values.ndim != 1:
            self.leave(name, f"{column.values.ndim} dimensions, where a signal has one")
        else:
            self.keep(name, column, attributes or {})

    def keep(self, name: str, column: LogColumn, attributes: Mapping[str, object], owner: str = "") -> str | None:
        """Add a column that its source may have packed, and return its full name; None if it cannot be unpacked."""
        try:
            unpack(column, attributes)
        except ValueError as error:
            self.leave(name, str(error))
            return None
        return self.add(name, column, owner)

    def leave(self, name: str, reason: str, word: str = "") -> None:
        """Leave out a column, and note the reason; one without a name only counts."""
        name = self._free(name, "") if name else ""
        self.names.append(name)
        if not name:
            return
        self.left_out[name] = reason
        if word:
            self.words[name] = word

    def find(self, wanted: str | int) -> str | None:
        """Full name of a column by its name, its name without the unit, or its number counted from 1 in the source.

        Raises
        ------
        InputError
            If several columns have the name.
        """
        if isinstance(wanted, int):
            # Signals with clocks of their own stand in no order.
            name = self.names[wanted - 1] if 1 <= wanted <= len(self.names) and not self.clock else ""
            return name if name in self.columns else None
        return wanted if wanted in self.columns else self.first_of((wanted,))

    def first_of(self, names: Sequence[str], among: Iterable[str] | None = None) -> str | None:
        """Full name of the first column with one of these names, with or without its unit: as it is written, else in
        any case.

        Raises
        ------
        InputError
            If several columns have that name.
        """
        known = list(self.columns if among is None else among)
        return self._asked(known, lambda: _core.first_of(known, list(names)))

    def _asked(self, names: Sequence[str], found: Callable[[], int | None]) -> str | None:
        try:
            index = found()
        except ValueError as error:
            raise InputError(f"{self.source} {error}") from None
        return None if index is None else names[index]

    def time_column(self) -> str | None:
        """Full name of the time column: that of the log, the one with such a name, the only one with dates, or that
        of the only group with times.

        Raises
        ------
        InputError
            If there are several.
        """
        if self.clock:
            return self.clock
        own = self.columns.items()
        heads = [(name, c.unit, None if c.start is None else (c.start, c.values)) for name, c in own]
        clocks = [i for i, (name, c) in enumerate(own) if c.clock == name and is_time(name)]
        return self._asked(list(self.columns), lambda: _core.time_column(heads, clocks))

    def unit_of(self, column: str) -> str:
        """The unit that the source states for a column; empty if it states none."""
        return _core.unit_of(column, self.columns[column].unit)


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


def is_time(name: str) -> bool:
    """Whether times are called so, in any group and any case."""
    return _core.split_name(name)[0].rsplit(".", 1)[-1].lower() in TIME_NAMES


def attribute(attributes: Mapping[str, object], *names: str) -> object:
    """The value of the first attribute with one of these names, in any case; None if there is none."""
    known = {name.lower(): attributes[name] for name in reversed(list(attributes))}
    return next((known[name] for name in names if name in known), None)


def stated_unit(attributes: Mapping[str, object]) -> str:
    """The unit that attributes state, as they write it; empty if they state none."""
    unit = attribute(attributes, "units", "unit")
    if isinstance(unit, np.ndarray) and unit.size == 1:
        unit = unit.item()
    return plain(unit.decode("utf-8", "replace") if isinstance(unit, bytes) else "" if unit is None else str(unit))


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


def as_column(values: object, unit: str = "") -> LogColumn | None:
    """Values as a column of float64, or None if they are no numbers; masked ones are NaN, and durations seconds."""
    masked = np.ma.getmaskarray(values) if isinstance(values, np.ma.MaskedArray) else None
    array = np.asarray(values)
    if array.dtype == object:
        array = _of_objects(array)
    if array.dtype.kind not in "buifmM" or not array.size:
        return None
    if array.dtype.kind == "M":
        return _of_dates(array)
    if array.dtype.kind == "m":
        missing = np.isnat(array)
        array = np.where(missing, np.nan, array / np.timedelta64(1, "ns") * 1e-9)
        unit = "s"
    column = LogColumn(array.astype(np.float64), unit)
    if masked is not None:
        column.mask(~masked)
    return column


def _of_dates(values: np.ndarray) -> LogColumn:
    """Values of ``datetime64``; NaN where there is none."""
    first = next(iter(values[~np.isnat(values)].flat), np.datetime64(0, "s"))
    nanosecond = np.timedelta64(1, "ns")
    start = float((first - np.datetime64(0, "s")) / nanosecond) * 1e-9
    return LogColumn(np.asarray((values - first) / nanosecond, np.float64) * 1e-9, "s", start=start)


def _of_objects(array: np.ndarray) -> np.ndarray:
    """Numbers, or dates with zones, that NumPy holds as objects; the array itself if there is anything else in it."""
    if any(isinstance(value, str | bytes | bool) for value in array.flat):
        return array
    try:
        kept = [None if value is None or str(value) == "<NA>" or value != value else value for value in array.flat]
        if all(value is None or hasattr(value, "timestamp") for value in kept):
            stamps = [np.nan if value is None else value.timestamp() for value in kept]
            return np.asarray(np.asarray(stamps) * 1e6, "M8[us]").reshape(array.shape)
        numbers = [np.nan if value is None else float(value) for value in kept]
    except (TypeError, ValueError):
        return array
    return np.asarray(numbers, np.float64).reshape(array.shape)


def unpack(column: LogColumn, attributes: Mapping[str, object]) -> None:
    """Numbers of a file that packs them by the conventions of NetCDF: marks of missing values, then factor and offset.

    Raises
    ------
    ValueError
        If a factor or an offset is no number.

    Sources
    -------
    NetCDF Climate and Forecast Metadata Conventions 1.11, sections 2.5.1 and 8.1.
    """

    def numbers(name: str) -> Array:
        stated = attribute(attributes, name.lower())
        found = np.ravel(np.asarray(() if stated is None else stated))
        try:
            return found.astype(np.float64) if found.dtype.kind in "buifSUO" else np.zeros(0)
        except (TypeError, ValueError):
            if name in ("scale_factor", "add_offset"):
                raise ValueError(f"its attribute `{name}` is no number, `{stated}`") from None
            return np.zeros(0)

    values = column.values
    marks = np.concatenate([numbers("_FillValue"), numbers("missing_value")])
    low = [*numbers("valid_min"), *numbers("valid_range")[:1]]
    high = [*numbers("valid_max"), *numbers("valid_range")[1:2]]
    valid = ~np.isin(values, marks[np.isfinite(marks)])
    for bound in low:
        valid &= ~(values < bound)
    for bound in high:
        valid &= ~(values > bound)
    column.mask(valid)
    for factor in numbers("scale_factor")[:1]:
        column.values = column.values * factor
    for offset in numbers("add_offset")[:1]:
        column.values = column.values + offset
