"""Height of the tip under levers, mode `height`, from random poses: `python docs/validation/tip_height.py [RUNS]`.

Prints a row for each machine, kind of sensors and share of the full lever: how far the tip leaves its height, in mm.
The levers of all cylinders but the follower's change every 0.75 s to values drawn evenly; the payload of 0 to 150 kg
is not told to the controller. Runs with the event that a cylinder cannot lift its load are counted apart.
"""

from __future__ import annotations

import sys

import numpy as np

import hydrocrane as hc

CASES = (
    ("rottne-f9-lab", "ideal", 1.0),
    ("rottne-f9-lab", "data-sheet", 1.0),
    ("hiab-xs031", "ideal", 0.1),
    ("hiab-xs031", "ideal", 0.3),
    ("hiab-xs031", "ideal", 1.0),
)
# The follower lifts the tip by at least this share of its own motion, so that it can hold a height.
LEAST_LIFT = 0.3


def most_off(machine: hc.Machine, sensors: str, share: float, seed: int) -> float | None:
    """Largest change of the tip's height (m) in one random drive; none where the load was too heavy."""
    rng = np.random.default_rng(seed)
    low, high = np.array(machine.joint_limits).T
    while True:
        pose = low + rng.uniform(0.25, 0.75, low.size) * (high - low)
        if abs(machine.tip_jacobian(pose)[1, -1]) > LEAST_LIFT:
            break
    times = np.arange(0.5, 8.0, 0.75)
    levers = {name: share * np.append(rng.uniform(-1, 1, times.size - 1), 0.0) for name in machine.cylinder_names[:-1]}
    run = hc.simulate(
        hc.Scenario(
            machine=machine.source,
            joints=dict(zip(machine.joint_names, pose, strict=True)),
            joystick=hc.Joystick(times, levers, mode="height"),
            payload=float(rng.uniform(0, 150)),
            controller_model={"payload.mass": 0.0},
            sensors=sensors,
            seed=seed,
            duration=10.0,
        )
    )
    if any("cannot lift" in event.text for event in run.events):
        return None
    height = run.columns["tip.z"].values
    return float(np.abs(height - height[0]).max())


def main(runs: int) -> None:
    print("| machine, sensors, levers | runs | too heavy | median | 90 % | most |\n|---|---|---|---|---|---|")
    for name, sensors, share in CASES:
        machine = hc.load_machine(name)
        found = [most_off(machine, sensors, share, seed) for seed in range(runs)]
        off = [1e3 * most for most in found if most is not None]
        median, most_of_all, most = np.percentile(off, [50, 90, 100])
        levers = f"up to {100 * share:.0f} %"
        print(
            f"| `{name}`, {sensors}, {levers} | {runs} | {runs - len(off)} "
            f"| {median:.1f} | {most_of_all:.1f} | {most:.1f} |"
        )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 40)
