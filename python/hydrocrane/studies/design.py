"""What a study varies and keeps: sources of values, the cases made of them, signals with their times."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, TypedDict, cast, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array, positive_number, whole_number
from hydrocrane.errors import InputError, check_known, nearest
from hydrocrane.machine.keys import Key, si_value
from hydrocrane.machine.machine import Machine
from hydrocrane.machine.overrides import Override
from hydrocrane.scenario.record_size import check_record, row_count
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.units import converted

SPAN = ("low", "high", "count", "log")
Convert = Callable[[object], Override]


@runtime_checkable
class Distribution(Protocol):
    """A frozen distribution of SciPy."""

    def ppf(self, q: ArrayLike, /) -> Array: ...


class SpanTable(TypedDict, total=False):
    low: object
    high: object
    count: int | None
    log: bool


@dataclass(frozen=True)
class Span:
    """From `low` to `high`, in equal steps or equal ratios; `count` values on a grid."""

    low: object
    high: object
    count: int | None = None
    log: bool = False

    def at(self, share: Array, name: str, convert: Convert) -> list[float]:
        """Values at shares (m,) of the range from low to high."""
        low, high = _number(convert(self.low)), _number(convert(self.high))
        if not low < high:
            raise InputError(f"the range of `{name}` must go from low to high; got {self.low!r} to {self.high!r}")
        if not self.log:
            return [float(value) for value in low + (high - low) * share]
        if low <= 0:
            raise InputError(f"the range of `{name}` has equal ratios (log), so it must lie above zero")
        return [float(value) for value in np.exp(np.log(low) + (np.log(high) - np.log(low)) * share)]


def _number(value: Override) -> float:
    """An end of a range, checked to be a number."""
    if not isinstance(value, int | float):
        raise InputError(f"a range goes from one number to another; got {value!r}")
    return float(value)


def is_distribution(spec: object) -> bool:
    """Whether `spec` is a frozen distribution of SciPy, or a table that names one."""
    return isinstance(spec, Distribution) or (isinstance(spec, Mapping) and "distribution" in spec)


def samples_of(name: str, spec: object) -> list[Override]:
    """Some values of a range with which a key is tried; empty if there are none."""
    if isinstance(spec, Mapping) and "distribution" in spec:
        return [spec.get("loc", 0.0), 1.0]
    if isinstance(spec, Mapping):
        shown = [spec.get("values", []), [spec[key] for key in ("low", "high") if key in spec]]
        return [value for group in shown for value in group]
    if isinstance(spec, Distribution):
        return [float(spec.ppf(0.5))]
    return _listed(name, spec)


def grid_size(spec: object) -> int:
    """Number of values of a key on a grid, before they are made; one for an invalid range, which is refused later."""
    if isinstance(spec, Mapping) and set(spec) != {"values"}:
        count = spec.get("count")
        return count if isinstance(count, int) and count > 0 else 1
    values = spec["values"] if isinstance(spec, Mapping) else spec
    return len(values) if isinstance(values, Sequence | np.ndarray) and len(values) else 1


def grid_values(name: str, spec: object, convert: Convert) -> list[Override]:
    """Values of a key on a grid."""
    if is_distribution(spec):
        raise InputError(f"`{name}` is a distribution: a grid takes a list, or low, high and count")
    if not isinstance(spec, Mapping):
        return [convert(value) for value in _listed(name, spec)]
    if set(spec) == {"values"}:
        return [convert(value) for value in _listed(name, spec["values"])]
    span = _span(name, spec)
    if not isinstance(span.count, int) or span.count < 2:
        raise InputError(f"the range of `{name}` needs count, a whole number of 2 or more, on a grid")
    return list(span.at(np.linspace(0.0, 1.0, span.count), name, convert))


def drawn_values(name: str, spec: object, share: Array, convert: Convert) -> list[Override]:
    """Values of a key at shares (n,) of probability, each between 0 and 1."""
    if isinstance(spec, Distribution):
        return [float(value) for value in spec.ppf(share)]
    if isinstance(spec, Mapping) and "distribution" in spec:
        return [float(value) for value in _named(name, spec, convert).ppf(share)]
    if isinstance(spec, Mapping) and set(spec) == {"values"}:
        values = [convert(value) for value in _listed(name, spec["values"])]
        return [values[min(int(part * len(values)), len(values) - 1)] for part in share]
    if isinstance(spec, Mapping):
        return list(_span(name, spec).at(share, name, convert))
    ends = _listed(name, spec)
    if len(ends) != 2:
        raise InputError(
            f"`{name}` has {len(ends)} values; drawing takes (low, high), a table with low and high, "
            '{"values": [...]} or a distribution of scipy.stats'
        )
    return list(Span(ends[0], ends[1]).at(share, name, convert))


def _named(name: str, spec: Mapping[str, object], convert: Convert) -> Distribution:
    """A distribution of SciPy by its name, its location and scale with units."""
    from scipy.stats import distributions as stats

    known = [known for known in stats.__all__ if isinstance(getattr(stats, known), stats.rv_continuous)]
    check_known("distribution", spec["distribution"], known)
    scaled = {key: convert(value) for key, value in spec.items() if key in ("loc", "scale")}
    shapes = {key: value for key, value in spec.items() if key not in ("distribution", "loc", "scale")}
    try:
        made: Distribution = getattr(stats, str(spec["distribution"]))(**shapes, **scaled)
        return made
    except TypeError as error:
        raise InputError(f"the distribution of `{name}`: {error}") from None


def _span(name: str, spec: Mapping[str, object]) -> Span:
    for key in spec:
        if key not in SPAN:
            raise InputError(f"the range of `{name}` has no `{key}`{nearest(str(key), SPAN)}")
    if "low" not in spec or "high" not in spec:
        raise InputError(f"the range of `{name}` needs both low and high")
    return Span(**cast("SpanTable", spec))


def _listed(name: str, spec: object) -> list[Override]:
    if isinstance(spec, str) or not hasattr(spec, "__iter__"):
        raise InputError(f"`{name}` needs a list of values or a range; got {spec!r}")
    values = list(spec)
    if not values:
        raise InputError(f"`{name}` has an empty list of values")
    return values


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


def known_signals(plan: Scenario, machine: Machine) -> dict[str, tuple[str, str]]:
    """Name to unit and meaning of all signals of a run of `plan` on `machine`."""
    states = zip(machine.state_names, machine.state_units, machine.core.state_long_names, strict=True)
    known = {name: (unit, text) for name, unit, text in (*states, *machine.core.output_info)}
    known |= {f"cylinder.{c}.command": ("m", f"{c} spool command") for c in machine.cylinder_names}
    known["payload"] = ("kg", "payload at the tip")
    if plan.has_controller:
        known["tip.deviation"] = ("m", "distance of the crane tip from the path of its set-point")
        known |= {f"controller.{c}": ("m", f"{c} spool command as given") for c in machine.cylinder_names}
        known |= {f"set_point.{axis}": ("m", f"set-point of the crane tip, {axis}") for axis in machine.tip_axes}
    return known


def signal_times(plan: Scenario, cases: Cases, resample: float | str | None) -> Array:
    """Common times (n_times,) of all cases, up to the longest duration, s."""
    if resample is None and cases.along("record-interval"):
        raise InputError("signals of runs with different record intervals need a common one: resample=0.05")
    interval = plan.record_interval if resample is None else _interval(resample)
    longest = max([float(cast(float, value)) for value in cases.along("duration")] or [plan.duration])
    rows = row_count(longest, interval)
    check_record(plan.load_machine(), plan, rows, interval="resample or record_interval")
    return np.arange(int(rows), dtype=np.float64) * interval


def check_records(plan: Scenario, machine: Machine, cases: Cases, *, ledger: bool) -> None:
    """Refuse a study before its first case if the record of a case would take more than its limit."""
    durations = cast("list[float]", cases.along("duration")) or [plan.duration]
    intervals = cast("list[float]", cases.along("record-interval")) or [plan.record_interval]
    both = not cases.grid and min(len(durations), len(intervals)) > 1
    pairs = zip(durations, intervals, strict=True) if both else itertools.product(durations, intervals)
    # What is no time is refused in its case.
    rows = max(
        (row_count(duration, interval) for duration, interval in pairs if min(duration, interval) > 0), default=0
    )
    check_record(machine, plan, rows, ledger=ledger)


def _interval(given: float | str) -> float:
    return positive_number("resample", converted("resample", given, "s") if isinstance(given, str) else given, "s")
