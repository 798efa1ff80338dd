"""What the scripts of chapter 5 share: logs of the virtual rig, their zero calibration, and friction over time.

The rig's friction is that of the thesis's own Tables 3 and 4. Agreement therefore verifies the chain from rig to
parameters; about the real cylinders, whose logs are not available, it says nothing.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from common import completed

from hydrocrane import rig
from hydrocrane.logs import Log
from hydrocrane.signals import RigParameters, SteadyWindows, steady_friction, steady_windows, zero_calibrated

RIGS = {"Rottne": "rig-rottne", "Kalmar": "rig-kalmar"}
SEED = 1
# Before each run the load is supported and both chambers are open to the tank, s.
CALIBRATION = 1.0
# Sensors without the errors that a calibration of the whole range would take out: noise and converter remain.
NOISE_ONLY = {
    "sensor.p1.accuracy": 1e-9,
    "sensor.p2.accuracy": 1e-9,
    "sensor.position.linearity": 1e-9,
    "sensor.position.repeatability": 1e-9,
}
# Exponent of viscous friction with which each rig is described; Table 3 leaves it open.
VISCOUS_EXPONENT = {"rig-rottne": 1.5, "rig-kalmar": 1.0}


def experiment(name: str, cylinder: str, *, calibration: float = CALIBRATION, **settings) -> rig.RigLog:
    """One run of the virtual rig with sensors as in the data sheets, zero calibration before it."""
    log = rig.run(name, RIGS[cylinder], seed=SEED, calibration=calibration, load_cell=False, **settings)
    completed(log.run)
    return log


def calibrated(log: rig.RigLog) -> Log:
    """The log after the calibration, less what the pressure transmitters read at zero pressure."""
    about = log.data.attrs
    return zero_calibrated(Log.of(log.data, source=about["experiment"]), about["calibration"]).log


def parameters(log: rig.RigLog) -> RigParameters:
    return RigParameters.of(log.run.machine, payload=log.data.attrs["payload"])


def smooth(values: np.ndarray, width: int) -> np.ndarray:
    """Moving average over `width` samples; at the ends over those there are."""
    kernel = np.ones(max(width, 1))
    return np.convolve(values, kernel, "same") / np.convolve(np.ones_like(values), kernel, "same")


@cache
def motion(name: str, cylinder: str, segment: int, average: float, /, **settings) -> dict[str, np.ndarray]:
    """Time from the start of a segment (s), position (m), velocity (m/s) and friction force (N) as the sensors give
    them, averaged over `average` seconds; `z` is the bristle deflection that was, and `raw_x` and `raw_friction` are
    as read.
    """
    log = experiment(name, cylinder, **settings)
    piece = log.segments[segment]
    readings = calibrated(log)
    time, step = readings.time, float(np.diff(readings.time[:2])[0])
    position, friction = readings["x"], steady_friction(readings, parameters(log))
    width = max(round(average / step), 1)
    x, force = smooth(position, width), smooth(friction, width)
    velocity = np.gradient(smooth(position, width), time)
    here = (time >= piece.start) & (time <= piece.end)
    deflection = np.interp(time, log.truth.time.values, log.truth.z.values)
    return {
        "time": time[here] - piece.start,
        "x": x[here],
        "velocity": smooth(velocity, width)[here],
        "friction": force[here],
        "z": deflection[here],
        "raw_x": position[here],
        "raw_friction": friction[here],
    }


def windows(log: rig.RigLog) -> SteadyWindows:
    """Steady motion in a log, found without being told where its levels are."""
    return steady_windows(calibrated(log), parameters(log))


def violations(held: list[bool]) -> float:
    """How many statements do not hold."""
    return float(sum(not one for one in held))
