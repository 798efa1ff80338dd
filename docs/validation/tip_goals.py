"""Random goals of the tip, point to point: `python docs/validation/tip_goals.py [RUNS]`.

Prints a row for each machine and kind of sensors: goals reached, the distance of the true tip from the goal at arrival
and from the straight line on the way, mm, and the time taken, s. The payload, none or a load in turn, is not told to
the controller.
"""

from __future__ import annotations

import sys
from typing import NamedTuple

import numpy as np

import hydrocrane as hc

# Machine, sensors, load (kg), share of all runs.
CASES = (
    ("rottne-f9-lab", "ideal", 150.0, 1.0),
    ("rottne-f9-lab", "data-sheet", 150.0, 0.5),
    ("hiab-xs031", "ideal", 200.0, 0.75),
)
REACH = 0.4
BEGINS = 0.2
DURATION = 30.0


class Way(NamedTuple):
    """Of a goal that was reached: distances (m) and time (s)."""

    from_goal: float
    from_line: float
    time: float


def drive(machine: hc.Machine, sensors: str, payload: float, seed: int) -> Way | None:
    """A random goal from a random pose; none where the tip stopped before it. What is refused is drawn again."""
    rng = np.random.default_rng(seed)
    low, high = np.array(machine.joint_limits).T
    while True:
        pose = low + rng.uniform(0.2, 0.8, low.size) * (high - low)
        start = np.array(machine.tip(pose))
        goal = start + rng.uniform(-REACH, REACH, 2)
        try:
            run = hc.simulate(
                hc.Scenario(
                    machine=machine.source,
                    joints=dict(zip(machine.joint_names, pose, strict=True)),
                    goals=[hc.Goal(BEGINS, *goal)],
                    payload=payload,
                    controller_model={"payload.mass": 0.0},
                    sensors=sensors,
                    seed=seed,
                    duration=DURATION,
                )
            )
            break
        except hc.HydrocraneError:
            continue
    reached = [event.time for event in run.events if "has reached its goal" in event.text]
    if not reached:
        return None
    columns = run.columns
    tip = np.column_stack([columns["tip.x"].values, columns["tip.z"].values])[columns.time <= reached[0]]
    along = (goal - start) / np.hypot(*(goal - start))
    off = (tip - start) @ np.array([-along[1], along[0]])
    return Way(float(np.hypot(*(tip[-1] - goal))), float(np.abs(off).max()), reached[0] - BEGINS)


def main(runs: int) -> None:
    print(
        "| machine, sensors, payloads | arrived | distance from the goal at arrival: median, 90 %, most "
        "| distance from the line: median, 90 %, most | time: median |\n|---|---|---|---|---|"
    )
    for name, sensors, load, share in CASES:
        machine, count = hc.load_machine(name), round(share * runs)
        ways = [way for seed in range(count) if (way := drive(machine, sensors, load * (seed % 2), seed)) is not None]
        goal, line = (
            ", ".join(f"{1e3 * q:.2g}" for q in np.percentile([way[k] for way in ways], [50, 90, 100])) for k in (0, 1)
        )
        time = np.median([way.time for way in ways])
        print(f"| `{name}`, {sensors}, 0 and {load:.0f} kg | {len(ways)} of {count} | {goal} | {line} | {time:.1f} |")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 40)
