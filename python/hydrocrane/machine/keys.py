"""Dotted keys of a machine file: resolved with their unit, and their values in SI."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NoReturn, cast

import numpy as np

from hydrocrane.errors import InputError, MachineFileError, translated
from hydrocrane.machine.machine import Machine
from hydrocrane.machine.overrides import Override, plain_overrides
from hydrocrane.units import converted

# Errors of a value that do not concern its key and unit; another value may have none.
OF_THE_VALUE = ("out-of-range", "not-finite", "crossed-limits", "cannot-close", "cannot-build")
# Number of values with which a key is tried.
MOST_TRIED = 200


@dataclass(frozen=True)
class Key:
    """A dotted key.

    Attributes
    ----------
    name : str
        As given.
    unit : str or None
        SI unit, empty for a plain number; None for words, switches and lists.
    whole : tuple of float or None
        If `name` means one value of a list, ``friction.lift.coulomb[0]``, the whole list, SI.
    """

    name: str
    unit: str | None
    whole: tuple[float, ...] | None = None


def machine_key(name: str, values: Sequence[object], base: Machine) -> Key:
    """The key `name` of `base`, resolved by building the machine with its values.

    For numbers one valid value is sufficient; each word is tried.

    Raises
    ------
    InputError, MachineFileError
        If there is no such key (the message has the nearest one), or no value is valid.
    """
    if name.endswith("]") and "[" in name:
        return _element_key(name, base)
    found, failure = None, None
    for value in distinct(values):
        if found is not None and (found.unit is not None or not isinstance(value, str)):
            continue
        try:
            with translated():
                made = base.core.rebuilt([*base.overrides.items(), (name, value)])
        except MachineFileError as error:
            if error.slug not in OF_THE_VALUE:
                raise
            failure = error
            continue
        found = _as_stated(name, Machine(made, base.source, {}))
    if found is None and name in base.keys:
        return _as_stated(name, base)
    if found is None:
        raise failure or InputError(f"key `{name}` has no values")
    return found


def distinct(values: Sequence[object]) -> list[Override]:
    """Each value once, in the form of overrides."""
    plain = [plain_overrides({"value": cast(Override, value)})["value"] for value in values[:MOST_TRIED]]
    return list({repr(value): value for value in plain}.values())


def _as_stated(name: str, machine: Machine) -> Key:
    if name not in machine.keys:
        return Key(name, None)
    value = machine.value(name)
    return Key(name, value.unit if np.ndim(value.si) == 0 else None)


def _element_key(name: str, base: Machine) -> Key:
    key, _, rest = name.removesuffix("]").partition("[")
    value = base.value(key)
    whole = np.atleast_1d(value.si)
    if not rest.isdigit() or int(rest) >= whole.size:
        raise InputError(f"key `{name}`: {key} has the values [0] to [{whole.size - 1}]")
    return Key(name, value.unit, tuple(map(float, whole)))


def put_value(overrides: dict[str, Override], key: Key, value: Override) -> None:
    """Adds a `value` of `key` to `overrides`; the other values of its list stay."""
    if key.whole is None:
        overrides[key.name] = value
        return
    name, _, index = key.name.removesuffix("]").partition("[")
    stated = overrides.get(name, key.whole)
    whole: list[Override] = list(cast("Sequence[Override]", stated))
    whole[int(index)] = value
    overrides[name] = whole if len(whole) > 1 else whole[0]


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
