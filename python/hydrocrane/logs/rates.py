"""Signals that were sampled less often than the log: blank, held or straight between their own samples."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrocrane.arrays import Array

# So many samples of its own a signal must show, and so regularly, before it counts as a slow one.
LEAST_OWN, REGULAR = 20, 0.95
# From this many rows per sample on a clock may be off by one row.
LOOSE = 6
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
    if sizes.size >= LEAST_JUMPS and _regular(np.diff(changes), exact=False):
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
    if usual < 2:
        return False
    off = np.abs(spacing - usual) if exact else np.abs(spacing - usual * np.round(spacing / usual))
    return float(np.mean(off <= (usual >= LOOSE))) >= REGULAR
