"""Units of data loggers: those of machine files, inches and pounds, gauge and absolute pressure, degrees."""

from __future__ import annotations

import math
import re
from functools import cache
from typing import NamedTuple

from hydrocrane import _core
from hydrocrane.arrays import Array

# Standard atmosphere, Pa: difference of absolute and gauge pressure if no other is stated.
ATMOSPHERE = 101325.0
# Least SI value of one unit of a log; its inverse is the greatest. Beyond these bounds its numbers lose precision.
LEAST_UNIT = 1e-30
# The dimension of times.
SECOND = _core.quantity("1 s")[1]
# Units that loggers and machine files write differently.
_SPELLINGS = {
    "sec": "s",
    "seconds": "s",
    **dict.fromkeys(("d", "day", "days"), "86400 s"),
    "hours": "h",
    "minutes": "min",
    "milliseconds": "ms",
    "microseconds": "1e-6 s",
    "nanoseconds": "1e-9 s",
    "us": "1e-6 s",
    "°": "deg",
    "degrees": "deg",
    "μm": "um",
    "Nm": "N m",
    "Bar": "bar",
    "BAR": "bar",
    "PSI": "psi",
    '"': "in",
    "ips": "in/s",
    "lpm": "l/min",
    # The US gallon is 231 cubic inches.
    "gpm": "3.785411784 l/min",
    "-": "",
    "counts": "",
}
# Symbols that machine files do not have, with the value of one. Inch, pound and gravity are exact by definition.
_SYMBOLS = {
    "in": (0.0254, "m"),
    "inch": (0.0254, "m"),
    "inches": (0.0254, "m"),
    "ft": (0.3048, "m"),
    "lbf": (0.45359237 * 9.80665, "N"),
    "lb": (0.45359237 * 9.80665, "N"),
    "lbs": (0.45359237 * 9.80665, "N"),
    "lbm": (0.45359237, "kg"),
    "kgf": (9.80665, "N"),
    "kp": (9.80665, "N"),
    "mA": (1e-3, "A"),
    "uA": (1e-6, "A"),
    "L": (1.0, "l"),
    "rpm": (2.0 * math.pi / 60.0, "rad/s"),
}
_SYMBOL = re.compile(r"(?P<over>/\s*)?(?P<symbol>[^\W\d_²³]+)(?:\^(?P<power>-?\d+)|(?P<raised>[²³]))?")
_NUMBER = re.compile(r"^[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_PRESSURE = re.compile(r"^(?P<unit>psi|bar|mbar|[kM]?Pa)[\s_(\[]*(?P<from>gauge|g|absolute|abs|a)[)\]]?$")
# Size of a degree in K, and zero in K.
_DEGREES = {"degC": (1.0, 273.15), "degF": (5.0 / 9.0, 273.15 - 32.0 * 5.0 / 9.0)}
_DEGREE_SPELLINGS = {"°C": "degC", "ºC": "degC", "deg C": "degC", "°F": "degF", "ºF": "degF", "deg F": "degF"}


class LogUnit(NamedTuple):
    """A unit of a log.

    Attributes
    ----------
    factor : float
        SI value of one of it.
    dimension : str
        In base units, as ``hydrocrane._core.quantity`` names it.
    zero : float
        SI value of the reading 0: 273.15 K for degC; 0 for every other unit.
    absolute : bool
        Whether it is a pressure relative to vacuum.
    """

    factor: float
    dimension: str
    zero: float = 0.0
    absolute: bool = False


def tidy_unit(text: str) -> str:
    """A logger's unit in the spelling of this package, without brackets."""
    bare = text.strip()
    if bare[:1] + bare[-1:] in ("[]", "()"):
        bare = bare[1:-1].strip()
    # NetCDF has times as "seconds since 2024-05-01".
    bare = bare.split(" since ")[0]
    return _SPELLINGS.get(bare, bare)


@cache
def log_unit(text: str) -> LogUnit:
    """The unit that a log or a mapping states, ``"psig"``, ``"in/s"``, ``"40 bar"``.

    Raises
    ------
    ValueError
        If it is no unit; the message names the nearest one.
    """
    text = _SPELLINGS.get(text.strip(), text.strip())
    found = _NUMBER.match(text)
    number, rest = (float(found[0]), text[found.end() :].strip()) if found else (1.0, text)
    bare = _SPELLINGS.get(rest, rest)
    bare = _DEGREE_SPELLINGS.get(bare, bare)
    if bare in _DEGREES:
        size, zero = _DEGREES[bare]
        return LogUnit(number * size, _core.quantity("1 K")[1], zero)
    reference = _PRESSURE.match(bare)
    if reference:
        bare = reference["unit"]
    factor, translated = _translated(bare)
    si, dimension = _core.quantity(f"{found[0] if found else '1'} {translated}".strip())
    return LogUnit(si * factor, dimension, absolute=bool(reference and reference["from"].startswith("a")))


def known_unit(text: str) -> bool:
    """Whether `text` is a unit that :func:`log_unit` reads."""
    try:
        log_unit(text)
    except ValueError:
        return False
    return True


def is_pounds(text: str) -> bool:
    """Whether a unit is the pound that may mean mass or force; it is read as force."""
    return text.strip() in ("lb", "lbs")


def scaled(values: Array, factor: float) -> Array:
    """`values` times `factor`. If its inverse is a whole number, they are divided by it, which rounds once, as for
    machine files."""
    inverse = round(1.0 / factor) if LEAST_UNIT <= factor < 1.0 else 0
    return values / inverse if inverse and 1.0 / inverse == factor else values * factor


def _translated(unit: str) -> tuple[float, str]:
    """A unit without the symbols that machine files do not have, and the factor of these."""
    factor = 1.0

    def known(found: re.Match[str]) -> str:
        nonlocal factor
        if found["symbol"] not in _SYMBOLS:
            return found[0]
        size, base = _SYMBOLS[found["symbol"]]
        power = int(found["power"] or {"²": 2, "³": 3}.get(found["raised"], 1))
        factor *= size ** (-power if found["over"] else power)
        raised = f"^{power}" if power != 1 else ""
        return f"{found['over'] or ''}({base}){raised}"

    translated = _SYMBOL.sub(known, unit)
    return factor, translated
