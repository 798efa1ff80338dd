"""Tables as text: delimiter, decimal marks, titles, comment lines and a row of units are detected."""

from __future__ import annotations

import gzip
import re
import zlib
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hydrocrane import _core
from hydrocrane.errors import InputError, ResultFileError
from hydrocrane.files.received import SHORTER, check_values
from hydrocrane.files.toml_file import parsed
from hydrocrane.logs.clock import is_moment, seconds_of
from hydrocrane.logs.flags import Flag
from hydrocrane.logs.table import DATE_ORDERS, NUMBER_FORMATS, Column, Form, Table, check_width, plain_facts
from hydrocrane.logs.units import tidy_unit

# Blanks come last, because they also follow other delimiters and occur within titles.
BLANK = " "
DELIMITERS = ("\t", ";", ",", BLANK)
# Between cells that are no part of a text file.
CELLS = "\x1f"
COMMENTS = ("#", "%", "//")
_LOOKED_AT = 50
# Largest text, bytes, most lines, and most letters of one.
LARGEST_TEXT, MOST_LINES, LONGEST_LINE = 2**28, 5_000_000, 2**20
# Most comments that are looked through for facts.
_MOST_COMMENTS = 1000
# Why a column that may be read in two ways has no numbers, by the kind of its doubt.
_UNDECIDED = {
    "undecided": "`{}` may mean decimals or thousands, and nothing in the file says which; say number_format = {}",
    "mixed": "`{}` and `{}` have different decimal marks; export it with one of them",
}


class Head(NamedTuple):
    """The lines above the numbers.

    Attributes
    ----------
    names, units : list of str
        Of every column; a unit may be empty.
    named : int
        Number of columns named by the header; all columns without a header.
    lines : int
        Lines before the first row of numbers.
    """

    names: list[str]
    units: list[str]
    named: int
    lines: int

    @classmethod
    def of(cls, names: list[str], units: list[str], width: int, lines: int) -> Head:
        """A head of at least `width` columns; columns without a name are called by their number."""
        size = max(width, len(names))
        full = [(names[i] if i < len(names) else "") or f"column {i + 1}" for i in range(size)]
        units = [tidy_unit(unit) for unit in units[:size]] + [""] * (size - len(units))
        return cls(full, units, len(names) or size, lines)


def read_text(path: Path, form: Form) -> Table:
    """Read a text table, packed or not: perhaps titles, a header row, perhaps a row of units, then rows of numbers."""
    stripped = [line.strip() for line in _text(path).splitlines()]
    comments = [line for line in stripped if line.startswith(COMMENTS) and _is_comment(line)]
    lines = [line for line in stripped if line and not (line.startswith(COMMENTS) and _is_comment(line))]
    if not lines:
        raise ResultFileError(f"{path} is empty; a log is a table with a time column")
    longest = max(map(len, lines))
    if longest > LONGEST_LINE:
        raise ResultFileError(f"{path} has a line of {longest} letters, more than {LONGEST_LINE}; is it a table?")
    delimiter = _delimiter(lines[:_LOOKED_AT])
    table = table_of_lines(path, lines, comments, delimiter, form)
    table.about = _facts(comments)
    return table


def table_of_lines(path: Path, lines: list[str], comments: list[str], delimiter: str, form: Form) -> Table:
    """The columns of a table of text; the names are in its first lines, or in the last comment."""
    rows = [_core.line_cells(line, delimiter) for line in lines[:_LOOKED_AT]]
    check_width(path, max(map(len, rows)))
    head = _head(rows, lines, comments, delimiter)
    if len(lines) == head.lines:
        raise ResultFileError(f"{path} holds {head.lines} line(s) of text and no row of numbers; is it a CSV log?")
    table = Table()
    add_lines(table, _whole(path, table, lines[head.lines :], delimiter), delimiter, head, form)
    if not table.columns:
        reasons = "; ".join(dict.fromkeys(table.left_out.values()))
        raise ResultFileError(f"{path} is not a CSV table: no column of numbers in it{reasons and ': '}{reasons}")
    return table


def _is_comment(line: str) -> bool:
    """Whether a line that begins like a comment is one: a cell may be `#N/A`."""
    return not _core.is_missing(line.split(",")[0])


def _facts(comments: list[str]) -> dict[str, str | float | int]:
    """Facts from comment lines like ``# payload = 20``, read as TOML; other comments are ignored."""
    facts: dict[str, object] = {}
    for line in comments[:_MOST_COMMENTS]:
        try:
            facts |= parsed(line.lstrip("#%/"), "a comment")
        except InputError:
            continue
    return plain_facts(facts)


def _text(path: Path) -> str:
    packed = path.suffix.lower() == ".gz"
    try:
        with gzip.open(path) if packed else path.open("rb") as stream:
            raw = stream.read(LARGEST_TEXT + 1)
    except (OSError, EOFError, zlib.error) as error:
        reason = f"cannot be {'unpacked' if packed else 'read'}: {error}"
        raise ResultFileError(f"{path} {reason}; copy it again from the logger") from None
    # Only the rows matter: a line takes more memory than its letters.
    if len(raw) > LARGEST_TEXT or raw.count(b"\n") > MOST_LINES:
        most = f"{LARGEST_TEXT >> 20} MiB of text or {MOST_LINES} lines"
        raise ResultFileError(f"{path} has more than {most}. {SHORTER}, or save it as .h5 or .nc")
    if b"\x00" in raw[:4096]:
        raise ResultFileError(f"{path} is not a CSV table: it is a binary file; give it the suffix of its format")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Older loggers write degree and micro signs in this encoding, in which every byte is a character.
        return raw.decode("latin-1")


def _delimiter(lines: list[str]) -> str:
    """The delimiter that splits most lines into the same number of cells, with numbers in them; one column needs
    none."""
    best, score = ",", (0.0, 0)
    for candidate in DELIMITERS:
        rows = [_core.line_cells(line, candidate) for line in lines]
        counts = [len(row) - 1 for row in rows]
        usual = max(set(counts), key=counts.count)
        if not usual or counts.count(usual) <= len(lines) // 2:
            continue
        cells = [cell for row in rows if len(row) == usual + 1 for cell in row if not _core.is_missing(cell)]
        share = round(sum(_core.is_number(cell) or is_moment(cell) for cell in cells) / max(len(cells), 1), 1)
        if (share, counts.count(usual)) > score and not (candidate == BLANK and not share):
            best, score = candidate, (share, counts.count(usual))
    return best


def _head(rows: list[list[str]], lines: list[str], comments: list[str], delimiter: str) -> Head:
    """Column names, units, and their number of lines.

    The header is the first row of words that is as wide as the rows of numbers, with only titles above it. Without such
    a row it is the last comment, if that has as many names as there are columns.
    """
    widths = [len(row) for row in rows if any(map(_core.is_number, row))]
    width = max(set(widths), key=widths.count) if widths else max(map(len, rows))
    first = None
    for i, row in enumerate(rows):
        share = _named(row if delimiter != BLANK else _names(lines[i], width)) / width
        # A row of words half as wide: names, if decimal commas split each number into two; a title, if names follow.
        if share > 0.5 or (share == 0.5 and first is None):
            first = i
        if share > 0.5 or not (share or _is_title(row, width)):
            break
    if first is None:
        start = next((i for i, row in enumerate(rows) if not _is_title(row, width)), 0)
        named = _names(comments[-1].lstrip("#%/ "), width) if comments else []
        names = named if 2 * _named(named) > width and len(named) == width else []
        return Head.of(names, [], width, start)
    names, below = (
        (_names(lines[i], width) if delimiter == BLANK else rows[i]) if i < len(rows) else []
        for i in (first, first + 1)
    )
    units = below if _is_unit_row(below) else []
    return Head.of(names, units, width, first + 1 + bool(units))


def _named(row: list[str]) -> int:
    """Number of cells of a row that are words; zero if one is a number or all are missing."""
    if any(_core.is_number(cell) or is_moment(cell) for cell in row) or all(map(_core.is_missing, row)):
        return 0
    return sum(1 for cell in row if cell)


def _is_title(row: list[str], width: int) -> bool:
    """A line above the table: narrower than it, or with a word in it."""
    filled = [cell for cell in row if cell]
    return 2 * len(filled) <= width or all(
        not _core.is_number(cell) and not is_moment(cell) and not _core.is_missing(cell) for cell in filled[:1]
    )


def _names(line: str, width: int) -> list[str]:
    """Names of columns separated by blanks: the names are separated by blanks, by another delimiter, or by wide
    gaps."""
    for cells in (
        line.split(),
        *(_core.line_cells(line, other) for other in (",", ";", "\t")),
        re.split(r"\s{2,}", line),
        re.split(r"\s+(?![\[(])", line),
    ):
        if len(cells) == width:
            return [cell.strip() for cell in cells]
    return line.split()


def _is_unit_row(cells: list[str]) -> bool:
    """Whether all cells are words, except the 1 of a ratio."""

    def is_word(cell: str) -> bool:
        return not (_core.is_number(cell) or _core.is_missing(cell) or is_moment(cell)) or cell == "-"

    words = [cell for cell in cells if is_word(cell)]
    return bool(words) and all(cell in ("", "1", "-", "--") or cell in words for cell in cells)


def _whole(path: Path, table: Table, lines: list[str], delimiter: str) -> list[str]:
    """The lines without a last one that is cut off."""
    cells = [len(line.split()) if delimiter == BLANK else line.count(delimiter) + 1 for line in lines]
    check_width(path, max(cells))
    check_values(path, len(lines) * max(cells))
    if len(lines) > 1 and cells[-1] < min(cells[:-1]):
        message = f"the last line of {path.name} is cut off and left out; was the file copied before it was complete?"
        table.notes.append(Flag("truncated", "", np.nan, np.nan, message))
        return lines[:-1]
    return lines


def add_lines(table: Table, lines: list[str], delimiter: str, head: Head, form: Form) -> None:
    """Add the columns of lines; those without numbers are left out with the reason, single words are noted."""
    wider, first, columns = _core.table_columns(lines, delimiter, head.named, form.numbers)
    if wider:
        start = _core.line_cells(lines[first], delimiter)[0]
        _tell_width(table, wider, start, head.named)
    head = Head.of(head.names, head.units, len(columns), head.lines)
    for name, unit, (values, rows, bad, blank, doubt, told) in zip(head.names, head.units, columns):
        column = Column(values, unit)
        moments = seconds_of(bad, form.dates) if any(map(is_moment, bad[:_LOOKED_AT])) else None
        if moments is not None:
            column = Column(np.full(values.size, np.nan), "s", dates=True)
            column.values[rows] = moments.seconds
            bad = [cell for cell, value in zip(bad, moments.seconds) if np.isnan(value)]
        # Delimiters at the ends of lines make empty columns without a name.
        if blank and name.startswith("column ") and name.removeprefix("column ").isdigit():
            continue
        if moments is not None and moments.undecided:
            orders = " or ".join(f'"{order}"' for order in DATE_ORDERS)
            table.leave(name, f"its dates do not say which number is the day; say [time] date-order = {orders}")
        elif doubt in _UNDECIDED:
            formats = " or ".join(f'"{known}"' for known in NUMBER_FORMATS)
            table.leave(name, _UNDECIDED[doubt].format(*told, formats))
        elif len(bad) * 2 > values.size:
            table.leave(name, "words, not numbers; export it as numbers if it is needed", bad[0])
        else:
            if bad:
                text = f"has {len(bad)} cells that are not numbers, the first is `{bad[0]}`; they count as missing"
                column.notes.append(("unreadable-cells", text))
            if doubt:
                text = f"has `{told[0]}`, which is read with marks of thousands, as other columns of the file say"
                column.notes.append(("number-format", text))
            table.add(name, column)


def _tell_width(table: Table, count: int, first: str, named: int) -> None:
    message = (
        f"{count} rows have more cells than the {named} of the header, the first begins with `{first}`; extra cells "
        "are read without a name. Are there decimal commas while commas also separate the columns? "
        "Export with semicolons"
    )
    table.notes.append(Flag("ragged-rows", "", np.nan, np.nan, message))
