"""Values of keys: numbers in SI, and coordinates of a result."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.machine.overrides import Override
from hydrocrane.units import converted


def si_numbers(value: Override, unit: str | None) -> Override:
    """Numbers, or lists of them, in SI; words if there is no unit."""
    if unit is None:
        return value
    if isinstance(value, list | tuple):
        return [si_numbers(item, unit) for item in value]
    return converted("a value of a list", value, unit) if isinstance(value, str) else value


def axis_values(values: Sequence[Override]) -> Array | list[str] | list[bool]:
    """Values as a coordinate: numbers, switches or words; lists are written out."""
    if all(isinstance(value, float) for value in values):
        return np.array(values, dtype=np.float64)
    if all(isinstance(value, bool) for value in values):
        return [bool(value) for value in values]
    return [value if isinstance(value, str) else json.dumps(value) for value in values]
