"""An operator in the loop: sticks that respond to the motion they cause, for either interface.

With levers the crane is stepped from one decision to the next (:class:`hydrocrane.Simulator`). The controller ``tip``
needs whole runs with sticks stated in advance. These sticks are found by waveform relaxation (E. Lelarasmee, A. E.
Ruehli and A. L. Sangiovanni-Vincentelli, *The waveform relaxation method for time-domain analysis of large scale
integrated circuits*, IEEE Transactions on Computer-Aided Design, 1982): run with guessed sticks, compute the operator's
response to that motion, run again. The reaction time makes this exact: the motion up to the first changed decision
determines the decisions until one reaction time later, so every run makes further decisions final.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass

import numpy as np
from modelled_operator import GLANCE, PERIOD, Driver
from numpy.typing import NDArray

from hydrocrane.arrays import Array
from hydrocrane.control.joystick import Joystick
from hydrocrane.errors import SimulationError
from hydrocrane.results.recording import Recording
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.simulation.running import integrate
from hydrocrane.simulation.simulator import Simulator

# Number of decisions in a run after the final ones.
AHEAD = 80
# Lag of the tip behind its stick under tip control, in periods; only guesses depend on it.
LAG = 4


@dataclass(frozen=True)
class Drive:
    """A drive of the operator.

    Attributes
    ----------
    scenario : Scenario
        The drive, with its sticks as a table and its loads at their times.
    sticks : (k, axes) array
        Deflections, one row for each ``PERIOD``.
    aims : (k,) array
        Index of the current way-point after each decision.
    finished : bool
        Whether the task was completed in time.
    runs : int
        Number of whole runs until the sticks were found; zero if the crane was stepped.
    """

    scenario: Scenario
    sticks: Array
    aims: NDArray[np.int64]
    finished: bool
    runs: int


@dataclass
class _Decisions:
    """Deflections of the sticks (k, axes), payloads (k,), kg, and aims (k,), one row for each ``PERIOD``."""

    sticks: Array
    payloads: Array
    aims: NDArray[np.int64]
    final: int = 0
    runs: int = 0


def drive(plan: Scenario, driver: Driver, longest: float) -> Drive:
    """Let `driver` drive the crane of `plan` from its start until the task is done or `longest`, s, has passed.

    Duration, joystick and payload changes of the scenario are replaced by those of the driver. A driver can be used
    once.

    Raises
    ------
    SimulationError
        If the simulation fails.
    """
    most = round(longest / PERIOD)
    made = _Decisions(np.zeros((most, driver.sticks.size)), np.zeros(most), np.zeros(most, dtype=np.int64))
    driver = (_step_by_step if driver.interface == "lever" else _run_by_run)(plan, driver, made)
    scenario = _scenario(plan, driver, made, made.final)
    return Drive(scenario, made.sticks[: made.final], made.aims[: made.final], driver.done, made.runs)


def _step_by_step(plan: Scenario, driver: Driver, made: _Decisions) -> Driver:
    """Fills `made` decision by decision, each from the motion so far."""
    crane = driver.machine
    simulator = Simulator(crane, PERIOD)
    seen = [simulator.reset(q=[plan.joints[name] for name in crane.joint_names])]
    for k in range(len(made.sticks)):
        late, earlier = (seen[i] for i in driver.operator.seen_at(k))
        made.sticks[k] = driver.decide(late.tip, (late.tip - earlier.tip) / GLANCE, late.q)
        made.payloads[k], made.aims[k] = driver.payload, driver.aim
        made.final = k + 1
        if driver.done:
            break
        if driver.payload != simulator.payload:
            simulator.set_payload(driver.payload)
        seen.append(simulator.step(made.sticks[k] * crane.spool_strokes))
    return driver


def _run_by_run(plan: Scenario, driver: Driver, made: _Decisions) -> Driver:
    """Fills `made` by whole runs, each with decisions from the previous run."""
    most = len(made.sticks)
    known = 0
    while made.final < most and not driver.done:
        end = min(made.final + AHEAD, most)
        if known < end:
            made.sticks[known:end], made.payloads[known:end] = made.sticks[known - 1], made.payloads[known - 1]
        trial = _scenario(plan, driver, made, end)
        run = integrate(driver.machine, trial, ledger=False, record=trial.record_times())
        if not run.outcome.completed:
            raise SimulationError(f"the drive ended early: {run.outcome.message}")
        made.runs += 1
        known = min(end + driver.operator.delay, most)
        driver = _answered(run, driver, made, end, known)
    return driver


def _answered(run: Recording, driver: Driver, made: _Decisions, end: int, known: int) -> Driver:
    """Repeat the decisions of `driver` that are not final, with the motion of `run`, up to the decision `known`.

    Until a decision differs from that of the run, the motion is what the operator will see. After that it is a guess in
    which the tip follows the changed stick. Returns the driver after the last final decision.
    """
    crane = driver.machine
    q = run.states[:, [crane.state_names.index(f"joint.{name}.q") for name in crane.joint_names]]
    tip = crane.tip(q)
    delay, follower, last = driver.operator.delay, copy.copy(driver), known
    for k in range(made.final, known):
        late, earlier = driver.operator.seen_at(k)
        sticks = follower.decide(tip[late], (tip[late] - tip[earlier]) / GLANCE, q[late])
        change = sticks - made.sticks[k]
        if k < end and (change.any() or follower.payload != made.payloads[k]):
            tip[k + 1 + LAG :] += change * (driver.operator.speed * PERIOD)
            last = min(last, k + delay + 1)
        made.sticks[k], made.payloads[k], made.aims[k] = sticks, follower.payload, follower.aim
        if k < last:
            driver, made.final = copy.copy(follower), k + 1
        if follower.done:
            break
    return driver


def _scenario(plan: Scenario, driver: Driver, made: _Decisions, count: int) -> Scenario:
    """The first `count` decisions as a scenario."""
    tip = driver.interface == "tip"
    time = PERIOD * np.arange(count)
    names = driver.machine.core.stick_axes if tip else driver.machine.cylinder_names
    stick = Joystick(
        time,
        dict(zip(names, made.sticks[:count].T, strict=True)),
        mode=driver.interface,
        full_speed=driver.operator.speed if tip else None,
    )
    changed = 1 + np.flatnonzero(np.diff(made.payloads[:count]))
    return plan.changed(
        joystick=stick,
        payload_changes={float(time[k]): float(made.payloads[k]) for k in changed},
        duration=PERIOD * count,
        record_interval=PERIOD,
    )
