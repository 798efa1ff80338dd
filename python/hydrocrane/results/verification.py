"""Repeat a scenario with a tighter tolerance, and judge the difference of both runs."""

from __future__ import annotations

import numpy as np

from hydrocrane import _core
from hydrocrane.arrays import Array
from hydrocrane.machine.machine import Machine
from hydrocrane.result_warning import ResultWarning
from hydrocrane.results.outcome import Verification
from hydrocrane.results.recording import Recording
from hydrocrane.scenario.scenario import Scenario

# Largest share of a run's own deviation from its path that its error may have.
OF_DEVIATION = 0.1


def compared(
    machine: Machine, plan: Scenario, run: Recording, repeat: Recording, deviation: float | None = None
) -> tuple[Verification, tuple[ResultWarning, ...]]:
    """The verification of `run` by a `repeat` with a tighter tolerance, and the warnings.

    Parameters
    ----------
    deviation : float, optional
        Largest distance of the tip from the path of its set-point, m, which the run was made to find.
    """
    settings = plan.solver.tightened().settings
    # What a run at the default tolerance promises. Edges of both runs a little apart are not counted.
    promised_tip, promised_pressure, brief = _core.PROMISES
    rows = min(len(run.time), len(repeat.time))
    time, mine, other = run.time[:rows], run.states[:rows], repeat.states[:rows]
    n = len(machine.joint_names)
    tips = np.linalg.norm(machine.tip(mine[:, :n]) - machine.tip(other[:, :n]), axis=-1)
    pressures = [i for i, unit in enumerate(machine.state_units) if unit == "Pa"]
    apart = _lasting(time, np.abs(mine - other)[:, pressures].max(axis=1, initial=0.0), brief)
    worst = int(tips.argmax()) if rows else 0
    found = Verification(
        solver=settings,
        tip=float(tips.max(initial=0.0)),
        pressure=float(apart.max(initial=0.0)),
        time=float(time[worst]) if rows else 0.0,
        tip_limit=promised_tip if deviation is None else min(promised_tip, OF_DEVIATION * deviation),
        pressure_limit=promised_pressure * machine.supply_pressure,
    )
    doubts = []
    cure = "tighten `rtol`, shorten `step`, or use `rodas5p`; repeat with `verify` until the two agree"
    if not found.converged:
        begins = [time[tips > found.tip_limit], time[apart > found.pressure_limit]]
        begin = min(float(times[0]) for times in begins if times.size)
        doubts.append(ResultWarning("not-converged", f"{found}", cure, begin))
    here, there = run.outcome, repeat.outcome
    if here.kind != there.kind:
        text = f"a repeat with {settings} ends as {there.kind} at {there.time:.4g} s, this run as {here.kind}"
        doubts.append(ResultWarning("not-converged", text, cure, float(min(here.time, there.time))))
    return found, tuple(doubts)


def _lasting(time: Array, apart: Array, brief: float) -> Array:
    """The part of a difference (m,) that lasts longer than `brief`, s."""
    from scipy.ndimage import minimum_filter1d

    if len(time) < 2:
        return apart
    samples = int(brief / float(np.median(np.diff(time)))) + 1
    return np.asarray(minimum_filter1d(apart, samples, mode="nearest"))
