"""Values that replace those of a machine file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from hydrocrane._core_types import Override as Override
from hydrocrane.errors import InputError

# Accepted values: plain values, numbers and arrays of NumPy, or lists of them.
OverrideLike: TypeAlias = "float | str | bool | np.generic | NDArray[np.generic] | Sequence[OverrideLike]"
Overrides: TypeAlias = Mapping[str, OverrideLike]


def plain_overrides(overrides: Overrides) -> dict[str, Override]:
    """Overrides with every value as plain Python: bool, float, str or list of these."""
    if not isinstance(overrides, Mapping):
        raise InputError(f"overrides must be a mapping of dotted key to value, got {overrides!r}")
    return {str(key): _plain(key, value) for key, value in overrides.items()}


def _plain(key: str, value: object) -> Override:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool | str):
        return value
    if isinstance(value, int | float):
        try:
            return float(value)
        except OverflowError:
            raise InputError(f"override `{key}` is a whole number beyond 1.8e308; give a smaller one") from None
    if isinstance(value, list | tuple | np.ndarray):
        if any(isinstance(item, list | tuple | np.ndarray) for item in value):
            raise InputError(f"override `{key}` is a list with lists in it; give numbers or texts")
        return [_plain(key, item) for item in value]
    raise InputError(f"override `{key}` must be a number (SI), a string with its unit, a bool or a list; got {value!r}")
