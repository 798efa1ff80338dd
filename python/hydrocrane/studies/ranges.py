"""Sources of the values of a key: a list, a range with both ends, or a distribution."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, TypedDict, cast, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, check_known, nearest
from hydrocrane.machine.overrides import Override

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
