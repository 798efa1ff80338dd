"""Runs the cases of a study, block by block, independent of their distribution and storage."""

from __future__ import annotations

import copy
import dataclasses
import hashlib
import math
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import xarray as xr

from hydrocrane import _core
from hydrocrane.arrays import Array
from hydrocrane.errors import HydrocraneError, InputError, translated
from hydrocrane.machine.keys import Key
from hydrocrane.machine.machine import Machine
from hydrocrane.machine.overrides import Override, plain_overrides
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.simulation.running import integrate
from hydrocrane.studies.keys import changed_plan
from hydrocrane.studies.measures import OF_ANY_RUN, CaseRecord, Measure, WrongMeasure, measured

# Outcomes of cases beyond those of runs.
INVALID, MEASURE_FAILED, CRASHED = "invalid-input", "measure-failed", "crashed"
KILLED, TIME_LIMIT, INTERRUPTED = "killed", "time-limit", "interrupted"
FAILED = (INVALID, MEASURE_FAILED, CRASHED, KILLED, TIME_LIMIT)
# Times closer than this are equal, s.
SAME_TIME = 1e-9


class Abandoned(Exception):
    """A block was stopped before its last case."""


@dataclass(frozen=True)
class CaseResult:
    """Stored result of a case: outcome, figures by name, signals (n_signals, n_times) or None."""

    outcome: str
    message: str
    figures: dict[str, float] = field(default_factory=dict)
    signals: Array | None = None


@dataclass(frozen=True)
class BlockTask:
    """The cases of a block.

    Attributes
    ----------
    values : list of tuple
        Values of the keys, a tuple per case.
    numbers : list of int
        Numbers of the cases in the study.
    given : dict
        Results, by number, of cases that are not run.
    """

    values: list[tuple[Override, ...]]
    numbers: list[int]
    given: dict[int, CaseResult] = field(default_factory=dict)


class Watch:
    """What a worker asks and tells while it computes its cases; this one has nobody to ask or tell."""

    def begin(self, case: int) -> None:
        """The case of this number begins."""

    def end(self) -> None:
        """It has ended."""

    def stopped(self) -> bool:
        """Whether the block is no longer wanted."""
        return False


@dataclass(frozen=True)
class BlockResult:
    """Stored results of the cases of a block, in their order.

    Attributes
    ----------
    outcomes, messages : list of str
    figures : dict
        Name to (n_cases,) values, NaN for a case without a value.
    signals : (n_signals, n_cases, n_times) array
    """

    outcomes: list[str]
    messages: list[str]
    figures: dict[str, Array]
    signals: Array


@dataclass(frozen=True)
class Job:
    """All data of a study for a worker, except the values of its cases.

    Attributes
    ----------
    plan : Scenario
    keys : tuple of Key
    measures : tuple of Measure
    signals : tuple of str
    times : (n_times,) array
        Times of the stored signals, s.
    ledger : bool
        Whether the energy ledger is integrated too, for your own functions.
    digest : str
        Digest of the machine with the plan's overrides; a worker with another machine is refused.
    taken : tuple of str
        Names in the result that no figure may have.
    limit : float or None
        Longest time that a case may take, s.
    """

    plan: Scenario
    keys: tuple[Key, ...]
    measures: tuple[Measure, ...]
    signals: tuple[str, ...]
    times: Array
    ledger: bool
    digest: str
    taken: tuple[str, ...]
    limit: float | None = None

    def __getstate__(self) -> dict[str, object]:
        # Objects made from the machine file are not sent.
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}

    @cached_property
    def base(self) -> _core.Machine:
        """The machine of the plan; its file is read once."""
        with translated():
            core = _core.load_machine(self.plan.machine, list(self.plan.machine_overrides.items()))
        if digest_of(core) != self.digest:
            raise InputError(f"the machine {self.plan.machine} has changed since the study began, or differs here")
        return core

    @cached_property
    def _recent(self) -> threading.local:
        """The last machine of each thread, and its last recorded times with what they follow from."""
        return threading.local()

    def grid(self, plan: Scenario) -> tuple[Array, np.ndarray]:
        """The :func:`recorded_times` of one case; consecutive cases of the same length share them."""
        asked = plan.duration, plan.record_interval
        recent: tuple[tuple[float, float], tuple[Array, np.ndarray]] | None = getattr(self._recent, "grid", None)
        if recent is None or recent[0] != asked:
            self._recent.grid = recent = asked, recorded_times(plan, self.times)
        return recent[1]

    def machine(self, plan: Scenario) -> Machine:
        """The machine of one case; consecutive cases with the same machine keys share it."""
        overrides = plain_overrides(plan.machine_overrides)
        recent: Machine | None = getattr(self._recent, "machine", None)
        if recent is not None and recent.overrides == overrides:
            return recent
        with translated():
            machine = Machine(self.base.rebuilt(list(overrides.items())), plan.machine, overrides)
        self._recent.machine = machine
        return machine


def digest_of(core: _core.Machine) -> str:
    """A digest that distinguishes machines."""
    return hashlib.sha256(core.resolved.encode()).hexdigest()


def run_block(job: Job, task: BlockTask, watch: Watch | None = None) -> BlockResult:
    """Run the cases of a block, one after the other.

    Raises
    ------
    Abandoned
        If `watch` says so before the last case is done.
    """
    watch = watch or Watch()
    # A different machine is an error of the whole study, not of its first case.
    _ = job.base
    # With its first array xarray loads libraries, for up to seconds: no part of the time that a case may take.
    xr.Variable((), 0.0)
    signals = np.full((len(job.signals), len(task.values), job.times.size), np.nan)
    results = []
    for i, (number, values) in enumerate(zip(task.numbers, task.values, strict=True)):
        watch.begin(number)
        result = task.given.get(number) or run_case(job, values, watch)
        watch.end()
        if watch.stopped():
            raise Abandoned
        if result.signals is not None:
            signals[:, i] = result.signals
        # The signals are most of the memory of a block, so there is only one copy.
        results.append(dataclasses.replace(result, signals=None))
    names = dict.fromkeys(name for result in results for name in result.figures)
    figures = {name: np.array([result.figures.get(name, np.nan) for result in results]) for name in names}
    return BlockResult([r.outcome for r in results], [r.message for r in results], figures, signals)


def run_case(job: Job, values: Sequence[Override], watch: Watch) -> CaseResult:
    """Run one case; an error in it becomes its outcome."""
    until = math.inf if job.limit is None else time.monotonic() + job.limit
    try:
        record = _simulated(job, values, lambda: watch.stopped() or time.monotonic() > until)
        if record.outcome.kind == INTERRUPTED and time.monotonic() > until:
            return too_long(job, f"it had reached {record.outcome.time:.4g} s of the run")
        result = _kept(job, record)
        late = time.monotonic() > until
        return too_long(job, "its run was complete, its measures were not") if late else result
    except WrongMeasure:
        # An error of the whole study.
        raise
    except HydrocraneError as error:
        return CaseResult(INVALID, str(error))
    except (KeyboardInterrupt, SystemExit, GeneratorExit):
        raise
    except BaseException as error:
        return CaseResult(CRASHED, f"{type(error).__name__}: {error}")


def too_long(job: Job, reached: str) -> CaseResult:
    """The result of a case that took longer than the study allows."""
    return CaseResult(TIME_LIMIT, f"took longer than the limit of {job.limit:g} s; {reached}; give a longer limit")


def _simulated(job: Job, values: Sequence[Override], should_stop: Callable[[], bool]) -> CaseRecord:
    plan = changed_plan(job.plan, job.keys, values)
    if not isinstance(plan.driver, str | None):
        # Your own controller may have states, so each run has a copy.
        plan = plan.changed(controller=copy.deepcopy(plan.controller))
    machine = job.machine(plan)
    payload = machine.payload(plan.payload)
    record, _ = job.grid(plan)
    recorded = integrate(machine, plan, ledger=job.ledger, record=record, should_stop=should_stop)
    return CaseRecord(machine, plan, recorded, payload)


def _kept(job: Job, record: CaseRecord) -> CaseResult:
    outcome = record.outcome
    doubts = "; ".join(f"warning: {warning.text}" for warning in record.warnings)
    message = doubts if outcome.completed else outcome.message
    signals = _signals(job, record) if job.signals else None
    try:
        figures = measured(job.measures, record, job.taken)
        return CaseResult(outcome.kind, message, figures, signals)
    except WrongMeasure:
        raise
    except Exception as error:
        figures = {OF_ANY_RUN: outcome.time}
        return CaseResult(MEASURE_FAILED, f"{type(error).__name__}: {error}", figures, signals)


def recorded_times(plan: Scenario, wanted: Array) -> tuple[Array, np.ndarray]:
    """Recorded times that include the `wanted` ones up to the end of the run, and the indices of these."""
    own = plan.record_times()
    wanted = wanted[wanted <= own[-1] + SAME_TIME]
    near = np.clip(np.searchsorted(own, wanted - SAME_TIME), 0, own.size - 1)
    missing = wanted[np.abs(own[near] - wanted) > SAME_TIME]
    times = np.sort(np.concatenate([own, missing])) if missing.size else own
    return times, np.searchsorted(times, wanted - SAME_TIME)


def _signals(job: Job, record: CaseRecord) -> Array:
    """(n_signals, n_times), NaN after the end of the run, and for a signal that a machine does not have."""
    times, places = job.grid(record.plan)
    # A run that ended early has its last state after the requested times.
    done = min(record.time.size, times.size)
    reached = int(np.count_nonzero(record.time[:done] == times[:done]))
    places = places[places < reached]
    table = np.full((len(job.signals), job.times.size), np.nan)
    for row, name in zip(table, job.signals, strict=True):
        try:
            row[: places.size] = record.signal(name)[places]
        except InputError:
            continue
    return table
