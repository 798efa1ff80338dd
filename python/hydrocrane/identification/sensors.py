"""How far off the sensors of a rig may be, by its file."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrocrane.machine.machine import Machine
from hydrocrane.signals import RigParameters

# Standard deviations as shares of the accuracy: of an error that is evenly likely within it, and of the error at zero,
# which is the zero point, up to half of the accuracy, and as much by the span where the range begins there
# (docs/theory/sensor/analogue.md).
UNIFORM = 1 / np.sqrt(3.0)
AT_ZERO = {"p1": 1 / np.sqrt(6.0), "p2": 1 / np.sqrt(6.0), "force": 1 / np.sqrt(12.0)}
PRESSURES = ("p1", "p2")
ENDINGS = {"p1": ".p1", "p2": ".p2", "force": ".force", "x": ".q"}


def properties(rig: Machine, signal: str) -> dict[str, float]:
    """Numbers of the sensor of ``x``, ``p1``, ``p2`` or ``force``, SI, by key; none where the rig's file has none."""
    found: dict[str, float] = {}
    for head in (f"sensor.{name}." for name, measured in rig.sensors.items() if measured.endswith(ENDINGS[signal])):
        for key in rig.keys:
            if key.startswith(head):
                found.setdefault(key.removeprefix(head), float(rig.value(key).si))
    return found


def stated(rig: Machine, signal: str, key: str) -> float | None:
    """A number of the sensor of ``x``, ``p1``, ``p2`` or ``force``; None where the rig's file has none."""
    return properties(rig, signal).get(key)


def largest_error(rig: Machine, signal: str) -> float | None:
    """Bound of a sensor's error, Pa or N; None where the rig's file has none."""
    share, full = stated(rig, signal, "accuracy"), stated(rig, signal, "range")
    return None if share is None or full is None else share * full


def bias_without_zero(rig: Machine, parameters: RigParameters, *, load_cell: bool) -> float:
    """Standard deviation of the constant error of the friction without a zero calibration, N."""
    factors = {"p1": parameters.piston_area, "p2": parameters.rod_area} | ({"force": 1.0} if load_cell else {})
    errors = [(largest_error(rig, name) or 0.0) * AT_ZERO[name] * factor for name, factor in factors.items()]
    return float(np.linalg.norm(errors))


def span_error(rig: Machine, signals: Sequence[str] = PRESSURES) -> float:
    """Standard deviation of the sensors' spans, as a share of the reading; of the worst of them."""
    return max(stated(rig, name, "accuracy") or 0.0 for name in signals) * UNIFORM


def bow(rig: Machine) -> float:
    """Standard deviation of the relative error of the velocity per metre of position, 1/m.

    The position sensor's deviation is a parabola about the middle of its range, whose height, twice the linearity at
    most, is evenly likely: b (4 s (1 - s) - 1/2) of the range R at the share s, so that its slope is -8 b x/R.
    """
    linearity, full = stated(rig, "x", "linearity"), stated(rig, "x", "range")
    return 16.0 * linearity * UNIFORM / full if linearity and full else 0.0
