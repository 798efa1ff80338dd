"""What an open loop would gain at most by laws as fast as the exported C.

`python -m benches.own_runs` prints a line for each machine and method; needs a C compiler and a release build.
Times are those of calls in a row, of Jacobians with all entries on both sides. The trial: docs/theory/tape.md.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import hydrocrane as hc
from benches.measures.exported import EXPORTED, c_compiler, exports
from benches.measures.laws import nanoseconds, right_hand_side
from benches.problem import Problem, clocked

RUNS = {
    "rottne-f9-lab": "vertical-lift-open-loop",
    "hiab-xs031": "hiab-lift",
    "rottne-f9-mobile": "vertical-lift-open-loop",
}
METHODS = ("hc-exponential-4", "rodas5p", "hc-rosenbrock-3")
ROUNDS = 15
# What a run counts, and the same in C.
CALLS = {"rhs": EXPORTED["rhs"], "jacobians": "hydrocrane_linearise(x, u, 0, out, more);"}


def measure(machine: str, scenario: str, folder: Path) -> list[str]:
    """A line for each method."""
    problem, rtol = Problem(hc.load_scenario(scenario).changed(machine=machine)), hc.Solver().rtol
    crane, x = problem.crane, np.ascontiguousarray(problem.integrate("rodas5p", rtol)["states"])
    u = np.tile(0.1 * crane.spool_strokes, (len(x), 1))
    in_core = right_hand_side(crane, x, u), nanoseconds(lambda: crane.core.jacobian(x, u, 0.0), len(x))
    programs = [exports(crane, folder, c_compiler(), call)["own functions"] for call in CALLS.values()]
    saved = [own - min(program() for _ in range(ROUNDS)) for own, program in zip(in_core, programs, strict=True)]
    lines = []
    for method in METHODS:
        counts = problem.integrate(method, rtol)["stats"]
        seconds = min(clocked(lambda m=method: problem.integrate(m, rtol)["states"]).seconds for _ in range(ROUNDS))
        less = 1e-9 * sum(counts[what] * ns for what, ns in zip(CALLS, saved, strict=True))
        lines.append(
            f"{machine}, {method}: {1e3 * seconds:.2f} ms, by C {seconds / (seconds - less):.2f} times as fast"
        )
    return lines


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        for machine, scenario in RUNS.items():
            print("\n".join(measure(machine, scenario, Path(folder))))
