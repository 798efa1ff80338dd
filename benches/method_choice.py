"""Which method `auto` should take: all that choose their steps, at equal error, on machines with and without bristles.

`python -m benches.method_choice` prints the table of docs/theory/integration.md. Per case `rodas5p` runs at the default
tolerance; each other method runs at its loosest tolerance whose tip error is not larger, four tolerances per decade, in
pairs with it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import hydrocrane as hc
from benches.compete import Effort, paired
from benches.problem import Problem, Solution, clocked

MEASURED, OTHERS = "rodas5p", ("hc-exponential-4", "tsit5")
TOLERANCE = 1e-4
DURATION = 20.0
EFFORT = Effort(per_decade=4, pairs=11, long_pairs=3)
# Machines on pumps of their own, under full and half spools that change at once every half second.
ON_PUMPS = {"rottne-f9-pump": 200.0, "rottne-f9-ls": 200.0, "rottne-f9-mobile": 400.0}
GROUND = {"ground.height": "-1.21 m", "payload.hang": "0.32 m", "payload.hang-growth": "0.044 m/kg^0.5"}


def static(scenario: str) -> hc.Scenario:
    """The scenario with the static map in every cylinder."""
    plan = hc.load_scenario(scenario)
    cylinders = plan.load_machine().cylinder_names
    return plan.changed(overrides={f"friction.{cylinder}.model": "static" for cylinder in cylinders})


def steps(name: str, payload: float, seed: int = 0) -> hc.Scenario:
    """A random drive by steps of the spools, from the machine's own pose with a load (kg)."""
    machine, draw = hc.load_machine(name), np.random.default_rng(seed)
    times = np.arange(0.0, 6.0, 0.5)
    shares = draw.choice([-1.0, -0.5, 0.0, 0.0, 0.5, 1.0], size=(times.size, len(machine.cylinder_names)))
    spools = dict(zip(machine.cylinder_names, (shares * machine.spool_strokes).T, strict=True))
    return hc.Scenario(
        machine=machine,
        joints=dict(zip(machine.joint_names, machine.home, strict=True)),
        payload=payload,
        commands={cylinder: hc.Command(times, spool, "hold") for cylinder, spool in spools.items()},
        duration=6.0,
    )


def cases() -> Iterator[tuple[str, hc.Scenario]]:
    """What is run, by a title."""
    bristles = (
        "vertical-lift-open-loop",
        "hiab-lift",
        "single-cylinder-step",
        "rig-load-variation",
        "tip-vertical-line",
    )
    for name in bristles:
        plan = hc.load_scenario(name)
        yield name, plan.changed(duration=min(plan.duration, DURATION))
    for name, payload in ON_PUMPS.items():
        yield f"{name}, {payload:g} kg, random steps", steps(name, payload)
    lowered = {"lift": ([0.0, 7.0, 10.0], [-0.015, 0.0, 0.015])}
    yield (
        "300 kg set down on the ground",
        hc.Scenario(
            machine="rottne-f9-lab",
            joints={"boom": 1.9, "jib": 1.7, "extension": 0.0},
            payload=300.0,
            payload_changes={8.0: 0.0, 9.0: 300.0},
            commands=lowered,
            duration=12.0,
            overrides=GROUND,
        ),
    )
    for name in ("vertical-lift-open-loop", "hiab-lift", "single-cylinder-step", "tip-vertical-line"):
        yield f"{name}, static friction", static(name)
    smooth = {"errata.friction-map": "corrected", "errata.orifice-law": "corrected"}
    yield (
        "heinze-2007-open-loop, no law that jumps",
        hc.load_scenario("heinze-2007-open-loop").changed(overrides=smooth),
    )


def solved(problem: Problem, method: str, rtol: float) -> Solution:
    """One run under the clock of all benchmarks."""
    return clocked(lambda: problem.integrate(method, rtol)["states"])


def loosest(problem: Problem, method: str, target: float) -> tuple[float, float] | None:
    """The loosest tolerance whose tip error (m) is within the target, with this error."""
    for rtol in EFFORT.tolerances():
        error = problem.tip_error(solved(problem, method, rtol).states)
        if error <= target:
            return rtol, error
    return None


def row(title: str, plan: hc.Scenario) -> str:
    """A row of the table: errors, tolerances and the median of the ratios of CPU time."""
    problem = Problem(plan)
    first = solved(problem, MEASURED, TOLERANCE)
    target = problem.tip_error(first.states)
    cells = [title, f"{target * 1e6:.2g}", f"{first.seconds * 1e3:.1f}"]
    for method in OTHERS:
        same = problem.tip_error(solved(problem, method, TOLERANCE).states)
        found = loosest(problem, method, target)
        cells.append(f"{same * 1e6:.2g}")
        if found is None:
            cells.append("at no tolerance")
            continue
        rtol, _ = found
        timed = paired(
            lambda: solved(problem, MEASURED, TOLERANCE), lambda m=method, r=rtol: solved(problem, m, r), EFFORT.pairs
        )
        cells.append(f"{timed['ratio']:.2g} at {rtol:.0e}")
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    heads = [f"`{m}`, error at {TOLERANCE:.0e} | `{m}`, time at equal error" for m in OTHERS]
    print("| case | " + f"`{MEASURED}` at {TOLERANCE:.0e}: tip error, um | ms | " + " | ".join(heads) + " |")
    print("|---|" + "---|" * (2 + 2 * len(OTHERS)))
    for title, plan in cases():
        print(row(title, plan), flush=True)


if __name__ == "__main__":
    main()
