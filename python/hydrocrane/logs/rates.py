"""Signals that were sampled less often than the log: blank, held or straight between their own samples."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrocrane.arrays import Array

# So many samples of its own a signal must show, and so regularly, before it counts as a slow one.
LEAST_OWN, REGULAR = 20, 0.95
# More rows per sample than this are no logger's; held velocities of a log without noise look alike.
MOST_ROWS = 200
# From this many rows per sample on a clock may be off by one row.
LOOSE = 6
# Of all samples of its own so many must differ from the one before: readings that seldom change are those of a signal
# that stands still.
LIVES = 0.4
# Jumps of one size only are those of a converter in slow motion, not of a held signal.
LEAST_JUMPS = 3


class OwnSamples(NamedTuple):
    """Rows (k,) of a log in which a slow signal has samples of its own, and what stands between them."""

    rows: np.ndarray
    between: str


def own_samples(values: Array) -> OwnSamples | None:
    """Where a signal (n,) of a log has samples of its own; nothing where every row is one, or no pattern shows."""
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
    # A staircase has straight parts too, of a converter in slow motion.
    if 2 * changes.size < jump.size:
        return None
    bends = np.flatnonzero(np.abs(np.diff(known, 2)) > 1e-12 * np.abs(known).max()) + 1
    # A knot between two rows bends the line at both.
    bends = bends[np.diff(bends, prepend=-1) > 1]
    spacing = np.diff(bends)
    if spacing.size and np.median(spacing) > 2 and _regular(spacing, exact=True):
        return OwnSamples(finite[bends], "interpolated")
    return None


def _regular(spacing: np.ndarray, exact: bool) -> bool:
    """Whether spacings in rows are all one number of two or more, or, where not `exact`, its multiples."""
    if spacing.size < LEAST_OWN - 1:
        return False
    usual = float(np.median(spacing[spacing <= 1.5 * np.quantile(spacing, 0.1)]))
    if not 2 <= usual <= MOST_ROWS:
        return False
    off = np.abs(spacing - usual) if exact else np.abs(spacing - usual * np.round(spacing / usual))
    return float(np.mean(off <= (usual >= LOOSE))) >= REGULAR
