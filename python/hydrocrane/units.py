"""Quantities as text: a number with its unit."""

from __future__ import annotations

from functools import cache

from hydrocrane import _core
from hydrocrane.errors import InputError


def plain_number(text: str) -> float:
    """The number that a text is.

    Raises
    ------
    ValueError
        If it is none. Python's own numbers may have underscores, ``1_10``, and digits of any script; here such a text
        is a misprint.
    """
    if "_" in text or not text.isascii():
        raise ValueError(f"`{text}` is not a number")
    return float(text)


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
