"""How cost grows: with joints, controller rate, recording and workers. Tolerance is in the curves of ``compete``."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import hydrocrane as hc
from benches.measures.closed_loop import DURATION, Loop
from benches.measures.laws import right_hand_side
from benches.models.chain import write_chain
from benches.problem import Problem, clocked

# The fastest of the package by tolerance.
METHOD = "hc-exponential-4"
RUNS = 15
JOINTS = range(1, 7)
RATES = (10, 20, 50, 100, 200, 500, 1000)
WORKERS, CASES = (1, 2), 1000
INTERVALS = (1.0, 0.1, 0.01, 0.001, 0.0001)


def chain_problem(joints: int, folder: Path) -> Problem:
    """A chain that stands level and is pushed for a second at every joint."""
    crane = hc.load_machine(write_chain(joints, folder))
    push = hc.Command(np.array([0.0, 0.2, 1.0]), np.array([0.0, 0.002, 0.0]))
    plan = hc.Scenario(
        machine=crane,
        joints=dict.fromkeys(crane.joint_names, 0.0),
        commands=dict.fromkeys(crane.cylinder_names, push),
        duration=2.0,
    )
    return Problem(plan)


def _least(work) -> float:
    return min(clocked(work).seconds for _ in range(RUNS))


def by_joints(rtol: float = 1e-4) -> list[dict[str, Any]]:
    """Chains of one to six links, a cylinder each."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for joints in JOINTS:
            problem = chain_problem(joints, Path(folder))
            raw = problem.integrate(METHOD, rtol)
            seconds = _least(lambda: problem.integrate(METHOD, rtol)["states"])
            x = np.ascontiguousarray(np.tile(raw["states"], (10, 1)))
            u = np.zeros((len(x), joints))
            row = {"joints": joints, "states": problem.start.size, "steps": raw["stats"]["steps"]}
            row |= {"seconds_per_step": seconds / raw["stats"]["steps"], "rhs_ns": right_hand_side(problem.crane, x, u)}
            rows.append(row | {"times_real_time": problem.end / seconds})
    return rows


def by_controller_rate(rtol: float = 1e-4) -> list[dict[str, float]]:
    """The lever at ten to a thousand samples per second."""
    rows = []
    for rate in RATES:
        loop = Loop("lever", 1 / rate)
        seconds = _least(lambda: loop.run(METHOD, rtol).states)
        rows.append({"rate_hz": rate, "times_real_time": DURATION / seconds})
    return rows


def by_recording(rtol: float = 1e-4) -> list[dict[str, float]]:
    """The open-loop lift recorded once a second to every tenth of a millisecond."""
    rows = []
    for interval in INTERVALS:
        problem = Problem(hc.load_scenario("vertical-lift-open-loop").changed(record_interval=interval))
        seconds = _least(lambda: problem.integrate(METHOD, rtol)["states"])
        rows.append({"interval_s": interval, "times_real_time": problem.end / seconds})
    return rows


def by_workers(cases: int = CASES) -> list[dict[str, float]]:
    """A study of random loads and supplies, on one thread and on two; by the wall clock."""
    keys = {"payload.mass": (0.0, 200.0), "supply.pressure": ("120 bar", "180 bar")}
    rows = []
    for workers in WORKERS:
        began = time.perf_counter()
        hc.sweep("vertical-lift-open-loop", keys, method="latin", n=cases, workers=workers, progress=False)
        rows.append({"workers": workers, "cases_per_second": cases / (time.perf_counter() - began)})
    return rows


def measure() -> dict[str, Any]:
    found = {"joints": by_joints(), "controller_rate": by_controller_rate(), "recording": by_recording()}
    return found | ({"workers": by_workers()} if hasattr(hc, "sweep") else {})
