"""Grids of poses."""

from __future__ import annotations

import math

import numpy as np

from hydrocrane.arrays import Array, whole_number
from hydrocrane.machine.machine import Machine
from hydrocrane.scenario.record_size import check_size

# Joints that take all points, and most points of each further one and of all these together: the number of poses grows
# with the square of the points.
_FULL, _FEWER, _TOGETHER = 2, 8, 64
# Most memory of a map, bytes; its numbers for each pose beside the pose: tip, payload, index, and a flag for a number.
_MOST_BYTES, _NUMBERS = 1e9, 5


def pose_grid(machine: Machine, samples: int, *, inset: float = 1e-6) -> Array:
    """Regular grid of poses (k_1, ..., k_n, n) inside the limits.

    The first two turning joints get `samples` points; telescopes and further joints get 3 to 8, because they matter
    less. A joint that slews all others has one point, home. `inset` is the share of each range that is kept clear at
    both ends: exactly at a limit the inverse relations may already be undefined.

    Raises
    ------
    InputError
        Less than two samples, or so many that a map would take more than 1 GB.
    """
    whole_number("samples", samples, 2)
    n = len(machine.joint_names)
    slewing = machine.first_in_plane
    turning = [i for i, unit in enumerate(machine.joint_units) if unit == "rad" and i >= slewing]
    full = turning[:_FULL] if n > 1 else [0]
    others = max(n - slewing - len(full), 1)
    fewer = max(3, min(samples // 6, _FEWER, round(_TOGETHER ** (1 / others))))
    counts = [int(samples) if i in full else 1 if i < slewing else fewer for i in range(n)]
    numbers = math.prod(counts) * (n + _NUMBERS)
    if full:
        most = int(samples * (_MOST_BYTES / (8 * numbers)) ** (1 / len(full)))
        counted = f"{math.prod(counts)} poses of {n + _NUMBERS} numbers"
        check_size(f"a map with samples={samples}", numbers, counted, f"{most} samples at most", _MOST_BYTES)
    axes = list(machine.home[:slewing, None])
    for (low, high), count in zip(machine.joint_limits[slewing:], counts[slewing:], strict=True):
        margin = inset * (high - low)
        axes.append(np.linspace(low + margin, high - margin, count))
    return np.stack(np.meshgrid(*axes, indexing="ij", copy=False), axis=-1)
