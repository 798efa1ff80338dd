"""Numbers and tables as the page of speed writes them."""

from __future__ import annotations

from math import floor, log10
from typing import Any

Results = dict[str, Any]


def digits(value: float, count: int = 3) -> str:
    """A number as a reader needs it: `count` digits, thousands plain."""
    if value == 0:
        return "0"
    places = max(count - 1 - floor(log10(abs(value))), 0)
    return f"{value:.{places}f}"


def table(heads: list[str], rows: list[list[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def lacking(section: Results | None) -> str:
    """Why a section has no numbers; empty if it has some."""
    if section is None:
        return "Not measured."
    return f"Not measured: {section['not_available']}." if "not_available" in section else ""
