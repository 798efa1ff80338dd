"""One run of a study, and the figures of it that are stored.

By name: one of :data:`BUILT_IN`, or a statistic of a signal, ``max(cylinder.lift.p1)``; or a function of a
:class:`hydrocrane.Run` that returns a number or a mapping of names to numbers. A run that ended early has NaN for all
of them except ``end_time``. An exception in a function is the outcome of its case; an answer that is no figure is an
error of the whole study, because no other case would have one either.
"""

from __future__ import annotations

import numbers
import re
import reprlib
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property, lru_cache
from pathlib import PurePosixPath, PureWindowsPath
from typing import TypeAlias

import numpy as np

from hydrocrane.arrays import Array, path_length
from hydrocrane.errors import InputError, check_known, nearest, unknown
from hydrocrane.machine.machine import Machine
from hydrocrane.result_warning import ResultWarning
from hydrocrane.results.dataset import outputs_table, run_dataset
from hydrocrane.results.outcome import Outcome
from hydrocrane.results.recording import Recording
from hydrocrane.results.run import Run
from hydrocrane.scenario.scenario import Scenario

# Its tables take longer than a run of a few seconds.
OIL = "energy.oil"


class CaseRecord:
    """The core's record of a run.

    Attributes
    ----------
    machine : Machine
    plan : Scenario
    outcome : Outcome
    warnings : tuple of ResultWarning
    time : (m,) array
        s.
    """

    def __init__(self, machine: Machine, plan: Scenario, recorded: Recording, payload: float) -> None:
        self.machine, self.plan, self._recorded, self._payload = machine, plan, recorded, payload
        self.outcome: Outcome = recorded.outcome
        self.warnings: tuple[ResultWarning, ...] = recorded.warnings
        self.time: Array = recorded.time

    @property
    def effort(self) -> dict[str, int]:
        """Steps, rejections, evaluations."""
        return self._recorded.effort

    @property
    def states(self) -> Array:
        """(m, n_states)."""
        return self._recorded.states

    def signal(self, name: str) -> Array:
        """A state, output, command or sample by its name, (m,) over :attr:`time`, SI."""
        if name in self._state_columns:
            return np.asarray(self.states[:, self._state_columns[name]])
        output = self.machine.core.output_index(name)
        if output is not None and name != OIL:
            return np.asarray(self._outputs[:, output])
        columns = self.run.columns
        check_known("signal", name, columns)
        return columns[name].values

    def pressures(self) -> Array:
        """(m, 2 n_cyl) chamber pressures, Pa."""
        return np.asarray(self.states[:, _pressure_columns(self.machine.state_names)])

    @cached_property
    def run(self) -> Run:
        """The whole run as a :class:`hydrocrane.Run`."""
        return Run(run_dataset(self.machine, self.plan, self._recorded, payload=self._payload, wall=0.0), self.machine)

    @cached_property
    def _state_columns(self) -> dict[str, int]:
        return _columns(self.machine.state_names)

    @cached_property
    def _outputs(self) -> Array:
        return outputs_table(self.machine, self._recorded, oil=False)


# The cases of a study differ seldom in their states.
@lru_cache(8)
def _columns(names: tuple[str, ...]) -> dict[str, int]:
    return {name: i for i, name in enumerate(names)}


@lru_cache(8)
def _pressure_columns(names: tuple[str, ...]) -> list[int]:
    return [i for i, name in enumerate(names) if name.endswith((".p1", ".p2"))]


STATISTICS: dict[str, Callable[[np.ndarray], float]] = {
    "min": np.min,
    "max": np.max,
    "mean": np.mean,
    "rms": lambda values: np.sqrt(np.mean(np.square(values))),
    "range": np.ptp,
    "start": lambda values: values[0],
    "end": lambda values: values[-1],
}
# A function of a run, and the accepted forms of the measures of a study.
Own: TypeAlias = Callable[[Run], Mapping[str, float] | float]
Measures: TypeAlias = str | Own | Sequence[str | Own] | Mapping[str, Own]
_STATISTIC = re.compile(r"(\w+)\(([^()]+)\)")


def _way(record: CaseRecord) -> float:
    return path_length(record.signal(f"tip.{axis}") for axis in record.machine.tip_axes)


def _pump_energy(record: CaseRecord) -> float:
    time, power = record.time, record.signal("supply.power")
    return float(((time[1:] - time[:-1]) * (power[1:] + power[:-1]) / 2.0).sum())


def _stroke_margin(record: CaseRecord) -> float:
    strokes = np.stack([record.signal(f"cylinder.{name}.x") for name in record.machine.cylinder_names], axis=-1)
    low, high = record.machine.stroke_limits.T
    return float(np.minimum(strokes - low, high - strokes).min())


# Name -> unit, meaning, function.
BUILT_IN: dict[str, tuple[str, str, Callable[[CaseRecord], float]]] = {
    "end_time": ("s", "end time of the run", lambda record: record.outcome.time),
    "tip_way": ("m", "path length of the tip", _way),
    "largest_pressure": ("Pa", "largest pressure of any chamber", lambda record: float(record.pressures().max())),
    "smallest_pressure": ("Pa", "smallest pressure of any chamber", lambda record: float(record.pressures().min())),
    "pump_energy": ("J", "work of the pump, from the recorded power by the trapezoidal rule", _pump_energy),
    "stroke_margin": ("m", "smallest distance of any piston from the end of its stroke", _stroke_margin),
    "steps": ("1", "steps of the integrator", lambda record: float(record.effort["steps"])),
    "rejected": ("1", "rejected steps of the integrator", lambda record: float(record.effort["rejected"])),
}
DEFAULT = ("tip_way", "largest_pressure", "pump_energy")
# The file of a folder of the store that says what is in it.
DESCRIPTION = "zarr.json"
# The measure that every run has and every study stores.
OF_ANY_RUN = "end_time"


def is_unfit(name: str) -> bool:
    """Whether no folder of the study's folder can have this name on some system, or its description has it."""
    apart = {name} != {PurePosixPath(name).name, PureWindowsPath(name).name}
    return apart or name in ("", "..", DESCRIPTION) or not name.isprintable()


@dataclass(frozen=True)
class Measure:
    """A figure of a run.

    Attributes
    ----------
    name : str
    unit, meaning : str
        Empty for your own functions.
    own : callable or None
        Your own function.
    """

    name: str
    unit: str = ""
    meaning: str = ""
    own: Own | None = None

    def of(self, record: CaseRecord) -> dict[str, float]:
        """Name to value, for a complete run."""
        if self.own is not None:
            return self._of_run(self.own(record.run))
        if self.name in BUILT_IN:
            return {self.name: BUILT_IN[self.name][2](record)}
        kind, signal = _parts(self.name)
        return {self.name: float(STATISTICS[kind](record.signal(signal)))}

    def _of_run(self, answer: object) -> dict[str, float]:
        """The figures of an own function's answer."""
        if not isinstance(answer, Mapping):
            return {self.name: self._number(answer, "returned")}
        for name in answer:
            if not isinstance(name, str) or is_unfit(name):
                raise self._refused(
                    f"returned a mapping with the name {name!r}, which is no text, empty, or no name of a folder"
                )
        return {str(name): self._number(value, f"returned for `{name}`") for name, value in answer.items()}

    def _number(self, value: object, returned: str) -> float:
        """A real number, also a scalar of NumPy, xarray and the like."""
        if value is np.ma.masked or (isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value)):
            raise self._refused(f"{returned} a masked value")
        try:
            array = np.asarray(None if isinstance(value, Mapping) else value)
        except (TypeError, ValueError):
            # Lists of lists of different lengths.
            array = np.asarray(None)
        real = isinstance(value, numbers.Real | Decimal) if array.dtype.kind == "O" else array.dtype.kind in "buif"
        if array.ndim or not real:
            shape = f" of shape {array.shape}" if array.ndim else ""
            raise self._refused(f"{returned} {type(value).__name__}{shape}, {reprlib.repr(value)}")
        return float(array)

    def _refused(self, what: str) -> WrongMeasure:
        return WrongMeasure(
            f"measure `{self.name}` {what}; a measure returns one real number, or a mapping of names to such numbers: "
            "take what is wanted of an array, such as its largest value, and float('nan') for no value"
        )


def checked_measures(given: Measures, units: Mapping[str, str]) -> tuple[Measure, ...]:
    """The measures of a study.

    Parameters
    ----------
    given : sequence of str or callable, or mapping of name to callable
    units : mapping
        Signal to unit, for the unchanged machine.
    """
    if isinstance(given, str) or callable(given):
        given = [given]
    if not isinstance(given, Mapping | Sequence):
        raise InputError(f"measures are names or functions of a run, or functions by their names; got {given!r}")
    if isinstance(given, Mapping):
        for name, own in given.items():
            if not callable(own):
                raise InputError(f"measure `{name}` must be a function of a run; got {own!r}")
    named = given.items() if isinstance(given, Mapping) else ()
    found = tuple(Measure(str(name), own=own) for name, own in named) or tuple(_checked(e, units) for e in given)
    names = [measure.name for measure in found]
    for name in names:
        if is_unfit(name):
            raise InputError(
                f"measure {name!r} has a name that is empty, or that no folder of a store can have; rename it"
            )
        if names.count(name) > 1:
            raise InputError(f"measure `{name}` is given twice; name functions by a mapping of name to function")
    return found if OF_ANY_RUN in names else (_checked(OF_ANY_RUN, units), *found)


def _checked(entry: object, units: Mapping[str, str]) -> Measure:
    if callable(entry):
        name = getattr(entry, "__name__", type(entry).__name__)
        return Measure("measure" if name == "<lambda>" else name, own=entry)
    if not isinstance(entry, str):
        raise InputError(f"a measure is a name or a function of a run; got {entry!r}")
    if entry in BUILT_IN:
        return Measure(entry, *BUILT_IN[entry][:2])
    if not _STATISTIC.fullmatch(entry):
        examples = ("max(tip.z)", "end(tip.x)")
        raise InputError(f"unknown measure `{entry}`{nearest(entry, [*BUILT_IN, *examples])}")
    kind, signal = _parts(entry)
    check_known("statistic", kind, STATISTICS)
    check_known("signal", signal, units)
    return Measure(entry, units[signal], f"{kind} of {signal}")


def _parts(name: str) -> tuple[str, str]:
    """``max(tip.z)`` as its statistic and its signal."""
    match = _STATISTIC.fullmatch(name)
    if match is None:
        raise unknown("measure", name, BUILT_IN)
    return match[1], match[2].strip()


class WrongMeasure(InputError):
    """A function returned what is no figure, or by a name that something else in the result has."""


def measured(measures: Sequence[Measure], record: CaseRecord, taken: Container[str]) -> dict[str, float]:
    """All figures of a complete run, or those that any run has; their names are not among the `taken` ones."""
    if not record.outcome.completed:
        return {OF_ANY_RUN: record.outcome.time}
    found: dict[str, float] = {}
    for measure in measures:
        figures = measure.of(record)
        for name in figures:
            if name in found or name in taken:
                raise WrongMeasure(
                    f"measure `{measure.name}` returns `{name}`, which would name two things in the result; rename it"
                )
        found |= figures
    return found
