"""First readings of the bristle parameters from a ramp and a step, before anything is simulated.
                                                              theory: docs/theory/identification/dynamic.md

Both start with the piston at rest and its bristles straight. The bristle deflection is the part of the piston's way
that the seal does not slip,

    z(t) = int (1 - |F| / g(v)) dx,                                     thesis (124), (125) with the sign of E18

where F is the measured friction force; for F = c t and g = alpha_0 + alpha_1 that integral is
x - c/(alpha_0 + alpha_1) (x t - int x dt), (125) as corrected. Then

    sigma_0: slope of F over z while the piston creeps                                  (123), (126)
    sigma_1: slope of F - sigma_0 z - F_v(v) over dz/dt just after a step               (127)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.identification.static_map import StaticMap

# Friction as a share of the static friction between which the ramp is read: above the noise, and before the slip.
RAMP_SHARE = (0.05, 0.7)
# A step is read while the bristles still follow the piston: dz/dt at least this share of the velocity.
FOLLOWING = 0.3
LEAST_SAMPLES = 8


@dataclass(frozen=True)
class Reading:
    """One parameter read from one experiment.

    Attributes
    ----------
    value, error : float
        And its standard error from the scatter about the straight line, SI.
    abscissa, ordinate : (n,) arrays
        What the line was drawn through: deflection (m) and friction (N), or dz/dt (m/s) and the damped part (N).
    start, end : float
        Of the stretch that was read, s.
    """

    value: float
    error: float
    abscissa: Array
    ordinate: Array
    start: float
    end: float


def without_slip(law: StaticMap, position: Array, velocity: Array, friction: Array) -> Array:
    """Bristle deflection (n,), m, from piston position (m), velocity (m/s) and friction force (N), each (n,)."""
    seal = np.abs(dry(law).force(_moving(velocity)))
    held = 1.0 - np.clip(np.abs(friction - viscous(law, velocity)) / seal, 0.0, 1.0)
    steps = np.diff(position)
    return np.concatenate([[0.0], np.cumsum(0.5 * (held[1:] + held[:-1]) * steps)])


def stiffness(time: Array, position: Array, velocity: Array, friction: Array, law: StaticMap) -> Reading:
    """sigma_0 (N/m) from a ramp, all signals (n,) from rest on; friction without its value at rest.

    The line is drawn through both quantities with their own noise (total least squares), as the potentiometer's noise
    on the deflection would flatten an ordinary regression.
    """
    _check(time, position, velocity, friction)
    way = np.sign(np.mean(velocity))
    limit = float(np.abs(dry(law).force(np.array([way * 1e-8]))[0]))
    share = _smooth(way * friction) / limit
    above = np.flatnonzero(share > RAMP_SHARE[1])
    last = int(above[0]) if above.size else len(time)
    first = int(np.flatnonzero(share[:last] < RAMP_SHARE[0])[-1]) + 1 if (share[:last] < RAMP_SHARE[0]).any() else 0
    if last - first < LEAST_SAMPLES:
        raise InputError(
            f"the ramp holds {last - first} samples between {RAMP_SHARE[0]:.0%} and {RAMP_SHARE[1]:.0%} of the static "
            "friction; use a slower ramp or a higher sampling rate"
        )
    z = without_slip(law, position, velocity, friction)
    pick = slice(first, last)
    value, error = _line(z[pick], friction[pick], _noise(position), _noise(friction))
    return Reading(value, error, z[pick], friction[pick], float(time[first]), float(time[last - 1]))


def damping(
    time: Array, position: Array, velocity: Array, friction: Array, law: StaticMap, bristle_stiffness: float
) -> Reading:
    """sigma_1 (N s/m) from a step, all signals (n,) from rest on; friction without its value at rest.

    The deflection follows (116) with the measured velocity, so that a wrong datum of the position does not enter.
    """
    _check(time, position, velocity, friction)
    z, rate = _deflection(time, velocity, law, bristle_stiffness)
    fastest = np.max(np.abs(rate))
    follows = (np.abs(rate) > FOLLOWING * np.abs(velocity)) & (np.abs(rate) > 0.2 * fastest)
    if np.count_nonzero(follows) < LEAST_SAMPLES:
        raise InputError(
            f"the step holds {np.count_nonzero(follows)} samples in which the bristles follow the piston; "
            "use a higher sampling rate"
        )
    damped = friction - bristle_stiffness * z - viscous(law, velocity)
    x, y = rate[follows], damped[follows]
    value = float(x @ y / (x @ x))
    error = float(np.sqrt(np.mean((y - value * x) ** 2) / (x @ x)))
    moments = time[follows]
    return Reading(value, error, x, y, float(moments[0]), float(moments[-1]))


def dry(law: StaticMap) -> StaticMap:
    """The map without its viscous part: sign(v) g(v), (117)."""
    return StaticMap.of({**law.pairs, "viscous": (0.0, 0.0)})


def viscous(law: StaticMap, velocity: Array) -> Array:
    """Viscous part of the map, N."""
    moving = _moving(velocity)
    return np.asarray(law.force(moving) - dry(law).force(moving), dtype=np.float64)


def _deflection(time: Array, velocity: Array, law: StaticMap, bristle_stiffness: float) -> tuple[Array, Array]:
    """z and dz/dt of (116) along a measured velocity; each interval is solved as if its velocity were constant."""
    moving = _moving(velocity)
    rest = dry(law).force(moving) / bristle_stiffness
    decay = bristle_stiffness * np.abs(velocity) / np.abs(dry(law).force(moving))
    z = np.zeros_like(velocity)
    for k, step in enumerate(np.diff(time)):
        z[k + 1] = rest[k] + (z[k] - rest[k]) * np.exp(-decay[k] * step)
    return z, velocity - decay * z


def _line(x: Array, y: Array, sigma_x: float, sigma_y: float) -> tuple[float, float]:
    """Slope of a line with noise in both coordinates (Deming), and its standard error."""
    dx, dy = x - x.mean(), y - y.mean()
    sxx, syy, sxy = dx @ dx, dy @ dy, dx @ dy
    if sxy == 0.0 or sxx == 0.0:
        raise InputError("friction does not change with the piston's position: the ramp shows no bristles")
    ratio = (max(sigma_y, 1e-12) / max(sigma_x, 1e-15)) ** 2
    slope = (syy - ratio * sxx + np.hypot(syy - ratio * sxx, 2.0 * np.sqrt(ratio) * sxy)) / (2.0 * sxy)
    scatter = np.sum((dy - slope * dx) ** 2) / max(len(x) - 2, 1)
    return float(slope), float(np.sqrt(scatter / sxx))


def _noise(signal: Array) -> float:
    """Standard deviation of the noise of a slow signal, from its second differences."""
    return float(np.std(np.diff(signal, 2)) / np.sqrt(6.0))


def _smooth(signal: Array) -> Array:
    width = max(len(signal) // 100, 1)
    return np.asarray(np.convolve(signal, np.full(width, 1.0 / width), mode="same"), dtype=np.float64)


def _moving(velocity: Array) -> Array:
    """Velocities kept off zero, where the map has no direction."""
    return np.where(np.abs(velocity) < 1e-9, np.copysign(1e-9, velocity), velocity)


def _check(*signals: Array) -> None:
    if len({len(signal) for signal in signals}) != 1 or len(signals[0]) < LEAST_SAMPLES:
        raise InputError(f"signals of one length and at least {LEAST_SAMPLES} samples are needed")
    if not all(np.isfinite(signal).all() for signal in signals):
        raise InputError("a signal holds values that are not finite; cut the log to where every sensor reads")
