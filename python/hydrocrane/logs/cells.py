"""Cells of a text table as numbers: decimal points and commas, marks of thousands, words among numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hydrocrane.arrays import Array

MISSING = {"", "nan", "na", "n/a", "null", "inf", "-inf", "+inf", "#n/a", "-nan", "nil", "--"}
_NUMBER = re.compile(r"^[+-]?(\d+([.,]\d*)*|[.,]\d+)([eE][+-]?\d+)?$")
# 1.234,5 or 1.234.567: points that mark thousands beyond doubt; and the same with both marks exchanged.
_POINTS = re.compile(r"^[+-]?[1-9]\d{0,2}((\.\d{3})+,\d+|(\.\d{3}){2,})$")
_COMMAS = re.compile(r"^[+-]?[1-9]\d{0,2}((,\d{3})+\.\d+|(,\d{3}){2,})$")
# 1.234 and 1,234 may be either.
_EITHER = re.compile(r"^[+-]?[1-9]\d{0,2}[.,]\d{3}$")
_WHOLE = re.compile(r"^[+-]?\d+$")


class Numbers(NamedTuple):
    """Values (n,) of a column, NaN where a cell is missing or none; the cells that are none; doubt about its marks."""

    values: Array
    bad: list[str]
    doubt: str = ""


def is_number(cell: str) -> bool:
    """Whether a cell is a number, with whatever marks."""
    return bool(_NUMBER.match(cell))


def is_missing(cell: str) -> bool:
    """Whether a cell says that there is no number."""
    return cell.lower() in MISSING


def marks_of(columns: Sequence[Sequence[str]]) -> tuple[bool, bool]:
    """Whether commas are decimal marks somewhere in a table, and whether they mark thousands somewhere."""
    decimal = thousands = False
    for cells in columns:
        for cell in cells:
            if "," in cell and is_number(cell):
                thousands |= bool(_COMMAS.match(cell))
                decimal |= not _COMMAS.match(cell) and not _EITHER.match(cell)
    return decimal, thousands


def numbers(cells: Sequence[str], decimal: bool, thousands: bool) -> Numbers:
    """A column's cells as numbers.

    Parameters
    ----------
    cells : sequence of str
    decimal, thousands : bool
        What commas are elsewhere in the table, see :func:`marks_of`: it settles ``1.234`` and ``1,234``.
    """
    points, commas = any(map(_POINTS.match, cells)), any(map(_COMMAS.match, cells))
    real = [cell for cell in cells if not is_missing(cell)]
    either = [cell for cell in real if _EITHER.match(cell)]
    # A column of nothing but whole numbers and 1.234 says nothing by itself.
    silent = bool(either) and all(_WHOLE.match(cell) or _EITHER.match(cell) for cell in real)
    doubt = ""
    if points and commas:
        return Numbers(np.full(len(cells), np.nan), real, "some of its cells mark thousands by points, some by commas")
    if silent and not (points or commas):
        mark = "." if "." in either[0] else ","
        points, commas = mark == "." and decimal, mark == "," and thousands and not decimal
        if points or commas or mark == ",":
            meant = "thousands" if points or commas else "decimals"
            doubt = f"`{either[0]}` may mean thousands or decimals, and {meant} are taken as elsewhere in the file"
            if mark == "," and not (commas or decimal):
                doubt = f"`{either[0]}` may mean thousands or decimals, and decimals are taken"
    if points:
        cells = [cell.replace(".", "") for cell in cells]
    elif commas:
        cells = [cell.replace(",", "") for cell in cells]
    values = np.array([_value(cell.replace(",", ".")) for cell in cells])
    bad = [cell for cell, value in zip(cells, values) if np.isnan(value) and not is_missing(cell)]
    return Numbers(values, bad, doubt)


def _value(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return float("nan")
