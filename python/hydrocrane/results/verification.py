"""Repeat a scenario with a tighter tolerance, and report the difference of both runs."""

from __future__ import annotations

import dataclasses

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.machine.machine import Machine
from hydrocrane.result_warning import ResultWarning
from hydrocrane.results.outcome import Verification
from hydrocrane.results.recording import Recording
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.scenario.solver import Solver

# Factor on the tolerance of a repeat; with fixed steps it uses half the step.
TIGHTER = 1e-2
TIGHTEST = 1e-12
# Negligible difference of the tip, m, and as a share of the path of the tip.
TIP = 1e-3
SHARE = 0.01


def tightened(solver: Solver) -> tuple[Solver, str]:
    """The solver with a tighter tolerance or half the step, and its description."""
    if solver.step is not None:
        step = 0.5 * solver.step
        return dataclasses.replace(solver, step=step), f"steps of {step * 1e3:g} ms"
    rtol = max(solver.rtol * TIGHTER, TIGHTEST)
    atol = None if solver.atol is None else solver.atol * rtol / solver.rtol
    return dataclasses.replace(solver, rtol=rtol, atol=atol), f"rtol {rtol:g}"


def compared(
    machine: Machine, plan: Scenario, run: Recording, repeat: Recording
) -> tuple[Verification, tuple[ResultWarning, ...]]:
    """The verification of `run` by a `repeat` with a tighter tolerance, and the warnings."""
    _, settings = tightened(plan.solver)
    rows = min(len(run.time), len(repeat.time))
    time, mine, other = run.time[:rows], run.states[:rows], repeat.states[:rows]
    n = len(machine.joint_names)
    tips = machine.tip(mine[:, :n])
    apart = np.linalg.norm(tips - machine.tip(other[:, :n]), axis=-1)
    pressures = [i for i, unit in enumerate(machine.state_units) if unit == "Pa"]
    pressure = float(np.abs(mine - other)[:, pressures].max(initial=0.0))
    worst = int(apart.argmax()) if rows else 0
    found = Verification(settings, float(apart.max(initial=0.0)), pressure, float(time[worst]) if rows else 0.0)
    doubts = []
    cure = "tighten `rtol`, shorten `step`, or use `rodas5p`; repeat with `verify` until the two agree"
    if found.tip > max(TIP, SHARE * _path(tips)):
        doubts.append(ResultWarning("not-converged", f"{found}", cure, found.time))
    here, there = run.outcome, repeat.outcome
    if here.kind != there.kind:
        text = f"a repeat with {settings} ends as {there.kind} at {there.time:.4g} s, this run as {here.kind}"
        doubts.append(ResultWarning("not-converged", text, cure, float(min(here.time, there.time))))
    return found, tuple(doubts)


def _path(tips: Array) -> float:
    """Length of the path through points (m, 2 or 3), m."""
    return float(np.linalg.norm(np.diff(tips, axis=0), axis=-1).sum())
