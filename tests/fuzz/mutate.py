"""Damages text files so that they are still nearly what they were: TOML, and tables of numbers."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Sequence

EXTREMES = (
    "0", "-1", "1", "1e-300", "1e300", "-1e300", "nan", "inf", "-inf", "9223372036854775807", "18446744073709551616",
    "1e400", "5e-324", "1e-9", "1e9", "1e6", "0.1", "100", "true", '""', "[]", "{}", '"nan m"', '"1e300 bar"',
    '"-1 kg"',
    '"0 m"', '"1e-300 s"', '"50 s"', '"1 furlong"', "1979-05-27", "1979-05-27T07:32:00Z",
)  # fmt: skip
CELLS = (
    "",
    "nan",
    "inf",
    "-inf",
    "1e300",
    "-1",
    "abc",
    "1,5",
    "1e400",
    "9" * 400,
    "2024-01-01T00:00:00",
    "é",
    "\x00",
    '"',
)
FACTORS = (0.0, -1.0, 1e-300, 1e300, 1e-9, 1e-6, 1e-3, 0.1, 0.5, 2.0, 10.0, 1e3, 1e6, 1e9)
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d*)?(?:[eE][+-]?\d+)?")
DEEP, LONG = 20_000, 300_000


def damaged_toml(draws: random.Random, text: str, others: Sequence[str]) -> str:
    """One to four damages, most often one."""
    return _damaged(draws, text, others, TOML)


def damaged_table(draws: random.Random, text: str, others: Sequence[str]) -> str:
    return _damaged(draws, text, others, TABLE)


Damage = Callable[[random.Random, list[str], Sequence[str]], None]


def _damaged(draws: random.Random, text: str, others: Sequence[str], ways: Sequence[tuple[Damage, int]]) -> str:
    for _ in range(1 + int(4 * draws.random() ** 3)):
        if draws.random() < 0.04:
            text = _bytes(draws, text)
            continue
        lines = text.split("\n")
        way = draws.choices([way for way, _ in ways], [weight for _, weight in ways])[0]
        way(draws, lines, others)
        text = "\n".join(lines)
    return text


def _bytes(draws: random.Random, text: str) -> str:
    raw = bytearray(text.encode(errors="surrogateescape"))
    for _ in range(draws.randint(1, 5)):
        if raw:
            raw[draws.randrange(len(raw))] = draws.randrange(256)
    return raw.decode(errors="surrogateescape")


def _keyed(draws: random.Random, lines: list[str]) -> int | None:
    found = [i for i, line in enumerate(lines) if " = " in line and not line.lstrip().startswith("#")]
    return draws.choice(found) if found else None


def _set(draws: random.Random, lines: list[str], value: str) -> None:
    if (at := _keyed(draws, lines)) is not None:
        lines[at] = f"{lines[at].split(' = ')[0]} = {value}"


def number(draws: random.Random, lines: list[str], _: Sequence[str]) -> None:
    """A number becomes another one, or itself times a factor."""
    found = [(i, hit) for i, line in enumerate(lines) for hit in NUMBER.finditer(line)]
    if not found:
        return
    i, hit = draws.choice(found)
    scaled = repr(float(hit[0]) * draws.choice(FACTORS))
    new = scaled if draws.random() < 0.7 else draws.choice(EXTREMES[:18])
    lines[i] = lines[i][: hit.start()] + new + lines[i][hit.end() :]


def value(draws: random.Random, lines: list[str], _: Sequence[str]) -> None:
    _set(draws, lines, draws.choice(EXTREMES))


def other_value(draws: random.Random, lines: list[str], _: Sequence[str]) -> None:
    if (at := _keyed(draws, lines)) is not None:
        _set(draws, lines, lines[at].split(" = ", 1)[1])


def removed(draws: random.Random, lines: list[str], _: Sequence[str]) -> None:
    del lines[draws.randrange(len(lines))]
    if not lines:
        lines.append("")


def doubled(draws: random.Random, lines: list[str], _: Sequence[str]) -> None:
    lines.insert(draws.randrange(len(lines)), draws.choice(lines))


def swapped(draws: random.Random, lines: list[str], _: Sequence[str]) -> None:
    i, j = draws.randrange(len(lines)), draws.randrange(len(lines))
    lines[i], lines[j] = lines[j], lines[i]


def foreign(draws: random.Random, lines: list[str], others: Sequence[str]) -> None:
    lines.insert(draws.randrange(len(lines)), draws.choice(draws.choice(others).split("\n")))


def key(draws: random.Random, lines: list[str], _: Sequence[str]) -> None:
    at, other = _keyed(draws, lines), _keyed(draws, lines)
    if at is not None and other is not None:
        name, rest = lines[at].split(" = ", 1)
        new = lines[other].split(" = ")[0] if draws.random() < 0.5 else name[: len(name) // 2] + name
        lines[at] = f"{new} = {rest}"


def deep(draws: random.Random, lines: list[str], _: Sequence[str]) -> None:
    _set(draws, lines, draws.choice(["[" * DEEP, "{a = " * DEEP, "[" * 50 + "]" * 50, "{" + "a." * DEEP + "a = 1}"]))


def long(draws: random.Random, lines: list[str], _: Sequence[str]) -> None:
    text = ['"' + "long " * (LONG // 5) + '"', "[" + ", ".join(["1"] * (LONG // 3)) + "]", "9" * 4000]
    _set(draws, lines, draws.choice(text))


def cell(draws: random.Random, lines: list[str], _: Sequence[str]) -> None:
    """One cell, or a whole column, becomes something else."""
    new, which = draws.choice(CELLS), draws.random()
    delimiter = max(",;\t", key=lambda d: sum(line.count(d) for line in lines[:20]))
    column = draws.randrange(6)
    rows = range(len(lines)) if draws.random() < 0.2 else [draws.randrange(len(lines))]
    for i in rows:
        cells = lines[i].split(delimiter)
        if column < len(cells):
            cells[column] = new
            if which < 0.1:
                del cells[column]
        lines[i] = delimiter.join(cells)


def delimiters(draws: random.Random, lines: list[str], _: Sequence[str]) -> None:
    old, new = draws.choice(",;\t."), draws.choice(",;\t. ")
    lines[:] = [line.replace(old, new) for line in lines]


def repeated(draws: random.Random, lines: list[str], _: Sequence[str]) -> None:
    """Very many rows, or one very wide one."""
    if draws.random() < 0.5:
        lines.extend(lines[-2:] * 20_000)
    else:
        lines[draws.randrange(len(lines))] = ",".join(["1"] * 50_000)


def cut(draws: random.Random, lines: list[str], _: Sequence[str]) -> None:
    lines[draws.randrange(len(lines)) :] = [""]


TOML: tuple[tuple[Damage, int], ...] = (
    (number, 18), (value, 10), (other_value, 3), (removed, 3), (doubled, 2), (swapped, 1), (foreign, 3), (key, 3),
    (deep, 1), (long, 1),
)  # fmt: skip
TABLE: tuple[tuple[Damage, int], ...] = (
    (cell, 12), (number, 8), (removed, 3), (doubled, 2), (swapped, 3), (foreign, 2), (delimiters, 3), (repeated, 1),
    (cut, 3),
)  # fmt: skip
