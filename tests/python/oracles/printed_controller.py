"""The thesis program's controller: inverse kinematics and PID, evaluated inside the solver.

Source: Heinze (2007), CRANE_MAIN (section 7.2), equations (35)-(39), (129), (130). The program
calls the controller at every evaluation of the right-hand side, so its memory advances with the
solver's stages and its integral gain acts per evaluation, not per second.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import RK23

from . import printed_program as program

GAINS = ((1.0, 1e-4, 0.01), (1.0, 5e-3, 0.01), (1.0, 5e-3, 0.01))  # proportional, integral, derivative
SPOOL_SIGNS = (1.0, -1.0, 1.0)
TASKS = {"vertical": (0.0, 2.5), "horizontal": (-2.5, 0.0)}  # one set-point 5 s x 0.5 m/s away
START = np.zeros((3, 6))
START[:2, 0] = np.deg2rad(100.0)


def ik(target: np.ndarray, x3: float = 0.0) -> np.ndarray:
    """Joint targets (3,) for a tip position (x, z) at a given extension (the program's is 0).

    The angle at the boom joint comes from unsigned arc cosines, as printed.
    """
    arm = program.beam_offset(x3) + program.TIP_ON_BEAM
    r2, r3 = abs(program.JIB_JOINT), abs(arm)
    point = complex(*target)
    pillar = abs(program.PILLAR_JOINT)
    diagonal = abs(point - program.PILLAR_JOINT)
    beta = np.arccos((r2**2 + r3**2 - diagonal**2) / (2 * r2 * r3))
    alpha = np.arccos((pillar**2 + diagonal**2 - abs(point) ** 2) / (2 * pillar * diagonal)) + np.arccos(
        (r2**2 + diagonal**2 - r3**2) / (2 * r2 * diagonal)
    )
    tilt = np.arctan(program.JIB_JOINT.imag / program.JIB_JOINT.real)
    return np.array([alpha - tilt, beta + tilt - np.arctan(arm.imag / arm.real), x3])


class IncrementalPid:
    """Three PID loops in the incremental form; `step` maps joint errors to spool commands (m)."""

    def __init__(self) -> None:
        self.errors = np.zeros((3, 3))  # newest first
        self.output = np.zeros(3)

    def step(self, error: np.ndarray) -> np.ndarray:
        self.errors = np.vstack([error, self.errors[:2]])
        now, before, earlier = self.errors
        kp, ki, kd = np.array(GAINS).T
        change = kp * (now - before) + ki * now + kd * (now - 2 * before + earlier)
        self.output = np.clip(self.output + change, -program.SPOOL_STROKE, program.SPOOL_STROKE)
        return np.array(SPOOL_SIGNS) * self.output


def published_run(
    rhs: Callable[[np.ndarray, np.ndarray], np.ndarray], task: str, duration: float = 5.0
) -> tuple[np.ndarray, np.ndarray]:
    """Run one of the two published tasks as the program does.

    Parameters
    ----------
    rhs : callable
        `rhs(state, spool_command)` with the state in the thesis's order.
    task : {"vertical", "horizontal"}

    Returns
    -------
    time (m,) in s and states (m, 18); Bogacki-Shampine steps with both tolerances 0.1.
    """
    start = START.ravel()
    target = ik(program.tip(START[:, 0]) + np.array(TASKS[task]))
    pid = IncrementalPid()

    def closed_loop(_: float, state: np.ndarray) -> np.ndarray:
        return rhs(state, pid.step(target - state[[0, 6, 12]]))

    solver = RK23(closed_loop, 0.0, start, duration, rtol=0.1, atol=0.1)
    times, states = [0.0], [start]
    while solver.status == "running":
        solver.step()
        times.append(solver.t)
        states.append(solver.y.copy())
    if solver.status != "finished":
        raise RuntimeError(f"the published {task} run failed at t = {solver.t:.3f} s")
    return np.array(times), np.array(states)


def tip_height(time: np.ndarray, states: np.ndarray, instant: float) -> float:
    """Height of the tip at one instant, linear between steps, m."""
    heights = [program.tip(s[[0, 6, 12]])[1] for s in states]
    return float(np.interp(instant, time, heights))
