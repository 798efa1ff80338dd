"""Fixed steps of one millisecond: how long each takes, called from Python."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

import hydrocrane as hc
from benches.problem import NotAvailable

STEP = 1e-3
SAMPLES = 50_000
POSE = np.deg2rad([100, 100, 0])


def measure(samples: int = SAMPLES) -> dict[str, Any]:
    """Median and rare step of ``hc.Simulator`` under commands that change every tenth of a second."""
    if "step" not in hc.Solver.__dataclass_fields__:
        raise NotAvailable("this version has no method of fixed steps")
    crane = hc.load_machine("rottne-f9-lab")
    simulator = hc.Simulator(crane, sample_time=STEP, method="ros3p", step=STEP)
    simulator.reset(q=POSE)
    rng = np.random.default_rng(0)
    # Small openings of changing sign: the crane swings about its pose all the time.
    commands = 0.1 * crane.spool_strokes * rng.uniform(-1, 1, (samples // 100 + 1, len(crane.cylinder_names)))
    took = np.empty(samples)
    for k in range(samples):
        spools = commands[k // 100]
        began = time.perf_counter_ns()
        simulator.step(spools)
        took[k] = time.perf_counter_ns() - began
    return {
        "step_s": STEP,
        "samples": samples,
        "median_us": float(np.median(took)) * 1e-3,
        "p999_us": float(np.quantile(took, 0.999)) * 1e-3,
    }
