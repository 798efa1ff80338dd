"""Values of machine keys that each crane of a batch has of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.machine.keys import Key, machine_key, put_value, si_value
from hydrocrane.machine.machine import Machine
from hydrocrane.machine.overrides import Override

# What a batch takes for its cranes, by key: one value for all or one for each, numbers in SI or texts with units.
CraneValue: TypeAlias = "float | str | Sequence[float] | Sequence[str] | NDArray[np.number]"
CraneValues: TypeAlias = Mapping[str, CraneValue]


@dataclass(frozen=True)
class CraneParameters:
    """Per key the numbers (n,) of the cranes, SI; nan is what the machine of the batch states."""

    machine: Machine
    n: int
    keys: Mapping[str, Key] = field(default_factory=dict)
    values: Mapping[str, Array] = field(default_factory=dict)

    def changed(self, given: CraneValues, cranes: NDArray[np.int64]) -> CraneParameters:
        """The same with values `given` for some cranes."""
        keys, values = dict(self.keys), dict(self.values)
        for name, own in crane_values(given).items():
            own = own.tolist() if isinstance(own, np.ndarray) else own
            listed = cast("Sequence[object]", own if isinstance(own, list | tuple) else [own])
            if name not in keys:
                keys[name] = machine_key(name, listed, self.machine)
            column = np.array(values.get(name, np.full(self.n, np.nan)))
            column[cranes] = _numbers(keys[name], listed, len(cranes))
            values[name] = column
        return CraneParameters(self.machine, self.n, keys, values)

    def taken(self, other: CraneParameters, cranes: NDArray[np.int64]) -> CraneParameters:
        """The same with the values that `other` has for some cranes."""
        values = {}
        for name, column in other.values.items():
            values[name] = np.array(self.values.get(name, np.full(self.n, np.nan)))
            values[name][cranes] = column[cranes]
        return CraneParameters(self.machine, self.n, other.keys, values)

    def changes(self, crane: int) -> list[tuple[str, Override]]:
        """What the machine of a crane has in place of the batch's values."""
        overrides: dict[str, Override] = {}
        for name, column in self.values.items():
            if not np.isnan(column[crane]):
                put_value(overrides, self.keys[name], float(column[crane]))
        return list(overrides.items())


def crane_values(given: object) -> CraneValues:
    """`given`, if it maps machine keys to values."""
    if not isinstance(given, Mapping):
        raise InputError(f"parameters must map machine keys to a value for each crane; got {given!r}")
    return given


def _numbers(key: Key, given: Sequence[object], count: int) -> Array:
    """The values of a key, SI, one for all of `count` cranes or one for each."""
    if len(given) not in (1, count):
        raise InputError(f"`{key.name}` needs one value, or {count}, one for each crane; got {len(given)}")
    numbers = [si_value(key, value) for value in given]
    for crane, number in enumerate(numbers):
        if isinstance(number, bool) or not isinstance(number, float):
            raise InputError(
                f"`{key.name}` is not one number, so cranes of a batch cannot differ in it; a value of a list is named "
                f"like friction.lift.coulomb[0]; got {given[crane]!r}"
            )
        if not np.isfinite(number):
            raise InputError(f"`{key.name}` must be a finite number for every crane; got {number} for value {crane}")
    return np.array(numbers, dtype=np.float64)
