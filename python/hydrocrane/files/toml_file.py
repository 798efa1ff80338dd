"""Reader of the TOML files that the Python side reads, with one message per fault."""

from __future__ import annotations

import json
import re
import tomllib
from datetime import date, datetime, time
from pathlib import Path
from typing import TypeAlias

from hydrocrane.errors import InputError
from hydrocrane.files.received import received

TomlValue: TypeAlias = "str | int | float | bool | date | time | datetime | list[TomlValue] | dict[str, TomlValue]"
TomlTable: TypeAlias = dict[str, TomlValue]

# Most levels of tables and lists in a file, and most bytes of a text: one key takes a millisecond with so many levels.
DEEPEST, LARGEST = 50, 2**20
# A key of more parts than that, for which the parser's time and memory grow with the square of their number.
_PART = r"""(?:[\w-]{1,200}+|"(?:[^"\\\n]|\\.){0,200}+"|'[^'\n]{0,200}+')[ \t]*+"""
_DEEP_KEY = re.compile(rf"(?<![\w\\-]){_PART}(?:\.[ \t]*+{_PART}){{{DEEPEST},}}")


def read_toml(path: Path, what: str) -> TomlTable:
    """The content of the file at `path`; `what` names its kind in messages, for example "study file".

    Raises
    ------
    InputError
        If the file cannot be read, is not UTF-8 text or no TOML, is too large, or is nested deeper than `DEEPEST`
        levels.
    """
    try:
        text = received(path, LARGEST, InputError, what).read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot read the {what} {path}: {error.strerror}; check the path") from None
    except UnicodeDecodeError:
        raise InputError(f"{path} is not UTF-8 text; is it a {what}?") from None
    return parsed(text, str(path))


def parsed(text: str, where: str) -> TomlTable:
    """The content of a text; messages begin with `where`.

    Raises
    ------
    InputError
        If it is no TOML, is too large, or is nested deeper than `DEEPEST` levels.
    """
    deep = InputError(f"{where} is nested deeper than {DEEPEST} levels; close brackets and braces where they belong")
    if len(text) > LARGEST:
        raise InputError(f"{where} has {len(text)} letters, more than {LARGEST}; leave out what is not needed")
    if _DEEP_KEY.search(text):
        raise deep
    try:
        content: TomlTable = tomllib.loads(text)
    except RecursionError:
        raise deep from None
    except ValueError as error:  # Numbers with too many digits raise another error than TOMLDecodeError.
        raise InputError(f"{where} is not valid TOML: {error}") from None
    level: list[TomlValue] = [content]
    for _ in range(DEEPEST):
        level = [part for whole in level for part in _parts(whole)]
        if not level:
            return content
    raise deep


def toml_key(name: str) -> str:
    """A name as a key: in quotes where it is no bare one."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name, ensure_ascii=False)


def _parts(whole: TomlValue) -> list[TomlValue]:
    """The tables and lists in a table or list."""
    inside = whole.values() if isinstance(whole, dict) else whole if isinstance(whole, list) else ()
    return [part for part in inside if isinstance(part, dict | list)]
