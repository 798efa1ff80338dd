"""Parts of the block of a machine file that a fit writes."""

from __future__ import annotations

import datetime
import json
import re

import numpy as np

from hydrocrane.errors import InputError


def checked_name(name: str) -> str:
    """A name that can head a table of a machine file."""
    if not re.fullmatch(r"[A-Za-z0-9_-]+", name):
        nearest = re.sub(r"[^A-Za-z0-9_-]+", "-", name).strip("-")
        raise InputError(
            f"`{name}` cannot be the name of a table [friction.<name>]: letters, digits, - and _ can"
            + (f"; take `{nearest}`" if nearest else "")
        )
    return name


def head(name: str, cylinder: str, source: str, model: str) -> list[str]:
    """The first lines of the block of a fit."""
    return [
        f"[friction.{checked_name(name)}]",
        'class = "fitted"',
        f"source = {json.dumps(source, ensure_ascii=False)}",
        f"cylinder = {json.dumps(cylinder)}",
        f"model = {json.dumps(model)}",
    ]


def signature(date: str = "") -> str:
    """Who fitted, and on which day; today by default."""
    from hydrocrane import __version__

    return f"hydrocrane {__version__}, {date or datetime.date.today().isoformat()}"


def interval(low: float, high: float) -> str:
    """An interval as a block's comments show it."""
    return f"{low:.4g} .. {high:.4g}" if np.isfinite(low) else "not told by the data"
