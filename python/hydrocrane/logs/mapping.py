"""Which column of a log is which signal, in which unit, and with which sign: the mapping file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TypeAlias, TypeVar

from hydrocrane import _core
from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, nearest
from hydrocrane.files.toml_file import read_toml
from hydrocrane.logs.signals import PRESSURES, SIGNALS
from hydrocrane.logs.table import AS_FOUND, LogForm

T = TypeVar("T")
_SIGNAL_KEYS = ("column", "unit", "sign", "offset", "time", "file")
_TIME_KEYS = ("column", "unit", "sample-rate", "date-order", "file")


@dataclass(frozen=True)
class Source:
    """Where a signal comes from: ``sign * unit * column + offset``.

    Parameters
    ----------
    column : str or int
        Name of the column in the file, or its number counted from 1; of times empty for the usual one.
    unit : str, optional
        Unit of the column's numbers; ``"40 bar"`` where one of them means 40 bar. By default what the file states.
    sign : {1, -1}
    offset : str
        Added after unit and sign, with its unit, for example ``"-625 mm"``.
    time : str, optional
        Name of the column of its times, if it has other times than the rest; both clocks must be the same.
    file : str, optional
        Name, or pattern, of the file in the log's folder that has the column, if it is another one than the log.
    """

    column: str | int
    unit: str | None = None
    sign: int = 1
    offset: str | None = None
    time: str | None = None
    file: str | None = None


@dataclass(frozen=True)
class LogMapping:
    """The mapping of a whole log; made from TOML or a mapping by :func:`log_mapping`.

    `sample_rate` in Hz stands in for a time column. `form` says how a text writes numbers and dates.
    """

    signals: Mapping[str, Source] = field(default_factory=dict)
    time: Source | None = None
    sample_rate: float | None = None
    origin: str = "the mapping"
    form: LogForm = AS_FOUND

    @property
    def files(self) -> bool:
        """Whether it names files."""
        return any(source.file is not None for source in (*self.signals.values(), *([self.time] if self.time else [])))


# A path to a TOML file, its content, or a LogMapping.
MappingLike: TypeAlias = "str | PathLike[str] | Mapping[str, object] | LogMapping | None"


def log_mapping(given: MappingLike) -> LogMapping | None:
    """A mapping from a path to a TOML file, from its content as a ``dict``, or an empty one."""
    if given is None or isinstance(given, LogMapping):
        return given
    if isinstance(given, Mapping):
        return _from_content(given, "the mapping")
    if not isinstance(given, str | PathLike):
        raise InputError(f"a mapping is a path to a TOML file or a dict with `time` and `signal`; got {given!r}")
    path = Path(given)
    return _from_content(read_toml(path, "mapping file"), str(path))


def _from_content(content: Mapping[str, object], origin: str) -> LogMapping:
    _only(content, ("time", "signal", "number-format"), origin)
    signals = _mapping(content.get("signal", {}), f"{origin}: [signal]")
    time = _mapping(content.get("time", {}), f"{origin}: [time]")
    _only(time, _TIME_KEYS, f"{origin}: [time]")
    if "sample-rate" in time and "column" in time:
        raise InputError(f"{origin}: [time] has both `column` and `sample-rate`; keep one")
    if "sample-rate" in time and any(isinstance(entry, Mapping) and "file" in entry for entry in signals.values()):
        raise InputError(f"{origin}: [time] has `sample-rate`, and signals have `file`; several files need clocks")
    rate = _rate(time["sample-rate"], f"{origin}: [time] sample-rate") if "sample-rate" in time else None
    sources = {}
    for name, entry in signals.items():
        where = f"{origin}: [signal.{name}]"
        table = _mapping(entry, where)
        _only(table, _SIGNAL_KEYS, where)
        sources[name] = _source(table, name, where)
    stated = {"column": "", **{key: time[key] for key in ("column", "unit", "file") if key in time}}
    clock = _source(stated, "time", f"{origin}: [time]") if len(stated) > 1 or stated["column"] else None
    form = LogForm.of(content.get("number-format"), time.get("date-order"), origin)
    return LogMapping(sources, clock, rate, origin, form)


def _mapping(value: object, where: str) -> Mapping[str, object]:
    if not isinstance(value, Mapping):
        raise InputError(f'{where} must be a table of keys, for example column = "Length_3"; got {value!r}')
    return value


def _only(content: Mapping[str, object], keys: tuple[str, ...], where: str) -> None:
    for key in content:
        if key not in keys:
            raise InputError(f"{where} has an unknown key `{key}`{nearest(str(key), keys)}")


def _source(entry: Mapping[str, object], name: str, where: str) -> Source:
    column = entry.get("column", name)
    if isinstance(column, bool) or not isinstance(column, str | int):
        raise InputError(f"{where} column must be a name or a number counted from 1; got {column!r}")
    sign = entry.get("sign", 1)
    if not isinstance(sign, int | float) or isinstance(sign, bool) or sign not in (1, -1):
        raise InputError(f"{where} sign must be 1 or -1; got {sign!r}")
    unit, offset = entry.get("unit"), entry.get("offset")
    if unit is not None:
        unit = _text(unit, f"{where} unit")
        _asked(f"{where} unit", _core.log_unit, unit, name, expected_units(name))
    if offset is not None:
        offset = _text(offset, f"{where} offset")
        _asked(f"{where} offset", _core.log_unit, offset, name, expected_units(name))
    own, file = (_name(entry.get(key), f"{where} {key}") for key in ("time", "file"))
    return Source(column, unit, int(sign), offset, own, file)


def _rate(text: object, where: str) -> float:
    rate, dimension = _asked(where, _core.quantity, _text(text, where))
    one, hertz = _core.quantity("1 Hz")
    if dimension != hertz or rate <= 0:
        raise InputError(f'{where} must be a positive frequency, for example "1 kHz"; got "{text}"')
    return rate / one


def _asked(where: str, ask: Callable[..., T], *given: object) -> T:
    """The answer of the core, or its refusal."""
    try:
        return ask(*given)
    except ValueError as error:
        raise InputError(f"{where}: {error}") from None


def _name(text: object, where: str) -> str | None:
    if text is not None and not isinstance(text, str):
        raise InputError(f"{where} must be a name; got {text!r}")
    return text


def _text(text: object, where: str) -> str:
    if not isinstance(text, str):
        raise InputError(f'{where} must be text with a unit, for example "1 mm"; got {text!r}')
    return text


def expected_units(name: str) -> tuple[str, ...]:
    """SI units that a signal may have; empty if any is allowed."""
    if name == "time":
        return ("s",)
    return SIGNALS[name].units if name in SIGNALS else ()


def si_values(
    values: Array, source: Source, stated: str, name: str, where: str, expected: tuple[str, ...] | None = None
) -> tuple[Array, str]:
    """A column as the signal `name` in SI, and the SI unit it then has.

    `stated` is the unit in the file; it counts if the source names none. `expected` are the SI units that the signal
    may have, by default those of its name. Pressures of the rig, and those that must be in Pa, are gauge: an absolute
    reading loses the standard atmosphere.
    """
    unit = source.unit if source.unit is not None else stated
    allowed = expected_units(name) if expected is None else expected
    if unit:
        _asked(f"{where} unit", _core.log_unit, unit, name, allowed)
    given = source.offset
    offset = 0.0 if given is None else _asked(f"{where} offset", _core.log_unit, given, name, allowed)[0]
    values = _asked(f"{where} unit", _core.in_si, values, unit, is_gauge(name, expected))
    si = si_unit(unit) if unit else (allowed or ("",))[0]
    return (values if (source.sign, offset) == (1, 0.0) else source.sign * values + offset), si


def is_gauge(name: str, expected: tuple[str, ...] | None) -> bool:
    """Whether a pressure is relative to the air."""
    return name in PRESSURES or expected == ("Pa",)


def si_unit(unit: str) -> str:
    """The SI unit of a unit's dimension, by its own name if it has one."""
    _, dimension, *_ = _core.log_unit(unit)
    named = ("Pa", "N", "m", "s", "m/s", "m/s^2", "V", "A", "W", "J", "rad", "rad/s", "m^3/s", "kg", "K")
    if dimension == _core.quantity("1")[1]:
        return "1"
    return next((name for name in named if _core.quantity(f"1 {name}")[1] == dimension), dimension)
