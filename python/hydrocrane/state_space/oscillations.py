"""Oscillating pairs of a linear system."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import Array, brief

# Records per period that show an oscillation well.
SHOWS_WELL = 10
# What takes longer than a quarter of an hour for a turn is drift by leakage, in pairs where pistons share a load, Hz.
_DRIFT = 1e-3
# Real parts this small beside the largest eigenvalue are rounding.
_ROUNDING = 1e-13


@dataclass(frozen=True)
class Oscillations:
    """Eigenvalues of a linear system, and its oscillating pairs, slowest first; drift below 1e-3 Hz is none.

    Attributes
    ----------
    frequency, damping : (k,) arrays
        Natural frequency, Hz, and damping ratio of each pair.
    state : tuple of str
        The state with the largest participation factor in each pair.
    eigenvalues : (n,) complex array
        All of them, 1/s.
    shapes : (k, n) complex array
        Right eigenvector of each pair.
    """

    frequency: Array
    damping: Array
    state: tuple[str, ...]
    eigenvalues: np.ndarray
    shapes: np.ndarray

    __repr__ = brief

    @property
    def record_interval(self) -> Array:
        """(k,) interval that records ten points per period of each mode, s."""
        return shows_well(self.frequency)


def shows_well(frequency: Array) -> Array:
    """Interval that records :data:`SHOWS_WELL` points per period of each frequency (Hz), s."""
    return 1.0 / (SHOWS_WELL * frequency)


def oscillations(matrix: Array, names: Sequence[str]) -> Oscillations:
    """Oscillating pairs of x' = A x, with A (n, n) and the `names` of its states."""
    from scipy.linalg import eig

    values, left, right = eig(matrix, left=True, right=True)
    # One of each conjugate pair; a real eigenvalue with a rounding error is no oscillation.
    swinging = np.flatnonzero(values.imag > max(1e-9 * np.abs(values).max(), 2 * np.pi * _DRIFT))
    swinging = swinging[np.argsort(np.abs(values[swinging]))]
    leading = np.argmax(np.abs(left.conj() * right), axis=0)
    size, decay = np.abs(values[swinging]), -values.real[swinging]
    return Oscillations(
        frequency=size / (2 * np.pi),
        damping=np.where(np.abs(decay) > _ROUNDING * np.abs(values).max(), decay / size, 0.0),
        state=tuple(names[leading[i]] for i in swinging),
        eigenvalues=values,
        shapes=right.T[swinging],
    )
