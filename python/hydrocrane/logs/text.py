"""Tables as text: delimiter, decimal marks, titles, comment lines and a row of units are detected."""

from __future__ import annotations

import csv
import gzip
import re
import zlib
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hydrocrane.errors import InputError, ResultFileError
from hydrocrane.files.received import SHORTER, check_values
from hydrocrane.files.toml_file import parsed
from hydrocrane.logs.cells import is_missing, is_number, marks_of, numbers
from hydrocrane.logs.clock import is_moment, seconds_of
from hydrocrane.logs.flags import Flag
from hydrocrane.logs.table import Table, check_width, plain_facts, split_name
from hydrocrane.logs.units import tidy_unit

# Blanks come last, because they also follow other delimiters and occur within titles.
BLANK = " "
DELIMITERS = ("\t", ";", ",", BLANK)
COMMENTS = ("#", "%", "//")
_LOOKED_AT = 50
# Largest text, bytes, most lines, and most letters of one.
LARGEST_TEXT, MOST_LINES, LONGEST_LINE = 2**28, 5_000_000, 2**20
# Most comments that are looked through for facts.
_MOST_COMMENTS = 1000
# 1.234 or 1,234, alone or within a longer number: the mark may be one of thousands.
_THOUSANDS = re.compile(r"(?<![\d.,])[1-9]\d{0,2}[.,]\d{3}(?!\d)")


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


def read_text(path: Path) -> Table:
    """Read a text table, packed or not: perhaps titles, a header row, perhaps a row of units, then rows of numbers."""
    stripped = [line.strip() for line in _text(path).splitlines()]
    lines = [line for line in stripped if line and not _is_comment(line)]
    comments = [line for line in stripped if _is_comment(line)]
    if not lines:
        raise ResultFileError(f"{path} is empty; a log is a table with a time column")
    longest = max(map(len, lines))
    if longest > LONGEST_LINE:
        raise ResultFileError(f"{path} has a line of {longest} letters, more than {LONGEST_LINE}; is it a table?")
    delimiter = _delimiter(lines[:_LOOKED_AT])
    rows = [_cells(line, delimiter) for line in lines[:_LOOKED_AT]]
    check_width(path, max(map(len, rows)))
    head = _head(rows, lines, comments, delimiter)
    if len(lines) == head.lines:
        raise ResultFileError(f"{path} holds {head.lines} line(s) of text and no row of numbers; is it a CSV log?")
    table = _numbers(path, lines[head.lines :], delimiter, head)
    if not table.columns:
        raise ResultFileError(f"{path} is not a CSV table: no column of numbers in it")
    table.units |= dict.fromkeys(table.clocks, "s")
    table.about = _facts(comments)
    return table


def _is_comment(line: str) -> bool:
    return line.startswith(COMMENTS) and not is_missing(line.split(",")[0])


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
        rows = [_cells(line, candidate) for line in lines]
        counts = [len(row) - 1 for row in rows]
        usual = max(set(counts), key=counts.count)
        if not usual or counts.count(usual) <= len(lines) // 2:
            continue
        cells = [cell for row in rows if len(row) == usual + 1 for cell in row if not is_missing(cell)]
        share = round(sum(is_number(cell) or is_moment(cell) for cell in cells) / max(len(cells), 1), 1)
        if (share, counts.count(usual)) > score and not (candidate == BLANK and not share):
            best, score = candidate, (share, counts.count(usual))
    return best


def _cells(line: str, delimiter: str) -> list[str]:
    if delimiter == BLANK:
        return line.split()
    if '"' in line:
        with suppress(csv.Error):  # A cell is longer than any.
            return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]
    return [cell.strip() for cell in line.split(delimiter)]


def _head(rows: list[list[str]], lines: list[str], comments: list[str], delimiter: str) -> Head:
    """Column names, units, and their number of lines.

    The header is the first row of words that is as wide as the rows of numbers, with only titles above it. Without such
    a row it is the last comment, if that has as many names as there are columns.
    """
    widths = [len(row) for row in rows if any(map(is_number, row))]
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
    if any(is_number(cell) or is_moment(cell) for cell in row) or all(map(is_missing, row)):
        return 0
    return sum(1 for cell in row if cell)


def _is_title(row: list[str], width: int) -> bool:
    """A line above the table: narrower than it, or with a word in it."""
    filled = [cell for cell in row if cell]
    return 2 * len(filled) <= width or all(
        not is_number(cell) and not is_moment(cell) and not is_missing(cell) for cell in filled[:1]
    )


def _names(line: str, width: int) -> list[str]:
    """Names of columns separated by blanks: the names are separated by blanks, by another delimiter, or by wide
    gaps."""
    for cells in (
        line.split(),
        *(_cells(line, other) for other in (",", ";", "\t")),
        re.split(r"\s{2,}", line),
        re.split(r"\s+(?![\[(])", line),
    ):
        if len(cells) == width:
            return [cell.strip() for cell in cells]
    return line.split()


def _is_unit_row(cells: list[str]) -> bool:
    """Whether all cells are words, except the 1 of a ratio."""
    words = [cell for cell in cells if not is_number(cell) and not is_missing(cell) or cell == "-"]
    return bool(words) and all(cell in ("", "1", "-", "--") or cell in words for cell in cells)


def _numbers(path: Path, lines: list[str], delimiter: str, head: Head) -> Table:
    """Columns of numbers by name, and faults of the rows."""
    found = Table({})
    cells = [len(_cells(line, delimiter)) if delimiter == BLANK else line.count(delimiter) for line in lines]
    check_width(path, max(cells))
    check_values(path, len(lines) * max(cells))
    if len(lines) > 1 and cells[-1] < min(cells[:-1]):
        message = f"the last line of {path.name} is cut off and left out; was the file copied before it was complete?"
        found.notes.append(Flag("truncated", "", np.nan, np.nan, message))
        lines = lines[:-1]
    # Each column is read separately if commas or points may separate thousands, or with words, which NumPy refuses.
    plain = delimiter == "," or not any("," in line for line in lines)
    commas = not plain and not (any("." in line for line in lines) and any(map(_THOUSANDS.search, lines)))
    try:
        rows = [line.replace(",", ".") for line in lines] if commas else lines
        if not plain and not commas:
            raise ValueError
        whole = np.loadtxt(rows, delimiter=None if delimiter == BLANK else delimiter, comments=None, ndmin=2)
    except ValueError:
        _fill(found, [_cells(line, delimiter) for line in lines], head)
        return found
    if whole.shape[1] > head.named:
        _tell_width(found, len(lines), _cells(lines[0], delimiter)[0], head.named)
    for i, column in enumerate(whole.T):
        found.add(head.names[i], column.copy(), head.units[i])
    return found


def _fill(found: Table, rows: list[list[str]], head: Head) -> None:
    """Add columns by name; columns of words are left out with the reason, single words among numbers are noted."""
    wider = [row for row in rows if any(row[head.named :])]
    if wider:
        _tell_width(found, len(wider), wider[0][0], head.named)
    head = Head.of(head.names, head.units, max(map(len, rows)), head.lines)
    columns = [[row[i] if i < len(row) else "" for row in rows] for i in range(len(head.names))]
    decimal, thousands = marks_of(columns)
    for i, cells in enumerate(columns):
        name = head.names[i]
        clock = seconds_of(cells) if any(map(is_moment, cells[:_LOOKED_AT])) else None
        if clock is not None:
            bad, doubt, values = [c for c, v in zip(cells, clock) if np.isnan(v) and not is_missing(c)], "", clock
        else:
            values, bad, doubt = numbers(cells, decimal, thousands)
        # Delimiters at the ends of lines make empty columns without a name.
        if not any(cells) and name == f"column {i + 1}":
            continue
        if len(bad) * 2 > len(cells) or doubt and bad:
            reason = doubt or "words, not numbers"
            found.leave(name, f"{reason}; export it as numbers if it is needed", bad[0])
            continue
        added = found.add(name, values, head.units[i])
        if clock is not None:
            found.clocks.append(added)
        signal = split_name(added)[0]
        if bad:
            message = f"{len(bad)} cells of `{added}` are not numbers, the first is `{bad[0]}`; they count as missing"
            found.notes.append(Flag("unreadable-cells", signal, np.nan, np.nan, message))
        if doubt:
            message = f"`{added}`: {doubt}; export without thousands separators"
            found.notes.append(Flag("number-format", signal, np.nan, np.nan, message))


def _tell_width(found: Table, count: int, first: str, named: int) -> None:
    message = (
        f"{count} rows have more cells than the {named} of the header, the first begins with `{first}`; extra cells "
        "are read without a name. Are there decimal commas while commas also separate the columns? "
        "Export with semicolons"
    )
    found.notes.append(Flag("ragged-rows", "", np.nan, np.nan, message))
