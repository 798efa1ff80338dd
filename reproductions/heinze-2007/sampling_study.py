"""Erratum E22: the printed PID, properly sampled, for several sampling times.

The printed program calls its PID at every evaluation of the right-hand side, so its gains are per call. Here the
same PID with the same gains runs once per sampling time, outside the solver, with its spool commands held.
"""

from __future__ import annotations

import numpy as np
from common import RUN_REPEATABILITY, printed_controller

import hydrocrane as hc

SAMPLE_TIMES = (1e-4, 2e-4, 2.8e-4, 1e-3, 1e-2)
DURATION = 5.0
# The printed laws jump: an explicit method at a moderate tolerance, as in the thesis.
SOLVER = {"method": "tsit5", "rtol": 1e-3}


def repeatability(_: str) -> float:
    return RUN_REPEATABILITY


def final_tip(task: str, sample_time: float, overrides: dict[str, str]) -> np.ndarray:
    """Tip (x, z) after 5 s, m."""
    crane = hc.load_machine("heinze-2007", overrides=overrides)
    simulator = hc.Simulator(crane, sample_time=sample_time, **SOLVER)
    start = np.array([np.deg2rad(100.0), np.deg2rad(100.0), 0.0])
    observed = simulator.reset(state=crane.pack_state(start))
    target = printed_controller.ik(observed.tip + np.array(printed_controller.TASKS[task]))
    pid = printed_controller.IncrementalPid()
    for _ in range(round(DURATION / sample_time)):
        observed = simulator.step(pid.step(target - observed.q))
    return observed.tip


def compute() -> dict[str, float]:
    numbers = {}
    for case, overrides in {"as-printed": {}, "gravity-down": {"errata.gravity-sign": "corrected"}}.items():
        for sample_time in SAMPLE_TIMES:
            for task in printed_controller.TASKS:
                height = final_tip(task, sample_time, overrides)[1]
                numbers[f"{case}.{sample_time * 1e3:g} ms.{task}_z_at_5s_m"] = float(height)
    return numbers
