"""Fixed steps of one millisecond, one by one as a real-time loop takes them: how long each takes."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

import hydrocrane as hc
from benches.problem import NotAvailable

STEP = 1e-3
MANOEUVRES, DURATION, HOLD = 50, 4.0, 0.05
# Steps of the random walk of commands, and the most they reach, m.
CHANGE, MOST = 0.01, 0.025
POSE = np.deg2rad([100, 100, 0])
PYTHON_CALLS = 20_000


def commands(manoeuvre: int) -> np.ndarray:
    """Spools (samples, cylinders) of one random manoeuvre, a new command every HOLD."""
    rng = np.random.default_rng(manoeuvre)
    spools, rows = np.zeros(POSE.size), []
    for _ in range(round(DURATION / HOLD)):
        spools = np.clip(spools + CHANGE * rng.uniform(-1, 1, POSE.size), -MOST, MOST)
        rows += [spools] * round(HOLD / STEP)
    return np.array(rows)


def microseconds(took: np.ndarray) -> dict[str, float]:
    shares = {"median_us": 0.5, "p99_us": 0.99, "p999_us": 0.999}
    return {name: float(np.quantile(took, share)) * 1e6 for name, share in shares.items()}


def measure(manoeuvres: int = MANOEUVRES) -> dict[str, Any]:
    """Steps as the core takes them, and as ``hc.Simulator.step`` hands them to Python, with its observation."""
    if "step" not in hc.Solver.__dataclass_fields__:
        raise NotAvailable("this version has no method of fixed steps")
    crane = hc.load_machine("rottne-f9-lab")
    simulator = hc.Simulator(crane, sample_time=STEP, method="hc-rosenbrock-3", step=STEP)
    alone = []
    for manoeuvre in range(manoeuvres):
        simulator.reset(q=POSE)
        # A manoeuvre may end at a stop of the stroke; what was timed until then counts.
        alone.append(simulator._core.step_times(commands(manoeuvre)))
    steps = np.concatenate(alone)
    return {
        "step_s": STEP,
        "steps": steps.size,
        "core": microseconds(steps),
        "python": microseconds(_called(simulator)),
    }


def _called(simulator: hc.Simulator) -> np.ndarray:
    """Seconds per call of ``step`` with the valves closed."""
    simulator.reset(q=POSE)
    closed, took = np.zeros(POSE.size), np.empty(PYTHON_CALLS)
    for k in range(took.size):
        began = time.perf_counter_ns()
        simulator.step(closed)
        took[k] = time.perf_counter_ns() - began
    return took * 1e-9
