"""Checked conversion of arguments to the arrays of the core.

The core needs C-contiguous float64 tables with one row per case. In arguments the last axis is the vector and all
leading axes are the batch; several arguments broadcast over the leading axes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import lru_cache, reduce
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrocrane import _core
from hydrocrane.errors import InputError, translated

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Array = NDArray[np.float64]

# Most numbers of an array, entries of a collection and letters of a text that a line shows.
_NUMBERS, _ENTRIES, _LETTERS = 6, 4, 80


def brief(self: DataclassInstance) -> str:
    """The ``__repr__`` of dataclasses that hold arrays: one line, arrays by shape and results by kind."""
    shown = ", ".join(f"{field.name}={_shown(getattr(self, field.name))}" for field in fields(self) if field.repr)
    return f"{type(self).__name__}({shown})"


def _shown(value: object) -> str:
    if isinstance(value, np.ndarray) and value.size > _NUMBERS:
        return f"<array {' x '.join(map(str, value.shape))}>"
    if isinstance(value, np.ndarray):
        return np.array2string(value, precision=4, separator=", ").replace("\n", "")
    if isinstance(value, Mapping):
        return f"<{len(value)}: {_few(list(map(str, value)))}>"
    if isinstance(value, list | tuple):
        few = len(value) <= _ENTRIES and all(isinstance(entry, str | int | float) for entry in value)
        return repr(value) if few else f"<{len(value)} {type(value[0]).__name__}>" if value else repr(value)
    if is_dataclass(value) and not isinstance(value, type):
        return f"<{type(value).__name__}>"
    text = repr(value)
    return text if len(text) <= _LETTERS else f"<{type(value).__name__}>"


def _few(names: list[str]) -> str:
    return ", ".join([*names[:_ENTRIES], *(["..."] if len(names) > _ENTRIES else [])])


def real_array(value: ArrayLike, name: str) -> Array:
    """`value` as a float64 array with finite entries only, or an :class:`InputError` that names `name`."""
    try:
        raw = np.asarray(value)
    except (TypeError, ValueError):
        raise InputError(f"{name} is not an array of numbers: its rows differ in length") from None
    if raw.dtype.kind not in "buif":
        raise InputError(f"{name} must hold real numbers, got {_described(value, raw)}")
    array = raw.astype(np.float64)
    if not np.isfinite(array).all():
        place = [int(i) for i in np.argwhere(~np.isfinite(array))[0]]
        where = f" at index {place}" if place else ""
        raise InputError(f"{name} must be finite, got {array[tuple(place)]}{where}")
    return array


def one_number(name: str, value: ArrayLike) -> float:
    """`value` as one number, or an :class:`InputError` that names `name`."""
    number = real_array(value, name)
    if number.ndim:
        raise InputError(f"{name} must be one number, got {value!r}")
    return float(number)


def positive_number(name: str, value: ArrayLike, unit: str = "") -> float:
    """`value` as one number greater than zero, in `unit`, or an :class:`InputError` that names `name`."""
    number = real_array(value, name)
    if number.ndim or number <= 0:
        raise InputError(f"{name} must be one number greater than zero{unit and f', in {unit}'}; got {value!r}")
    return float(number)


def check_level(level: float) -> None:
    """Raises an :class:`InputError` if `level` is no level of confidence."""
    if not 0.0 < level < 1.0:
        raise InputError(f"level must lie between 0 and 1, got {level:g}; 0.95 is usual")


def rms(values: Array) -> float:
    """Root of the mean square; NaN without values."""
    return float(np.sqrt(np.mean(values**2))) if values.size else np.nan


def path_length(places: Iterable[Array]) -> float:
    """Length of a path of places, given axis by axis."""
    return float(reduce(np.hypot, (np.diff(along) for along in places)).sum())


def checked_name(what: str, name: object) -> str:
    """`name` if it is one as in machine files, or an :class:`InputError`; `what` it is the name of."""
    return _checked(what, name, _core.name_fault)


def checked_line(what: str, text: object) -> str:
    """`text` if it is a text of one line without characters of control, or an :class:`InputError`."""
    return _checked(what, text, _core.text_fault)


def _checked(what: str, text: object, fault_of: Callable[[str], str | None]) -> str:
    if not isinstance(text, str):
        raise InputError(f"{what} must be a text; got {text!r}")
    fault = _fault(fault_of, text)
    if fault is not None:
        raise InputError(f"{what} is {text!r}: {fault}")
    return text


# A study checks the same fields of its scenario in every case.
_judged_quantity = lru_cache(256)(_core.judged_quantity)


@lru_cache(64)
def _fault(fault_of: Callable[[str], str | None], text: str) -> str | None:
    with translated():
        return fault_of(text)


def scenario_quantity(key: str, name: str, value: ArrayLike) -> float:
    """`value` as one number, SI, that a scenario file may have at `key`; `name` is the name of the argument."""
    number = value
    if type(number) is not float or not math.isfinite(number):
        number = one_number(name, value)
    refused, _ = _judged_quantity(key, number)
    if refused:
        raise InputError(f"{name}: {refused}")
    return number


def unusual_quantity(key: str, value: float) -> tuple[str, str] | None:
    """What a scenario file with `value` (SI) at `key` is warned of, and the cure; None where it is usual."""
    return _judged_quantity(key, float(value))[1]


def whole_number(name: str, value: object, least: int = 1, most: int | None = None) -> int:
    """`value` as a whole number within bounds, or an :class:`InputError` that names `name`."""
    whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if whole and least <= value and (most is None or value <= most):  # type: ignore[operator]
        return int(value)  # type: ignore[call-overload]
    words = {0: "zero or more", 1: "one or more"}.get(least, f"at least {least}")
    raise InputError(
        f"{name} must be a whole number{f', {words}' if most is None else f' from {least} to {most}'}; got {value!r}"
    )


def seed_number(value: object) -> int:
    """A seed: a whole number from 0 to 2^64 - 1."""
    if isinstance(value, int | np.integer) and not isinstance(value, bool) and 0 <= value < 2**64:
        return int(value)
    raise InputError(f"seed must be a whole number, zero or greater and below 2^64; got {value!r}")


def vectors(value: ArrayLike, name: str, labels: Sequence[str]) -> Array:
    """`value` as an array of shape (..., len(labels)), all finite."""
    array = real_array(value, name)
    width = len(labels)
    if array.ndim == 0 or array.shape[-1] != width:
        shown = ", ".join(labels) if width <= 6 else f"{', '.join(labels[:3])}, ... {labels[-1]}"
        raise InputError(
            f"{name} must have shape ({width},) or (..., {width}), one value each of {shown}; got shape {array.shape}"
        )
    return array


def rows(*arrays: Array) -> tuple[tuple[int, ...], list[Array]]:
    """Broadcast the leading axes; return them and every array as a contiguous table of shape (m, width)."""
    try:
        lead = np.broadcast_shapes(*(a.shape[:-1] for a in arrays))
    except ValueError:
        shapes = ", ".join(str(a.shape) for a in arrays)
        raise InputError(f"leading axes do not broadcast against each other: shapes {shapes}") from None
    tables = [np.ascontiguousarray(np.broadcast_to(a, lead + a.shape[-1:]).reshape(-1, a.shape[-1])) for a in arrays]
    return lead, tables


def scalars(*arrays: Array) -> tuple[tuple[int, ...], list[Array]]:
    """As :func:`rows` for plain numbers: every array flattened to shape (m,)."""
    lead, tables = rows(*(a[..., np.newaxis] for a in arrays))
    return lead, [np.ascontiguousarray(t[:, 0]) for t in tables]


def _described(value: object, raw: np.ndarray) -> str:
    return f"complex numbers {value!r}" if raw.dtype.kind == "c" else f"{value!r}"
