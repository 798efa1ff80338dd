"""Pieces of a fit as text: the head of a machine file's block, intervals, rows of a table."""

from __future__ import annotations

import datetime
import json
from collections.abc import Callable
from os import PathLike
from pathlib import Path

import numpy as np

from hydrocrane.arrays import checked_name
from hydrocrane.errors import ResultFileError, printable
from hydrocrane.files.toml_file import toml_key
from hydrocrane.files.whole_file import write_text


def comment(text: str) -> str:
    """A line of comment, whatever the names in it hold."""
    return f"# {printable(' '.join(text.splitlines()))}"


def fitted_key(name: str, value: str, source: str, ends: str) -> str:
    """A key with its value in the notation of machine files, where it comes from, and its interval as a comment."""
    stated = json.dumps(source, ensure_ascii=False)
    return f'{name} = {{ value = {value}, class = "fitted", source = {stated} }}  # 95 %: {ends}'


def write_part(path: str | PathLike[str], text: Callable[[str], str]) -> Path:
    """Write a part of a machine file; `text` makes it for the name of the file."""
    target = Path(path)
    if target.suffix != ".toml":
        raise ResultFileError(f"a part of a machine file ends in .toml, unlike `{target.name}`")
    return write_text(target, text(target.name))


def head(name: str, cylinder: str, source: str, model: str) -> list[str]:
    """The first lines of the block of a fit."""
    return [
        f"[friction.{toml_key(checked_name('the name of a friction table', name))}]",
        'class = "fitted"',
        f"source = {json.dumps(source, ensure_ascii=False)}",
        f"cylinder = {json.dumps(cylinder, ensure_ascii=False)}",
        f"model = {json.dumps(model)}",
    ]


def signature(date: str = "") -> str:
    """Program, version and day of the fit; today by default."""
    from hydrocrane import __version__

    return f"hydrocrane {__version__}, {date or datetime.date.today().isoformat()}"


def interval(low: float, high: float) -> str:
    """An interval as a block's comments show it: from zero, the bound of a positive quantity, by its upper end only."""
    if not np.isfinite([low, high]).all():
        return "not identifiable"
    return f"not determined, at most {high:.4g}" if low == 0.0 else f"{low:.4g} .. {high:.4g}"


def shown(value: float, low: float, high: float) -> str:
    """A value beside its interval. Rounding errors of zero, where only a prior or a bound determines a value, are shown
    as zero."""
    return "0" if abs(value) < 1e-6 * max(abs(low), abs(high)) else f"{value:.4g}"


def parameter_row(label: str, unit: str, value: float, low: float, high: float) -> tuple[str, str, str, str, str]:
    """A row of a table: parameter, unit, value, both ends of its interval."""
    if not (np.isfinite(low) and np.isfinite(high)):
        return (label, unit, "-", "not identifiable", "")
    if low == 0.0:
        return (label, unit, "not determined", "0", f"{high:.4g}")
    return (label, unit, shown(value, low, high), f"{low:.4g}", f"{high:.4g}")
