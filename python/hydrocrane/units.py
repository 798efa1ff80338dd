"""Quantities as text: a number with its unit."""

from __future__ import annotations

from functools import cache

from hydrocrane import _core
from hydrocrane.errors import InputError


def converted(what: str, text: str, unit: str) -> float:
    """A text with its unit in SI; its dimension must be that of the SI unit `unit`."""
    try:
        number, dimension = _core.quantity(text, unit)
    except ValueError as error:
        raise InputError(f"`{what}`: {error}") from None
    if dimension != _dimension(unit):
        raise InputError(f"`{what}` is in {unit or 'plain numbers'}; `{text}` is another quantity")
    return float(number)


@cache
def _dimension(unit: str) -> str:
    return str(_core.quantity(f"1 {unit}".strip())[1])
