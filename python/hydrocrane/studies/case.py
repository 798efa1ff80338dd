"""Runs the cases of a study, block by block, independent of their distribution and storage."""

from __future__ import annotations

import copy
import dataclasses
import hashlib
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hydrocrane import _core
from hydrocrane.arrays import Array
from hydrocrane.errors import HydrocraneError, InputError, translated
from hydrocrane.machine.keys import Key
from hydrocrane.machine.machine import Machine
from hydrocrane.machine.overrides import Override, plain_overrides
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.simulation.running import integrate
from hydrocrane.studies.changes import changed_plan
from hydrocrane.studies.measures import OF_ANY_RUN, Measure, TakenName, measured
from hydrocrane.studies.record import CaseRecord

# Outcomes of cases beyond those of runs.
INVALID, MEASURE_FAILED, CRASHED = "invalid-input", "measure-failed", "crashed"
FAILED = (INVALID, MEASURE_FAILED, CRASHED)
# Times closer than this are equal, s.
SAME_TIME = 1e-9


class Abandoned(Exception):
    """A block was stopped before its last case."""


@dataclass(frozen=True)
class CaseResult:
    """Stored result of a case: outcome, figures by name, signals (n_signals, n_times) or None."""

    outcome: str
    message: str
    figures: dict[str, float]
    signals: Array | None


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
    """

    plan: Scenario
    keys: tuple[Key, ...]
    measures: tuple[Measure, ...]
    signals: tuple[str, ...]
    times: Array
    ledger: bool
    digest: str
    taken: tuple[str, ...]

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
        """The last machine of each thread."""
        return threading.local()

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


def run_block(
    job: Job, cases: Sequence[tuple[Override, ...]], should_stop: Callable[[], bool] | None = None
) -> BlockResult:
    """Run the cases of a block, one after the other.

    Raises
    ------
    Abandoned
        If `should_stop` is true before the last case is done.
    """
    # A different machine is an error of the whole study, not of its first case.
    _ = job.base
    signals = np.full((len(job.signals), len(cases), job.times.size), np.nan)
    results = []
    for i, values in enumerate(cases):
        result = run_case(job, values, should_stop)
        if should_stop is not None and should_stop():
            raise Abandoned
        if result.signals is not None:
            signals[:, i] = result.signals
        # The signals are most of the memory of a block, so there is only one copy.
        results.append(dataclasses.replace(result, signals=None))
    names = dict.fromkeys(name for result in results for name in result.figures)
    figures = {name: np.array([result.figures.get(name, np.nan) for result in results]) for name in names}
    return BlockResult([r.outcome for r in results], [r.message for r in results], figures, signals)


def run_case(job: Job, values: Sequence[Override], should_stop: Callable[[], bool] | None = None) -> CaseResult:
    """Run one case; an error in it becomes its outcome."""
    try:
        return _kept(job, _simulated(job, values, should_stop))
    except TakenName:
        # An error of the whole study.
        raise
    except HydrocraneError as error:
        return CaseResult(INVALID, str(error), {}, None)
    except (KeyboardInterrupt, SystemExit, GeneratorExit):
        raise
    except BaseException as error:
        return CaseResult(CRASHED, f"{type(error).__name__}: {error}", {}, None)


def _simulated(job: Job, values: Sequence[Override], should_stop: Callable[[], bool] | None) -> CaseRecord:
    plan = changed_plan(job.plan, job.keys, values)
    if not isinstance(plan.driver, str | None):
        # Your own controller may have states, so each run has a copy.
        plan = plan.changed(controller=copy.deepcopy(plan.controller))
    machine = job.machine(plan)
    payload = machine.payload(plan.payload)
    record, _ = recorded_times(plan, job.times)
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
    except TakenName:
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
    times, places = recorded_times(record.plan, job.times)
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
