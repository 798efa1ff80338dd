"""The machine as resolved by the core: links, joints, cylinders and points with their positions.

The core returns it as one text in Rust's debug notation: ``Link { name: "boom" }``, ``Some(1.0)``, ``[0.0, 1.0]``.
Reading the numbers gives the same bits.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TypeAlias

from hydrocrane import _core

Part: TypeAlias = "DescriptionRecord | list[Part] | str | float | bool | None"
_TOKEN = re.compile(r'\s*("(?:[^"\\]|\\.)*"|[A-Za-z_]\w*|-?(?:inf|NaN|[\d.]+(?:e-?\d+)?)|[{}()\[\],:])')
# In texts.
_ESCAPED = re.compile(r"\\(?:u\{(\w+)\}|(.))")
_WORDS: dict[str, Part] = {"true": True, "false": False, "None": None, "inf": float("inf"), "NaN": float("nan")}


@dataclass(frozen=True)
class DescriptionRecord:
    """A structure or a variant: its name and its fields; fields without names are called 0, 1, and so on."""

    kind: str
    fields: dict[str, Part]

    def record(self, name: str) -> DescriptionRecord:
        """A field that is a structure."""
        found = self.fields[name]
        assert isinstance(found, DescriptionRecord), f"{self.kind}.{name}"
        return found

    def records(self, name: str) -> list[DescriptionRecord]:
        """A field that is a list of structures."""
        found = self.fields[name]
        assert isinstance(found, list), f"{self.kind}.{name}"
        return [part for part in found if isinstance(part, DescriptionRecord)]

    def number(self, name: str) -> float:
        """A field that is a number."""
        found = self.fields[name]
        assert isinstance(found, float), f"{self.kind}.{name}"
        return found

    def text(self, name: str) -> str:
        """A field that is a text."""
        found = self.fields[name]
        assert isinstance(found, str), f"{self.kind}.{name}"
        return found

    def direction(self, name: str) -> tuple[float, float, float] | None:
        """A field that is a unit vector (x, y, z), or is not stated."""
        found = self.fields[name]
        if found is None:
            return None
        assert isinstance(found, list), f"{self.kind}.{name}"
        x, y, z = (part for part in found if isinstance(part, float))
        return x, y, z

    def place(self, name: str) -> tuple[float, float]:
        """A field that is a point (x, z), m."""
        (pair,) = pairs([self.fields[name]])
        return pair


def pairs(values: Part) -> list[tuple[float, float]]:
    """A list of points (x, z), m."""
    assert isinstance(values, list)
    found = []
    for value in values:
        assert isinstance(value, list) and len(value) == 2
        x, z = value
        assert isinstance(x, float) and isinstance(z, float)
        found.append((x, z))
    return found


def described(core: _core.Machine) -> DescriptionRecord:
    """The whole machine; `crates/machine/src/model/mod.rs` describes its fields."""
    tokens = _TOKEN.findall(core.resolved)
    found, end = _part(tokens, 0)
    assert isinstance(found, DescriptionRecord) and end == len(tokens)
    return found


def _part(tokens: list[str], at: int) -> tuple[Part, int]:
    """The part that begins at a token, and the begin of the next one."""
    word = tokens[at]
    if word[0] == '"':
        return _ESCAPED.sub(_unescaped, word[1:-1]), at + 1
    if word == "[":
        return _items(tokens, at + 1, "]")
    if word in _WORDS:
        return _WORDS[word], at + 1
    if word[0] in "-0123456789":
        return float(word), at + 1
    if word == "Some":
        inside, end = _items(tokens, at + 2, ")")
        return inside[0], end
    if at + 1 < len(tokens) and tokens[at + 1] == "(":
        items, end = _items(tokens, at + 2, ")")
        return DescriptionRecord(word, {str(i): item for i, item in enumerate(items)}), end
    if at + 1 < len(tokens) and tokens[at + 1] == "{":
        fields: dict[str, Part] = {}
        at += 2
        while tokens[at] != "}":
            name = tokens[at]
            fields[name], at = _part(tokens, at + 2)
            at += tokens[at] == ","
        return DescriptionRecord(word, fields), at + 1
    return DescriptionRecord(word, {}), at + 1


def _items(tokens: list[str], at: int, close: str) -> tuple[list[Part], int]:
    """Parts up to the closing bracket."""
    items = []
    while tokens[at] != close:
        item, at = _part(tokens, at)
        items.append(item)
        at += tokens[at] == ","
    return items, at + 1


def _unescaped(escape: re.Match[str]) -> str:
    """A character that Rust does not print as it is: of control, or a mark at the beginning of a text."""
    if escape[1]:
        return chr(int(escape[1], 16))
    return {"n": "\n", "r": "\r", "t": "\t", "0": "\0"}.get(escape[2], escape[2])
