"""SciPy's solvers, started anew at every command: on the core's right-hand side and on a model in NumPy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import odeint, solve_ivp

from benches.models import crane
from benches.problem import MAX_STEP, Problem, Segment, Solution, Solver, clocked

MAX_STEPS = 1_000_000
Law = Callable[[np.ndarray, np.ndarray], np.ndarray]
# States at the record times of a segment and at its end, from right-hand side, Jacobian, segment, start, tolerances.
Stretch = Callable[[Any, Any, Segment, np.ndarray, float, np.ndarray], np.ndarray]


def by_solve_ivp(method: str) -> Stretch:
    def stretch(rate: Any, jac: Any, s: Segment, x: np.ndarray, rtol: float, atol: np.ndarray) -> np.ndarray:
        options = {"t_eval": s.record, "rtol": rtol, "atol": atol, "max_step": MAX_STEP, "jac": jac}
        options = {name: value for name, value in options.items() if value is not None}
        return solve_ivp(rate, (s.begin, s.end), x, method=method, **options).y.T

    return stretch


def by_odeint(rate: Any, jac: Any, s: Segment, x: np.ndarray, rtol: float, atol: np.ndarray) -> np.ndarray:
    options = {"rtol": rtol, "atol": atol, "hmax": MAX_STEP, "mxstep": MAX_STEPS, "tfirst": True}
    return odeint(rate, x, np.append(s.begin, s.record), Dfun=jac, tcrit=[s.end], **options)[1:]


def solver(problem: Problem, stretch: Stretch, law: Law, slopes: Law | None) -> Solver:
    """The whole scenario by one of SciPy's functions."""

    def solve(rtol: float) -> Solution:
        count = {"rhs": 0, "jacobians": 0}

        def counted(name: str, function: Law, spools: np.ndarray) -> Callable[[float, np.ndarray], np.ndarray]:
            def call(_t: float, x: np.ndarray) -> np.ndarray:
                count[name] += 1
                return function(x, spools)

            return call

        def work() -> np.ndarray:
            states = [problem.start[None]]
            for segment in problem.segments():
                rate = counted("rhs", law, segment.spools)
                jac = None if slopes is None else counted("jacobians", slopes, segment.spools)
                states.append(stretch(rate, jac, segment, states[-1][-1], rtol, rtol * problem.sizes))
            return np.concatenate(states)

        return clocked(work, lambda: dict(count))

    return solve


def on_core(problem: Problem) -> dict[str, Solver]:
    """Compiled laws, called back through Python."""
    core, payload = problem.crane.core, problem.payload

    def law(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return core.state_derivative(x[None], u[None], payload)[0]

    def slopes(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return core.jacobian(x[None], u[None], payload)[0]

    lsoda = by_solve_ivp("LSODA")
    return {
        "SciPy LSODA, compiled laws": solver(problem, lsoda, law, None),
        "SciPy odeint, compiled laws": solver(problem, by_odeint, law, None),
        "SciPy odeint, compiled laws and Jacobian": solver(problem, by_odeint, law, slopes),
    }


def on_numpy(problem: Problem) -> dict[str, Solver]:
    """Laws in NumPy; Jacobians by difference quotients."""
    numbers = crane.parameters(problem.crane)

    def law(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return crane.state_derivative(x, u, numbers)

    names = ("LSODA", "BDF", "Radau")
    return {f"SciPy {name}, laws in NumPy": solver(problem, by_solve_ivp(name), law, None) for name in names}
