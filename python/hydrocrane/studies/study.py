"""A study: the varied keys, the stored results, and how it is run."""

from __future__ import annotations

import copy
import dataclasses
import math
import warnings
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Unpack, cast

import numpy as np
import xarray as xr

from hydrocrane.arrays import seed_number, whole_number
from hydrocrane.errors import HydrocraneError, InputError, ResultFileError, check_known, unknown
from hydrocrane.files.whole_file import cannot_write
from hydrocrane.machine.machine import Machine
from hydrocrane.notebook import card
from hydrocrane.result_warning import DoubtfulResult
from hydrocrane.scenario.changes import Changes, RunChanges, SweepChanges
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.scenario.scenario_file import load_scenario
from hydrocrane.studies.board import Board, Progress, board_of, telling
from hydrocrane.studies.case import FAILED, BlockResult, Job, digest_of
from hydrocrane.studies.design import (
    Cases,
    Place,
    block_shape,
    check_records,
    designed,
    known_signals,
    samples_of,
    signal_times,
    size_of,
)
from hydrocrane.studies.distribution import WAYS, Local, on_cluster, thread_count
from hydrocrane.studies.identity import identity
from hydrocrane.studies.integrity import written_by_one
from hydrocrane.studies.keys import resolved_key
from hydrocrane.studies.measures import DEFAULT, OF_ANY_RUN, Measures, checked_measures
from hydrocrane.studies.processes import NotComputed
from hydrocrane.studies.store import LIMIT, MESSAGE, OUTCOME, RESUME, TIME, Layout, Store
from hydrocrane.units import converted

if TYPE_CHECKING:
    from distributed import Client


def varied_and_kept(cases: Cases, job: Job) -> list[str]:
    """Values of each key, measures and signals, a line each: label, two spaces, value."""
    lines = []
    for key, values in zip(cases.keys, cases.axes, strict=True):
        tried = list(dict.fromkeys(map(_shown, values)))
        numbers = [value for value in values if isinstance(value, (int, float))]
        # Drawn numbers come in no order.
        first, last = (min(numbers), max(numbers)) if len(numbers) == len(values) else (values[0], values[-1])
        ends = ", ".join(tried) if len(tried) <= 6 else f"{_shown(first)} ... {_shown(last)}"
        lines.append(f"{key.name}  {len(values)} values: {ends}")
    lines.append(f"measures  {', '.join(measure.name for measure in job.measures)}")
    if job.signals:
        lines.append(f"signals  {', '.join(job.signals)}")
    return lines


def _shown(value: object) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)


# Cases that take longer than this are named by the progress bar, s.
LONG = 2.0
RESERVED = (OUTCOME, MESSAGE, TIME, "case")


class StudyInterrupted(KeyboardInterrupt):
    """A study was stopped by Ctrl-C; its text says how many cases are done and how to resume."""


@dataclass(frozen=True)
class Study:
    """A scenario that is run many times, with other values of some keys each time.

    Parameters
    ----------
    scenario : str, path or Scenario
    keys : mapping
        Dotted key of machine, scenario or controller to its values. On a grid and in a list: a sequence of values, or
        ``{"low": ..., "high": ..., "count": ..., "log": False}``. Drawn: a pair (low, high), a table with low, high
        and log, ``{"values": [...]}``, a frozen distribution of ``scipy.stats``, or ``{"distribution": "norm",
        "loc": ..., "scale": ...}``. Numbers are SI, texts need a unit.
    method : {"grid", "random", "latin", "list"}
        All combinations; independent draws; a Latin hypercube; the first values of all keys, the second ones, ...
    n : int
        Number of cases to draw.
    seed : int
        Seed of the random values.
    measures : sequence of str or callable, or mapping of name to callable
        Measures to store, see ``hydrocrane.studies.measures``.
    signals : sequence of str
        Signals to store, on one time grid for all cases; NaN after the end of a run.
    resample : float or str, optional
        Interval of that grid, s; default is the scenario's record interval.
    ledger : bool
        Integrate the energy ledger too, for functions that read it.
    machine : Machine, str or path, optional
        Replaces the scenario's machine.
    changes : mapping
        Fields of the scenario or its solver to change in all cases, as in :func:`hydrocrane.simulate`.

    Examples
    --------
    >>> loads = {"payload.mass": ["0 kg", "50 kg", "100 kg"]}
    >>> study = hc.Study("vertical-lift-open-loop", loads, measures=["max(tip.z)"], changes={"duration": 1.0})
    >>> print(study.cases.count)
    3
    """

    scenario: str | PathLike[str] | Scenario
    keys: Mapping[str, object]
    method: str = "grid"
    n: int | None = None
    seed: int = 0
    measures: Measures = DEFAULT
    signals: Sequence[str] = ()
    resample: float | str | None = None
    ledger: bool = False
    machine: Machine | str | PathLike[str] | None = None
    changes: RunChanges = field(default_factory=lambda: RunChanges())

    @cached_property
    def plan(self) -> Scenario:
        """The scenario with the settings for all cases."""
        plan = self.scenario if isinstance(self.scenario, Scenario) else load_scenario(self.scenario)
        changes = cast(Changes, dict(self.changes))
        if isinstance(self.machine, Machine):
            changes["overrides"] = {**self.machine.overrides, **plan.overrides, **changes.get("overrides", {})}
            changes["machine"] = self.machine.source
        elif self.machine is not None:
            changes["machine"] = str(self.machine)
        plan = plan.changed(**changes)
        try:
            copy.deepcopy(plan.controller)
        except Exception as error:
            raise InputError(
                f"every case needs a copy of the controller, and this one cannot be copied: {error}"
            ) from None
        return plan

    def _repr_html_(self) -> str:
        try:
            how = self.method + ("" if self.method in ("grid", "list") else f", seed {self.seed}")
            lines = [f"machine  {self.base_machine.name}", f"cases  {self.cases.count}, {how}"]
            return card(f"Study of {self.plan.name}", [*lines, *varied_and_kept(self.cases, self.job)], "study.keys")
        except HydrocraneError as error:
            return card("Study", [f"warning  {error}"])

    @cached_property
    def base_machine(self) -> Machine:
        """The machine before any key is varied."""
        made, own = self.plan.load_machine(), self.machine
        if isinstance(own, Machine) and own.changed(self.plan.machine_overrides).core.resolved != made.core.resolved:
            raise InputError(
                f"{own.source} was changed after this machine was loaded from it, and the cases of a study read the "
                "file: load the machine again"
            )
        return made

    @cached_property
    def cases(self) -> Cases:
        """The cases, their keys checked."""
        if not isinstance(self.keys, Mapping) or not self.keys:
            raise InputError('a study needs keys with their values, such as {"payload.mass": [0, 100]}')
        given = {str(key): spec for key, spec in self.keys.items()}
        tried = {key: samples_of(key, spec) for key, spec in given.items()}
        keys = [resolved_key(key, values, self.plan, self.base_machine) for key, values in tried.items()]
        return designed(keys, given, self.method, self.n, seed_number(self.seed))

    @cached_property
    def job(self) -> Job:
        """The task for the workers."""
        units = {name: unit for name, (unit, _) in self._known_signals.items()}
        for name in self.signals:
            check_known("signal", name, units)
        measures = checked_measures(self.measures, units)
        others = [*(key.name for key in self.cases.keys), *self.signals]
        names = [*others, *(measure.name for measure in measures)]
        for name in names:
            if names.count(name) > 1 or name in RESERVED:
                raise InputError(f"`{name}` would name two things in the result; rename or remove one of them")
        check_records(self.plan, self.base_machine, self.cases, ledger=self.ledger)
        times = signal_times(self.plan, self.cases, self.resample) if self.signals else np.empty(0)
        digest = digest_of(self.base_machine.core)
        taken = (*RESERVED, *others)
        return Job(self.plan, self.cases.keys, measures, tuple(self.signals), times, self.ledger, digest, taken)

    def run(
        self,
        store: str | PathLike[str] | None = None,
        *,
        overwrite: bool = False,
        resume: str = "same",
        workers: int | None = None,
        scheduler: str | Client | None = None,
        block: int | None = None,
        time_limit: float | str | None = None,
        progress: Progress | bool | None = None,
    ) -> xr.Dataset:
        """Run the cases that are not done; parameters and result as in :func:`sweep`.

        Examples
        --------
        >>> loads = {"payload.mass": ["0 kg", "100 kg"]}
        >>> study = hc.Study("vertical-lift-open-loop", loads, measures=["max(tip.z)"], changes={"duration": 0.1})
        >>> found = study.run()
        >>> print(list(found))
        ['end_time', 'max(tip.z)', 'message', 'outcome']
        """
        check_known("way to resume", resume, RESUME)
        if isinstance(scheduler, str) and ":" not in scheduler and scheduler not in WAYS:
            raise unknown("scheduler", scheduler, (*WAYS, "tcp://host:8786"))
        job = dataclasses.replace(self.job, limit=_limit(time_limit))
        with written_by_one(None if store is None else Path(store)):
            kept = Store.at(store, self._layout(block, job), overwrite=overwrite, resume=resume)
            self._fill(kept, job, thread_count(workers), scheduler, progress)
            data = kept.dataset()
        if failed := _failed(data):
            warnings.warn(failed, DoubtfulResult, stacklevel=2)
        return data

    def _fill(
        self, kept: Store, job: Job, workers: int, scheduler: str | Client | None, progress: Progress | bool | None
    ) -> None:
        """Run the cases that are not done."""
        places, total = kept.pending(), kept.total
        done = total - _sizes(places)
        try:
            with board_of(kept.path, workers) as board, telling(progress, self.plan.name) as tell:

                def look() -> None:
                    tell(done, total, self._longest(board))

                if scheduler is None or scheduler in WAYS:
                    here = Local(job, self.cases, board, look)
                    results = here.results(places, workers, scheduler)
                else:
                    results = on_cluster(job, self.cases, places, scheduler, look)
                tell(done, total)
                with closing(results):
                    for place, result in results:
                        _write(kept, place, result)
                        done += size_of(place)
                        tell(done, total)
        except KeyboardInterrupt:
            # Ctrl-C may have come between the writing and the counting of a block, so the store is asked.
            raise StudyInterrupted(_stopped(total - _sizes(kept.pending()), total, kept)) from None
        except NotComputed as error:
            stopped = _stopped(total - _sizes(kept.pending()), total, kept)
            raise type(error)(f"{error}; {stopped}") from error

    def _longest(self, board: Board) -> str:
        """The case that is computed for the longest time, in words; empty while all are quick."""
        number, seconds = board.longest() or (0, 0.0)
        if seconds < LONG:
            return ""
        values = zip(self.cases.keys, self.cases.values_of(number), strict=True)
        return f"case {number} for {seconds:.0f} s: " + ", ".join(f"{key.name} = {value}" for key, value in values)

    def pictured(self, measure: str | None) -> str:
        """The measure to draw: `measure`, which must be one of the study's, or the first after the end time.

        Examples
        --------
        >>> loads = {"payload.mass": ["0 kg", "100 kg"]}
        >>> study = hc.Study("vertical-lift-open-loop", loads, measures=["max(tip.z)"], changes={"duration": 0.1})
        >>> print(study.pictured(None))
        max(tip.z)
        """
        names = [own.name for own in self.job.measures]
        if measure is not None and measure not in names:
            raise unknown("measure of the study", measure, names)
        return measure or next((name for name in names if name != OF_ANY_RUN), OF_ANY_RUN)

    @cached_property
    def _known_signals(self) -> dict[str, tuple[str, str]]:
        return known_signals(self.plan, self.base_machine)

    def _layout(self, block: int | None, job: Job) -> Layout:
        cases = self.cases
        settings: dict[str, object] = {
            "method": self.method,
            "signals": list(job.signals),
            "times": job.times,
            "ledger": self.ledger,
        }
        about: dict[str, str | int] = {
            "title": self.plan.title or self.plan.name,
            "scenario": self.plan.name,
            "machine": self.base_machine.name,
            "method": self.method,
            "seed": int(self.seed),
            "source": _versions(),
            LIMIT: "none" if job.limit is None else f"{job.limit:g} s",
            "Conventions": "SI units, radians, gauge pressures",
        }
        return Layout(
            cases=cases,
            block=block_shape(
                cases.shape,
                None if block is None else whole_number("block", block),
                8 * len(job.signals) * job.times.size,
            ),
            times=job.times,
            signals={name: self._known_signals[name] for name in job.signals},
            figures={measure.name: (measure.unit, measure.meaning) for measure in job.measures if not measure.own},
            identity=identity(self.plan, self.base_machine, cases, job.measures, settings),
            about=about,
        )


def sweep(
    scenario: str | PathLike[str] | Scenario,
    keys: Mapping[str, object],
    *,
    method: str = "grid",
    n: int | None = None,
    seed: int = 0,
    measures: Measures = DEFAULT,
    signals: Sequence[str] = (),
    resample: float | str | None = None,
    ledger: bool = False,
    machine: Machine | str | PathLike[str] | None = None,
    store: str | PathLike[str] | None = None,
    overwrite: bool = False,
    resume: str = "same",
    workers: int | None = None,
    scheduler: str | Client | None = None,
    block: int | None = None,
    time_limit: float | str | None = None,
    progress: Progress | bool | None = None,
    **changes: Unpack[SweepChanges],
) -> xr.Dataset:
    """Run a scenario for many values of some keys, and store measures or signals of every run.

    Parameters
    ----------
    scenario, keys, method, n, seed, measures, signals, resample, ledger, machine
        As in :class:`Study`.
    store : path, optional
        Folder for the results, written during the computation (Zarr). The same call with the same store resumes
        an earlier one that was stopped. Without it everything stays in memory.
    overwrite : bool
        Delete a study in the store and start again.
    resume : {"same", "trust"}
        A study is resumed if it is the same: values, logs, the state of your own controllers and measures, and the code
        that they call. Where that cannot be told of an object, the call is refused with the reason; "trust" resumes
        regardless, and the store says so (attribute ``resumed_on_trust``). Cases that crashed are computed again.
    workers : int, optional
        Cases computed at a time on this computer; default is the number of cores.
    scheduler : {"threads", "processes"}, address or distributed.Client, optional
        Where the cases are computed. By default in threads; if more than 8 s are left, for a stretch in processes, and
        then in the faster of the two; with controllers or measures of your own always in threads, unless you say
        "processes": then what they print, draw or remember stays in those processes. A case that ends its process is
        left out at the second time, with outcome ``killed``. An address, ``tcp://host:8786``, is that of a Dask
        scheduler.
    block : int, optional
        Cases that are computed and written together; at most the blocks in progress are lost in a crash.
    time_limit : float or str, optional
        Longest time of a case by the clock, s. A case that takes longer ends with outcome ``time-limit``; it is
        computed again when the study is resumed with another limit. In processes functions that hang are ended too.
    progress : callable or bool, optional
        Called with (cases done, cases in all); True draws a bar, which is the default on a terminal.
    **changes
        Fields of the scenario or its solver to change in all cases, as in :func:`hydrocrane.simulate`.

    Returns
    -------
    xarray.Dataset
        One dimension per key on a grid, else a dimension ``case`` with the values of the keys along it; measures,
        signals over ``time``, ``outcome`` and ``message``. Read from the store when it is used.

    Raises
    ------
    StudyInterrupted
        After Ctrl-C; finished cases are in the store.
    NotComputed
        If the cluster or the processes are lost. The message says how many cases are done.

    Examples
    --------
    >>> loads = {"payload.mass": [0.0, 50.0, 100.0]}
    >>> found = hc.sweep("vertical-lift-open-loop", loads, measures=["max(tip.z)"], duration=2.0)
    >>> print(found["max(tip.z)"].dims, found["max(tip.z)"].values.round(3))
    ('payload.mass',) [ 0.002 -0.005 -0.013]
    """
    study = Study(
        scenario, keys, method, n, seed, measures, tuple([signals] if isinstance(signals, str) else signals),
        resample, ledger, machine, cast(RunChanges, changes),
    )  # fmt: skip
    return study.run(
        store, overwrite=overwrite, resume=resume, workers=workers, scheduler=scheduler, block=block,
        time_limit=time_limit, progress=progress,
    )  # fmt: skip


def _failed(data: xr.Dataset) -> str:
    """The number of cases without results, and why the first of them has none; empty if there are none."""
    outcomes, messages = (data[name].values.ravel() for name in (OUTCOME, MESSAGE))
    failed = np.flatnonzero(np.isin(outcomes.astype(str), FAILED))
    if not failed.size:
        return ""
    kinds = ", ".join(sorted(set(map(str, outcomes[failed]))))
    return f"{failed.size} of {outcomes.size} cases have no results ({kinds}), the first: {messages[failed[0]]}"


def _sizes(places: Iterable[Place]) -> int:
    return sum(map(size_of, places))


def _write(kept: Store, place: Place, result: BlockResult) -> None:
    try:
        kept.write(place, result)
    except OSError as error:
        done = kept.total - _sizes(kept.pending())
        failure = cannot_write(Path(str(kept.path)), error)
        raise ResultFileError(f"{failure}. {_stopped(done, kept.total, kept)}") from None


def _limit(given: float | str | None) -> float | None:
    if given is None:
        return None
    limit = converted("time_limit", given, "s") if isinstance(given, str) else given
    if isinstance(limit, bool) or not isinstance(limit, int | float) or not 0 < limit < math.inf:
        raise InputError(f"time_limit must be a time above zero, in s or with its unit; got {given!r}")
    return float(limit)


def _stopped(done: int, total: int, kept: Store) -> str:
    how = "give a store to be able to resume" if kept.path is None else f"the same call resumes there ({kept.path})"
    return f"stopped after {done} of {total} cases; {how}"


def _versions() -> str:
    from hydrocrane import __version__

    return f"hydrocrane {__version__}, numpy {np.__version__}"
