"""CasADi: the independent model in its symbols, compiled to C with its exact Jacobian, integrated by its CVODES."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from benches.models import crane
from benches.problem import MAX_STEP, NotAvailable, Problem, Segment, Solution, Solver, clocked

FLAGS = ("-O3", "-march=native", "-fPIC", "-shared")
MAX_STEPS = 1_000_000


def arrays() -> crane.Arrays:
    """What the model needs, for CasADi's scalar symbols."""
    import casadi as ca

    def column(values: Any) -> Any:
        return ca.vertcat(*values) if isinstance(values, list | tuple) else ca.SX(ca.DM(values))

    def matrix(rows: list[list[Any]]) -> Any:
        return ca.vertcat(*[ca.horzcat(*row) for row in rows])

    return crane.Arrays(ca, ca.if_else, column, matrix, lambda parts: ca.vertcat(*parts), ca.solve)


@cache
def compiled_model(machine: str, sizes: tuple[float, ...]) -> tuple[Any, tempfile.TemporaryDirectory]:
    """The right-hand side as a shared library that brings its Jacobian; the folder lives as long as the function.

    CVODES takes one absolute tolerance, so that the states are counted in their sizes.
    """
    import casadi as ca

    import hydrocrane as hc

    loaded = hc.load_machine(machine)
    x, u = ca.SX.sym("x", len(loaded.state_names)), ca.SX.sym("u", crane.JOINTS)
    size = ca.DM(sizes)
    rate = ca.Function("rate", [x, u], [crane.state_derivative(x * size, u, crane.parameters(loaded), arrays()) / size])
    folder = tempfile.TemporaryDirectory()
    code = ca.CodeGenerator("model.c", {})
    code.add(rate)
    code.add(rate.jacobian())
    source, target = Path(code.generate(f"{folder.name}/")), Path(folder.name, "model.so")
    compiler = next((name for name in ("gcc", "clang", "cc") if shutil.which(name)), None)
    if compiler is None:
        raise NotAvailable("no C compiler is installed")
    subprocess.run([compiler, *FLAGS, str(source), "-o", str(target), "-lm"], check=True, capture_output=True)
    return ca.external("rate", str(target)), folder


def solvers(problem: Problem) -> dict[str, Solver]:
    if importlib.util.find_spec("casadi") is None:
        raise NotAvailable("casadi is not installed")
    import casadi as ca

    rate, _ = compiled_model(problem.crane.source, tuple(problem.sizes))
    x, u = ca.MX.sym("x", problem.start.size), ca.MX.sym("u", crane.JOINTS)
    equations = {"x": x, "p": u, "ode": rate(x, u)}

    def prepared(rtol: float) -> list[tuple[Segment, Any]]:
        """One integrator per segment; equal stretches share one, as the equations do not know the time."""
        made: dict[tuple, Any] = {}
        options = {"reltol": rtol, "abstol": rtol, "max_step_size": MAX_STEP}
        options |= {"max_num_steps": MAX_STEPS, "newton_scheme": "direct"}
        plan = []
        for segment in problem.segments():
            grid = tuple(
                np.round(np.append(segment.record, segment.end)[: max(segment.record.size, 1)] - segment.begin, 9)
            )
            if grid not in made:
                made[grid] = ca.integrator(f"run{len(made)}", "cvodes", equations, 0.0, list(grid), options)
            plan.append((segment, made[grid]))
        return plan

    prepare = cache(prepared)

    def solve(rtol: float) -> Solution:
        plan = prepare(rtol)

        def work() -> np.ndarray:
            states = [problem.start[None] / problem.sizes]
            for segment, integrator in plan:
                states.append(np.array(integrator(x0=states[-1][-1], p=segment.spools)["xf"]).T)
            return np.concatenate(states) * problem.sizes

        return clocked(work)

    return {"CasADi CVODES": solve}
