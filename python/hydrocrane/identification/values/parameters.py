"""The unknowns of a fit, their priors, and values that change with them.  theory: docs/theory/identification/fitting.md

A parameter is a key of the machine file, ``friction.lift.coulomb[0]``, or an error of the sensor of a logged signal:
``cylinder.lift.p1.zero`` (in the signal's unit), ``.span`` (a share of the reading) or ``.delay`` (s). Other keys may
be tied to it. Break-away friction is the usual case: a fit of the Coulomb force alone does not change it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

import numpy as np

from hydrocrane import _core
from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import HydrocraneError, InputError, check_known
from hydrocrane.identification.sensors import UNIFORM, ZERO, data_sheets
from hydrocrane.identification.solve import Unknown
from hydrocrane.machine.machine import Machine

# Standard deviation of a value's prior as a share of the value, by its provenance class in the machine file.
SHARES = {"measured": 0.02, "setting": 0.05, "fitted": 0.1, "literature": 0.2, "assumed": 1.0}
# Range in which the bounds of a key are searched, in standard deviations, and the resolution of the search.
FARTHEST, HALVINGS = 10.0, 30
# The same for a value that was given in the call, which is a guess.
GUESSED = 1.0
# Default standard deviation of a delay, and its bound, s.
DELAY, LONGEST_DELAY = 0.02, 0.5
ERRORS = ("zero", "span", "delay")

# A standard deviation; a mean and a standard deviation; None for no prior at all.
Prior: TypeAlias = "float | tuple[float, float] | None"
Priors: TypeAlias = "Mapping[str, Prior]"


@dataclass(frozen=True)
class SensorError:
    """An error of the sensor of a signal: ``reading = (1 + span) signal(t - delay) + zero``.

    The kind ``start`` is the error of the start value that was read from a log: a zero of that `log` alone.
    """

    signal: str
    kind: str
    log: int | None = None

    @property
    def name(self) -> str:
        return f"{self.signal}.{self.kind}" + ("" if self.log is None else f"[{self.log}]")


def sensor_error(name: str, signals: Sequence[str]) -> SensorError | None:
    """The sensor error of that name; None if it is a key of the machine file."""
    signal, _, kind = name.rpartition(".")
    return SensorError(signal, kind) if kind in ERRORS and signal in signals else None


def key_value(machine: Machine, key: str) -> float:
    """Value of a key, or one value of a pair, SI."""
    path, _, element = key.partition("[")
    values = np.atleast_1d(real_array(machine.value(path).si, path))
    if element not in ("", "0]", "1]") or (element and values.size < 2):
        raise InputError(
            f"`{key}` is not a value of the machine file; the values of a pair are `{path}[0]` and `{path}[1]`"
        )
    if not element and np.ptp(values) > 0.0:
        raise InputError(f"`{path}` holds two values: name one of them, `{path}[0]` or `{path}[1]`")
    return float(values[1 if element == "1]" else 0])


def unknown_key(machine: Machine, key: str, priors: Priors, alone: bool, along: Mapping[str, float]) -> Unknown:
    """A key of the machine file as an unknown, with a prior by the provenance of its value unless one is given.

    Its bounds are those of the file. If it is not `alone`, another unknown of its table may move these bounds, and only
    its sign bounds it. `along` are keys that change with it, by their ratio to it.
    """
    path = key.partition("[")[0]
    value, known = key_value(machine, key), machine.value(path)
    values = np.atleast_1d(real_array(known.si, path))
    guessed = known.source == "override"
    share = GUESSED if guessed else SHARES.get(known.provenance, GUESSED)
    deviation = share * (abs(value) if values.size < 2 or signed(path) is False else float(np.linalg.norm(values)))
    if key not in priors and deviation == 0.0:
        raise InputError(
            f"`{key}` is zero, so a relative prior is impossible; give its standard deviation with "
            f"priors={{{key!r}: ...}} in {known.unit or 'its unit'}"
        )
    prior = _prior(key, value, priors.get(key, deviation))
    start = value if prior is None or key not in priors else prior[0]
    scale = prior[1] if prior is not None else (0.2 * abs(value) or 1.0)
    low, high = (-np.inf, np.inf) if signed(path) else (0.0, np.inf)
    if alone:
        together = {key: 1.0, **along}
        low = max(low, _end(machine, together, start, max(start - FARTHEST * scale, low)))
        high = min(high, _end(machine, together, start, start + FARTHEST * scale))
    return Unknown(key, start, scale, prior, (low, high))


def _end(machine: Machine, together: Mapping[str, float], start: float, far: float) -> float:
    """Bound of a value, times each key's ratio, between `start` and `far`; infinity if `far` is allowed."""
    if _allowed(machine, together, far):
        return float(np.copysign(np.inf, far - start))
    good = start
    for _ in range(HALVINGS):
        middle = 0.5 * (good + far)
        good, far = (middle, far) if _allowed(machine, together, middle) else (good, middle)
    return good


def _allowed(machine: Machine, together: Mapping[str, float], value: float) -> bool:
    try:
        machine.changed(machine.overrides_at(list(together), [ratio * value for ratio in together.values()]))
    except HydrocraneError:
        return False
    return True


def unknown_error(machine: Machine, error: SensorError, spread: float, priors: Priors) -> Unknown:
    """A sensor error as an unknown; `spread` is the range of the signal, in its unit."""
    deviation = _stated_error(machine, error)
    if error.kind == "delay":
        deviation = DELAY
    given = priors.get(error.name, deviation)
    prior = _prior(error.name, 0.0, given)
    rough = {"zero": 0.1 * spread, "span": 0.1, "delay": DELAY}[error.kind]
    bounds = (-LONGEST_DELAY, LONGEST_DELAY) if error.kind == "delay" else (-np.inf, np.inf)
    start = prior[0] if prior is not None else 0.0
    return Unknown(error.name, start, prior[1] if prior is not None else max(rough, 1e-12), prior, bounds)


def unknown_start(signal: str, log: int, deviation: float) -> tuple[SensorError, Unknown]:
    """The error of a start value that was read with this standard deviation."""
    error = SensorError(signal, "start", log)
    return error, Unknown(error.name, 0.0, deviation, (0.0, deviation))


def stated_errors(machine: Machine, signals: Sequence[str]) -> list[SensorError]:
    """Zero and span of the signals whose sensors state an accuracy in the machine file."""
    return [
        error
        for signal in signals
        for error in (SensorError(signal, "zero"), SensorError(signal, "span"))
        if _stated_error(machine, error)
    ]


def check_names(names: Sequence[str], priors: Priors) -> None:
    """Refuse parameters named twice, and priors of parameters that are not fitted."""
    if isinstance(names, str) or not names or not all(isinstance(name, str) for name in names):
        raise InputError(f'parameters must be a list of keys, such as ["payload.mass"]; got {names!r}')
    for name in names:
        if list(names).count(name) > 1:
            raise InputError(f"`{name}` is named twice among the parameters; name each once")
    for name in priors:
        check_known("parameter with a prior", name, names)


def _stated_error(machine: Machine, error: SensorError) -> float | None:
    """Standard deviation of a sensor's zero or span by its data sheet; None where the file states no accuracy."""
    for sheet in data_sheets(machine, error.signal):
        if {"accuracy", "range"} <= set(sheet):
            accuracy = sheet["accuracy"]
            return {"zero": ZERO * accuracy * sheet["range"], "span": UNIFORM * accuracy}.get(error.kind)
    return None


def _prior(name: str, value: float, given: Prior) -> tuple[float, float] | None:
    if given is None:
        return None
    numbers = np.atleast_1d(real_array(given, f"the prior of `{name}`"))
    mean, deviation = (value, numbers[0]) if numbers.size == 1 else (numbers[0], numbers[-1])
    if numbers.size > 2 or not np.isfinite(numbers).all() or not deviation > 0.0:
        raise InputError(f"the prior of `{name}` is a deviation above zero, or (mean, deviation), in SI; got {given!r}")
    return float(mean), float(deviation)


def signed(path: str) -> bool:
    """Whether a key of machine files may be negative."""
    return next((sign for pattern, sign in _declared() if pattern.fullmatch(path)), True)


@lru_cache(maxsize=1)
def _declared() -> list[tuple[re.Pattern[str], bool]]:
    """Every declared key as a pattern, and whether its values may be negative."""
    rows = json.loads(_core.key_list("machine"))
    named = [(re.sub(r"<[^>]+>", "*", row["path"]), row["sign"] == "any") for row in rows]
    return [(re.compile(re.escape(path).replace(r"\*", r"[^.]+")), any_sign) for path, any_sign in named]


# The leading parameter of each tied key.
Ties: TypeAlias = Mapping[str, str]
# Change of the ratio of break-away to Coulomb friction above which a warning is given.
SHIFT = 0.1


@dataclass(frozen=True)
class Tie:
    """A key that is `ratio` times a fitted one, its `leader`."""

    key: str
    leader: str
    ratio: float


def ties_of(machine: Machine, ties: Ties, parameters: Sequence[str]) -> tuple[Tie, ...]:
    """The ties between keys of a machine, with the ratios of its file."""
    if not isinstance(ties, Mapping) or not all(isinstance(name, str) for pair in ties.items() for name in pair):
        raise InputError(
            f'ties are pairs of keys, such as {{"friction.lift.breakaway": "friction.lift.coulomb"}}; got {ties!r}'
        )
    found: list[Tie] = []
    for key, leader in ties.items():
        check_known(f"parameter that `{key}` is tied to", leader, parameters)
        other = next((name for name in (*parameters, *(tie.key for tie in found)) if _overlap(name, key)), None)
        if other is not None:
            raise InputError(f"`{key}` is tied to `{leader}`, and `{other}` among the parameters or ties moves it too")
        value, head = key_value(machine, key), key_value(machine, leader)
        if head == 0.0 or value == 0.0:
            zero = leader if head == 0.0 else key
            raise InputError(f"`{key}` cannot move in proportion to `{leader}`: `{zero}` is zero; fit both")
        found.append(Tie(key, leader, value / head))
    return tuple(found)


def _overlap(one: str, other: str) -> bool:
    """Whether two keys name the same value, or one names both values of a pair."""
    (path, _, element), (path_2, _, element_2) = one.partition("["), other.partition("[")
    return path == path_2 and (element == element_2 or not element or not element_2)


def tie_matrix(ties: Sequence[Tie], keys: Sequence[str], others: int) -> Array | None:
    """From values of the `keys` and of the `others` to those of the keys, of the ties and of the others; None without
    ties."""
    if not ties:
        return None
    rows = np.zeros((len(ties), len(keys) + others))
    for row, tie in zip(rows, ties, strict=True):
        row[list(keys).index(tie.leader)] = tie.ratio
    own = np.eye(len(keys) + others)
    return np.concatenate([own[: len(keys)], rows, own[len(keys) :]])


def left_behind(before: Machine, after: Machine, keys: Sequence[str], ties: Sequence[Tie]) -> Iterator[str]:
    """Warnings on break-away friction that was constant while the Coulomb friction changed."""
    moved = (*keys, *(tie.key for tie in ties))
    for key in keys:
        partner = key.replace(".coulomb", ".breakaway")
        if not (key.startswith("friction.") and partner != key) or any(_overlap(partner, name) for name in moved):
            continue
        coulomb = key_value(before, key), key_value(after, key)
        if abs(coulomb[1] - coulomb[0]) > SHIFT * abs(coulomb[0]):
            yield (
                f"`{partner}` is unchanged while `{key}` went from {coulomb[0]:.4g} to {coulomb[1]:.4g} N, so their "
                f"ratio has changed; fit both, or tie them with ties={{{partner!r}: {key!r}}}"
            )
