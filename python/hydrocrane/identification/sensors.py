"""How far off the sensors of a rig may be, by its file."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.identification.least_squares import OffsetPrior
from hydrocrane.logs import Log
from hydrocrane.machine import Machine
from hydrocrane.signals import RigParameters

# Standard deviation of an error that is evenly likely within its bound, as a share of the bound.
UNIFORM = 1.0 / np.sqrt(3.0)
ENDINGS = {"p1": ".p1", "p2": ".p2", "force": ".force"}


class AnalogueError(NamedTuple):
    """Bound of a sensor's error in its unit, and the same as a share of its range."""

    bound: float
    share: float

    def deviation(self, reading: Array, calibrated: bool) -> float:
        """Standard deviation of the constant error at usual readings: once the zero is off, only that of the span,
        which grows with the reading, is left."""
        if not calibrated:
            return self.bound * UNIFORM
        return self.share * UNIFORM * float(np.median(np.abs(reading)))


def analogue_error(rig: Machine, signal: str) -> AnalogueError | None:
    """What the rig's file says of the sensor of ``p1``, ``p2`` or ``force``; None where it has none."""
    for name, measured in rig.sensors.items():
        key = f"sensor.{name}.accuracy"
        if measured.endswith(ENDINGS[signal]) and key in rig.keys:
            share = float(rig.value(key).si)
            return AnalogueError(share * float(rig.value(f"sensor.{name}.range").si), share)
    return None


def offset_prior(
    rig: Machine,
    parameters: RigParameters,
    log: Log,
    stretches: list[tuple[float, float]],
    *,
    calibrated: bool,
    load_cell: bool,
) -> OffsetPrior:
    """What the sensors may add to the friction of a log, the worst of its `stretches` of steady motion counting: the
    pressures of the two directions differ, and with them the error of the span. A sensor not stated has none."""
    factors = {"p1": parameters.piston_area, "p2": parameters.rod_area} | ({"force": 1.0} if load_cell else {})
    known = {name: error for name in factors if (error := analogue_error(rig, name)) is not None}
    deviations = []
    for start, end in stretches:
        inside = (log.time >= start) & (log.time <= end)
        parts = [factors[name] * e.deviation(log[name][inside], calibrated) for name, e in known.items()]
        deviations.append(float(np.linalg.norm(parts)))
    return OffsetPrior(max(deviations, default=0.0))
