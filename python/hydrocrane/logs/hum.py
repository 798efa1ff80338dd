"""Mains hum: a spectral line at 50 or 60 Hz that a cable picks up, independent of the motion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrocrane.arrays import Array

MAINS, HARMONICS = (50.0, 60.0), 3
# Largest frequency error of networks and logger clocks, Hz per harmonic.
WANDER = 0.5
# Length of the blocks of a record, s, their least number, and about the most that are needed.
BLOCK, LEAST_BLOCKS, MOST_BLOCKS = 1.0, 4, 256
# Least power of a line over the usual power beside it; and the share of the quieter half of the blocks that must show
# it, each within this factor of the usual amplitude. In the other blocks steps of the signal hide it.
LINE, SHARE, FACTOR = 10.0, 0.8, 2.0
# Hum is independent of motion: the speed of some blocks must be below this share of the fastest.
SLOW, LEAST_SLOW = 0.3, 0.1
# Share of an interval by which times that count as even are off.
EVEN = 0.01


class Hum(NamedTuple):
    """A permanent spectral line: frequency as logged, Hz, amplitude in the signal's unit, mains frequency."""

    frequency: float
    amplitude: float
    mains: float


def hum_of(time: Array, values: Array, x: Array, interval: float | None = None) -> list[Hum]:
    """Lines of the mains in a signal (n,), with its harmonics, at their (possibly aliased) frequency in the log.

    A line counts as hum if its amplitude is the same at rest, in slow and in fast motion of the position `x` (n,),
    because a vibration of the rig changes with the motion. A record of a single velocity cannot show this, so nothing
    is found in it. `interval` is the usual one of the samples, s, if it is known.
    """
    usable = np.isfinite(values) & np.isfinite(x)
    if usable.sum() < 64:
        return []
    rate = 1.0 / (interval or float(np.median(np.diff(time))))
    size = int(round(BLOCK * rate))
    if size < 64:
        return []
    # At even times, also across gaps, which are filled by straight lines.
    even = np.arange(time[0], time[-1], 1.0 / rate)
    count = even.size // size
    if count < LEAST_BLOCKS:
        return []
    even = even[: count * size]
    signal, place = values[: even.size], x[: even.size]
    if signal.size < even.size or not usable.all() or np.abs(even - time[: even.size]).max() > EVEN / rate:
        signal, place = (np.interp(even, time[usable], each[usable]) for each in (values, x))
    place, signal = (each.reshape(count, size)[:: -(-count // MOST_BLOCKS)] for each in (place, signal))
    travel = np.abs(place[:, -size // 10 :].mean(axis=1) - place[:, : size // 10].mean(axis=1))
    power = _power(signal)
    slow = travel < SLOW * travel.max()
    lines = [_line(power, slow, rate, size, mains, k) for mains in MAINS for k in range(1, HARMONICS + 1)]
    found: list[Hum] = []
    for line in lines:
        if line is not None and all(abs(line.frequency - other.frequency) > 2.0 / BLOCK for other in found):
            found.append(line)
    return found


def at_mains(frequency: float) -> bool:
    """Whether a frequency, Hz, is that of the mains or one of its harmonics."""
    return any(abs(frequency - mains * k) <= WANDER * k for mains in MAINS for k in range(1, HARMONICS + 1))


def _power(blocks: Array) -> Array:
    """Squared amplitudes (blocks, bins) of a sine in each bin, after subtraction of a parabola."""
    size = blocks.shape[1]
    t = np.linspace(-1.0, 1.0, size)
    basis = np.linalg.qr(np.vander(t, 3))[0]
    rest = blocks - (blocks @ basis) @ basis.T
    # The window reduces a sine to half its amplitude in its bin, and to a quarter in each neighbour.
    return np.asarray(np.abs(np.fft.rfft(rest * np.hanning(size), axis=1)) ** 2 * (4.0 / size) ** 2)


def _line(power: Array, slow: np.ndarray, rate: float, size: int, mains: float, harmonic: int) -> Hum | None:
    wanted = mains * harmonic
    shown = abs(wanted - round(wanted / rate) * rate)
    width = rate / size
    bins = power.shape[1]
    near = np.arange(bins)[np.abs(np.arange(bins) * width - shown) <= WANDER * harmonic + 0.5 * width]
    if not near.size or near[0] < 6 or near[-1] > bins - 4:
        return None
    peak = int(near[np.argmax(np.median(power[:, near], axis=0))])
    beside = np.r_[max(peak - 20, 4) : peak - 3, peak + 4 : min(peak + 21, bins)]
    usual = np.median(power[:, beside], axis=1)
    quiet = usual <= np.median(usual)
    if not LEAST_SLOW <= np.mean(slow[quiet]) < 1.0:
        return None
    # Three bins contain a sine at any frequency between them; their powers add up to 3/2 of its square.
    squares = power[:, peak - 1 : peak + 2].sum(axis=1) / 1.5
    level = float(np.median(squares[quiet]))
    alike = (squares > level / FACTOR**2) & (squares < level * FACTOR**2) & (squares > LINE * usual)
    if np.mean(alike[quiet]) < SHARE:
        return None
    weights = power[quiet, peak - 1 : peak + 2].sum(axis=0)
    frequency = float(weights @ np.arange(peak - 1, peak + 2) / weights.sum()) * width
    return Hum(frequency, float(np.sqrt(level)), mains)
