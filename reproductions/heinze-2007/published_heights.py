"""The heights of Figures 80 to 85 from model to model: the program restated, hydrocrane as printed, sampled, corrected.

The restated program is the oracle of the tests, written from the listing without hydrocrane. The sampled rows run the
printed PID once every 0.2 ms, outside the solver.
"""

from __future__ import annotations

import numpy as np
from common import RUN_REPEATABILITY, completed, printed_controller, printed_program

import hydrocrane as hc

INSTANTS = (3.0, 5.0)
SAMPLE_TIME = 2e-4
ROWS = {
    "program": "the printed program, restated from its listing",
    "sampled": "as printed, PID sampled at 0.2 ms",
    "corrected": "`rottne-f9-lab`, PID sampled at 0.2 ms",
}


def repeatability(_: str) -> float:
    return RUN_REPEATABILITY


def program_heights(task: str) -> list[float]:
    """Tip heights of the restated program, m."""
    time, states = printed_controller.published_run(printed_program.state_derivative, task)
    return [printed_controller.tip_height(time, states, instant) for instant in INSTANTS]


def sampled_heights(machine: str, task: str) -> list[float]:
    """Tip heights under `heinze-pid` with one set-point for the whole run, as in the thesis, m."""
    way = np.array(printed_controller.TASKS[task])
    distance = float(np.abs(way).max())
    stick = hc.Joystick([0.0], dict(zip("xz", (way / distance)[:, np.newaxis], strict=True)), full_speed=distance / 5.0)
    explicit, stiff = hc.Solver(method="tsit5", rtol=1e-3), hc.Solver(method="rodas5p")
    plan = hc.Scenario(
        machine=machine,
        joints={"boom": np.deg2rad(100.0), "jib": np.deg2rad(100.0), "extension": 0.0},
        pressures=dict.fromkeys(("lift", "jib", "extension"), (0.0, 0.0)),
        duration=INSTANTS[-1],
        # The thesis's run has one set-point, set at once, and nothing that keeps the tip from anywhere.
        overrides={"control.heinze-pid.set-point-interval": 5.0, "control.heinze-pid.working-area": "none"},
        controller="heinze-pid",
        joystick=stick,
        period=SAMPLE_TIME,
        solver=explicit if machine == "heinze-2007" else stiff,
    )
    data = completed(hc.simulate(plan, ledger=False))
    return [float(np.interp(instant, data.time.values, data["tip.z"].values)) for instant in INSTANTS]


def compute() -> dict[str, float]:
    numbers = {}
    for task in printed_controller.TASKS:
        heights = {
            "program": program_heights(task),
            "sampled": sampled_heights("heinze-2007", task),
            "corrected": sampled_heights("rottne-f9-lab", task),
        }
        for row, values in heights.items():
            for instant, z in zip(INSTANTS, values, strict=True):
                numbers[f"{row}.{task}_z_at_{instant:g}s_m"] = z
    return numbers
