"""First benchmark: right-hand side, Jacobian, and the open-loop run against SciPy's LSODA on the same right-hand side.

Run with ``make bench``. Prints a table and writes ``results.json`` beside this file; README.md says what is measured.
"""

from __future__ import annotations

import json
import platform
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np
from scipy.integrate import odeint, solve_ivp

import hydrocrane as hc

SCENARIO = "vertical-lift-open-loop"
REPEATS = 5
# Largest deviation of the tip from the reference along the run that a solver may have, m.
TIP_ERROR = 1e-5
TOLERANCES = [10 ** (-k / 4) for k in range(8, 41)]
REFERENCE = 1e-11
# Size of a state per kind: absolute tolerance of LSODA per unit of relative tolerance, as hydrocrane's own.
SIZES = {"q": 0.1, "qd": 0.1, "p1": 1e6, "p2": 1e6, "vs": 50.0, "z": 1e-3}


@dataclass
class Effort:
    """What one run took: seconds, and calls of the right-hand side and of the exact Jacobian."""

    seconds: float
    right_hand_sides: int
    jacobians: int


class Problem:
    """The scenario with its tables, so that every solver does the same work and nothing else."""

    def __init__(self) -> None:
        self.plan = hc.load_scenario(SCENARIO)
        self.crane = self.plan.load_machine()
        self.start = self.plan.initial_state(self.crane)
        self.times, self.spools, _ = self.plan.command_grid(self.crane)
        self.record = self.plan.record_times()
        sizes = dict(zip(self.crane.cylinder_names, self.crane.spool_strokes, strict=True))
        kinds = [(name.split(".")[1], name.split(".")[2]) for name in self.crane.state_names]
        self.sizes = np.array([sizes[owner] if kind == "xs" else SIZES[kind] for owner, kind in kinds])
        self.joints = len(self.crane.joint_names)

    def tip(self, states: np.ndarray) -> np.ndarray:
        return self.crane.tip(states[:, : self.joints])


def hydrocrane(problem: Problem, method: str, rtol: float) -> tuple[np.ndarray, Effort]:
    """States at the record times; the clock of the run itself, without the labelling of its results."""
    run = hc.simulate(problem.plan, machine=problem.crane, method=method, rtol=rtol, ledger=False)
    states = np.stack([run.data[name].values for name in problem.crane.state_names], axis=-1)
    about = run.data.attrs
    return states, Effort(about["wall_time"], about["solver_rhs"], about["solver_jacobians"])


def lsoda(problem: Problem, call: str, exact_jacobian: bool, rtol: float) -> tuple[np.ndarray, Effort]:
    """States at the record times by SciPy, started anew at every command as hydrocrane is."""
    count = [0, 0]
    core, mass, states = problem.crane.core, problem.crane.payload_mass, [problem.start[None]]
    began = time.perf_counter()
    for k, begin in enumerate(problem.times):
        end = problem.times[k + 1] if k + 1 < len(problem.times) else problem.plan.duration
        spool = problem.spools[k : k + 1]

        def rate(_t: float, x: np.ndarray, u: np.ndarray = spool) -> np.ndarray:
            count[0] += 1
            return core.state_derivative(x[None], u, mass)[0]

        def jacobian(_t: float, x: np.ndarray, u: np.ndarray = spool) -> np.ndarray:
            count[1] += 1
            return core.jacobian(x[None], u, mass)[0]

        inside = problem.record[(problem.record > begin + 1e-9) & (problem.record <= end + 1e-9)]
        jac = jacobian if exact_jacobian else None
        states.append(SEGMENT[call](rate, jac, (begin, end), states[-1][-1], inside, rtol, rtol * problem.sizes))
    return np.concatenate(states), Effort(time.perf_counter() - began, *count)


def by_solve_ivp(rate, jac, span, start, times, rtol, atol) -> np.ndarray:
    options = {"t_eval": np.minimum(times, span[1]), "rtol": rtol, "atol": atol, "max_step": 0.05}
    return solve_ivp(rate, span, start, method="LSODA", jac=jac, **options).y.T


def by_odeint(rate, jac, span, start, times, rtol, atol) -> np.ndarray:
    grid = np.concatenate([span[:1], times])
    options = {"rtol": rtol, "atol": atol, "hmax": 0.05, "mxstep": 100_000}
    return odeint(rate, start, grid, Dfun=jac, tfirst=True, tcrit=[span[1]], **options)[1:]


SEGMENT = {"solve_ivp": by_solve_ivp, "odeint": by_odeint}
SOLVERS: dict[str, Callable[[Problem, float], tuple[np.ndarray, Effort]]] = {
    "hydrocrane rodas5p": lambda p, rtol: hydrocrane(p, "rodas5p", rtol),
    "hydrocrane tsit5": lambda p, rtol: hydrocrane(p, "tsit5", rtol),
    "LSODA solve_ivp": lambda p, rtol: lsoda(p, "solve_ivp", False, rtol),
    "LSODA solve_ivp, exact Jacobian": lambda p, rtol: lsoda(p, "solve_ivp", True, rtol),
    "LSODA odeint": lambda p, rtol: lsoda(p, "odeint", False, rtol),
    "LSODA odeint, exact Jacobian": lambda p, rtol: lsoda(p, "odeint", True, rtol),
}


def nanoseconds(call: Callable[[], object], cases: int) -> float:
    """Median over REPEATS of the time per case of a batch call."""
    took = []
    for _ in range(REPEATS):
        began = time.perf_counter_ns()
        call()
        took.append((time.perf_counter_ns() - began) / cases)
    return statistics.median(took)


def measure_laws(problem: Problem, states: np.ndarray) -> dict[str, float]:
    """Right-hand side and exact Jacobian at the states of the run, in batches through Python."""
    x = np.ascontiguousarray(np.tile(states, (10, 1)))
    u = np.full((len(x), problem.joints), 0.01)
    core = problem.crane.core
    rhs = nanoseconds(lambda: core.state_derivative(x, u, 0.0), len(x))
    jacobian = nanoseconds(lambda: core.jacobian(x, u, 0.0), len(x))
    single = nanoseconds(lambda: [core.state_derivative(x[:1], u[:1], 0.0) for _ in range(2000)], 2000)
    return {
        "states": len(problem.crane.state_names),
        "rhs_ns": rhs,
        "jacobian_ns": jacobian,
        "jacobian_in_rhs": jacobian / rhs,
        "rhs_one_python_call_ns": single,
    }


def loosest_tolerance(problem: Problem, solver: str, exact: np.ndarray) -> tuple[float, float]:
    """The loosest relative tolerance from which on the tip error stays below TIP_ERROR, and its error."""
    chosen = None
    for rtol in reversed(TOLERANCES):
        states, _ = SOLVERS[solver](problem, rtol)
        error = np.linalg.norm(problem.tip(states) - exact, axis=1).max()
        if error > TIP_ERROR:
            break
        chosen = rtol, float(error)
    if chosen is None:
        raise RuntimeError(f"{solver} stays above a tip error of {TIP_ERROR} m even at rtol {TOLERANCES[-1]:g}")
    return chosen


def measure_runs(problem: Problem, exact: np.ndarray, laws: dict[str, float]) -> dict[str, dict[str, float]]:
    """All solvers at equal tip error, interleaved, so that a slow moment of the computer meets them all."""
    tuned = {solver: loosest_tolerance(problem, solver, exact) for solver in SOLVERS}
    efforts: dict[str, list[Effort]] = {solver: [] for solver in SOLVERS}
    for _ in range(REPEATS):
        for solver, (rtol, _) in tuned.items():
            efforts[solver].append(SOLVERS[solver](problem, rtol)[1])
    rows = {}
    for solver, (rtol, error) in tuned.items():
        seconds = statistics.median(e.seconds for e in efforts[solver])
        calls = efforts[solver][0]
        laws_alone = 1e-9 * (calls.right_hand_sides * laws["rhs_ns"] + calls.jacobians * laws["jacobian_ns"])
        rows[solver] = {
            "rtol": rtol,
            "tip_error_m": error,
            "seconds": seconds,
            "times_real_time": problem.plan.duration / seconds,
            "right_hand_sides": calls.right_hand_sides,
            "jacobians": calls.jacobians,
            "laws_alone_seconds": laws_alone,
        }
    fastest = min(rows[s]["seconds"] for s in rows if s.startswith("hydrocrane"))
    for row in rows.values():
        row["in_fastest_hydrocrane"] = row["seconds"] / fastest
        row["laws_alone_in_fastest_hydrocrane"] = row["laws_alone_seconds"] / fastest
    return rows


def print_tables(laws: dict[str, float], runs: dict[str, dict[str, float]]) -> None:
    print(f"right-hand side  {laws['rhs_ns']:8.0f} ns   ({laws['states']} states, in a batch)")
    print(f"one Python call  {laws['rhs_one_python_call_ns']:8.0f} ns   of the same right-hand side")
    print(f"exact Jacobian   {laws['jacobian_ns']:8.0f} ns   = {laws['jacobian_in_rhs']:.1f} right-hand sides\n")
    heads = ("rtol", "tip error", "time", "x real time", "x fastest", "laws alone", "x fastest", "rhs", "Jacobians")
    print(f"{SCENARIO:32}" + "".join(f"{head:>12}" for head in heads))
    for solver, row in runs.items():
        cells = (
            f"{row['rtol']:.1e}",
            f"{row['tip_error_m'] * 1e6:.1f} um",
            f"{row['seconds'] * 1e3:.2f} ms",
            f"{row['times_real_time']:.0f}",
            f"{row['in_fastest_hydrocrane']:.2f}",
            f"{row['laws_alone_seconds'] * 1e3:.2f} ms",
            f"{row['laws_alone_in_fastest_hydrocrane']:.2f}",
            f"{row['right_hand_sides']}",
            f"{row['jacobians']}",
        )
        print(f"{solver:32}" + "".join(f"{cell:>12}" for cell in cells))


def main() -> None:
    problem = Problem()
    reference, _ = hydrocrane(problem, "rodas5p", REFERENCE)
    laws = measure_laws(problem, reference)
    runs = measure_runs(problem, problem.tip(reference), laws)
    print_tables(laws, runs)
    about = {
        "hydrocrane": version("hydrocrane"),
        "scipy": version("scipy"),
        "python": platform.python_version(),
        "machine": platform.machine(),
        "repeats": REPEATS,
        "tip_error_allowed_m": TIP_ERROR,
    }
    results = {"about": about, "laws": laws, SCENARIO: runs}
    Path(__file__).with_name("results.json").write_text(json.dumps(results, indent=2) + "\n")


if __name__ == "__main__":
    main()
