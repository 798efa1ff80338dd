"""Times of day and dates in the formats of loggers and pandas, as seconds from the first."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, date, datetime, timedelta
from typing import NamedTuple

import numpy as np

from hydrocrane.arrays import Array

_CLOCK = re.compile(r"^\d{1,2}:\d{2}:\d{2}([.,]\d+)?( ?[AaPp][Mm])?$")
# Day first with points, 31.12.2024; day or month first with other marks, 12/31/2024; year first with any.
_DATE = re.compile(r"^(?:(\d{4})[/.](\d{1,2})[/.](\d{1,2})|(\d{1,2})([/.-])(\d{1,2})[/.-](\d{4}))[ T]+(.*)$")
_DAY = 86400.0
# A time column with larger numbers is not in seconds: they would be 3000 years.
_LATEST = 1e11
# Days of 1900 to 2100 as MATLAB and Excel count them.
_SERIAL = ((693962.0, 767010.0), (25569.0, 73051.0))
# Days that count as these have steps of less: more than a thousand samples per second if they were seconds.
_LEAST_STEP = 1e-3


class Moments(NamedTuple):
    """Seconds (n,) from the first moment, NaN where a cell is none; whether the order of day and month is undecided."""

    seconds: Array
    undecided: bool = False


def seconds_of(cells: Sequence[str], order: str | None = None) -> Moments | None:
    """Seconds from the first of ISO 8601 dates with time, or times of day; None if more than half of the cells are
    neither.

    Times without a zone are taken as they are; a time of day that jumps back by more than half a day has passed
    midnight. `order` of day and month is "day-month" or "month-day"; by default all cells together decide it.
    """
    dated = [found for cell in cells if (found := _DATE.match(cell.strip())) and found[5] in ("/", "-")]
    day_first = (
        order == "day-month"
        if order
        else _day_first([(int(found[4]), int(found[6]), int(found[7])) for found in dated])
    )
    moments = [_moment(cell, bool(day_first)) for cell in cells]
    known = [moment for moment in moments if moment is not None]
    if 2 * len(known) <= len(cells):
        return None
    first = known[0]
    seconds = np.array([np.nan if moment is None else (moment - first).total_seconds() for moment in moments])
    if all(_CLOCK.match(cell.strip()) for cell, moment in zip(cells, moments) if moment is not None):
        real = np.flatnonzero(np.isfinite(seconds))
        seconds[real] += _DAY * np.cumsum(np.diff(seconds[real], prepend=0.0) < -_DAY / 2)
    return Moments(seconds, day_first is None)


def _day_first(stated: Sequence[tuple[int, int, int]]) -> bool | None:
    """Whether the first of two numbers before a year is the day in all dates of a column; None if nothing says so."""
    changes = [each for i, each in enumerate(stated) if not i or each != stated[i - 1]]
    if len(changes) < 2:
        # Seconds from the first moment do not depend on its date.
        return any(first > 12 for first, _, _ in changes)
    days = {day_first: _ordinals(changes, day_first) for day_first in (True, False)}
    possible = [day_first for day_first, found in days.items() if found]
    if len(possible) == 2:
        # A log goes on from one day to the next.
        possible = [day_first for day_first, found in days.items() if set(np.diff(found)) == {1}]
    return possible[0] if len(possible) == 1 else None


def _ordinals(stated: Sequence[tuple[int, int, int]], day_first: bool) -> list[int]:
    """Dates as numbers of days; empty if one of them does not exist."""
    try:
        return [date(year, *((b, a) if day_first else (a, b))).toordinal() for a, b, year in stated]
    except ValueError:
        return []


def is_moment(cell: str) -> bool:
    """Whether a cell is a date with time, or a time of day."""
    return _moment(cell, day_first=True) is not None or _moment(cell, day_first=False) is not None


def seconds_of_dates(values: np.ndarray) -> Array:
    """Seconds (n,) from the first of ``datetime64`` values; NaN where there is none."""
    real = values[~np.isnat(values)]
    if not real.size:
        return np.full(values.shape, np.nan)
    return np.asarray((values - real[0]) / np.timedelta64(1, "ns"), dtype=np.float64) * 1e-9


def counted_in(values: Array) -> str:
    """The likely unit of times without a unit, if they cannot be seconds; else empty.

    Times since 1970 are too large for seconds; serial days of MATLAB and Excel have too small steps.
    """
    finite = values[np.isfinite(values)]
    largest = np.abs(finite).max(initial=0.0)
    if largest >= _LATEST:
        return "ms" if largest < 1e14 else "1e-6 s" if largest < 1e17 else "1e-9 s"
    day = any(low <= finite.min() and finite.max() <= high for low, high in _SERIAL) if finite.size > 1 else False
    return "d" if day and 0.0 < float(np.median(np.diff(finite))) < _LEAST_STEP else ""


def _moment(cell: str, day_first: bool) -> datetime | None:
    text = cell.strip()
    try:
        if _CLOCK.match(text):
            return datetime(1970, 1, 1, tzinfo=UTC) + _time_of_day(text)
        dated = _DATE.match(text)
        if dated and _CLOCK.match(dated[8]):
            return datetime(*_day(dated, day_first), tzinfo=UTC) + _time_of_day(dated[8])
        if ":" not in text or "-" not in text:
            return None
        found = datetime.fromisoformat(text)
    except ValueError:
        return None
    return found if found.tzinfo else found.replace(tzinfo=UTC)


def _time_of_day(text: str) -> timedelta:
    half = text[-2:].lower() if text[-1] in "mM" else ""
    hours, minutes, seconds = text.replace(",", ".").rstrip("aApPmM ").split(":")
    hour = int(hours) % 12 + 12 * (half == "pm") if half else int(hours)
    return timedelta(hours=hour, minutes=int(minutes), seconds=float(seconds))


def _day(dated: re.Match[str], day_first: bool) -> tuple[int, int, int]:
    """Year, month, day."""
    if dated[1]:
        return int(dated[1]), int(dated[2]), int(dated[3])
    first, second, year = int(dated[4]), int(dated[6]), int(dated[7])
    return (year, second, first) if day_first or dated[5] == "." else (year, first, second)
