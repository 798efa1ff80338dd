"""Errors of a rig's sensors by its file, and their effect on its signals.
                                                              theory: docs/theory/identification/dynamic.md

Each sensor has noise, a lag, and constant errors, which a fit estimates as nuisances.
Their standard deviations follow from the data sheet's bounds, taken as those of a uniform distribution.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError
from hydrocrane.machine.machine import Machine
from hydrocrane.signals import RigParameters

# Standard deviations as shares of the accuracy: of an error uniformly distributed within it, and of the error at zero,
# which consists of the zero point, up to half of the accuracy, and as much of the span if the range begins there
# (docs/theory/sensor/analogue.md).
UNIFORM, ZERO = 1 / np.sqrt(3.0), 1 / np.sqrt(6.0)
AT_ZERO = {"p1": ZERO, "p2": ZERO, "force": 1 / np.sqrt(12.0)}
PRESSURES = ("p1", "p2")
ENDINGS = {"p1": ".p1", "p2": ".p2", "force": ".force", "x": ".q"}


def data_sheets(machine: Machine, signal: str) -> list[dict[str, float]]:
    """Numbers of each sensor of a signal, or of the signal that ends so, SI, by key."""
    heads = [f"sensor.{name}." for name, measured in machine.sensors.items() if measured.endswith(signal)]
    return [
        {key.removeprefix(head): float(machine.value(key).si) for key in machine.keys if key.startswith(head)}
        for head in heads
    ]


def data_sheet(rig: Machine, signal: str) -> dict[str, float]:
    """Numbers of the sensor of ``x``, ``p1``, ``p2`` or ``force``, SI, by key, of several those of the first that
    states one; empty if the rig's file has no such sensor."""
    sheets = data_sheets(rig, ENDINGS[signal])
    return {key: value for sheet in reversed(sheets) for key, value in sheet.items()}


def stated(rig: Machine, signal: str, key: str) -> float | None:
    """A number of the sensor of ``x``, ``p1``, ``p2`` or ``force``; None if the rig's file has none."""
    return data_sheet(rig, signal).get(key)


def largest_error(rig: Machine, signal: str) -> float | None:
    """Bound of a sensor's error, Pa or N; None if the rig's file has none."""
    share, full = stated(rig, signal, "accuracy"), stated(rig, signal, "range")
    return None if share is None or full is None else share * full


def bias_without_zero(rig: Machine, parameters: RigParameters, *, load_cell: bool) -> float:
    """Standard deviation of the constant error of the friction without a zero calibration, N."""
    factors = {"p1": parameters.piston_area, "p2": parameters.rod_area} | ({"force": 1.0} if load_cell else {})
    errors = [(largest_error(rig, name) or 0.0) * AT_ZERO[name] * factor for name, factor in factors.items()]
    return float(np.linalg.norm(errors))


def span_error(rig: Machine, signals: Sequence[str] = PRESSURES) -> float:
    """Largest standard deviation of the sensors' spans, as a share of the reading."""
    return max(stated(rig, name, "accuracy") or 0.0 for name in signals) * UNIFORM


def linearity_error(rig: Machine) -> float:
    """Standard deviation of the relative error of the velocity per metre of position, 1/m.

    The position sensor's deviation is a parabola about the middle of its range, b (4 s (1 - s) - 1/2) of the range R at
    the share s, so its slope is -8 b x/R. Its height b is uniformly distributed up to twice the linearity.
    """
    linearity, full = stated(rig, "x", "linearity"), stated(rig, "x", "range")
    return 16.0 * linearity * UNIFORM / full if linearity and full else 0.0


# Assumed zero error of a pressure after a zero calibration without a stated one, Pa.
CALIBRATED_ZERO = 500.0
# Least standard deviation of a zero, Pa.
BEST_ZERO = 10.0
# Difference between a potentiometer's hysteresis after a reversal and the exponential model of it, as a share of the
# hysteresis.
TURNING = 0.4
# Standard deviation of a start value, as a share of the noise of one reading; on the safe side.
START_READING = 0.5
# A parabola's deviation from a line between -d and d over its range r has at most the slope 8 d / r and the curvature
# coefficient 8 d / r^2.
PARABOLA = 8.0
# Standard deviation of the delay of the readings against the command, s. Conversion or filtering of single channels
# makes about one sample.
DELAY = 1e-3
# Whether the zeros of p1 and p2 were subtracted, or their remaining standard errors, Pa.
Calibrated = bool | Sequence[float]
NUISANCES = ("p1.zero", "p2.zero", "p1.span", "p2.span", "x.slope", "x.curve", "x.hysteresis", "delay")
# The same for each log: each zero calibration has its own error.
OF_A_LOG = ("x.offset", "p1.start", "x.start", "rest.friction", "p1.calibration", "p2.calibration")


@dataclass(frozen=True)
class RigSensors:
    """Errors of the sensors of x, p1 and p2.

    Attributes
    ----------
    lag : float
        Time constant of the pressure transmitters, s.
    pressure_noise, position_noise : float
        Standard deviation of one reading, Pa and m.
    zeros, left : (float, float)
        Standard deviations of the zero errors of p1 and p2, Pa: those common to all logs, and those of each log, which
        was calibrated separately.
    span : float
        Standard deviation of a pressure's span, 1.
    linearity_error, width : float
        Deviation of the position sensor from a line and range of its parabola, m.
    hysteresis : float
        Hysteresis of the position sensor, m: the reading depends on the direction of approach.
    """

    lag: float
    pressure_noise: float
    position_noise: float
    zeros: tuple[float, float]
    left: tuple[float, float]
    span: float
    linearity_error: float
    width: float
    hysteresis: float

    @classmethod
    def of(cls, rig: Machine, *, calibrated: Calibrated) -> RigSensors:
        """From the machine file of a rig and the zero errors that remain after a calibration."""
        pressure, position = _properties(rig, "p1"), _properties(rig, "x")
        full, width = pressure["range"], position["range"]
        span = UNIFORM * pressure.get("accuracy", 0.0)
        zeros, left = _zeros(calibrated, float(span * full))
        return cls(
            lag=pressure.get("rise-time", 0.0) / np.log(9.0),
            pressure_noise=max(_noise(pressure) * full, 1.0),
            position_noise=max(_noise(position) * width, 1e-8),
            zeros=zeros,
            left=left,
            span=max(span, 1e-6),
            linearity_error=max(UNIFORM * position.get("linearity", 0.0) * width, 1e-7),
            width=width,
            hysteresis=max(UNIFORM * position.get("repeatability", 0.0) * width, 1e-9),
        )

    def of_a_log(self, supply: float, breakaway: float) -> tuple[float, ...]:
        """Standard deviations of :data:`OF_A_LOG`: errors that remain after a reading at rest and a calibration.

        The error of the span is proportional to the pressure, which is below that of the `supply`, Pa. Friction at rest
        is anything up to `breakaway`, N.
        """
        offset, pressure = START_READING * self.position_noise, START_READING * self.pressure_noise
        p1 = float(np.linalg.norm([pressure, self.zeros[0], self.left[0], self.span * supply]))
        x = float(np.hypot(self.hysteresis, self.linearity_error))
        return (offset, p1, x, UNIFORM * breakaway, *self.left)

    @property
    def deviations(self) -> tuple[float, ...]:
        """Standard deviations of the :data:`NUISANCES`."""
        slope = PARABOLA * self.linearity_error / self.width
        return (*self.zeros, self.span, self.span, slope, slope / self.width, self.hysteresis, DELAY)

    def turned(self, x: Array) -> Array:
        """(n,) in [-1, 1]: error of the position sensor along a motion x (n,), m, as a share of its hysteresis.

        It starts at zero and approaches the sign of the velocity within a displacement of twice the hysteresis.
        """
        steps = np.diff(x)
        kept = np.exp(-np.abs(steps) / (2.0 * self.hysteresis))
        share = np.zeros(x.size)
        for i, (sense, keep) in enumerate(zip(np.sign(steps), kept, strict=True)):
            share[i + 1] = sense + (share[i] - sense) * keep
        return share

    def root_of_covariance(self, x: Array, count: NDArray[np.intp]) -> Array:
        """(b, b) Cholesky factor of the covariance of mean positions along a motion x (b,), m, of `count` (b,) samples.

        The remaining error of the hysteresis decays over displacement and not over time: more samples at one place do
        not reduce it.
        """
        travel = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(x)))])
        near = np.exp(-np.abs(travel[:, np.newaxis] - travel) / (2.0 * self.hysteresis))
        covariance = (TURNING * self.hysteresis) ** 2 * near + np.diag(self.position_noise**2 / count)
        return np.asarray(cholesky(covariance, lower=True))


def read(
    y: Array, turned: Array, by_delay: Array, by_start: Array, nuisances: Array, of_log: Array
) -> tuple[Array, Array]:
    """Readings of the sensors.

    Parameters
    ----------
    y : (b, 3) array
        x, p1, p2, SI.
    turned : (b,) array
        As from :meth:`RigSensors.turned`.
    by_delay, by_start : (b, 3) and (b, 3, 3) arrays
        As from :class:`RigLogModel`.
    nuisances, of_log : (8,) and (6,) arrays
        In the order of :data:`NUISANCES` and :data:`OF_A_LOG`.

    Returns
    -------
    readings : (b, 3) array
    slopes : (b, 3, 14) array
        Derivatives of the readings by both.
    """
    travel = y[:, 0] - y[0, 0]
    slopes = np.zeros((*y.shape, len(NUISANCES) + len(OF_A_LOG)))
    slopes[:, 1, 0] = slopes[:, 2, 1] = slopes[:, 0, 8] = 1.0
    slopes[:, 1, 2], slopes[:, 2, 3] = y[:, 1], y[:, 2]
    slopes[:, 0, 4], slopes[:, 0, 5], slopes[:, 0, 6] = travel, travel**2, -turned
    slopes[:, :, 7], slopes[:, :, 9:12] = by_delay, by_start
    slopes[:, 1, 12] = slopes[:, 2, 13] = 1.0
    # The readings are linear in the errors of the sensors.
    return y + slopes @ np.concatenate([nuisances, of_log]), slopes


def gains(y: Array, nuisances: Array) -> Array:
    """(b, 3) derivatives of the readings by the signals."""
    _, _, p1_span, p2_span, x_slope, x_curve, *_ = nuisances
    travel = y[:, 0] - y[0, 0]
    ones = np.ones_like(travel)
    return np.stack([1.0 + x_slope + 2.0 * x_curve * travel, (1.0 + p1_span) * ones, (1.0 + p2_span) * ones], axis=-1)


def whitened(root: Array, values: Array) -> Array:
    """Values (b, ...) with a covariance of Cholesky factor `root` (b, b), transformed to independent values of variance
    one."""
    return np.asarray(solve_triangular(root, values, lower=True, check_finite=False))


def _zeros(calibrated: Calibrated, largest: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Standard deviations of the zero errors common to all logs, and of those of each log, Pa."""
    if isinstance(calibrated, bool):
        known = (BEST_ZERO, CALIBRATED_ZERO) if calibrated else (max(largest, CALIBRATED_ZERO), BEST_ZERO)
        return (known[0], known[0]), (known[1], known[1])
    errors = real_array(calibrated, "calibrated")
    if errors.shape != (2,) or (errors < 0.0).any():
        raise InputError(f"calibrated is yes, no, or the standard errors of the zeros of p1 and p2, got {calibrated!r}")
    return (BEST_ZERO, BEST_ZERO), (max(float(errors[0]), BEST_ZERO), max(float(errors[1]), BEST_ZERO))


def _noise(sensor: dict[str, float]) -> float:
    """Standard deviation of one reading including rounding, as a share of the range."""
    step = 2.0 ** -sensor["bits"] if "bits" in sensor else 0.0
    return float(np.hypot(sensor.get("noise", 0.0), step / np.sqrt(12.0)))


def _properties(rig: Machine, signal: str) -> dict[str, float]:
    """Numbers of a sensor that a fit needs, SI."""
    found = data_sheet(rig, signal)
    if not found:
        raise InputError(f"{rig.name} has no sensor for a signal that ends in `{ENDINGS[signal]}`; add one to its file")
    return found
