"""Grids of poses, and positions of the tip that are forbidden."""

from __future__ import annotations

import numpy as np

from hydrocrane.arrays import Array, rows
from hydrocrane.errors import InputError
from hydrocrane.machine.machine import Machine


def pose_grid(machine: Machine, samples: int, *, inset: float = 1e-6) -> Array:
    """Regular grid of poses (k_1, ..., k_n, n) inside the limits.

    Turning joints get `samples` points; a telescope gets fewer, because it matters less. `inset` is the share of each
    range that is kept clear at both ends: exactly at a limit the inverse relations may already be undefined.
    """
    if samples < 2:
        raise InputError(f"samples must be at least 2, got {samples}")
    axes = []
    for (low, high), unit in zip(machine.joint_limits, machine.joint_units, strict=True):
        margin = inset * (high - low)
        count = samples if unit == "rad" or len(machine.joint_units) == 1 else max(3, samples // 6)
        axes.append(np.linspace(low + margin, high - margin, count))
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def forbidden(machine: Machine, tip: Array, load: Array | float) -> np.ndarray:
    """Whether tips (..., 2) that carry `load` (...), kg, are in a keep-out region or in the ground."""
    lead, (places,) = rows(tip)
    loads = np.ascontiguousarray(np.broadcast_to(load, lead), dtype=np.float64).ravel()
    height = machine.core.heights_above_ground(places, loads)
    return (machine.clearance(places) < 0.0).reshape(lead) | (height < 0.0).reshape(lead)
