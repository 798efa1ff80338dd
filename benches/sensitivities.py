"""Second benchmark: cost and accuracy of the sensitivities of a run to keys of its machine.

Run with ``make bench``. Prints two tables and writes ``sensitivities.json`` beside this file; README.md says what is
measured. ``docs/reference/sensitivities.py`` takes the tables of the documentation from there.
"""

from __future__ import annotations

import json
import platform
import statistics
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

import hydrocrane as hc
from hydrocrane.analysis.sensitivity import Experiment, solve

REPEATS = 15
COUNTS = (1, 4, 8)
# Long enough to be a run, short enough to take no step that counts.
INSTANT = 1e-6

RIG, CRANE = "single-cylinder-step", "vertical-lift-open-loop"
RIG_KEYS = (
    "friction.test.coulomb[0]",
    "friction.test.bristle-stiffness",
    "payload.mass",
    "supply.pressure",
    "fluid.bulk-modulus-max",
    "valve.test.natural-frequency",
    "friction.test.viscous[0]",
    "friction.test.breakaway[0]",
)
CRANE_KEYS = (
    "friction.lift.coulomb[0]",
    "friction.lift.bristle-stiffness",
    "link.boom.mass",
    "supply.pressure",
    "fluid.bulk-modulus-max",
    "valve.lift.natural-frequency",
    "friction.lift.viscous[0]",
    "friction.jib.coulomb[0]",
)
RUNS: dict[str, dict[str, Any]] = {
    RIG: {"keys": RIG_KEYS, "duration": 2.0, "record_interval": 0.01},
    CRANE: {"keys": CRANE_KEYS, "duration": 5.0, "record_interval": 0.01},
}
COST_SOLVER: dict[str, Any] = {"method": "tsit5", "rtol": 1e-4}

EXACT_KEYS = RIG_KEYS[:6]
SIGNALS = (
    "joint.slide.q",
    "joint.slide.qd",
    "cylinder.test.p1",
    "cylinder.test.p2",
    "cylinder.test.z",
    "cylinder.test.friction",
)
METHODS = ("tsit5", "rodas5p", "hc-exponential-4")
# Those that are run to REFERENCE, the first compared with the last.
EXACT = ("tsit5", "rodas5p")
TOLERANCES = (1e-4, 1e-6, 1e-8)
REFERENCE = 1e-11


def milliseconds(call: Callable[[], object]) -> float:
    """Median over REPEATS of the CPU time of a call."""
    took = []
    for _ in range(REPEATS):
        began = time.process_time()
        call()
        took.append(time.process_time() - began)
    return 1e3 * statistics.median(took)


def measure_cost(scenario: str) -> dict[str, Any]:
    """Times of a run alone and of runs with sensitivities, and of these the time before the first step."""
    about = RUNS[scenario]
    fields = {name: about[name] for name in ("duration", "record_interval")} | COST_SOLVER
    plan = hc.load_scenario(scenario).changed(**fields)
    crane = plan.load_machine()
    alone = [hc.simulate(plan, machine=crane, ledger=False).data.attrs["wall_time"] for _ in range(REPEATS)]
    rows = {}
    for count in COUNTS:
        keys = about["keys"][:count]
        whole, start = Experiment(plan, keys), Experiment(plan, keys, duration=INSTANT, times=[0.0])
        rows[str(count)] = {"ms": milliseconds(whole.run), "before_the_first_step_ms": milliseconds(start.run)}
    return {
        "duration_s": plan.duration,
        "times": int(plan.record_times().size),
        "alone_ms": 1e3 * statistics.median(alone),
        "keys": rows,
    }


def errors(found: np.ndarray, exact: np.ndarray) -> tuple[float, float]:
    """Largest error of any slope, and the largest root mean square over time; shares of the slope's largest value."""
    share = (found - exact) / np.abs(exact).max(axis=0)
    return float(np.abs(share).max()), float(np.sqrt((share**2).mean(axis=0)).max())


def measure_errors() -> dict[str, Any]:
    """Errors against a tight run for all methods, with and without the sensitivities in the step size control."""

    def run(method: str, rtol: float, resolve: bool) -> tuple[np.ndarray, int]:
        made = Experiment(RIG, EXACT_KEYS, signals=SIGNALS, resolve_sensitivities=resolve, method=method, rtol=rtol)
        raw = made.run()
        found = made.select(raw)
        if not found.outcome.completed:
            raise RuntimeError(f"the run ended early: {found.outcome}")
        return found.sensitivities, int(raw["stats"]["steps"])

    other, exact = (run(method, REFERENCE, True)[0] for method in EXACT)
    rows = []
    for method in METHODS:
        for rtol in TOLERANCES:
            row: dict[str, Any] = {"method": method, "rtol": rtol}
            for name, resolve in (("states", False), ("slopes", True)):
                found, steps = run(method, rtol, resolve)
                largest, mean = errors(found, exact)
                row[name] = {"steps": steps, "largest_error": largest, "root_mean_square_error": mean}
            rows.append(row)
    return {"reference_difference": errors(other, exact)[0], "rows": rows}


def print_tables(costs: dict[str, Any], exactness: dict[str, Any]) -> None:
    print("CPU time [ms]" + " " * 19 + "alone" + "".join(f"{count:>8} keys" for count in COUNTS))
    for scenario, cost in costs.items():
        cells = "".join(f"{cost['keys'][str(count)]['ms']:13.2f}" for count in COUNTS)
        print(f"{scenario:30} {cost['alone_ms']:6.2f}{cells}")
        cells = "".join(f"{cost['keys'][str(count)]['before_the_first_step_ms']:13.2f}" for count in COUNTS)
        print(f"{'  before the first step':37}{cells}")
    print(f"\n{'method':10}{'rtol':>8}   step control by states: steps, error   by sensitivities: steps, error")
    for row in exactness["rows"]:
        cells = "".join(f"{row[n]['steps']:17} {row[n]['largest_error']:11.1e}" for n in ("states", "slopes"))
        print(f"{row['method']:10}{row['rtol']:8.0e}{cells}")
    print(f"references of both methods differ by {exactness['reference_difference']:.1e}")


def main() -> None:
    # A first call loads what is loaded once.
    solve(Experiment(RIG, RIG_KEYS[0], duration=0.1))
    costs = {scenario: measure_cost(scenario) for scenario in RUNS}
    exactness = measure_errors()
    print_tables(costs, exactness)
    about = {
        "hydrocrane": version("hydrocrane"),
        "python": platform.python_version(),
        "machine": platform.machine(),
        "repeats": REPEATS,
    }
    results = {"about": about, "cost": costs, "exactness": exactness}
    Path(__file__).with_name("sensitivities.json").write_text(json.dumps(results, indent=2) + "\n")


if __name__ == "__main__":
    main()
