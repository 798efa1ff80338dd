"""The model as the thesis prints it, 18 states: with friction that jumps, where every solver chatters, and with the
sign of that friction run through zero over the velocity that the machine file can state."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

import hydrocrane as hc
from benches.competitors import compiled, own, scipy_solvers
from benches.problem import NotAvailable, Problem

SCENARIO = "heinze-2007-open-loop"
SMOOTHING = "1 mm/s"
# Largest distance of the tip from the reference, m. The jumping model does not tell more, its jumps see to that.
TIP_ERRORS = {"jumping": 2.5e-3, "smoothed": 1e-4}
REFERENCES = {"jumping": ("tsit5", 1e-4), "smoothed": ("rodas5p", 1e-8)}
TOLERANCES = {
    # The last ones are steps of two and one milliseconds of the method with fixed steps.
    "jumping": (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 3e-6, 1e-6),
    "smoothed": (1e-1, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5),
}
# Solvers that are left out: for the jumps these need minutes where the others need a fraction of a second, and fixed
# steps cannot follow the smoothed sign of friction to a tenth of a millimetre at a sensible size.
LEFT_OUT = {
    "jumping": {"hydrocrane rodas5p", "hydrocrane hc-exponential-4"},
    "smoothed": {"hydrocrane hc-rosenbrock-3"},
}
REPEATS = 5
# A run of so many seconds is not repeated, and after one of so many a solver is given up.
LONG, HOPELESS = 0.5, 10.0


def measure() -> dict[str, Any]:
    """Per variant, the loosest tolerance of each solver within its tip error, and the time it takes."""
    jumping = hc.load_scenario(SCENARIO)
    names = jumping.load_machine().cylinder_names
    smoothed = jumping.changed(overrides={f"friction.{name}.smoothing-velocity": SMOOTHING for name in names})
    problems = {"jumping": Problem(jumping), "smoothed": Problem(smoothed)}
    return {
        "duration_s": problems["jumping"].end,
        "states": problems["jumping"].start.size,
        "smoothing": SMOOTHING,
        "tip_errors_allowed_m": TIP_ERRORS,
        "variants": {
            kind: race(problem, REFERENCES[kind], TIP_ERRORS[kind], TOLERANCES[kind], LEFT_OUT[kind])
            for kind, problem in problems.items()
        },
    }


def race(
    problem: Problem,
    reference: tuple[str, float],
    allowed: float,
    tolerances: Sequence[float],
    left_out: Collection[str],
) -> dict[str, Any]:
    """Each solver's row at the loosest tolerance that keeps the tip within `allowed` m of the reference."""
    exact = problem.tip(problem.integrate(*reference)["states"])
    solvers = own.solvers(problem) | scipy_solvers.on_core(problem)
    for family in (compiled.cvode, compiled.diffsol):
        try:
            solvers |= family(problem)
        except NotAvailable:
            continue
    rows = {}
    for name, solve in solvers.items():
        for rtol in () if name in left_out else tolerances:
            run = solve(rtol)
            if run.seconds > HOPELESS:
                break
            if run.states.shape[0] != exact.shape[0]:
                continue
            error = float(np.linalg.norm(problem.tip(run.states) - exact, axis=1).max())
            if error <= allowed:
                times = [run.seconds] + [solve(rtol).seconds for _ in range(REPEATS - 1) if run.seconds < LONG]
                rows[name] = {"rtol": rtol, "tip_error_m": error, "seconds": min(times)} | run.counts
                break
    return rows
