"""Run a scenario again, tighter, and say by how much the two runs differ."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrocrane.result_warning import ResultWarning

if TYPE_CHECKING:
    from hydrocrane.arrays import Array
    from hydrocrane.machine.machine import Machine
    from hydrocrane.scenario.scenario import Scenario
    from hydrocrane.scenario.solver import Solver

# A repeat takes so much less of the tolerance, or half the step.
TIGHTER = 1e-2
TIGHTEST = 1e-12
# Difference of the tip that is none, m, and as a share of the path of the tip.
TIP = 1e-3
SHARE = 0.01


@dataclass(frozen=True)
class Verification:
    """How a run differs from its tighter repeat.

    Attributes
    ----------
    solver : str
        Settings of the repeat.
    tip : float
        Largest distance between the tips at one time, m.
    pressure : float
        Largest difference of a chamber pressure, Pa.
    time : float
        When the tips were farthest apart, s.
    """

    solver: str
    tip: float
    pressure: float
    time: float

    def __str__(self) -> str:
        tip, pressure = self.tip * 1e3, self.pressure / 1e5
        return f"a repeat with {self.solver} differs by at most {tip:.3g} mm at the tip and {pressure:.3g} bar"


def tightened(solver: Solver) -> tuple[Solver, str]:
    """The solver with a tighter tolerance or half the step, and what that is in words."""
    if solver.step is not None:
        step = 0.5 * solver.step
        return dataclasses.replace(solver, step=step), f"steps of {step * 1e3:g} ms"
    rtol = max(solver.rtol * TIGHTER, TIGHTEST)
    atol = None if solver.atol is None else solver.atol * rtol / solver.rtol
    return dataclasses.replace(solver, rtol=rtol, atol=atol), f"rtol {rtol:g}"


def compared(
    crane: Machine, plan: Scenario, raw: dict[str, Any], repeat: dict[str, Any]
) -> tuple[Verification, tuple[ResultWarning, ...]]:
    """The verification of the record `raw` by that of a tighter `repeat`, and what it makes doubtful."""
    _, settings = tightened(plan.solver)
    rows = min(len(raw["t"]), len(repeat["t"]))
    time, mine, other = (
        np.asarray(raw["t"])[:rows],
        np.asarray(raw["states"])[:rows],
        np.asarray(repeat["states"])[:rows],
    )
    n = len(crane.joint_names)
    tips = crane.tip(mine[:, :n])
    apart = np.linalg.norm(tips - crane.tip(other[:, :n]), axis=-1)
    pressures = [i for i, unit in enumerate(crane.state_units) if unit == "Pa"]
    pressure = float(np.abs(mine - other)[:, pressures].max(initial=0.0))
    worst = int(apart.argmax()) if rows else 0
    found = Verification(settings, float(apart.max(initial=0.0)), pressure, float(time[worst]) if rows else 0.0)
    doubts = []
    cure = "tighten `rtol`, shorten `step`, or take `rodas5p`; repeat with `verify` until the two agree"
    if found.tip > max(TIP, SHARE * _path(tips)):
        doubts.append(ResultWarning("not-converged", f"{found}", cure, found.time))
    ends = [record["outcome"][0] for record in (raw, repeat)]
    if ends[0] != ends[1]:
        text = f"a repeat with {settings} ends as {ends[1]} at {repeat['outcome'][1]:.4g} s, this run as {ends[0]}"
        doubts.append(ResultWarning("not-converged", text, cure, float(min(raw["outcome"][1], repeat["outcome"][1]))))
    return found, tuple(doubts)


def _path(tips: Array) -> float:
    """Length of the path through points (m, 2 or 3), m."""
    return float(np.linalg.norm(np.diff(tips, axis=0), axis=-1).sum())
