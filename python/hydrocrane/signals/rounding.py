"""What a converter's rounding does to means of noisy readings."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from hydrocrane.arrays import Array
from hydrocrane.logs.noise import Noise, noise_of

# Samples in which a signal is seen to stand: it moves by less than this share of a converter's step.
BLOCK, STANDS = 64, 0.5
# A place that shows this many times the variance of the others shakes.
SHAKES = 5.0


def rounding_bias(sigma: float, step: float, travel: float = 0.0) -> float:
    """Error that a converter's rounding leaves in a mean, as a standard deviation over all places within a step.

    Noise of standard deviation `sigma` before a converter of `step` smooths its staircase: the first harmonic of the
    rounding error, amplitude step/pi, fades as exp(-2 pi^2 sigma^2 / step^2) (Widrow and Kollar, Quantization Noise,
    2008). A steady change by `travel` averages over the places that it crosses: step/(pi travel) is left at most.

    `sigma` must come from readings all over the steps. The spread of readings at one place says less: in the middle of
    a code they are all alike, at its edge they fall on two.
    """
    if step <= 0.0:
        return 0.0
    faded = step / (np.pi * np.sqrt(2.0)) * np.exp(-2.0 * (np.pi * sigma / step) ** 2)
    return float(min(step / np.sqrt(12.0), faded) * min(1.0, step / (np.pi * travel) if travel else 1.0))


def noise_before_rounding(values: Array) -> Noise:
    """Noise of a signal (n,) as the converter meets it, also where the signal stands still for long.

    Each place where the signal stands counts once, however long it stays. On average over all places within a step
    readings scatter by sigma^2 + step^2/12 less what rounding leaves in their mean, which does not scatter.
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
    """Number of the place of each of successive means (b,): another one where they have moved by more than `apart`."""
    number, at, found = 0, float(means[0]), []
    for mean in means:
        if abs(mean - at) > apart:
            number, at = number + 1, float(mean)
        found.append(number)
    return np.array(found)
