"""Many cranes as stable-baselines3 takes them, with what a policy learns from within minutes (the extra ``rl``)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np
from gymnasium.spaces import Box
from stable_baselines3.common.vec_env import VecEnv

from hydrocrane.gym.random_machine import RandomMachines
from hydrocrane.gym.task import Numbers, TipTask
from hydrocrane.gym.vector import CraneTipVectorEnv

# Distances from here on, m, count by their ratio, in the reward and in what the policy sees.
NEAR = 3e-3
# Reward of a crane that is lost: more than all that an episode can cost otherwise.
LOST = -100.0


class Cranes(VecEnv):
    """:class:`~hydrocrane.gym.CraneTipVectorEnv` for stable-baselines3.

    The policy sees :func:`features` of the environment's observation. The reward is minus the decimal logarithm of the
    distance from the target in metres, so that from 20 mm to 10 mm counts as much as from 2 m to 1 m. A finished
    episode restarts at the next step, whose action and reward count for nothing.

    Parameters
    ----------
    cranes : CraneTipVectorEnv or RandomMachines

    Attributes
    ----------
    ends : list of float
        Distances (m) at the ends of the episodes so far.

    Examples
    --------
    Needs the extra ``rl``::

        from stable_baselines3 import PPO
        from hydrocrane.gym import CraneTipVectorEnv
        from hydrocrane.gym.stable_baselines import Cranes

        model = PPO("MlpPolicy", Cranes(CraneTipVectorEnv(256))).learn(100_000)
    """

    def __init__(self, cranes: CraneTipVectorEnv | RandomMachines) -> None:
        self.cranes, self.task = cranes, cast(CraneTipVectorEnv, cranes.unwrapped).task
        seen = self.task.observation_space.shape or (0,)
        width = seen[0] + 2 * len(self.task.machine.cylinder_names)
        super().__init__(cranes.num_envs, Box(-np.inf, np.inf, (width,), np.float32), self.task.action_space)
        self.ends: list[float] = []
        self._seed: int | None = None
        self._actions = np.zeros(0)

    def seed(self, seed: int | None = None) -> Sequence[None | int]:
        self._seed = seed
        return [seed]

    def reset(self) -> Numbers:
        return features(self.task, self.cranes.reset(seed=self._seed)[0])

    def step_async(self, actions: np.ndarray) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[Numbers, Numbers, np.ndarray, list[dict[str, object]]]:
        seen, paid, lost, late, _ = self.cranes.step(self._actions)
        distance = np.linalg.norm(seen[:, -2:], axis=1)
        over, own = lost | late, features(self.task, seen)
        self.ends += distance[over].tolist()
        reward = np.where(paid == 0.0, 0.0, -np.log10(distance + NEAR)) + LOST * lost
        facts: list[dict[str, object]] = [{} for _ in over]
        for i in np.flatnonzero(over):
            facts[i] = {"terminal_observation": own[i], "TimeLimit.truncated": bool(late[i] and not lost[i])}
        return own, reward.astype(np.float32), over, facts

    def close(self) -> None:
        self.cranes.close()

    def get_attr(self, attr_name: str, indices: object = None) -> list[object]:
        return [getattr(self.cranes, attr_name, None)] * self.num_envs

    def set_attr(self, attr_name: str, value: object, indices: object = None) -> None:
        raise NotImplementedError("cranes of one batch have no attributes of their own")

    def env_method(self, method_name: str, *args: object, indices: object = None, **kwargs: object) -> list[object]:
        raise NotImplementedError("cranes of one batch have no methods of their own")

    def env_is_wrapped(self, wrapper_class: object, indices: object = None) -> list[bool]:
        return [False] * self.num_envs


def features(task: TipTask, seen: Numbers) -> Numbers:
    """What a policy sees, (n, width), of observations (n, ...) of a :class:`~hydrocrane.gym.TipTask`.

    The observation, and how far each piston has to go to bring the tip to the target, by the Jacobians at the present
    pose: once in tenths of a metre, once by its ratio to 3 mm.
    """
    machine = task.machine
    lower, upper = machine.joint_limits.T
    q = np.clip(0.5 * (seen[:, : len(lower)] * (upper - lower) + lower + upper), lower, upper).astype(np.float64)
    # The shortest motion of the pistons that moves the tip to the target.
    by_piston = machine.tip_jacobian(q) @ np.linalg.inv(machine.stroke_jacobian(q))
    travel = (np.linalg.pinv(by_piston, rcond=0.05) @ seen[:, -2:, np.newaxis].astype(np.float64))[..., 0]
    ratio = travel / (np.abs(travel) + NEAR)
    return np.concatenate([seen, np.clip(travel / 0.1, -3.0, 3.0), ratio], axis=1).astype(np.float32)
