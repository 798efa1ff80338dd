"""From a file's columns to signals in SI: assignment of columns, times, and notes on the unused columns."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from hydrocrane import _core
from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, nearest
from hydrocrane.logs.checks import GAP
from hydrocrane.logs.mapping import LogMapping, Source, expected_units, is_gauge, si_values
from hydrocrane.logs.signals import ATMOSPHERE, SIGNALS, Flag, known_unit
from hydrocrane.logs.table import TIME_NAMES, LogTable, said_of

if TYPE_CHECKING:
    import xarray as xr

# Digits of the marks that loggers write for a missing value, -999 and longer.
_NINES = re.compile(r"-?9{3,}\.(0|9+)")


def signals_of(
    table: LogTable, mapping: LogMapping | None, source: str, units: Mapping[str, str] | None = None
) -> tuple[xr.Dataset, list[Flag]]:
    """A table's columns as signals over ``time``, and the flags of its reader and its units.

    `units` are SI units that signals must have; without one a signal of a rig has its own, and others any.

    Raises
    ------
    InputError
        If a column, a time or a unit does not agree with the mapping.
    """
    import xarray as xr

    made = _Assembly(table, mapping, source, units or {})
    variables = {"time": ("time", made.time, {"units": "s", "long_name": "time"})}
    for name, entry in made.wanted().items():
        found = made.signal(name, entry)
        if found is not None:
            values, unit, about = found
            variables[name] = ("time", values, {"units": unit, "long_name": about})
    # All variables at once: a dataset checks all its variables with each new one.
    return xr.Dataset(variables, attrs={**table.about, "source": source}), made.notes()


class _Assembly:
    """The conversion of one table to signals.

    Attributes
    ----------
    time : (n,) array
        s.
    """

    def __init__(self, table: LogTable, mapping: LogMapping | None, source: str, units: Mapping[str, str]) -> None:
        self.table, self.mapping, self.source, self.units = table, mapping, source, units
        self.time, self.clock = _time(table, mapping, source)
        self.every = mapping is None or not mapping.signals
        self.left_out = dict(table.left_out)
        self.assumed: list[str] = []
        self.flags: list[Flag] = []
        if self.clock is not None:
            self._decided("time", self.clock)

    def wanted(self) -> dict[str, Source]:
        if self.mapping is not None and self.mapping.signals:
            return dict(self.mapping.signals)
        wanted: dict[str, Source] = {}
        for column in self.table.columns:
            own_clock = self.table.clock and self.table.columns[column].clock == column
            if column != self.clock and not own_clock:
                short = _core.split_name(column)[0]
                names = (short, column, *(f"{short}.{i}" for i in range(2, len(self.table.columns) + 2)))
                name = next(n for n in names if n not in wanted and n != "time")
                if name not in names[:2]:
                    self._flag(
                        "renamed", name, f"column `{column}` is signal `{name}`, because another column has its name"
                    )
                wanted[name] = Source(column)
        return wanted

    def signal(self, name: str, entry: Source) -> tuple[Array, str, str] | None:
        """Values in SI, unit and long name of a signal; None if its column has other times than the log."""
        table, source = self.table, self.source
        column = table.find(entry.column)
        if column is None:
            origin = self.mapping.origin if self.mapping else source
            where = "" if origin == source else f"{origin}: "
            raise InputError(f"{where}{source} {no_column(table, entry.column)}")
        self._decided(name, column, entry.unit is not None)
        values = table.columns[column].values
        own = entry.time or (table.columns[column].clock if table.clock else "")
        if own and own != self.clock:
            values, apart = self._at_times(name, column, values, own)
        else:
            apart = self._apart(column, bool(entry.time))
        if apart and not self.every:
            raise InputError(f"{source}: column `{column}` does not fit the log's times: {apart}")
        if apart:
            self.left_out[column] = apart
            return None
        self._tell_mark(name, table.columns[column].values)
        about = SIGNALS[name].long_name if name in SIGNALS else column
        stated = table.unit_of(column)
        if entry.unit is None and stated and not known_unit(stated):
            foreign = f"the unit `{stated}` of column `{column}` is not known"
            if name in self.units:
                raise InputError(f"{source}: {foreign}; it must be one of {self.units[name]}")
            text = f"{foreign}; its numbers are used unchanged. Give it in a mapping"
            self._flag("unknown-unit", name, text, fatal=name in SIGNALS)
            return values * entry.sign, stated, about
        where = (
            f"{self.mapping.origin}: [signal.{name}]"
            if self.mapping and not self.every
            else f"{source}: column `{column}`"
        )
        expected = (self.units[name],) if name in self.units else None
        si, unit = si_values(values, entry, stated, name, where, expected)
        self._tell_unit(name, column, entry.unit if entry.unit is not None else stated)
        return si, unit, about

    def notes(self) -> list[Flag]:
        """Notes of the reader, assumptions, and every column that was left out."""
        notes = [*self.table.notes, *self.flags]
        if self.assumed and not self.table.in_memory:
            names = ", ".join(self.assumed)
            text = f"no unit is stated for {names}; SI units are assumed. State them in the file or a mapping"
            notes.append(self._whole("assumed-unit", "", text))
        # A mapping is a choice of columns; without one all columns are wanted.
        if self.every:
            notes += [self._whole("left-out", "", text) for text in said_of(self.left_out)]
        return notes

    def _whole(self, kind: str, signal: str, message: str, fatal: bool = False) -> Flag:
        return Flag(kind, signal, float(self.time[0]), float(self.time[-1]), message, fatal)

    def _flag(self, kind: str, signal: str, message: str, fatal: bool = False) -> None:
        if not self.table.in_memory or fatal:
            self.flags.append(self._whole(kind, signal, message, fatal))

    def _decided(self, name: str, column: str, with_unit: bool = False) -> None:
        """Flags of what was decided on a column and of what it misses; assumed units if it is not `with_unit`."""
        for kind, text in self.table.columns[column].notes:
            if not (with_unit and kind == "assumed-unit"):
                self.flags.append(self._whole(kind, name, f"`{name}` {text}"))

    def _tell_unit(self, name: str, column: str, unit: str) -> None:
        """Flags of ambiguous units."""
        if not unit:
            if name in SIGNALS:
                self.assumed.append(name)
                self._name_ends_in_unit(name, column)
            return
        if _core.log_unit(unit)[-1]:
            if is_gauge(name, (self.units[name],) if name in self.units else None):
                text = (
                    f"`{name}` is absolute; {ATMOSPHERE / 1e5:g} bar of standard atmosphere are subtracted, because "
                    "rigs measure relative to the air. If the air pressure is known, give the difference as `offset`"
                )
            else:
                text = f"`{name}` is absolute pressure and remains so; p1 and p2 of a rig are gauge"
            self._flag("absolute-pressure", name, text)
        # Mass or force; the core reads a force.
        if unit.strip() in ("lb", "lbs"):
            text = (
                f'`{unit}` of column `{column}` is read as pound-force, 4.448 N; for a mass give unit = "lbm", and '
                'for no question unit = "lbf"'
            )
            self._flag("assumed-unit", name, text)

    def _tell_mark(self, name: str, values: Array) -> None:
        """Flag of an end of the values that is written in nines, and far from all others."""
        known = values[np.isfinite(values)]
        for mark in {float(known.min()), float(known.max())} if known.size else ():
            rest = known[known != mark] if _NINES.fullmatch(repr(mark)) else known[:0]
            if rest.size and 0.0 < 2.0 * np.ptp(rest) < np.abs(rest - mark).min():
                text = (
                    f"`{name}` reads {mark:g} in {known.size - rest.size} samples and {rest.min():.4g} to "
                    f"{rest.max():.4g} in all others: is it the mark of a missing value? Leave such cells empty"
                )
                self.flags.append(self._whole("missing-mark", name, text))

    def _name_ends_in_unit(self, name: str, column: str) -> None:
        ending = column.rsplit("_", 1)[-1] if "_" in column else ""
        if not ending or not known_unit(ending):
            return
        factor, dimension, *_ = _core.log_unit(ending)
        if factor != 1.0 or dimension not in [_core.log_unit(unit)[1] for unit in expected_units(name)]:
            text = (
                f"the name of column `{column}` ends in `{ending}`, which is not taken as its unit; if it is, give "
                f'unit = "{ending}" under [signal.{name}]'
            )
            self._flag("assumed-unit", name, text)

    def _apart(self, column: str, stated: bool) -> str:
        """Reason why a column does not fit the log's times, unless a mapping `stated` its times; empty if it does."""
        columns = self.table.columns
        own, size = columns[column].clock, columns[column].values.size
        if not stated and self.clock is not None and own not in (self.clock, columns[self.clock].clock):
            if not own:
                return f'of no known times; if they are `{self.clock}`, give [signal.NAME] time = "{self.clock}"'
            if own == column:
                return f'the time of another recording; read that one with [time] column = "{own}"'
            if not np.array_equal(columns[own].values, columns[self.clock].values):
                return (
                    f"part of another recording, with times in `{own}`; read that one with [time] column = "
                    f'"{own}", or give [signal.NAME] time = "{own}" where both run on one clock'
                )
        if size == self.time.size:
            return ""
        fitting = [n for n, found in columns.items() if found.values.size == size and _increases(found.values)]
        other = [n for n in fitting if n != column]
        cure = f'; its times may be in `{other[0]}`: give [signal.NAME] time = "{other[0]}"' if other else ""
        return f"{size} values for {self.time.size} times{cure}"

    def _at_times(self, name: str, column: str, values: Array, own: str) -> tuple[Array, str]:
        """A column with its own times, interpolated at those of the log, or the reason why it cannot be."""
        where = f"{self.source}: [signal.{name}] time"
        clock = self.table.find(own)
        if clock is None:
            raise InputError(f"{where}: the file {no_column(self.table, own)}")
        times = clock_seconds(self.table, clock, None, where)
        if times.size != values.size:
            return values, f"its times `{clock}` have {times.size} values, it has {values.size}"
        if np.array_equal(times, self.time):
            return values, ""
        if times.size > 1 and not _increases(times):
            return values, f"its times `{clock}` do not increase throughout"
        shared = np.count_nonzero((self.time >= times[0]) & (self.time <= times[-1]))
        if not shared:
            ends = (f"{each[0]:.6g} to {each[-1]:.6g} s" for each in (times, self.time))
            return values, "its times `{}`, {}, have none in common with the log, {}; are all clocks set alike?".format(
                clock, *ends
            )
        found = np.interp(self.time, times, values, left=np.nan, right=np.nan)
        gaps = _in_gaps(times, self.time)
        found[gaps] = np.nan
        text = (
            f"`{name}` has its own times, `{clock}`, {times.size} from {times[0]:.6g} to {times[-1]:.6g} s, and is "
            f"interpolated at those of the log: {np.isfinite(found).sum()} of {found.size} have a value"
        )
        if gaps.any():
            text += f", {gaps.sum()} are in gaps of more than {GAP:g} of its usual intervals"
        if times.size > 2 * shared:
            text += f'. Most of its samples are lost; [time] {self.table.clock_key} = "{clock}" reads the log at these'
        self._flag("resampled", name, text)
        return found, ""


def _in_gaps(times: Array, wanted: Array) -> np.ndarray:
    """Which of the `wanted` times lie between two `times` that are further apart than usual."""
    if times.size < 2:
        return np.zeros(wanted.shape, bool)
    steps = np.diff(times)
    after = np.searchsorted(times, wanted).clip(1, times.size - 1)
    inside = (times[after - 1] < wanted) & (wanted < times[after])
    return np.asarray(inside & (steps[after - 1] > GAP * np.median(steps)))


def _increases(values: Array) -> bool:
    return values.size > 1 and bool((np.diff(values) > 0).all())


def _time(table: LogTable, mapping: LogMapping | None, source: str) -> tuple[Array, str | None]:
    """Times, s, and the full name of the time column that they came from."""
    if mapping is not None and mapping.sample_rate is not None:
        length = max(column.values.size for column in table.columns.values())
        return np.arange(length) / mapping.sample_rate, None
    entry = mapping.time if mapping is not None else None
    wanted = entry.column if entry else ""
    column = table.time_column() if wanted == "" else table.find(wanted)
    # A column with the name of times that could not be read says why.
    wanted = wanted or table.first_of(TIME_NAMES, table.left_out) or ""
    if column is None and wanted != "":
        raise InputError(f"{source} {no_column(table, wanted)}")
    if column is None:
        known = ", ".join(dict.fromkeys([*table.columns, *table.words, *table.left_out]))
        raise InputError(
            f"{source} has no time column; name it `time`, or state which it is, or the sample rate, under [time] of a "
            f"mapping: hc.Log.of(log, mapping). It has {known or 'no columns'}"
        )
    return clock_seconds(table, column, entry, f"{source}: time column `{column}`"), column


def clock_seconds(table: LogTable, column: str, entry: Source | None, where: str) -> Array:
    """Times of a column, s, in the unit of its mapping `entry` or of its own."""
    values, stated = table.columns[column].values, table.unit_of(column)
    if table.columns[column].start is not None:
        return values
    seems = None if stated or (entry is not None and entry.unit is not None) else _core.counted_in(values)
    if seems:
        cure = f'say [time] unit = "{seems}" in a mapping, hc.Log.of(log, mapping), or call it `{column} [{seems}]`'
        raise InputError(f'{where} cannot be in seconds, it seems to count {seems}; {cure}; "s" if it is in seconds')
    return si_values(values, entry or Source(column), stated, "time", where)[0]


def no_column(table: LogTable, wanted: str | int) -> str:
    """Message on a missing column, with the likeliest reason."""
    if isinstance(wanted, int):
        if table.clock:
            return f"has signals with clocks of their own, which have no number `{wanted}`; give the name"
        if not 1 <= wanted <= len(table.names) or not table.names[wanted - 1]:
            return f"has no column `{wanted}`; columns count from 1 to {len(table.names)}"
        wanted = table.names[wanted - 1]
    lost = table.first_of((wanted,), table.left_out) or wanted
    if lost in table.words:
        return (
            f"has no numbers in its column `{lost}`, which begins with `{table.words[lost]}`; times are written "
            "as seconds or as ISO 8601, 2024-05-01T12:30:00.25"
        )
    if lost in table.left_out:
        return f"cannot read its column `{lost}`: {table.left_out[lost]}"
    return f"has no column `{wanted}`{nearest(wanted, table.columns)}"
