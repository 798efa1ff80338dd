"""Timed entries of a scenario, in order of time, with distinct times."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol, TypeVar

from hydrocrane.errors import InputError


class Due(Protocol):
    """An entry with a time, s."""

    @property
    def time(self) -> float: ...


D = TypeVar("D", bound=Due)


def in_order_of_time(given: Iterable[D] | D, kind: type[D], name: str, twice: str) -> tuple[D, ...]:
    """The entries `given` of one `kind`, in order of time.

    In messages `name` is the name of the argument, and `twice` says what two entries do at one time.
    """
    listed = list(given) if isinstance(given, Iterable) else [given]
    if not all(isinstance(one, kind) for one in listed):
        raise InputError(f"{name} must be a list of {kind.__name__}; got {given!r}")
    ordered = sorted(listed, key=lambda one: one.time)
    for early, late in zip(ordered[:-1], ordered[1:], strict=True):
        if early.time == late.time:
            raise InputError(f"two {name} {twice} at {late.time:g} s; give each a different time")
    return tuple(ordered)
