"""Run a scenario."""

from __future__ import annotations

import dataclasses
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from os import PathLike
from typing import Any

from hydrocrane import _core
from hydrocrane.arrays import Array
from hydrocrane.controllers import SampledController
from hydrocrane.dataset import run_dataset, stage_machine
from hydrocrane.errors import translated
from hydrocrane.machine import Machine, load_machine
from hydrocrane.result import Run
from hydrocrane.scenario import Scenario, load_scenario


def simulate(
    scenario: str | PathLike[str] | Scenario,
    *,
    machine: Machine | str | PathLike[str] | None = None,
    ledger: bool = True,
    **changes: Any,
) -> Run:
    """Simulate a scenario and return what happened, also where it ends early.

    Parameters
    ----------
    scenario : str, path or Scenario
        Bundled name, scenario file, or a scenario built in Python.
    machine : Machine, str or path, optional
        Used in place of the scenario's machine; the scenario's overrides still apply.
    ledger : bool
        Integrate the energy ledger along with the states.
    **changes
        Fields of the scenario or its solver to change: ``duration=2.0``, ``payload=150``, ``rtol=1e-8``,
        ``overrides={"supply.pressure": "100 bar"}``, ...

    Returns
    -------
    Run
        Ctrl-C ends the run early with outcome ``interrupted``; what was computed is there.
    """
    plan = scenario if isinstance(scenario, Scenario) else load_scenario(scenario)
    plan = plan.changed(**changes)
    crane = _machine_for(plan, machine)
    payload = crane.payload(plan.payload)
    began = time.perf_counter()
    with interruptible() as should_stop:
        raw = integrate(crane, plan, payload, ledger=ledger, record=plan.record_times(), should_stop=should_stop)
    wall = time.perf_counter() - began
    return Run(run_dataset(crane, plan, raw, payload=payload, wall=wall), crane)


def integrate(
    crane: Machine,
    plan: Scenario,
    payload: float,
    *,
    ledger: bool,
    record: Array,
    should_stop: Callable[[], bool] | None = None,
) -> dict[str, Any]:
    """Hand the plan to the core, which records states, commands and ledger until the end or a reason to stop.

    Parameters
    ----------
    record : (m,) array
        Times to record at, s, increasing.
    should_stop : callable, optional
        Asked now and then; True ends the run with outcome ``interrupted``.
    """
    start = plan.initial_state(crane)
    settings = {**dataclasses.asdict(plan.solver), "payload": payload, "ledger": ledger}
    settings["payload_changes"] = list(plan.payload_changes.items())
    if plan.closed_loop:
        stages = [_stage(begin, stage, crane) for begin, stage in plan.stages() if begin < plan.duration]
        with translated():
            return _core.simulate_controlled(start, float(plan.duration), stages, record, settings, should_stop)
    times, spools, linear = plan.command_grid(crane)
    head = (crane.core, start, float(plan.duration))
    with translated():
        return _core.simulate(*head, times, spools, linear, record, settings, should_stop)


def _stage(begin: float, stage: Scenario, crane: Machine) -> dict[str, Any]:
    """What holds from `begin` (s) on, as the core takes it; `crane` is the machine at the start."""
    here = stage_machine(crane, stage)
    driver, believed = stage.driver, stage.believed_machine(here)
    if not isinstance(driver, str):
        full_speed = stage.joystick.full_speed if stage.joystick else None
        driver = SampledController(driver, believed, stage.stick_mode, full_speed)
    with translated():
        plan = stage.loop_plan(here)
    return {"from": begin, "machine": here.core, "controller": driver, "believed": believed.core, "plan": plan}


def _machine_for(plan: Scenario, machine: Machine | str | PathLike[str] | None) -> Machine:
    if machine is None:
        return plan.load_machine()
    if not isinstance(machine, Machine):
        return load_machine(machine, plan.machine_overrides)
    return machine.changed(plan.machine_overrides)


@contextmanager
def interruptible() -> Iterator[Callable[[], bool] | None]:
    """While inside, the first Ctrl-C only asks to stop; the second one interrupts as usual.

    Signals reach the main thread alone, so elsewhere there is nothing to ask.
    """
    if threading.current_thread() is not threading.main_thread():
        yield None
        return
    asked = threading.Event()
    before = signal.getsignal(signal.SIGINT)

    def ask(_number: int, _frame: object) -> None:
        asked.set()
        signal.signal(signal.SIGINT, before)

    signal.signal(signal.SIGINT, ask)
    try:
        yield asked.is_set
    finally:
        signal.signal(signal.SIGINT, before)
