"""Tables as text: delimiter, decimal comma, comment lines and a row of units are found by looking."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from hydrocrane.errors import InputError, ResultFileError
from hydrocrane.files.toml_file import parsed
from hydrocrane.logs.clock import is_moment, seconds_of
from hydrocrane.logs.flags import Flag
from hydrocrane.logs.table import Table, check_width, plain_facts, split_name, tidy_unit

DELIMITERS = ("\t", ";", ",")
COMMENTS = ("#", "%", "//")
_LOOKED_AT = 50
_NUMBER = re.compile(r"^[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?$")
_MISSING = {"", "nan", "na", "n/a", "null", "inf", "-inf", "+inf", "#n/a"}


def read_text(path: Path) -> Table:
    """Read a CSV file: a header row, perhaps a row of units, then rows of numbers."""
    stripped = [line.strip() for line in _text(path).splitlines()]
    lines = [line for line in stripped if line and not line.startswith(COMMENTS)]
    about = _facts(line for line in stripped if line.startswith(COMMENTS))
    if not lines:
        raise ResultFileError(f"{path} is empty; a log is a table with a time column")
    delimiter = _delimiter(lines[:_LOOKED_AT])
    rows = [_cells(line, delimiter) for line in lines[:_LOOKED_AT]]
    check_width(path, max(map(len, rows)))
    names, units, head = _head(rows)
    if len(lines) == head:
        raise ResultFileError(f"{path} holds {head} line(s) of text and no row of numbers; is it a CSV log?")
    table = _numbers(path, lines[head:], delimiter, names)
    if not table.columns:
        raise ResultFileError(f"{path} is not a CSV table: no column of numbers in it")
    table.units = {name: unit for name, unit in units.items() if name in table.columns} | dict.fromkeys(
        table.clocks, "s"
    )
    table.about = about
    return table


def _facts(comments: Iterable[str]) -> dict[str, str | float | int]:
    """What comment lines like ``# payload = 20`` say about the log, as TOML; other comments are passed over."""
    facts: dict[str, object] = {}
    for line in comments:
        try:
            facts |= parsed(line.lstrip("#%/"), "a comment")
        except InputError:
            continue
    return plain_facts(facts)


def _text(path: Path) -> str:
    raw = path.read_bytes()
    if b"\x00" in raw[:4096]:
        raise ResultFileError(f"{path} is not a CSV table: it is a binary file; give it the suffix of its format")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Older loggers write degree and micro signs in this encoding, in which every byte is a character.
        return raw.decode("latin-1")


def _delimiter(lines: list[str]) -> str:
    """The delimiter that cuts most lines into equally many cells; one column alone needs none."""
    best, score = ",", 0
    for candidate in DELIMITERS:
        counts = [line.count(candidate) for line in lines]
        usual = max(set(counts), key=counts.count)
        if usual and counts.count(usual) > score and counts.count(usual) > len(lines) // 2:
            best, score = candidate, counts.count(usual)
    return best


def _cells(line: str, delimiter: str) -> list[str]:
    return [cell.strip().strip('"') for cell in line.split(delimiter)]


def _is_number(cell: str) -> bool:
    return bool(_NUMBER.match(cell)) or cell.lower() in _MISSING


def _head(rows: list[list[str]]) -> tuple[list[str], dict[str, str], int]:
    """Column names, units, and how many lines they take."""
    width = max(map(len, rows))
    texts = [not any(_NUMBER.match(cell) for cell in row) for row in rows]
    if not texts[0]:
        return [f"column {i + 1}" for i in range(width)], {}, 0
    # A title above the header is shorter than the table.
    first = next((i for i, row in enumerate(rows) if texts[i] and len(row) == width), 0)
    names = rows[first] + [f"column {i + 1}" for i in range(len(rows[first]), width)]
    names = [name or f"column {i + 1}" for i, name in enumerate(names)]
    units = dict(zip(names, map(tidy_unit, rows[first + 1]))) if _is_unit_row(rows[first + 1 : first + 2]) else {}
    head = first + 1 + bool(units)
    stated = {name: split_name(name)[1] for name in names}
    return names, {name: units.get(name) or stated[name] for name in names if units.get(name) or stated[name]}, head


def _is_unit_row(rows: list[list[str]]) -> bool:
    """Words throughout, but for the 1 of a ratio."""
    cells = rows[0] if rows else []
    words = [cell for cell in cells if not _is_number(cell)]
    return bool(words) and all(cell in ("", "1") or cell in words for cell in cells)


def _numbers(path: Path, lines: list[str], delimiter: str, names: list[str]) -> Table:
    """Columns of numbers by name, and what was odd about the rows."""
    found = Table({})
    cells = [line.count(delimiter) for line in lines]
    if len(lines) > 1 and cells[-1] < min(cells[:-1]):
        message = f"the last line of {path.name} is cut off and left out; was the file copied before it was complete?"
        found.notes.append(Flag("truncated", "", np.nan, np.nan, message))
        lines = lines[:-1]
    comma = delimiter != "," and any(re.search(r"\d,\d|^,\d", line) for line in lines[:_LOOKED_AT])
    if comma:
        lines = [line.replace(",", ".") for line in lines]
    _fill(found, lines, delimiter, names)
    return found


def _fill(found: Table, lines: list[str], delimiter: str, names: list[str]) -> None:
    """Put in columns by name; those of words are left out, single words among numbers are noted."""
    try:
        whole = np.loadtxt(lines, delimiter=delimiter, comments=None, ndmin=2)
        found.columns |= {name: column.copy() for name, column in zip(names, whole.T)}
        return
    except ValueError:
        rows = [_cells(line, delimiter) for line in lines]
    for i, name in enumerate(names):
        cells = [row[i] if i < len(row) else "" for row in rows]
        clock = seconds_of(cells) if any(map(is_moment, cells[:_LOOKED_AT])) else None
        values = np.array([_value(cell) for cell in cells]) if clock is None else clock
        bad = [cell for cell, value in zip(cells, values) if np.isnan(value) and cell.lower() not in _MISSING]
        if clock is not None:
            found.clocks.append(name)
        # Delimiters at the ends of the lines make columns that nobody named.
        if len(bad) * 2 > len(cells) or (not any(cells) and name == f"column {i + 1}"):
            if bad:
                found.words[name] = bad[0]
            continue
        if bad:
            message = f"{len(bad)} cells of `{name}` are no numbers, the first is `{bad[0]}`; they count as missing"
            found.notes.append(Flag("unreadable-cells", split_name(name)[0], np.nan, np.nan, message))
        found.columns[name] = values


def _value(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return float("nan")
