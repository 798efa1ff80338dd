"""Figures 80 to 85: the two published control tasks, with hydrocrane's right-hand side.

The controller sits inside the right-hand side and its memory advances with the solver's stages,
as in the printed program (E22); hydrocrane's own controllers never do that.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from common import RUN_REPEATABILITY, figure, printed_controller, printed_program, program_rhs, save

import hydrocrane as hc

# Mean tip speeds that the text states, m/s, and the direction of each task in (x, z).
SPEEDS = {"vertical": 0.25, "horizontal": -0.3}
AXES = {"vertical": 1, "horizontal": 0}
# The slope of a straight line is taken from here on, when all pressures have built up, s.
UNDER_WAY = 1.0
HEIGHTS = {"vertical": ((0.0, -0.2), (5.0, 1.1)), "horizontal": ((0.0, -0.2), (3.0, -0.6), (5.0, -0.3))}


@cache
def run(task: str, gravity: str = "as-printed") -> tuple[np.ndarray, np.ndarray]:
    """Time (m,) and states (m, 18) of one task, states in the thesis's order."""
    crane = hc.load_machine("heinze-2007", overrides={"errata.gravity-sign": gravity})
    return printed_controller.published_run(program_rhs(crane), task)


def repeatability(key: str) -> float:
    """A mean speed repeats to the tip's repeatability over the 5 s of the run."""
    return RUN_REPEATABILITY / 5.0 if "speed" in key else RUN_REPEATABILITY


def tips(states: np.ndarray) -> np.ndarray:
    return np.array([printed_program.tip(y[[0, 6, 12]]) for y in states])


def compute() -> dict[str, float]:
    numbers = {}
    for task, printed in HEIGHTS.items():
        time, states = run(task)
        path = tips(states)
        height = {t: float(np.interp(t, time, path[:, 1])) for t, _ in printed}
        gaps = {t: abs(height[t] - z) for t, z in printed}
        numbers |= {f"{task}_z_at_{t:g}s_m": z for t, z in height.items()}
        numbers[f"{task}_start_deviation_m"] = gaps[0.0]
        numbers[f"{task}_end_deviation_m"] = gaps[5.0]
        numbers[f"{task}_deviation_m"] = max(gaps.values())
        numbers[f"{task}_x_drift_m"] = float(path[-1, 0] - path[0, 0])
        along = path[:, AXES[task]]
        even = np.linspace(UNDER_WAY, time[-1], 1001)
        mean = float((along[-1] - along[0]) / time[-1])
        numbers[f"{task}_mean_speed_m_s"] = mean
        numbers[f"{task}_speed_from_1s_m_s"] = float(np.polyfit(even, np.interp(even, time, along), 1)[0])
        numbers[f"{task}_speed_deviation_m_s"] = abs(mean - SPEEDS[task])
        time, states = run(task, "corrected")
        numbers[f"{task}_z_at_5s_gravity_down_m"] = printed_controller.tip_height(time, states, 5.0)
    return numbers


def draw() -> None:
    crane = hc.load_machine("heinze-2007")
    fig, axes = figure(2, 3, (11.0, 6.5))
    for row, (task, printed) in enumerate(HEIGHTS.items()):
        time, states = run(task)
        path = tips(states)
        for axis, y, number in zip(axes[row], (states[0], states[-1]), (80 + 3 * row, 81 + 3 * row)):
            for _, _, line in crane.drawing(y[[0, 6, 12]]):
                axis.plot(*np.asarray(line).T, "k-", lw=1.2)
            axis.plot(*path.T, color="tab:blue", lw=1)
            axis.set(title=f"Figure {number}", xlabel="x [m]", ylabel="z [m]", aspect="equal")
        axes[row, 2].plot(time, path[:, 0], label="x")
        axes[row, 2].plot(time, path[:, 1], label="z")
        axes[row, 2].plot(*zip(*printed), "ko", label="stated in the text")
        axes[row, 2].set(title=f"Figure {82 + 3 * row}", xlabel="time [s]", ylabel="tip [m]")
    axes[0, 2].legend(frameon=False)
    save(fig, "fig80_85_published_run")
