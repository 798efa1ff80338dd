"""Noise and resolution of a signal, from the signal alone."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrocrane.arrays import Array

# Standard deviation of normal values over their median absolute value.
BY_MEDIAN = 1.4826


class Noise(NamedTuple):
    """Standard deviation of the fast noise, and the converter's step (zero if none is seen), in the signal's unit."""

    sigma: float
    step: float

    @property
    def total(self) -> float:
        """Standard deviation of both together; the rounding error is uniform over a step."""
        return float(np.hypot(self.sigma, self.step / np.sqrt(12.0)))


def noise_of(values: Array) -> Noise:
    """Noise of a signal (n,) that also contains slow motion.

    Second differences remove any trend that is linear over three samples. Their median absolute value is robust against
    jumps. If the converter's step exceeds the noise, only the step is found.
    """
    finite = finite_of(values)
    if finite.size < 5:
        return Noise(0.0, 0.0)
    second = np.abs(np.diff(finite, 2))
    spread = BY_MEDIAN * float(np.median(second))
    # The median is a multiple of the converter's step; the mean square without jumps is not.
    kept = second[second <= 5.0 * spread]
    sigma = float(np.sqrt(np.mean(kept**2))) / np.sqrt(6.0)
    step = converter_step(finite)
    # Rounding alone causes second differences of the size of a step.
    return Noise(float(np.sqrt(max(sigma**2 - step**2 / 12.0, 0.0))), step)


def most_noise(values: Array) -> Noise:
    """What :func:`noise_of` cannot exceed, in a fraction of its time."""
    finite = finite_of(values)
    # Some of the levels: with more of them the gaps between them are narrower.
    levels = np.unique(finite[:: finite.size // 1000 + 1])
    if levels.size < 4:
        return Noise(np.inf, np.inf)
    second = np.diff(finite, 2)
    mean_square = float(second @ second) / second.size
    return Noise(float(np.sqrt(mean_square / 6.0)), 2.0 * float(np.ptp(finite)) / (levels.size - 1))


def converter_step(values: Array) -> float:
    """Step of the lattice on which the values (n,) lie; zero if there is none."""
    ordered = np.sort(values)
    gaps = np.diff(ordered)
    gaps = gaps[gaps > 0.0]
    if not 2 <= gaps.size + 1 <= max(0.5 * values.size, 2):
        return 0.0
    # Levels that differ by rounding of the last digits only are one.
    gaps = gaps[gaps > 1e-9 * max(abs(ordered[0]), abs(ordered[-1]))]
    if not gaps.size:
        return 0.0
    step = float(np.quantile(gaps, 0.05))
    multiples = gaps / step
    return step if float(np.median(np.abs(multiples - np.round(multiples)))) < 0.02 else 0.0


def carries_noise(values: Array) -> bool:
    """Whether successive changes alternate in sign, as those of noise do and those of motion do not."""
    change = np.diff(finite_of(values))
    change = change[change != 0.0]
    return change.size > 10 and float(np.mean(change[1:] * change[:-1] < 0.0)) > 0.2


def finite_of(values: Array) -> Array:
    """The finite ones of `values`, which are not copied if all are."""
    finite = np.isfinite(values)
    return values if finite.all() else values[finite]
