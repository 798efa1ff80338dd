"""Excel workbooks: a sheet with the data, and one with their description."""

from __future__ import annotations

import errno
import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hydrocrane.errors import ResultFileError
from hydrocrane.files.columns import Columns
from hydrocrane.files.received import check_values
from hydrocrane.files.text_rows import in_blocks

if TYPE_CHECKING:
    import xarray as xr
    from openpyxl import Workbook
    from openpyxl.cell import WriteOnlyCell
    from openpyxl.worksheet._write_only import WriteOnlyWorksheet

# Limits of a sheet, including the row of names, and of a cell.
MOST_ROWS, MOST_COLUMNS, LONGEST = 1_048_576, 16_384, 32_767


def write_excel(data: xr.Dataset | Columns, path: Path) -> None:
    """Sheet ``data``: ``name [unit]`` over each column, missing values empty. Sheet ``about``: their description."""
    columns = Columns.of(data)
    table = columns.over_time()
    check_sheet(columns.rows, len(table))
    words = [name for name, values in table.items() if values.dtype.kind not in "buif"]
    if words:
        raise ResultFileError(f"`{words[0]}` has no numbers, and the sheet has only these; drop it, or save .csv")
    with _errors_of_the_system(path):
        _filled(columns, table).save(path)


def read_sheet(path: Path) -> Iterator[list[str]]:
    """The rows of the first sheet as texts; a number has an exponent, so that its point is no mark of thousands.

    Below a header with a percent sign a number that is shown in percent counts as it is shown.
    """
    from openpyxl import load_workbook

    book = load_workbook(path, read_only=True, data_only=True)
    read = 0
    percent: set[int] = set()
    for row in book.worksheets[0].iter_rows():
        read += len(row)
        check_values(path, read)
        values = [cell.value for cell in row]
        percent |= {i for i, value in enumerate(values) if isinstance(value, str) and "%" in value}
        for i in percent.intersection(range(len(row))):
            if isinstance(values[i], int | float) and "%" in row[i].number_format:
                values[i] = 100.0 * values[i]
        yield [cell_text(value) for value in values]


def cell_text(value: object) -> str:
    """A value of a cell as the text of one; missing ones are empty."""
    if isinstance(value, timedelta):
        value = value.total_seconds()
    if isinstance(value, float):
        return "" if math.isnan(value) else repr(value) if "e" in repr(value) else f"{value!r}e0"
    return "" if value is None else str(int(value) if isinstance(value, bool) else value).replace('"', "")


def check_sheet(rows: int, columns: int = 1) -> None:
    """Refuse a table that no sheet holds.

    Raises
    ------
    ResultFileError
        With the limits and the cure.
    """
    if rows >= MOST_ROWS or columns > MOST_COLUMNS:
        raise ResultFileError(
            f"a sheet of Excel has {MOST_ROWS - 1} rows of numbers and {MOST_COLUMNS} columns, and these are "
            f"{rows} and {columns}; record less often, or save .nc or .parquet"
        )


def _filled(columns: Columns, table: Mapping[str, np.ndarray]) -> Workbook:
    from openpyxl import Workbook

    names = list(table)
    book = Workbook(write_only=True)
    sheet = book.create_sheet("data")
    sheet.freeze_panes = "B2"
    sheet.append([_text(sheet, titled(columns, name)) for name in names])
    for block in in_blocks(list(table.values())):
        for row in zip(*(values.tolist() for values in block), strict=True):
            sheet.append([value if math.isfinite(value) else None for value in row])
    about = book.create_sheet("about")
    about.append(["name", "unit", "meaning"])
    for name in names:
        attributes = columns[name].attrs
        about.append(
            [_text(about, str(text)) for text in (name, attributes.get("units", ""), attributes.get("long_name", ""))]
        )
    about.append([])
    for key, value in columns.attrs.items():
        about.append([_text(about, str(key)), value if isinstance(value, float) else _text(about, str(value))])
    return book


def _text(sheet: WriteOnlyWorksheet, text: str) -> WriteOnlyCell:
    """A cell that holds a text, never a formula."""
    from openpyxl.cell import WriteOnlyCell
    from openpyxl.cell.cell import ILLEGAL_CHARACTERS_RE

    cell = WriteOnlyCell(sheet, ILLEGAL_CHARACTERS_RE.sub("\ufffd", text)[:LONGEST])
    cell.data_type = "s"
    return cell


@contextmanager
def _errors_of_the_system(path: Path) -> Iterator[None]:
    """Converts errors of temporary files into ``OSError``: sheets go through lxml if it is installed, which raises its
    own."""
    try:
        yield
    except Exception as error:
        if type(error).__name__ != "SerialisationError":
            raise
        code = getattr(errno, str(error).removeprefix("IO_"), errno.EIO)
        raise OSError(code, os.strerror(code), str(path)) from None


def titled(columns: Columns, name: str) -> str:
    """The name of a variable with its unit: ``tip.z [m]``; plain numbers have none."""
    unit = str(columns[name].attrs.get("units", ""))
    return f"{name} [{unit}]" if unit not in ("", "1") else name
