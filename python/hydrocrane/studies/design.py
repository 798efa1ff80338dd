"""Design of a study: all combinations, random cases, a Latin hypercube, or a list."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import Array, whole_number
from hydrocrane.errors import InputError, check_known
from hydrocrane.machine.keys import Key, si_value
from hydrocrane.machine.overrides import Override
from hydrocrane.studies.ranges import Convert, drawn_values, grid_size, grid_values

METHODS = ("grid", "random", "latin", "list")
DRAWN = ("random", "latin")
CASE = "case"
# Most cases of a study, limited by memory and time.
MOST_CASES = 10_000_000
# Number of blocks of a study, unless they would be too small or too large.
BLOCKS = 64
LARGEST_BLOCK = 1024
# Bytes of signals in one block.
BLOCK_BYTES = 16_000_000

Place = tuple[slice, ...]


def size_of(place: Place) -> int:
    """Number of cases of a block."""
    return math.prod(part.stop - part.start for part in place)


@dataclass(frozen=True)
class Cases:
    """The cases of a study, in an array with one dimension per key or in a list.

    Attributes
    ----------
    keys : tuple of Key
    axes : tuple of list
        Values of each key: those of its dimension on a grid, else one per case.
    grid : bool
    """

    keys: tuple[Key, ...]
    axes: tuple[list[Override], ...]
    grid: bool

    @property
    def dims(self) -> tuple[str, ...]:
        return tuple(key.name for key in self.keys) if self.grid else (CASE,)

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(len(axis) for axis in self.axes) if self.grid else (len(self.axes[0]),)

    @property
    def count(self) -> int:
        return math.prod(self.shape)

    def values(self, place: Place) -> list[tuple[Override, ...]]:
        """Values of the keys, one tuple per case of a block."""
        if not self.grid:
            return list(zip(*(axis[place[0]] for axis in self.axes), strict=True))
        return list(itertools.product(*(axis[part] for axis, part in zip(self.axes, place, strict=True))))

    def numbers(self, place: Place) -> list[int]:
        """Numbers of the cases of a block, counted through the whole study."""
        parts = [range(part.start, part.stop) for part in place]
        return np.ravel_multi_index(np.ix_(*parts), self.shape).ravel().tolist()

    def values_of(self, number: int) -> tuple[Override, ...]:
        """Values of the keys of one case."""
        return self.values(tuple(slice(i, i + 1) for i in map(int, np.unravel_index(number, self.shape))))[0]

    def along(self, key: str) -> list[Override]:
        """All values of a key; none for a key that is not varied."""
        return next((axis for own, axis in zip(self.keys, self.axes, strict=True) if own.name == key), [])


def designed(keys: Sequence[Key], given: Mapping[str, object], method: str, n: int | None, seed: int) -> Cases:
    """The cases of a study.

    Parameters
    ----------
    keys : sequence of Key
    given : mapping
        Values or range of each key, as given.
    method : {"grid", "random", "latin", "list"}
    n : int
        Number of random cases.
    seed : int
    """
    check_known("method of a study", method, METHODS)
    if (n is not None) != (method in DRAWN):
        need = "needs n, the number of cases" if n is None else "takes no n: its values determine the number of cases"
        raise InputError(f"the method `{method}` {need}")
    if method in DRAWN:
        return Cases(tuple(keys), _drawn(keys, given, method, n, seed), grid=False)
    sizes = [grid_size(spec) for spec in given.values()]
    _bounded(math.prod(sizes) if method == "grid" else max(sizes), method)
    axes = tuple(grid_values(key.name, spec, _to_si(key)) for key, spec in zip(keys, given.values(), strict=True))
    if method == "list" and len({len(axis) for axis in axes}) > 1:
        counts = ", ".join(f"{key.name} {len(axis)}" for key, axis in zip(keys, axes, strict=True))
        raise InputError(f"a list of cases needs as many values of every key; got {counts}")
    return Cases(tuple(keys), axes, grid=method == "grid")


def _bounded(count: int, method: str) -> None:
    if count > MOST_CASES:
        fewer = "draw fewer" if method in DRAWN else "give fewer values of some keys"
        raise InputError(f"the study has {count:.3g} cases, at most {MOST_CASES:.3g} are possible; {fewer}")


def _to_si(key: Key) -> Convert:
    return lambda value: si_value(key, value)


def _drawn(
    keys: Sequence[Key], given: Mapping[str, object], method: str, n: object, seed: int
) -> tuple[list[Override], ...]:
    count = whole_number("n", n)
    _bounded(count, method)
    shares = _shares(method, count, len(keys), seed)
    columns = zip(keys, given.values(), shares.T, strict=True)
    return tuple(drawn_values(key.name, spec, share, _to_si(key)) for key, spec, share in columns)


def _shares(method: str, n: int, width: int, seed: int) -> Array:
    """Points (n, width) of the unit cube."""
    generator = np.random.default_rng(seed)
    if method == "random":
        return generator.random((n, width))
    from scipy.stats import qmc

    return np.asarray(qmc.LatinHypercube(width, rng=generator).random(n), dtype=np.float64)


def block_shape(shape: Sequence[int], size: int | None, bytes_per_case: int) -> tuple[int, ...]:
    """Shape of a block of about `size` neighbouring cases."""
    count = int(np.prod(shape))
    if size is None:
        size = min(max(count // BLOCKS, 1), LARGEST_BLOCK)
    left = max(min(size, BLOCK_BYTES // max(bytes_per_case, 1)), 1)
    parts: list[int] = []
    for length in reversed(shape):
        parts.append(min(length, left))
        left = max(left // length, 1)
    return tuple(reversed(parts))


def blocks(shape: Sequence[int], block: Sequence[int]) -> Iterator[Place]:
    """The indices of all blocks, in order."""
    starts = [range(0, length, step) for length, step in zip(shape, block, strict=True)]
    for corner in itertools.product(*starts):
        yield tuple(slice(a, min(a + b, n)) for a, b, n in zip(corner, block, shape, strict=True))
