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
    known = values[finite]
    jump = np.diff(known)
    changes = np.flatnonzero(jump != 0.0)
    sizes = np.unique(np.round(1e6 * np.abs(jump[changes]) / np.abs(jump).max())) if changes.size else changes
    spacing = np.diff(changes)
    lives = changes.size > 1 and changes.size * np.quantile(spacing, 0.1) >= LIVES * known.size
    if lives and sizes.size >= LEAST_JUMPS and _regular(spacing, exact=False):
        return OwnSamples(finite[changes + 1], "held")
    # The staircase of a converter in slow motion has straight parts too.
    if 2 * changes.size < jump.size:
        return None
    bends = np.flatnonzero(np.abs(np.diff(known, 2)) > 1e-12 * np.abs(known).max()) + 1
    # A knot between two rows changes the slope at both rows.
    bends = bends[np.diff(bends, prepend=-1) > 1]
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
