"""Noise and resolution of a signal, from the signal alone, and the effect of rounding on means of noisy readings."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from hydrocrane.arrays import Array

# Standard deviation of normal values over their median absolute value.
BY_MEDIAN = 1.4826
# Number of samples over which a signal at rest is detected: it changes by less than this share of a converter's step.
BLOCK, STANDS = 64, 0.5
# A place with more than this multiple of the variance of the others vibrates.
SHAKES = 5.0
# Harmonics of the rounding error that are summed.
HARMONICS = np.arange(1.0, 41.0)


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


def rounding_bias(sigma: float, step: float, travel: float = 0.0) -> float:
    """Error of a mean due to a converter's rounding, as a standard deviation over all positions within a step.

    Noise of standard deviation `sigma` before a converter with `step` smooths its staircase: harmonic k of the rounding
    error, amplitude step/(pi k), is reduced by exp(-2 (pi k sigma / step)^2) (Widrow and Kollar, Quantization Noise,
    2008). Without noise their sum is step/sqrt(12). A steady change by `travel` averages over the crossed steps: at
    most the share step/(pi travel) remains.

    `sigma` must come from readings at many positions within the steps. Readings at one position are not sufficient: in
    the middle of a code they are all equal, at its edge they have two values.
    """
    if step <= 0.0:
        return 0.0
    left = np.exp(-2.0 * (np.pi * HARMONICS * sigma / step) ** 2) / HARMONICS
    whole = step / (np.pi * np.sqrt(2.0)) * np.sqrt(left @ left)
    return float(whole * min(1.0, step / (np.pi * travel) if travel else 1.0))


def noise_before_rounding(values: Array) -> Noise:
    """Noise of a signal (n,) before the converter, also for a signal that is at rest for a long time.

    Each place at which the signal rests counts once, independent of the time. On average over all positions within a
    step the variance of the readings is sigma^2 + step^2/12 less the square of the rounding error of their mean, which
    does not scatter.
    """
    noise = noise_of(values)
    finite = values[np.isfinite(values)]
    count = finite.size // BLOCK
    blocks = finite[: count * BLOCK].reshape(count, BLOCK)
    halves = blocks.reshape(count, 2, BLOCK // 2).mean(axis=2)
    blocks = blocks[np.abs(halves[:, 1] - halves[:, 0]) <= STANDS * noise.step]
    if not noise.step or not blocks.size:
        return noise
    place = _places(blocks.mean(axis=1), STANDS * noise.step)
    shown = np.bincount(place, np.mean(np.diff(blocks, 2, axis=1) ** 2, axis=1) / 6.0) / np.bincount(place)
    still = shown <= SHAKES * max(float(np.median(shown)), noise.step**2 / 12.0)
    variance = float(shown[still].mean())

    def excess(sigma: float) -> float:
        return sigma**2 + noise.step**2 / 12.0 - rounding_bias(sigma, noise.step) ** 2 - variance

    sigma = float(brentq(excess, 0.0, np.sqrt(variance) + noise.step)) if excess(0.0) < 0.0 else 0.0
    return Noise(sigma, noise.step)


def _places(means: Array, apart: float) -> Array:
    """Index of the place of each of successive means (b,); a new place begins after a change by more than `apart`."""
    number, at, found = 0, float(means[0]), []
    for mean in means:
        if abs(mean - at) > apart:
            number, at = number + 1, float(mean)
        found.append(number)
    return np.array(found)
