"""Effect of a converter's rounding on means of noisy readings."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from hydrocrane.arrays import Array
from hydrocrane.logs.noise import Noise, noise_of

# Number of samples over which a signal at rest is detected: it changes by less than this share of a converter's step.
BLOCK, STANDS = 64, 0.5
# A place with more than this multiple of the variance of the others vibrates.
SHAKES = 5.0


def rounding_bias(sigma: float, step: float, travel: float = 0.0) -> float:
    """Error of a mean due to a converter's rounding, as a standard deviation over all positions within a step.

    Noise of standard deviation `sigma` before a converter with `step` smooths its staircase: the first harmonic of the
    rounding error, amplitude step/pi, is reduced by exp(-2 pi^2 sigma^2 / step^2) (Widrow and Kollar, Quantization
    Noise, 2008). A steady change by `travel` averages over the crossed steps: at most the share step/(pi travel)
    remains.

    `sigma` must come from readings at many positions within the steps. Readings at one position are not sufficient: in
    the middle of a code they are all equal, at its edge they have two values.
    """
    if step <= 0.0:
        return 0.0
    faded = step / (np.pi * np.sqrt(2.0)) * np.exp(-2.0 * (np.pi * sigma / step) ** 2)
    return float(min(step / np.sqrt(12.0), faded) * min(1.0, step / (np.pi * travel) if travel else 1.0))


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
