"""The methods of this package."""

from __future__ import annotations

from typing import Any

import numpy as np

import hydrocrane as hc
from benches.problem import Problem, Solution, Solver, clocked

METHODS = ("hc-exponential-4", "rodas5p", "tsit5")
FIXED_STEPS = "hc-rosenbrock-3"


def step_at(rtol: float) -> float:
    """Step of the method of third order that stands in for a tolerance, s."""
    return 0.1 * rtol ** (1 / 3)


def solvers(problem: Problem) -> dict[str, Solver]:
    def solver(method: str) -> Solver:
        def solve(rtol: float) -> Solution:
            kept: dict[str, Any] = {}
            step = step_at(rtol) if method == FIXED_STEPS else None

            def work() -> np.ndarray:
                kept.update(problem.integrate(method, rtol, step=step))
                return kept["states"]

            def count() -> dict[str, float]:
                counts = {name: kept["stats"][name] for name in ("steps", "rhs", "jacobians")}
                return counts if step is None else counts | {"step_s": step}

            return clocked(work, count)

        return solve

    fixed = (FIXED_STEPS,) if "step" in hc.Solver.__dataclass_fields__ else ()
    return {f"hydrocrane {method}": solver(method) for method in METHODS + fixed}
