"""What one right-hand side and one Jacobian of the crane cost."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

import hydrocrane as hc
from benches.competitors.compiled import Task
from benches.problem import NotAvailable, Problem

ROUNDS = 15


def nanoseconds(call: Callable[[], object], cases: int) -> float:
    """Least CPU time per case of a call."""
    took = []
    for _ in range(ROUNDS):
        began = time.thread_time_ns()
        call()
        took.append((time.thread_time_ns() - began) / cases)
    return min(took)


def right_hand_side(crane: hc.Machine, x: np.ndarray, u: np.ndarray) -> float:
    """ns per state, in a batch through Python."""
    return nanoseconds(lambda: crane.core.state_derivative(x, u, 0.0), len(x))


def pace() -> float:
    """How fast the processor is just now: the right-hand side of a crane at rest, ns."""
    crane = hc.load_machine("rottne-f9-lab")
    x = np.tile(crane.equilibrium(np.deg2rad([100, 100, 0])), (5000, 1))
    u = np.zeros((len(x), len(crane.cylinder_names)))
    return right_hand_side(crane, x, u)


def measure(problem: Problem) -> dict[str, Any]:
    """Laws at the states of the run: in batches through Python, and one state per call."""
    x = np.ascontiguousarray(np.tile(problem.integrate("rodas5p", 1e-6)["states"], (10, 1)))
    u = np.full((len(x), len(problem.crane.cylinder_names)), 0.01)
    core = problem.crane.core
    jacobian = nanoseconds(lambda: core.jacobian(x, u, 0.0), len(x))
    single = nanoseconds(lambda: [core.state_derivative(x[:1], u[:1], 0.0) for _ in range(2000)], 2000)
    return compiled(problem, x) | {
        "states": len(problem.crane.state_names),
        "rhs_ns": right_hand_side(problem.crane, x, u),
        "dense_jacobian_ns": jacobian,
        "rhs_one_python_call_ns": single,
    }


def compiled(problem: Problem, x: np.ndarray) -> dict[str, float]:
    """The laws called from Rust, where the library for that can be built."""
    try:
        task = Task(problem)
    except NotAvailable:
        return {}
    return {
        "compiled_rhs_ns": nanoseconds(lambda: task.evaluate(x, False), len(x)),
        "compiled_structured_ns": nanoseconds(lambda: task.evaluate(x, True), len(x)),
    }
