"""Values of keys: numbers in SI, and coordinates of a result."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import NoReturn

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.machine.overrides import Override
from hydrocrane.studies.key import Key
from hydrocrane.units import converted


def si_value(key: Key, value: object) -> Override:
    """`value` in SI if the key has a unit: a number is unchanged, a text with its unit is converted. Else unchanged."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, list | tuple | np.ndarray):
        if key.unit is not None:
            _not_one_number(key, value)
        return [si_value(key, item) for item in value]
    if isinstance(value, bool):
        if key.unit is not None:
            _not_one_number(key, value)
        return value
    if isinstance(value, int | float):
        return float(value)
    if not isinstance(value, str):
        _not_one_number(key, value)
    return value if key.unit is None else converted(key.name, value, key.unit)


def _not_one_number(key: Key, value: object) -> NoReturn:
    raise InputError(f"a value of `{key.name}` must be one number (SI) or a text with its unit; got {value!r}")


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
