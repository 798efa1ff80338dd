"""Test whether a piece of constant velocity is settled, and its mean friction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.logs.hum import Hum
from hydrocrane.logs.noise import Noise, rounding_bias
from hydrocrane.signals.statistics import fitted_line

# Share at the end of a piece that may already belong to the next one.
MARGIN = 0.05
# Limit of the change of friction over the second half of the displacement since the motion began, as a share of
# friction. If friction approaches its final value exponentially with displacement, 10 % means that about 1 % is still
# missing.
HALF_WAY_SHARE = 0.1
# A peak of the spectrum is a line above this multiple of the mean of the rest; and the largest amplitude of its
# velocity, as a share of the mean velocity.
LINE, OSCILLATION_SHARE = 25.0, 0.2
# Width of a hum line about its frequency, Hz; a line stronger than this multiple is more than hum.
HUM_WIDTH, HUM_FACTOR = 0.6, 2.0
# Drift over a window that still counts as steady: as a share of the friction, and in its standard errors.
STEADY_SHARE, STEADY_ERRORS = 0.03, 2.5
# Pressures may drift more than friction, because a common drift of both chambers has no net force.
PRESSURE_SHARE = 0.1
BATCHES = 100
# A later start must reduce the error of the mean by more than this factor.
WORTH = 1.1
# Conditions for the treatment of rounding as a wave in time: least number of crossed steps, least samples per step, and
# largest residuals as a multiple of noise and rounding.
CROSSINGS, SAMPLED, EXPLAINED = 3.0, 8.0, 1.3


class Piece(NamedTuple):
    """A piece of constant velocity.

    Attributes
    ----------
    time, friction : (n,) arrays
        s, N.
    chambers : list of (n,) arrays
        p1 A1 and p2 A2, N.
    later_friction : (k,) array
        Friction over the second half of the displacement since the motion began, up to the end of the piece, N.
    later_time : (k,) array
        s.
    """

    time: Array
    friction: Array
    chambers: list[Array]
    later_time: Array
    later_friction: Array


class WindowMotion(NamedTuple):
    """Velocity and its standard error, m/s, and travel, m."""

    velocity: float
    error: float
    travel: float


def motion_of(time: Array, x: Array, noise: Noise) -> WindowMotion:
    """Velocity of a straight piece by least squares.

    The scatter about the line contains the noise. A short stretch may have too little scatter by chance, so the larger
    of both counts. The rounding error is periodic in the converter's steps; incomplete periods at both ends leave
    step^2 / (duration travel).
    """
    line = fitted_line(time, x)
    duration = float(time[-1] - time[0])
    travel = line.slope * duration
    wave = _staircase(line.residual, abs(travel), noise)
    if wave is not None:
        error = wave / duration
    else:
        crossed = max(abs(travel) / noise.step, 1.0) if noise.step else 1.0
        scatter = max(line.slope_error, noise.sigma * np.sqrt(12.0 / x.size) / duration)
        error = float(np.hypot(scatter, noise.step / crossed / duration))
    return WindowMotion(line.slope, float(np.hypot(error, _change(time, x, 4.0 * error))), travel)


def _staircase(residual: Array, travel: float, noise: Noise) -> float | None:
    """Standard deviation, m, of a least-squares travel if rounding is a wave in time; None if it is not.

    As a wave in time rounding must not count as noise too. A wave of amplitude a, k periods and unknown phase changes
    the travel by 6 a / (pi k) times a cosine. The first harmonic of the staircase, reduced by noise, is that of
    :func:`rounding_bias`. Over several steps the residuals are those of rounding and noise together, even if
    neighbouring samples have the same code.
    """
    crossed = travel / noise.step if noise.step else 0.0
    spread = float(np.std(residual))
    if crossed < CROSSINGS or residual.size < SAMPLED * crossed or spread > EXPLAINED * noise.total:
        return None
    sigma = noise.sigma or float(np.sqrt(max(spread**2 - noise.step**2 / 12.0, 0.0)))
    harmonic = rounding_bias(sigma, noise.step)
    # Noise makes the rest of the rounding random.
    white = np.sqrt(max(spread**2 - harmonic**2, sigma**2))
    return float(np.hypot(white * np.sqrt(12.0 / residual.size), 6.0 / np.pi * harmonic / crossed))


def _change(time: Array, x: Array, insignificant: float) -> float:
    """Significant part of half the difference between the velocities of both halves, m/s.

    The error of the velocity of each half is 2 sqrt(2) times that of the whole, and that of the difference 4 times.
    """
    middle = x.size // 2
    if middle < 3:
        return 0.0
    slopes = [np.polynomial.polynomial.polyfit(t - t[0], y, 1)[1] for t, y in (
        (time[:middle], x[:middle]), (time[middle:], x[middle:]))]  # fmt: skip
    return 0.5 * max(abs(float(slopes[1] - slopes[0])) - 2.0 * insignificant, 0.0)


def settled(piece: Piece, skipped: int, least: int) -> tuple[int | None, str]:
    """First sample after which friction and pressures are steady, or the reason why there is none.

    The start minimises the standard error of the mean of the rest (marginal standard error rule, White, Simulation 69,
    1997). It is then moved later in steps of a tenth of the rest until nothing drifts.
    """
    n = piece.time.size
    still = _settling(piece)
    if still:
        return None, still
    first = max(skipped, _least_marginal_error(piece.friction))
    if n - first < least:
        return None, "the transient fills it; record for longer at this command"
    reason = ""
    while n - first >= least:
        reason = _drift(piece, first)
        if not reason:
            return first, ""
        first += max((n - first) // 10, 1)
    return None, reason


def _settling(piece: Piece) -> str:
    """Whether friction still approaches its final value, judged over the second half of the displacement so far."""
    if piece.later_friction.size < 8:
        return ""
    line = fitted_line(piece.later_time, piece.later_friction)
    duration = float(piece.later_time[-1] - piece.later_time[0])
    level = abs(float(piece.friction[piece.friction.size // 2 :].mean()))
    change = abs(line.slope) * duration
    if change <= max(HALF_WAY_SHARE * level, STEADY_ERRORS * line.slope_error * duration):
        return ""
    change = line.slope * duration
    return f"friction still settles, by {change:.3g} N over the second half of the travel so far; travel further"


def oscillation(time: Array, force: Array, mass: float, hums: Sequence[Hum] = ()) -> tuple[float, float]:
    """Amplitude of velocity, m/s, and frequency, Hz, of the strongest line in the pressure force (n,); 0 without a
    line.

    A force oscillation of amplitude F at frequency f moves the mass with velocity F / (2 pi f m), which the position
    sensor may not show. Lines of `hums` count if they are stronger here than the hum.
    """
    n = force.size
    if n < 32:
        return 0.0, 0.0
    residual = fitted_line(time, force).residual * np.hanning(n)
    power = np.abs(np.fft.rfft(residual)) ** 2
    # The slowest lines are drift, which has its own test.
    power[:4] = 0.0
    width = (n - 1) / (n * float(time[-1] - time[0]))
    for hum in hums:
        middle = int(round(hum.frequency / width))
        near = slice(max(middle - 3 - int(HUM_WIDTH / width), 0), middle + 4 + int(HUM_WIDTH / width))
        # The window leaves 3/8 of the power of a sine.
        if np.sqrt(float(power[near].sum()) / (n * n * 0.375 / 4.0)) < HUM_FACTOR * hum.amplitude:
            power[near] = 0.0
    peak = int(np.argmax(power))
    near = slice(max(peak - 3, 0), peak + 4)
    line = float(power[near].sum())
    others = (float(power.sum()) - line) / max(power.size - 11, 1)
    if power[peak] <= LINE * others:
        return 0.0, 0.0
    amplitude = np.sqrt(line / (n * n * 0.375 / 4.0))
    return float(amplitude / (2.0 * np.pi * peak * width * mass)), peak * width


def _least_marginal_error(values: Array) -> int:
    """Start sample with the least error of the mean, computed for independent samples."""
    batch = max(values.size // BATCHES, 1)
    count = values.size // batch
    # The remainder is at the front, which is tested and not used.
    means = values[values.size - count * batch :].reshape(count, batch).mean(axis=1)
    tail = means[::-1]
    size = np.arange(1, count + 1)
    centred = tail - tail.mean()
    spread = np.cumsum(centred**2) - np.cumsum(centred) ** 2 / size
    # Fewer than a quarter of the batches give no reliable variance.
    lowest = max(count // 4, 1)
    error = np.maximum(spread[lowest - 1 :], 0.0) / size[lowest - 1 :] ** 2
    # Among nearly equal starts the first is taken, because the least of many estimated errors is so by chance.
    kept = lowest + int(np.flatnonzero(error <= WORTH * error.min())[-1])
    return values.size - kept * batch if kept < count else 0


def _drift(piece: Piece, first: int) -> str:
    """Message on the quantity that drifts after `first`; empty if none does."""
    time, friction = piece.time[first:], piece.friction[first:]
    duration = float(time[-1] - time[0])
    level = abs(float(friction.mean()))
    line = fitted_line(time, friction)
    if abs(line.slope) * duration > max(STEADY_SHARE * level, STEADY_ERRORS * line.slope_error * duration):
        return f"friction still drifts by {line.slope * duration:.3g} N; travel further at this command"
    for name, force in zip(("p1", "p2"), piece.chambers):
        part = fitted_line(time, force[first:])
        allowed = PRESSURE_SHARE * max(level, abs(part.mean))
        if abs(part.slope) * duration > max(allowed, STEADY_ERRORS * part.slope_error * duration):
            return (
                f"{name} still drifts, by {part.slope * duration:.3g} N on the piston; travel further at this command"
            )
    return ""


def mean_force(time: Array, friction: Array, readings: list[tuple[Array, Noise, float]]) -> tuple[float, float, float]:
    """Mean friction, its standard error, N, and the effective number of samples.

    The error contains the scatter with its correlation in time, half of a visible drift, and the rounding of the
    converters; `readings` are (values, noise of the whole signal, factor to N) of the signals in the sum.
    """
    line = fitted_line(time, friction)
    duration = float(time[-1] - time[0])
    drift = max(abs(line.slope) * duration - 2.0 * line.slope_error * duration, 0.0)
    rounding = 0.0
    for values, noise, factor in readings:
        travel = abs(np.polynomial.polynomial.polyfit(time - time[0], values, 1)[1]) * duration
        # Without noise a reading may change by a step where the signal hardly does.
        known = max(travel - np.sqrt(12.0) * rounding_bias(*noise), 0.0)
        rounding += (factor * rounding_bias(*noise, known)) ** 2
    error = float(np.sqrt(line.mean_error**2 + (0.5 * drift) ** 2 + rounding))
    return line.mean, error, line.effective
