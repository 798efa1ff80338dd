"""A fitted map as the block of a machine file."""

from __future__ import annotations

import datetime
import json
import re
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from hydrocrane.errors import InputError
from hydrocrane.identification.points import DIRECTIONS
from hydrocrane.identification.static_map import PARAMETERS, unit_of

if TYPE_CHECKING:
    from hydrocrane.identification.result import StaticFit


def friction_block(
    fit: StaticFit,
    cylinder: str,
    *,
    name: str | None = None,
    source: Iterable[str] = (),
    date: str = "",
    bristles: Iterable[str] = (),
) -> str:
    """``[friction.<name>]`` with class ``fitted``; parameters that were held are ``assumed`` and say so.

    Parameters
    ----------
    cylinder : str
        The cylinder it belongs to; also the table's name unless `name` is given.
    source : iterable of str
        Names of the logs; by default those the points came from.
    date : str
        Day of the fit, by default today.
    bristles : iterable of str
        Lines of the bristles' values; with any, the model is LuGre's.

    Comments give the 95 % intervals.
    """
    _check(fit)
    added = list(bristles)
    origin = f"{_files(fit, source)}; {fit.method} fit of {int(fit.accepted.sum())} points, {signature(date)}"
    lines = head(name or cylinder, cylinder, origin, "lugre" if added else "static")
    # Exponents are rounded first, because the unit of the viscous coefficient carries them.
    powers = [float(f"{p:.4g}") for p in fit.params["viscous-exponent"]]
    return "\n".join([*lines, *(_line(fit, key, powers) for key in PARAMETERS), *added]) + "\n"


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


def _check(fit: StaticFit) -> None:
    """A machine file needs finite numbers in both directions."""
    values = fit.law.values.reshape(-1, 2)
    for side, name in enumerate(DIRECTIONS):
        if not np.isfinite(values[:, side]).all():
            raise InputError(
                f"no friction {name} was measured, so there is no block for a machine file; "
                f"add logs of the piston {name}"
            )


def _files(fit: StaticFit, source: Iterable[str]) -> str:
    return ", ".join(source) or ", ".join(fit.points.source) or "points handed over in Python"


def _line(fit: StaticFit, key: str, powers: list[float]) -> str:
    shown = []
    for side, direction in enumerate(DIRECTIONS):
        unit = unit_of(f"{key}.{direction}", powers[side])
        value = powers[side] if key == "viscous-exponent" else fit.params[key][side]
        shown.append(f"{value:.4g}" if unit == "1" else f'"{value:.5g} {unit}"')
    pair = f"[{', '.join(shown)}]"
    if fit.spread is not None and not any(label.startswith(f"{key}.") for label in fit.spread.labels):
        return f'{key} = {{ value = {pair}, class = "assumed", source = "held in the fit" }}'
    return f"{key} = {pair}{_comment(fit, key)}"


def _comment(fit: StaticFit, key: str) -> str:
    if fit.spread is None:
        return ""
    known = fit.intervals(0.95)
    ends = [known.get(f"{key}.{direction}") for direction in DIRECTIONS]
    return f"  # 95 %: {' and '.join(interval(*e) for e in ends if e is not None)}"


def interval(low: float, high: float) -> str:
    """An interval as a block's comments show it."""
    return f"{low:.4g} .. {high:.4g}" if np.isfinite(low) else "not told by the data"
