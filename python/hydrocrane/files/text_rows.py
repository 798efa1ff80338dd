"""Tables as text, made block by block: no table is held a second time, and the core makes the texts of numbers."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence

import numpy as np

from hydrocrane import _core

# Cells per block: some megabytes of text.
_BLOCK = 2**18


def csv_rows(columns: Sequence[np.ndarray]) -> Iterator[bytes]:
    """The rows of `columns`, each (m,), as CSV; of numbers the shortest text that reads back as the same double."""
    for block in in_blocks(columns):
        yield _core.csv_rows([_cells(values) for values in block])


def csv_line(cells: Sequence[str]) -> bytes:
    """One line of CSV, UTF-8."""
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(cells)
    return line.getvalue().encode()


def in_blocks(columns: Sequence[np.ndarray]) -> Iterator[list[np.ndarray]]:
    """The columns, each (m,), some rows at a time."""
    step = max(_BLOCK // len(columns), 1)
    for begin in range(0, len(columns[0]), step):
        yield [column[begin : begin + step] for column in columns]


def _cells(values: np.ndarray) -> np.ndarray | list[str]:
    """Doubles as they are; of whatever else somebody put into the data the text, quoted where CSV asks for it."""
    if values.dtype == np.float64:
        return values
    return [csv_line([str(value)]).decode().removesuffix("\n") for value in values.tolist()]
