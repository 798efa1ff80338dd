"""The zero calibration of a log: sensor readings without a load are subtracted from the whole log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError, check_known
from hydrocrane.logs.checks import rechecked
from hydrocrane.logs.log import Log
from hydrocrane.logs.noise import noise_before_rounding, noise_of, rounding_bias
from hydrocrane.signals.friction import RigParameters
from hydrocrane.signals.resample import readable
from hydrocrane.signals.statistics import fitted_line

# Signals with a zero that can be read while the rig is at rest.
SIGNALS = ("p1", "p2", "force")
LEAST_SAMPLES = 20
# Allowed drift of a reading at rest in standard errors; with four, the rate of false alarms is below one in a thousand.
STEADY_ERRORS = 5.0
# Allowed ratio of its scatter to that of neighbouring samples.
WANDER = 3.0


@dataclass(frozen=True)
class ZeroCalibrated:
    """A log without the zero errors of its sensors.

    Attributes
    ----------
    log : Log
        The rest of the log, after the calibration, zeros subtracted.
    zeros, errors : dict
        Zero reading of each signal and its standard error, Pa or N.
    """

    log: Log
    zeros: Mapping[str, float]
    errors: Mapping[str, float]

    def force_error(self, rig: RigParameters, *, load_cell: bool = False) -> float:
        """Standard deviation of the remaining constant error of the friction force, N: `bias` of a fit."""
        parts = [self.errors["p1"] * rig.piston_area, self.errors["p2"] * rig.rod_area]
        if load_cell:
            if "force" not in self.errors:
                raise InputError("the zero of the load cell was not calibrated; name `force` among the signals too")
            parts.append(self.errors["force"])
        return float(np.sqrt(np.sum(np.square(parts))))


def zero_calibrated(
    log: Log, until: float, *, start: float | None = None, signals: Sequence[str] = ()
) -> ZeroCalibrated:
    """Subtract the sensor readings without a load: chambers open to the tank, load supported.

    Parameters
    ----------
    log : Log
    until, start : float
        The calibration, s, by default from the start of the log. The result begins at `until`.
    signals : sequence of str
        Signals to calibrate; by default those of ``p1``, ``p2``, ``force`` that the log has.

    Returns
    -------
    ZeroCalibrated
        Its errors contain the noise with its correlation in time, and the rounding.

    Raises
    ------
    InputError
        If the stretch is too short, has faulty readings, or was not at rest.
    """
    for name in signals:
        check_known("signal with a zero", name, SIGNALS)
    chosen = tuple(signals) or tuple(name for name in SIGNALS if name in log)
    log = log.usable(*(chosen or SIGNALS[:2]))
    whole = readable(log, *chosen)
    first = float(log.time[0]) if start is None else float(real_array(start, "start"))
    inside = _inside(whole, first, float(real_array(until, "until")))
    if whole.stuck(*chosen)[inside].any():
        raise InputError(
            f"{log.source}: between {first:g} and {until:g} s a sensor is frozen or at the end of its range,"
            f" so that its zero cannot be read; see the flags, or calibrate with another stretch"
        )
    found = {name: _zero(whole, name, inside, first, until) for name in chosen}
    data = log.data.isel(time=log.time >= until).copy()
    for name, (zero, _) in found.items():
        data[name] = (data[name] - zero).assign_attrs(log.data[name].attrs)
    later = replace(log, data=data, flags=rechecked(data, log.flags))
    return ZeroCalibrated(later, {n: z for n, (z, _) in found.items()}, {n: e for n, (_, e) in found.items()})


def _inside(log: Log, start: float, until: float) -> np.ndarray:
    time = log.time
    inside = (time >= start) & (time < until)
    if inside.sum() < LEAST_SAMPLES:
        raise InputError(
            f"{log.source}: {int(inside.sum())} samples between {start:g} and {until:g} s are too few for a zero, which"
            f" needs {LEAST_SAMPLES} or more; the log runs from {time[0]:g} to {time[-1]:g} s"
        )
    if not (time >= until).any():
        raise InputError(
            f"{log.source}: no sample is left after the calibration, which ends at {until:g} s; the log ends at"
            f" {time[-1]:g} s"
        )
    return np.asarray(inside)


def _zero(log: Log, name: str, inside: np.ndarray, start: float, until: float) -> tuple[float, float]:
    """Mean reading and its standard error; an error if it drifts, such as pressures that still decrease."""
    values: Array = log[name][inside]
    line, noise = fitted_line(log.time[inside], values), noise_of(values)
    drift = line.slope * (until - start)
    spread = float(np.std(values))
    drifts = abs(drift) > max(STEADY_ERRORS * line.slope_error * (until - start), noise.step)
    if drifts or spread > WANDER * noise.total + noise.step:
        unit = log.data[name].attrs.get("units", "")
        raise InputError(
            f"{log.source}: {name} changes by {np.ptp(values):.3g} {unit} between {start:g} and {until:g} s; the rig"
            f" was not at rest without a load. Wait until it is, or state another stretch"
        )
    # The rest of the log has other positions within the steps, and gives the noise before them.
    return line.mean, float(np.hypot(line.mean_error, rounding_bias(*noise_before_rounding(log[name]))))
