"""A controller at 100 Hz: how fast, at what tip error."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import hydrocrane as hc
from benches.problem import REFERENCE, Solution, clocked
from hydrocrane import _core
from hydrocrane.scenario.scenario import scenario_entry

# Largest distance of the tip from the tightest run of the same loop, m.
TIP_ERROR = 5e-5
DURATION, PERIOD = 8.0, 0.01
TOLERANCES = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5)
STEPS = (PERIOD, PERIOD / 2, PERIOD / 4, PERIOD / 10)
RUNS = 30
START = {"boom": np.deg2rad(100), "jib": np.deg2rad(100), "extension": 0.0}
STICKS = {
    "tip": hc.Joystick([0.5, 3.5, 4.0, 7.0], {"z": [1, 0, -1, 0]}, full_speed=0.1, ramp=0.2),
    "lever": hc.Joystick(
        [0.5, 3.5, 4.0, 7.0],
        {"lift": [0.5, 0, -0.5, 0], "jib": [0.3, 0, -0.3, 0], "extension": [-0.2, 0, 0.2, 0]},
        mode="lever",
        ramp=0.2,
    ),
}


class Loop:
    """One controller with its stick on the laboratory crane, ideal sensors."""

    def __init__(self, controller: str, period: float = PERIOD) -> None:
        stick = STICKS[controller]
        plan = hc.Scenario(joints=START, joystick=stick, period=period, duration=DURATION, record_interval=0.01)
        self.plan, self.crane = plan, plan.load_machine()
        self.record = plan.record_times()

    def run(self, method: str, rtol: float, step: float | None = None) -> Solution:
        """The whole loop by the core, sampling, sensors and controller included."""
        solver = hc.Solver(method=method, rtol=rtol) if step is None else hc.Solver(method=method, step=step)
        entry = scenario_entry(self.plan.changed(solver=solver), self.crane.cylinder_names)
        kept: dict[str, Any] = {}

        def work() -> np.ndarray:
            kept.update(_core.run(self.crane.core, entry, self.record, False, None, None))
            return kept["states"]

        run = clocked(work, lambda: {name: kept["stats"][name] for name in ("steps", "rhs", "jacobians")})
        if kept["outcome"][0] != "completed":
            raise RuntimeError(f"the loop ended early: {kept['outcome']}")
        return run

    def tip(self, run: Solution) -> np.ndarray:
        return self.crane.tip(run.states[:, : len(self.crane.joint_names)])


def candidates() -> dict[str, Callable[[Loop], Solution]]:
    """Methods with their tolerances or steps, fixed steps where the package has them."""
    made = {
        f"{m} {r:g}": lambda p, m=m, r=r: p.run(m, r)
        for m in ("rodas5p", "hc-exponential-4", "tsit5")
        for r in TOLERANCES
    }
    if "step" in hc.Solver.__dataclass_fields__:
        made |= {f"hc-rosenbrock-3 {h * 1e3:g} ms": lambda p, h=h: p.run("hc-rosenbrock-3", 1e-4, h) for h in STEPS}
    return made


def measure() -> dict[str, Any]:
    """Per controller, every candidate with its tip error and time, and the fastest within TIP_ERROR."""
    rows: dict[str, Any] = {}
    for controller in STICKS:
        loop = Loop(controller)
        exact = loop.tip(loop.run("rodas5p", REFERENCE))
        found = {}
        for name, solve in candidates().items():
            runs = [solve(loop) for _ in range(RUNS)]
            error = float(np.linalg.norm(loop.tip(runs[0]) - exact, axis=1).max())
            seconds = min(run.seconds for run in runs)
            counts = {"tip_error_m": error, "seconds": seconds, "times_real_time": DURATION / seconds}
            found[name] = counts | runs[0].counts
        within = [name for name in found if found[name]["tip_error_m"] <= TIP_ERROR]
        best = max(within, key=lambda name: found[name]["times_real_time"])
        rows[controller] = {"best": best, "candidates": found}
    return rows
