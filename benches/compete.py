"""Open loop: every solver at the same or a smaller tip error than this package's, timed in pairs with it."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from benches.competitors import casadi_cvodes, compiled, own, scipy_solvers
from benches.problem import NotAvailable, Problem, Solution, Solver

# Largest tip error that this package may have at its operating point, m.
TIP_ERROR = 1e-5
OWN = "hydrocrane"
FAMILIES: dict[str, Callable[[Problem], dict[str, Solver]]] = {
    OWN: own.solvers,
    "CVODE": compiled.cvode,
    "diffsol": compiled.diffsol,
    "CasADi": casadi_cvodes.solvers,
    "SciPy, compiled laws": scipy_solvers.on_core,
    "SciPy, laws in NumPy": scipy_solvers.on_numpy,
}
# Runs that take longer than this are not repeated for a curve, s.
LONG = 0.2


@dataclass(frozen=True)
class Effort:
    """How thorough a measurement is: tolerances per decade, pairs of runs, pairs of long runs."""

    per_decade: int = 4
    pairs: int = 21
    long_pairs: int = 3

    def tolerances(self) -> Iterable[float]:
        """From loose to tight, 1e-2 to 1e-8."""
        return (10.0 ** (-k / self.per_decade) for k in range(2 * self.per_decade, 8 * self.per_decade + 1))


QUICK = Effort(per_decade=2, pairs=5, long_pairs=1)


def curve(problem: Problem, solver: Solver, effort: Effort, target: float) -> list[dict[str, Any]]:
    """Tip error, time and counts per tolerance; for solvers that take long it ends at the first error in the target."""
    points: list[dict[str, Any]] = []
    for rtol in effort.tolerances():
        run = solver(rtol)
        error = problem.tip_error(run.states)
        seconds = run.seconds
        if seconds < LONG:
            seconds = min([seconds] + [solver(rtol).seconds for _ in range(2)])
        points.append({"rtol": rtol, "tip_error_m": error, "seconds": seconds} | run.counts)
        if error <= target and seconds > LONG:
            break
    return [point for point in points if point["tip_error_m"] < float("inf")]


def operating_point(points: list[dict[str, Any]], target: float) -> dict[str, Any] | None:
    """The loosest tolerance within the target: a looser one costs less, whatever the clock said of single runs."""
    within = [point for point in points if point["tip_error_m"] <= target]
    return max(within, key=lambda point: point["rtol"], default=None)


def paired(ours: Callable[[], Solution], theirs: Callable[[], Solution], pairs: int) -> dict[str, float]:
    """Times of both and the median of their ratios, each pair run one right after the other."""
    runs = [(ours().seconds, theirs().seconds) for _ in range(pairs)]
    ratios = sorted(b / a for a, b in runs)
    return {
        "seconds": statistics.median(b for _, b in runs),
        "ratio": statistics.median(ratios),
        "ratio_low": ratios[len(ratios) // 4],
        "ratio_high": ratios[(3 * len(ratios)) // 4],
        "pairs": pairs,
    }


def compete(
    problem: Problem, effort: Effort, families: Iterable[str] = tuple(FAMILIES), say: Callable[[str], None] = print
) -> dict[str, Any]:
    """Rows of all solvers, curves for the work-precision picture, and what could not run."""
    missing: dict[str, str] = {}
    solvers: dict[str, tuple[str, Solver]] = {}
    for family in families:
        try:
            solvers |= {name: (family, solver) for name, solver in FAMILIES[family](problem).items()}
        except NotAvailable as reason:
            missing[family] = str(reason)
    names = [name for name, (family, _) in solvers.items() if family == OWN]
    curves = {name: curve(problem, solvers[name][1], effort, TIP_ERROR) for name in names}
    points = {name: operating_point(curves[name], TIP_ERROR) for name in names}
    ours = min((name for name in names if points[name]), key=lambda name: points[name]["seconds"])
    target = points[ours]["tip_error_m"]
    rows = {}
    for name, (family, solver) in solvers.items():
        if family != OWN:
            curves[name] = curve(problem, solver, effort, target)
            points[name] = operating_point(curves[name], target)
        point = points[name]
        if point is None:
            missing[name] = f"stays above {target * 1e6:.1f} um at every tolerance"
            continue
        pairs = effort.long_pairs if point["seconds"] > LONG else effort.pairs
        timed = paired(lambda: solvers[ours][1](points[ours]["rtol"]), lambda: solver(point["rtol"]), pairs)
        rows[name] = point | timed | {"family": family, "times_real_time": problem.end / timed["seconds"]}
        say(f"{name:42}{point['tip_error_m'] * 1e6:8.2f} um{timed['seconds'] * 1e3:11.3f} ms{timed['ratio']:10.1f}")
    return {"ours": ours, "rows": rows, "curves": curves, "missing": missing}
