"""Grids of poses, and positions of the tip that are forbidden."""

from __future__ import annotations

import math

import numpy as np

from hydrocrane.arrays import Array, rows
from hydrocrane.errors import InputError
from hydrocrane.machine.machine import Machine

# Most points of a telescope beside turning joints, and most poses: a chart takes some 150 bytes for each.
_TELESCOPE, MOST_POSES = 8, 2**23


def pose_grid(machine: Machine, samples: int, *, inset: float = 1e-6) -> Array:
    """Regular grid of poses (k_1, ..., k_n, n) inside the limits.

    Turning joints get `samples` points; a telescope gets fewer, because it matters less. `inset` is the share of each
    range that is kept clear at both ends: exactly at a limit the inverse relations may already be undefined.

    Raises
    ------
    InputError
        Less than two samples, or more poses than `MOST_POSES`.
    """
    if samples < 2:
        raise InputError(f"samples must be at least 2, got {samples}")
    units = machine.joint_units

    def counts(points: int) -> list[int]:
        fewer = min(max(3, points // 6), _TELESCOPE)
        return [points if unit == "rad" or len(units) == 1 else fewer for unit in units]

    if math.prod(counts(samples)) > MOST_POSES:
        turning = sum(count == samples for count in counts(samples))
        most = int((MOST_POSES / math.prod(counts(samples)) * samples**turning) ** (1 / turning))
        raise InputError(f"samples={samples} makes more than {MOST_POSES} poses; take {most} at most")
    axes = []
    for (low, high), count in zip(machine.joint_limits, counts(samples), strict=True):
        margin = inset * (high - low)
        axes.append(np.linspace(low + margin, high - margin, count))
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def forbidden(machine: Machine, tip: Array, load: Array | float) -> np.ndarray:
    """Whether tips (..., 2) that carry `load` (...), kg, are in a keep-out region or in the ground."""
    lead, (places,) = rows(tip)
    loads = np.ascontiguousarray(np.broadcast_to(load, lead), dtype=np.float64).ravel()
    height = machine.core.heights_above_ground(places, loads)
    return (machine.clearance(places) < 0.0).reshape(lead) | (height < 0.0).reshape(lead)
