"""Learns tip control by PPO, and compares it with `tip` and `heinze-pid` on the same targets.

    python docs/validation/reinforcement_learning.py            # a few minutes on two cores for each of three seeds

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
from stable_baselines3.common.vec_env import VecEnv

import hydrocrane as hc
from hydrocrane.gym import CraneTipVectorEnv, TipTask

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from benches.tables import table  # noqa: E402

PAGE = Path(__file__).with_name("reinforcement-learning.md")
CURVE, FIGURES = PAGE.with_suffix(".png"), PAGE.with_suffix(".json")
SEEDS = (0, 1, 2)
CRANES, STEPS = 256, 2_500_000
# Targets of the comparison, and the seed of the first.
TARGETS, FIRST = 100, 10_000
# Distances from here on, m, count by their ratio, in the reward and in what the policy sees.
NEAR = 3e-3


class Cranes(VecEnv):
    """Many cranes as stable-baselines3 takes them.

    The policy sees the environment's observation and, twice, how far each piston has to go by the Jacobians: in
    tenths of a metre, and by
    its ratio to `NEAR`. The reward is minus the decimal logarithm of the distance from the target, so that from 20
    mm to 10 mm counts as
    much as from 2 m to 1 m. A finished episode restarts at the next step, whose action and reward count for nothing.
    """

    def __init__(self, cranes: int) -> None:
        self.cranes = CraneTipVectorEnv(cranes)
        self.task = self.cranes.task
        width = self.task.observation_space.shape[0] + 2 * len(self.task.machine.cylinder_names)
        space = type(self.task.observation_space)(-np.inf, np.inf, (width,), np.float32)
        super().__init__(cranes, space, self.task.action_space)
        self.ends: list[float] = []
        self._actions = np.zeros((cranes, 1))

    def seed(self, seed: int | None = None) -> Sequence[None | int]:
        self._seed = seed
        return [seed]

    def reset(self) -> np.ndarray:
        return features(self.task, self.cranes.reset(seed=getattr(self, "_seed", None))[0])

    def step_async(self, actions: np.ndarray) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        seen, paid, lost, late, _ = self.cranes.step(self._actions)
        distance = np.linalg.norm(seen[:, -2:], axis=1)
        over, own = lost | late, features(self.task, seen)
        self.ends += distance[over].tolist()
        reward = np.where(paid == 0.0, 0.0, -np.log10(distance + NEAR)) - 100.0 * lost
        facts: list[dict[str, Any]] = [{} for _ in over]
        for i in np.flatnonzero(over):
            facts[i] = {"terminal_observation": own[i], "TimeLimit.truncated": bool(late[i] and not lost[i])}
        return own, reward.astype(np.float32), over, facts

    def close(self) -> None:
        self.cranes.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [None] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        raise NotImplementedError

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        raise NotImplementedError

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        return [False] * self.num_envs


def features(task: TipTask, seen: np.ndarray) -> np.ndarray:
    """What the policy sees, (n, width), of observations (n, ...)."""
    machine = task.machine
    lower, upper = machine.joint_limits.T
    q = np.clip(0.5 * (seen[:, : len(lower)] * (upper - lower) + lower + upper), lower, upper).astype(np.float64)
    # The shortest motion of the pistons, as shares of their strokes, that moves the tip to the target.
    by_piston = machine.tip_jacobian(q) @ np.linalg.inv(machine.stroke_jacobian(q))
    way = (np.linalg.pinv(by_piston, rcond=0.05) @ seen[:, -2:, np.newaxis].astype(np.float64))[..., 0]
    ratio = way / (np.abs(way) + NEAR)
    return np.concatenate([seen, np.clip(way / 0.1, -3.0, 3.0), ratio], axis=1).astype(np.float32)


def trained(seed: int, steps: int = STEPS) -> tuple[PPO, list[tuple[int, float, float]]]:
    """A policy, and over the training the steps taken, the processor time, s, and the median distance at the end of
    episodes, m."""
    cranes = Cranes(CRANES)
    model = PPO(
        "MlpPolicy", cranes, seed=seed, n_steps=100, batch_size=3200, n_epochs=6, gamma=0.98, gae_lambda=0.95,
        learning_rate=lambda left: 1e-3 * left, ent_coef=0.0, device="cpu",
        policy_kwargs={"net_arch": [64, 64], "log_std_init": -1.0},
    )  # fmt: skip
    begin, curve = time.process_time(), []

    def note(local: dict[str, Any], _: dict[str, Any]) -> bool:
        if len(cranes.ends) >= CRANES:
            curve.append((model.num_timesteps, time.process_time() - begin, float(np.median(cranes.ends))))
            cranes.ends.clear()
            print(f"seed {seed}: {curve[-1][0]} steps, {curve[-1][1]:.0f} s, {1e3 * curve[-1][2]:.1f} mm", flush=True)
        return True

    model.learn(steps, callback=note)
    return model, curve


def plan_of(task: TipTask, seed: int) -> tuple[hc.Scenario, np.ndarray]:
    """The episode of a seed with `tip` and its target as a goal, and the target."""
    (start,), (target,) = task.drawn([np.random.default_rng(seed)])
    joints = dict(zip(task.machine.joint_names, start, strict=True))
    goal = hc.Goal(0.0, *target)
    return hc.Scenario(machine=task.machine, joints=joints, goals=[goal], duration=task.duration), target


@cache
def compared() -> tuple[int, ...]:
    """Seeds of the first episodes whose targets `tip` takes: outside of the machine's regions, and not next to a
    limit."""
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


def controlled(name: str) -> np.ndarray:
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
        run = hc.simulate(plan)
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
Then {targets} episodes of 10 s
with other starts and targets: where the tip is at the end, for the policies without exploration and for two
controllers of the package
from the same starts to the same targets. `tip` gets each target as a goal; `heinze-pid` a stick that points there
for 7 s.

![learning curve](reinforcement-learning.png)

The curve shows the median of episodes during training, with exploration.

"""


def main(arguments: Sequence[str]) -> None:
    seeds = tuple(map(int, arguments)) or SEEDS
    torch.set_num_threads(os.cpu_count() or 1)
    found: dict[str, Any] = {"policies": {}, "controllers": {}}
    for name in ("tip", "heinze-pid"):
        found["controllers"][name] = summary(controlled(name))
        print(name, found["controllers"][name], flush=True)
    for seed in seeds:
        began, processor = time.perf_counter(), time.process_time()
        model, curve = trained(seed)
        seconds = [time.perf_counter() - began, time.process_time() - processor]
        task = TipTask.of("rottne-f9-lab")
        ends = ends_of(lambda seen: model.predict(features(task, seen), deterministic=True)[0])
        found["policies"][str(seed)] = summary(ends) | {"seconds": seconds[0], "processor": seconds[1], "curve": curve}
        print(seed, summary(ends), seconds, flush=True)
        FIGURES.write_text(json.dumps(found) + "\n", encoding="utf-8")
    written(found)


def written(found: dict[str, Any]) -> None:
    drawn({seed: of["curve"] for seed, of in found["policies"].items()})
    figures = lambda of: [f"{1e3 * of['median']:.1f}", f"{1e3 * of['90 %']:.1f}", f"{100 * of['within 10 mm']:.0f} %"]  # noqa: E731
    rows = [[f"PPO, seed {seed}", *figures(of), f"{of['processor']:.0f}"] for seed, of in found["policies"].items()]
    rows += [[f"`{name}`", *figures(of), ""] for name, of in found["controllers"].items()]
    heads = ["controller", "median, mm", "90 %, mm", "within 10 mm", "training, s of processor time"]
    PAGE.write_text(
        HEAD.format(cranes=CRANES, steps=1e-6 * STEPS, targets=TARGETS) + table(heads, rows) + "\n", encoding="utf-8"
    )


if __name__ == "__main__":
    main(sys.argv[1:])
