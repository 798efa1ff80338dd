"""The methods of this package."""

from __future__ import annotations

from benches.problem import Problem, Solution, Solver, clocked

METHODS = ("rodas5p", "tsit5")


def solvers(problem: Problem) -> dict[str, Solver]:
    def solver(method: str) -> Solver:
        def solve(rtol: float) -> Solution:
            kept: dict = {}

            def work():
                kept.update(problem.integrate(method, rtol))
                return kept["states"]

            return clocked(work, lambda: {name: kept["stats"][name] for name in ("steps", "rhs", "jacobians")})

        return solve

    return {f"hydrocrane {method}": solver(method) for method in METHODS}
