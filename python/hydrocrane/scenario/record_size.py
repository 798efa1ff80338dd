"""Limit of the size of a record, estimated before a run, so that no run fails for lack of memory."""

from __future__ import annotations

import math

from hydrocrane.errors import InputError

# Largest record of one run, of a case of a study, or state of a batch, bytes.
MOST_BYTES = 2 * 1024**3
# Numbers that a run keeps at each time: 94 for the lab crane with its ledger, more for longer chains.
NUMBERS_PER_ROW = 100
_BYTES = 8


def row_count(duration: float, interval: float) -> float:
    """Times from 0 to `duration` (s) every `interval` (s); a float, because it may exceed the range of integers."""
    steps = duration / interval * (1 + 1e-12) if interval > duration / 1e300 else math.inf
    return math.floor(steps) + 1.0 if math.isfinite(steps) else math.inf


def check_size(what: str, rows: float, numbers: float, cure: str) -> None:
    """Refuse `rows` of `numbers` each if they need more than :data:`MOST_BYTES`.

    Raises
    ------
    InputError
        With the number of bytes and the `cure`.
    """
    size = rows * numbers * _BYTES
    if size > MOST_BYTES:
        counted = f"{_shown(size)} ({rows:.3g} times {numbers} numbers)"
        raise InputError(f"{what} would take {counted}, more than 2 GiB; give {cure}")


def _shown(size: float) -> str:
    if math.isinf(size):
        return "more bytes than can be counted"
    return f"{size / 1024**3:.3g} GiB"
