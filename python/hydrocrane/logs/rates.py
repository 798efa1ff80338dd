"""Signals with a lower sampling rate than the log: missing, held or interpolated between their own samples."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrocrane.arrays import Array

# Least number of own samples of a slow signal, and the least regularity of their spacing.
LEAST_OWN, REGULAR = 20, 0.95
# Most rows per sample; a larger number is rather a held velocity in a log without noise.
MOST_ROWS = 200
# Least number of rows per sample at which spacings may differ by one row.
LOOSE = 6
# Least share of own samples that differ from the previous one: otherwise the signal is rather at rest.
LIVES = 0.4
# Jumps of one size only are steps of a converter in slow motion, not those of a held signal.
LEAST_JUMPS = 3


def runs(mask: np.ndarray) -> np.ndarray:
    """(k, 2) first and last + 1 of every stretch in which `mask` is true."""
    beside = np.zeros(mask.size + 2, dtype=bool)
    beside[1:-1] = mask
    return np.flatnonzero(beside[1:] != beside[:-1]).reshape(-1, 2)


class OwnSamples(NamedTuple):
    """Rows (k,) of a log in which a slow signal has its own samples, and the kind of values between them."""

    rows: np.ndarray
    between: str


def own_samples(values: Array) -> OwnSamples | None:
    """Rows in which a signal (n,) of a log has its own samples; None if every row is one, or without a pattern."""
    finite = np.flatnonzero(np.isfinite(values))
    if finite.size < LEAST_OWN:
        return None
    if finite.size <= 0.6 * values.size:
        return OwnSamples(finite, "blank") if _regular(np.diff(finite), exact=True) else None
    known = values[finite] if finite.size < values.size else values
    jump = np.diff(known)
    count = np.count_nonzero(jump)
    # More changes than this follow each other row by row.
    if 1 < count <= 0.6 * known.size:
        changes = np.flatnonzero(jump)
        spacing = np.diff(changes)
        if count * np.quantile(spacing, 0.1) >= LIVES * known.size and _regular(spacing, exact=False):
            sizes = np.abs(jump[changes])
            if np.unique(np.round(1e6 * sizes / sizes.max())).size >= LEAST_JUMPS:
                return OwnSamples(finite[changes + 1], "held")
    # The staircase of a converter in slow motion has straight parts too.
    if 2 * count < jump.size:
        return None
    # A knot between two rows changes the slope at both rows.
    bends = runs(np.abs(np.diff(jump)) > 1e-12 * max(known.max(), -known.min()))[:, 0] + 1
    spacing = np.diff(bends)
    if spacing.size and np.median(spacing) > 2 and _regular(spacing, exact=True):
        return OwnSamples(finite[bends], "interpolated")
    return None


def _regular(spacing: np.ndarray, exact: bool) -> bool:
    """Whether all spacings in rows are one number of two or more, or, unless `exact`, its multiples."""
    if spacing.size < LEAST_OWN - 1:
        return False
    usual = float(np.median(spacing[spacing <= 1.5 * np.quantile(spacing, 0.1)]))
    if not 2 <= usual <= MOST_ROWS:
        return False
    off = np.abs(spacing - usual) if exact else np.abs(spacing - usual * np.round(spacing / usual))
    return float(np.mean(off <= (usual >= LOOSE))) >= REGULAR
