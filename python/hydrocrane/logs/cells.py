"""Cells of a text table as numbers: decimal points and commas, marks of thousands, words among numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.units import plain_number

MISSING = {"", "nan", "na", "n/a", "null", "inf", "-inf", "+inf", "#n/a", "-nan", "nil", "--"}
_NUMBER = re.compile(r"^[+-]?(\d+([.,]\d*)*|[.,]\d+)([eE][+-]?\d+)?$")
# The cells of a column are on separate lines, so that one search finds any match.
# 1.234,5 or 1.234.567: points are certainly thousands separators; and the same with both marks exchanged.
_POINTS = re.compile(r"^[+-]?[1-9]\d{0,2}((\.\d{3})+,\d+|(\.\d{3}){2,})$", re.MULTILINE)
_COMMAS = re.compile(r"^[+-]?[1-9]\d{0,2}((,\d{3})+\.\d+|(,\d{3}){2,})$", re.MULTILINE)
# 1.234 and 1,234 are ambiguous; in all other numbers a comma is a decimal mark.
_EITHER = re.compile(r"^[+-]?[1-9]\d{0,2}[.,]\d{3}$", re.MULTILINE)
_DECIMAL = re.compile(r"^(?![+-]?[1-9]\d{0,2}(,\d{3})+(\.\d+)?$)[+-]?(\d[\d.]*,\d*|,\d+)([eE][+-]?\d+)?$", re.MULTILINE)
_WHOLE = re.compile(r"^[+-]?\d+$")


class Numbers(NamedTuple):
    """Values (n,) of a column, NaN where a cell is missing or no number; the cells that are no numbers; doubt about its
    marks."""

    values: Array
    bad: list[str]
    doubt: str = ""


def is_number(cell: str) -> bool:
    """Whether a cell is a number, with any marks."""
    return bool(_NUMBER.match(cell))


def is_missing(cell: str) -> bool:
    """Whether a cell says that there is no number."""
    return cell.lower() in MISSING


def marks_of(columns: Sequence[Sequence[str]]) -> tuple[bool, bool]:
    """Whether commas are decimal marks in some cell of a table, and whether they separate thousands in some cell."""
    texts = ["\n".join(cells) for cells in columns]
    return any(map(_DECIMAL.search, texts)), any(map(_COMMAS.search, texts))


def numbers(cells: Sequence[str], decimal: bool, thousands: bool) -> Numbers:
    """A column's cells as numbers.

    Parameters
    ----------
    cells : sequence of str
    decimal, thousands : bool
        Meaning of commas elsewhere in the table, see :func:`marks_of`; it decides on ``1.234`` and ``1,234``.
    """
    text = "\n".join(cells)
    points, commas = bool(_POINTS.search(text)), bool(_COMMAS.search(text))
    if points and commas:
        bad = [cell for cell in cells if not is_missing(cell)]
        return Numbers(np.full(len(cells), np.nan), bad, "some of its cells mark thousands by points, some by commas")
    doubt = ""
    either = _EITHER.search(text)
    # A column with only whole numbers and numbers like 1.234 is ambiguous.
    if either and not (points or commas) and all(_silent(cell) for cell in cells):
        comma = "," in either[0]
        points, commas = not comma and decimal, comma and thousands and not decimal
        settled = "as elsewhere in the file" if points or commas or decimal else "since nothing in the file settles it"
        if points or commas or comma:
            meant = "thousands" if points or commas else "decimals"
            doubt = f"`{either[0]}` may mean thousands or decimals, and {meant} are taken {settled}"
    if points or commas:
        text = text.replace("." if points else ",", "")
    found = text.replace(",", ".").split("\n")
    values = np.array([_value(cell) for cell in found])
    bad = [cells[int(i)] for i in np.flatnonzero(np.isnan(values)) if not is_missing(cells[int(i)])]
    return Numbers(values, bad, doubt)


def _silent(cell: str) -> bool:
    return bool(_EITHER.match(cell) or _WHOLE.match(cell)) or is_missing(cell)


def _value(cell: str) -> float:
    try:
        return plain_number(cell)
    except ValueError:
        return float("nan")
