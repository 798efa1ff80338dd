"""Run a scenario."""

from __future__ import annotations

import time
from collections.abc import Callable
from os import PathLike
from typing import Unpack

import numpy as np

from hydrocrane import _core
from hydrocrane.arrays import Array
from hydrocrane.control.controllers import ON_ERROR, SampledController
from hydrocrane.errors import check_known, translated
from hydrocrane.machine.machine import Machine, load_machine
from hydrocrane.results.dataset import run_dataset
from hydrocrane.results.outcome import Outcome
from hydrocrane.results.recording import Recording
from hydrocrane.results.run import Run
from hydrocrane.results.verification import compared
from hydrocrane.scenario.changes import RunChanges
from hydrocrane.scenario.record_size import check_record
from hydrocrane.scenario.scenario import Scenario, own_controllers, scenario_entry
from hydrocrane.scenario.scenario_file import load_scenario
from hydrocrane.simulation.interruption import interruptible


def simulate(
    scenario: str | PathLike[str] | Scenario,
    *,
    machine: Machine | str | PathLike[str] | None = None,
    ledger: bool = True,
    verify: bool = False,
    on_error: str = "raise",
    **changes: Unpack[RunChanges],
) -> Run:
    """Simulate a scenario and return the run, also if it ends early.

    Parameters
    ----------
    scenario : str, path or Scenario
        Bundled name, scenario file, or a scenario built in Python.
    machine : Machine, str or path, optional
        Used in place of the scenario's machine; the scenario's overrides still apply.
    ledger : bool
        Integrate the energy ledger along with the states.
    verify : bool
        Repeat with a hundredth of the tolerance, or half the step, and judge the difference in `Run.verification`:
        beyond 1 mm at the tip, a tenth of the run's own distance from its path, or 3 % of the supply pressure for
        longer than 20 ms is a warning, ``not-converged``.
    on_error : {"raise", "stop", "neutral"}
        What happens after an exception in your own controller. ``raise``: the run stops, and the exception is
        raised again with its own traceback; its attribute ``run`` holds the :class:`Run` until then. ``stop``: the
        run ends with outcome ``controller-failed``, whose message has the exception, the file and the line.
        ``neutral``: the spools go to neutral for that sample, an event says so, and the run ends only after ten such
        samples in a row.
    **changes
        Fields of the scenario or its solver to change: ``duration=2.0``, ``payload=150``, ``rtol=1e-8``,
        ``overrides={"supply.pressure": "100 bar"}``, ...

    Returns
    -------
    Run

    Raises
    ------
    KeyboardInterrupt
        After Ctrl-C, also in a loop of runs; its attribute ``run`` holds the run until then, with outcome and
        warning ``interrupted``; the whole run, without a verification, if its repeat was stopped. Also if your own
        controller raises it, whatever `on_error` says.

    Examples
    --------
    >>> run = hc.simulate("vertical-lift-open-loop", overrides={"supply.pressure": "120 bar"}, duration=2.0)
    >>> z = run.columns["tip.z"].values
    >>> print(run.outcome.kind, f"up by {z[-1] - z[0]:.2f} m")
    completed up by 0.19 m
    """
    check_known("choice of on_error", on_error, ON_ERROR)
    plan = scenario if isinstance(scenario, Scenario) else load_scenario(scenario)
    plan = plan.changed(**changes)
    machine = machine_for(plan, machine)
    payload = machine.payload(plan.payload)
    began = time.perf_counter()
    repeat_stopped = False
    with interruptible() as should_stop:

        def go(plan: Scenario, ledger: bool) -> Recording:
            record = plan.record_times()
            return recorded(machine, plan, ledger=ledger, record=record, should_stop=should_stop, on_error=on_error)

        found = go(plan, ledger)
        wall = time.perf_counter() - began
        if verify and found.error is None and found.outcome.kind != "interrupted":
            repeat = go(plan.changed(solver=plan.solver.tightened()), ledger=False)
            repeat_stopped = repeat.outcome.kind == "interrupted"
            if not repeat_stopped:
                columns = Run(run_dataset(machine, plan, found, payload=payload, wall=wall), machine).columns
                path = columns["tip.deviation"].values if "tip.deviation" in columns else np.empty(0)
                farthest = float(np.nanmax(path)) if np.isfinite(path).any() else None
                found.verification, doubts = compared(machine, plan, found, repeat, farthest)
                found.warnings += doubts
    run = Run(run_dataset(machine, plan, found, payload=payload, wall=wall), machine)
    error = found.error
    if error is not None and (on_error == "raise" or not isinstance(error, Exception)):
        raise _with_run(error, run)
    # Also where the core ended before it asked.
    if should_stop is not None and should_stop():
        at = f"run was stopped at t = {run.outcome.time:.4g} s"
        raise _with_run(KeyboardInterrupt(f"the {'repeat for `verify` was stopped' if repeat_stopped else at}"), run)
    return run


def _with_run(error: BaseException, run: Run) -> BaseException:
    """`error` with the run until then as its attribute, and a note that says so."""
    error.run = run  # type: ignore[attr-defined]
    returned = '; on_error="stop" returns it in place of raising' if isinstance(error, Exception) else ""
    error.add_note(
        f"The run until then, t = {run.outcome.time:.4g} s, is the attribute `run` of this exception{returned}."
    )
    return error


def integrate(
    machine: Machine,
    plan: Scenario,
    *,
    ledger: bool,
    record: Array,
    should_stop: Callable[[], bool] | None = None,
) -> Recording:
    """As :func:`recorded`, for runs within a larger task: a KeyboardInterrupt of one's own controller ends that too."""
    found = recorded(machine, plan, ledger=ledger, record=record, should_stop=should_stop, on_error="stop")
    if found.error is not None and not isinstance(found.error, Exception):
        raise found.error
    return found


def recorded(
    machine: Machine,
    plan: Scenario,
    *,
    ledger: bool,
    record: Array,
    should_stop: Callable[[], bool] | None,
    on_error: str,
) -> Recording:
    """Run the plan in the core, which records states, commands and ledger until the end or a reason to stop.

    Parameters
    ----------
    record : (m,) array
        Recorded times, s, increasing.
    should_stop : callable or None
        Called from time to time; True ends the run with outcome ``interrupted``.
    on_error : {"raise", "stop", "neutral"}
        As in :func:`simulate`, but nothing is raised: the recording's `error` states what ended the run.

    Raises
    ------
    InputError
        If the record would take more than the plan's `record_limit`.
    """
    check_record(machine, plan, record.size, ledger=ledger)
    own = own_controllers(plan)
    made: list[SampledController] = []

    def make(number: int, model: _core.Machine, mode: str, full_speed: float | None) -> SampledController:
        law = own[number]
        assert not isinstance(law, str), "controllers by name are the core's"
        made.append(SampledController(law, machine.made(model), mode, full_speed, on_error=on_error))
        return made[-1]

    entry = scenario_entry(plan, machine.cylinder_names)
    with translated():
        raw = _core.run(machine.core, entry, record, ledger, make if own else None, should_stop)
    found = Recording.of(raw, machine, plan.warnings)
    if found.outcome.kind == "controller-failed":
        found.error = next((law.error for law in reversed(made) if law.error is not None), None)
        if found.error is not None and not isinstance(found.error, Exception):
            found.outcome = Outcome.stopped(found.outcome.time)
    found.warnings += found.outcome.doubts(float(plan.duration))
    return found


def machine_for(plan: Scenario, machine: Machine | str | PathLike[str] | None) -> Machine:
    """The plan's machine, or `machine` in its place, with the plan's overrides."""
    if machine is None:
        return plan.load_machine()
    if not isinstance(machine, Machine):
        return load_machine(machine, plan.machine_overrides)
    return machine.changed(plan.machine_overrides)
