"""Times of day and dates in the formats of loggers and pandas, as seconds from the first."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta

import numpy as np

from hydrocrane.arrays import Array

_CLOCK = re.compile(r"^\d{1,2}:\d{2}:\d{2}([.,]\d+)?( ?[AaPp][Mm])?$")
# Day first with points, 31.12.2024; month or day first with slashes, 12/31/2024; year first with either sign.
_DATE = re.compile(r"^(?:(\d{4})[/.](\d{1,2})[/.](\d{1,2})|(\d{1,2})([/.])(\d{1,2})[/.](\d{4}))[ T]+(.*)$")
_DAY = 86400.0
# A time column with larger numbers is not in seconds: they would be 3000 years.
_LATEST = 1e11


def seconds_of(cells: Sequence[str]) -> Array | None:
    """Seconds (n,) from the first of ISO 8601 dates with time, or times of day; NaN where a cell is neither.

    None if more than half of the cells are neither. Times without a zone are taken as they are; a time of day
    that jumps back by more than half a day has passed midnight.
    """
    found = [_moment(cell) for cell in cells]
    known = [moment for moment in found if moment is not None]
    if 2 * len(known) <= len(cells):
        return None
    first = known[0]
    seconds = np.array([np.nan if moment is None else (moment - first).total_seconds() for moment in found])
    if all(_CLOCK.match(cell) for cell in cells if _moment(cell) is not None):
        real = np.flatnonzero(np.isfinite(seconds))
        seconds[real] += _DAY * np.cumsum(np.diff(seconds[real], prepend=0.0) < -_DAY / 2)
    return seconds


def is_moment(cell: str) -> bool:
    """Whether a cell is a date with time, or a time of day."""
    return _moment(cell) is not None


def seconds_of_dates(values: np.ndarray) -> Array:
    """Seconds (n,) from the first of ``datetime64`` values; NaN where there is none."""
    real = values[~np.isnat(values)]
    if not real.size:
        return np.full(values.shape, np.nan)
    return np.asarray((values - real[0]) / np.timedelta64(1, "ns"), dtype=np.float64) * 1e-9


def epoch_unit(values: Array) -> str:
    """The likely unit of times since 1970 without a unit, if they cannot be seconds; else empty."""
    finite = np.abs(values[np.isfinite(values)])
    if not finite.size or finite.max() < _LATEST:
        return ""
    return "ms" if finite.max() < 1e14 else "1e-6 s" if finite.max() < 1e17 else "1e-9 s"


def _moment(cell: str) -> datetime | None:
    text = cell.strip()
    try:
        if _CLOCK.match(text):
            return datetime(1970, 1, 1, tzinfo=UTC) + _time_of_day(text)
        dated = _DATE.match(text)
        if dated and _CLOCK.match(dated[8]):
            return datetime(*_day(dated), tzinfo=UTC) + _time_of_day(dated[8])
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


def _day(dated: re.Match[str]) -> tuple[int, int, int]:
    """Year, month, day. With slashes an ambiguous month is the first number, as in the United States."""
    if dated[1]:
        return int(dated[1]), int(dated[2]), int(dated[3])
    first, second, year = int(dated[4]), int(dated[6]), int(dated[7])
    day_first = dated[5] == "." or first > 12
    return (year, second, first) if day_first else (year, first, second)
