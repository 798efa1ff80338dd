"""Times of day and dates, as loggers and pandas write them, as seconds from the first."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta

import numpy as np

from hydrocrane.arrays import Array

_CLOCK = re.compile(r"^\d{1,2}:\d{2}:\d{2}([.,]\d+)?$")
_DAY = 86400.0
# Seconds of a time column beyond this are no seconds: they would be 3000 years.
_LATEST = 1e11


def seconds_of(cells: Sequence[str]) -> Array | None:
    """Seconds (n,) from the first of ISO 8601 dates with time, or times of day; NaN where a cell is none.

    Nothing where more than half of the cells are neither. Times without a zone are taken as they are; a time of day
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
    """The unit in which unitless times since 1970 seem to be counted, where they cannot be seconds; else empty."""
    finite = np.abs(values[np.isfinite(values)])
    if not finite.size or finite.max() < _LATEST:
        return ""
    return "ms" if finite.max() < 1e14 else "1e-6 s" if finite.max() < 1e17 else "1e-9 s"


def _moment(cell: str) -> datetime | None:
    text = cell.strip()
    try:
        if _CLOCK.match(text):
            hours, minutes, seconds = text.replace(",", ".").split(":")
            part = timedelta(hours=int(hours), minutes=int(minutes), seconds=float(seconds))
            return datetime(1970, 1, 1, tzinfo=UTC) + part
        if ":" not in text or "-" not in text:
            return None
        found = datetime.fromisoformat(text)
    except ValueError:
        return None
    return found if found.tzinfo else found.replace(tzinfo=UTC)
