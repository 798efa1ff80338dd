"""Learns tip control by PPO, and compares it with `tip` and `heinze-pid` on the same targets.

    python docs/validation/reinforcement_learning.py            # two minutes on two cores for each of three seeds
    python docs/validation/reinforcement_learning.py 1          # one of them again, the others are kept

Needs the extra ``rl``. Writes docs/validation/reinforcement-learning.md with its learning curve;
docs/howto/train-a-controller.md explains.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Sequence
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import torch
from stable_baselines3 import PPO

import hydrocrane as hc
from hydrocrane.gym import CraneTipVectorEnv, TipTask
from hydrocrane.gym.stable_baselines import Cranes, features
from hydrocrane.gym.task import starts_and_targets

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from benches.computer import processor  # noqa: E402
from benches.tables import table  # noqa: E402

PAGE = Path(__file__).with_name("reinforcement-learning.md")
CURVE, FIGURES = PAGE.with_suffix(".png"), PAGE.with_suffix(".json")
SEEDS = (0, 1, 2)
CRANES, STEPS = 256, 2_500_000
# Targets of the comparison, and the seed of the first.
TARGETS, FIRST = 100, 10_000


def trained(seed: int, steps: int = STEPS) -> tuple[PPO, list[tuple[int, float, float]]]:
    """A policy; over the training the steps taken, the time, s, and the median distance at the end of episodes, m."""
    cranes = Cranes(CraneTipVectorEnv(CRANES))
    model = PPO(
        "MlpPolicy", cranes, seed=seed, n_steps=100, batch_size=3200, n_epochs=6, gamma=0.98, gae_lambda=0.95,
        learning_rate=lambda left: 1e-3 * left, ent_coef=0.0, device="cpu",
        policy_kwargs={"net_arch": [64, 64], "log_std_init": -1.0},
    )  # fmt: skip
    begin, curve = time.perf_counter(), []

    def note(local: dict[str, Any], _: dict[str, Any]) -> bool:
        if len(cranes.ends) >= CRANES:
            curve.append((model.num_timesteps, time.perf_counter() - begin, float(np.median(cranes.ends))))
            cranes.ends.clear()
            print(f"seed {seed}: {curve[-1][0]} steps, {curve[-1][1]:.0f} s, {1e3 * curve[-1][2]:.1f} mm", flush=True)
        return True

    model.learn(steps, callback=note)
    return model, curve


def plan_of(task: TipTask, seed: int) -> tuple[hc.Scenario, np.ndarray]:
    """The episode of a seed with `tip` and its target as a goal, and the target."""
    (start,), (target,) = starts_and_targets([task.machine], [np.random.default_rng(seed)])
    joints = dict(zip(task.machine.joint_names, start, strict=True))
    goal = hc.Goal(0.0, *target)
    return hc.Scenario(machine=task.machine, joints=joints, goals=[goal], duration=task.duration), target


@cache
def compared() -> tuple[int, ...]:
    """Seeds of the first episodes whose targets `tip` takes: outside of all regions, and not next to a limit."""
    task, found = TipTask.of("rottne-f9-lab"), []
    for seed in count(FIRST):
        try:
            hc.simulate(plan_of(task, seed)[0], duration=0.01)
        except hc.InputError:
            continue
        found.append(seed)
        if len(found) == TARGETS:
            return tuple(found)
    raise AssertionError


def ends_of(act: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Distances (TARGETS,), m, at the end of the episodes of the comparison."""
    cranes = CraneTipVectorEnv(TARGETS)
    seen, _ = cranes.reset(seed=list(compared()))
    for _ in range(cranes.task.samples):
        seen, *_ = cranes.step(act(seen))
    return np.linalg.norm(seen[:, -2:], axis=1)


def controlled(name: str, times: float = 1.0) -> np.ndarray:
    """The same by a controller: `tip` goes to the target, `heinze-pid` follows a stick that points there."""
    task = TipTask.of("rottne-f9-lab")
    ends = []
    for seed in compared():
        plan, target = plan_of(task, seed)
        if name != "tip":
            way, moving = target - task.machine.tip(list(plan.joints.values())), 0.7 * task.duration
            speed = float(np.linalg.norm(way)) / moving
            x, z = way / np.linalg.norm(way)
            stick = hc.Joystick([0.0, moving], {"x": [x, 0.0], "z": [z, 0.0]}, full_speed=speed, interpolation="hold")
            plan = plan.changed(goals=[], controller=name, joystick=stick)
        run = hc.simulate(plan, duration=times * task.duration)
        ends.append(
            np.hypot(*(run.columns[f"tip.{axis}"].values[-1] - goal for axis, goal in zip("xz", target, strict=True)))
        )
    return np.array(ends)


def summary(ends: np.ndarray) -> dict[str, float]:
    return {
        "median": float(np.median(ends)),
        "90 %": float(np.quantile(ends, 0.9)),
        "within 10 mm": float((ends < 0.01).mean()),
    }


def drawn(curves: dict[str, list[Any]]) -> None:
    figure, axes = plt.subplots(figsize=(7, 4))
    for seed, curve in curves.items():
        steps, _, distance = np.array(curve).T
        axes.semilogy(1e-6 * steps, 1e3 * distance, label=f"seed {seed}")
    axes.axhline(10.0, color="0.5", linestyle="--", linewidth=1)
    axes.set(xlabel="steps of all cranes, millions", ylabel="median distance at the end, mm")
    axes.legend()
    figure.tight_layout()
    figure.savefig(CURVE, dpi=120)


HEAD = """# Tip control learnt

Generated by `docs/validation/reinforcement_learning.py`; do not edit. How it is done: [train a
controller](../howto/train-a-controller.md).

PPO of stable-baselines3 learns on {cranes} cranes `hydrocrane/CraneTip-v0`, {steps:.1f} million steps for each seed.
Then {targets} episodes of 10 s with other starts and targets: where the tip is at the end, for the policies without
exploration and for two controllers of the package from the same starts to the same targets. `tip` gets each target as a
goal; `heinze-pid` a stick that points there for 7 s. Cores that a training had: {computer}.

Failures first: about every fifth target is not reached by the policies. `tip` keeps to the full speed of its machine
file, so that 10 s are too short for every third target; the row with 40 s shows what it reaches then. The environment
is the model that the controllers are made from: nothing here says how a policy does on another machine.

![learning curve](reinforcement-learning.png)

The curve shows the median of episodes during training, with exploration.

"""


def main(arguments: Sequence[str]) -> None:
    seeds, cores = tuple(map(int, arguments)) or SEEDS, len(os.sched_getaffinity(0))
    torch.set_num_threads(cores)
    found: dict[str, Any] = json.loads(FIGURES.read_text(encoding="utf-8")) if arguments and FIGURES.exists() else {}
    found = {"policies": {}, "controllers": {}} | found | {"computer": f"{cores} of {processor()}"}
    for name, controller, times in (
        ("`tip`", "tip", 1.0),
        ("`tip`, 40 s", "tip", 4.0),
        ("`heinze-pid`", "heinze-pid", 1.0),
    ):
        found["controllers"][name] = summary(controlled(controller, times))
        print(name, found["controllers"][name], flush=True)
    for seed in seeds:
        began = time.perf_counter()
        model, curve = trained(seed)
        seconds = time.perf_counter() - began
        task = TipTask.of("rottne-f9-lab")
        ends = ends_of(lambda seen: model.predict(features(task, seen), deterministic=True)[0])
        found["policies"][str(seed)] = summary(ends) | {"seconds": seconds, "curve": curve}
        print(seed, summary(ends), seconds, flush=True)
        FIGURES.write_text(json.dumps(found) + "\n", encoding="utf-8")
    written(found)


def written(found: dict[str, Any]) -> None:
    drawn({seed: of["curve"] for seed, of in found["policies"].items()})
    figures = lambda of: [f"{1e3 * of['median']:.1f}", f"{1e3 * of['90 %']:.1f}", f"{100 * of['within 10 mm']:.0f} %"]  # noqa: E731
    rows = [[f"PPO, seed {seed}", *figures(of), f"{of['seconds']:.0f}"] for seed, of in found["policies"].items()]
    rows += [[name, *figures(of), ""] for name, of in found["controllers"].items()]
    heads = ["controller", "median, mm", "90 %, mm", "within 10 mm", "training, s"]
    text = HEAD.format(cranes=CRANES, steps=1e-6 * STEPS, targets=TARGETS, computer=found["computer"])
    PAGE.write_text(text + table(heads, rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
