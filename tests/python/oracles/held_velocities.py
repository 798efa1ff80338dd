"""A log of a piston that moves at held velocities against a known friction, in NumPy: no code of the core."""

from __future__ import annotations

import numpy as np

from hydrocrane.signals import RigParameters

RATE = 1000.0
RIG = RigParameters(piston_area=3.117e-3, rod_area=2.111e-3, mass=200.0, gravity=9.81)
SPEEDS = (5e-4, 0.005, 0.02, 0.05, -5e-4, -0.005, -0.02, -0.05)


def friction(v):
    """Coulomb, Stribeck and viscous, N."""
    return np.sign(v) * (300.0 + 120.0 * np.exp(-((np.abs(v) / 0.01) ** 2))) + 4000.0 * v


def made(seed=0, seconds=3.0, speeds=SPEEDS):
    """A log at `RATE` with half a second of rest around every held velocity."""
    rng = np.random.default_rng(seed)
    v = np.concatenate([part for speed in speeds for part in (np.zeros(500), np.full(int(seconds * RATE), speed))])
    v = np.concatenate([v, np.zeros(500)])
    time = np.arange(v.size) / RATE
    x = np.cumsum(v) / RATE
    p2 = 20e5 + 0.0 * time
    p1 = (friction(v) - RIG.mass * RIG.gravity + p2 * RIG.rod_area) / RIG.piston_area
    return {
        "time": time,
        "x": x + rng.normal(0, 2e-5, time.size),
        "p1": p1 + rng.normal(0, 3e3, time.size),
        "p2": p2 + rng.normal(0, 3e3, time.size),
    }
