"""One crane as an environment."""

from __future__ import annotations

from typing import cast

import gymnasium
import numpy as np
from numpy.typing import NDArray

from hydrocrane.gym.task import Draw, Numbers, TipTask
from hydrocrane.machine.machine import MachineLike


class CraneTipEnv(gymnasium.Env[Numbers, NDArray[np.floating]]):
    """Bring the tip of a crane to a target and keep it there; :class:`TipTask` has the numbers.

    Parameters
    ----------
    machine : Machine or str
    sample_time, duration, payload
        As in :class:`TipTask`.
    """

    metadata = {"render_modes": []}

    def __init__(
        self,
        machine: MachineLike = "rottne-f9-lab",
        sample_time: float = 0.05,
        duration: float = 10.0,
        payload: float | None = None,
    ) -> None:
        self.task = TipTask.of(machine, sample_time=sample_time, duration=duration, payload=payload)
        self.action_space = cast("gymnasium.Space[NDArray[np.floating]]", self.task.action_space)
        self.observation_space = cast("gymnasium.Space[Numbers]", self.task.observation_space)
        self._cranes = self.task.simulator(1, threads=1)
        self._target = np.zeros((1, 2))
        self._samples = 0
        # What draws a machine for each episode.
        self.draw: Draw | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, object] | None = None
    ) -> tuple[Numbers, dict[str, object]]:
        """Start an episode.

        ``options`` may hold ``q``, a pose to start from, ``target``, (x, z) in m, and ``parameters``, values of machine
        keys as for :class:`hydrocrane.BatchSimulator`, in force until a reset states others.
        """
        super().reset(seed=seed)
        self._target, own = self.task.begin(
            self._cranes, np.zeros(1, dtype=np.int64), [self.np_random], options, self.draw
        )
        self._samples = 0
        information: dict[str, object] = {"target": self._target[0].copy()}
        if own:
            information["parameters"] = {name: float(value[0]) for name, value in own.items()}
        return self.task.observation(self._cranes.observe(), self._target)[0], information

    def step(self, action: NDArray[np.floating]) -> tuple[Numbers, float, bool, bool, dict[str, object]]:
        """Hold the spool commands for one sample."""
        seen = self._cranes.step(self.task.commands(action)[np.newaxis])
        self._samples += 1
        lost = ~self._cranes.alive
        reward = float(self.task.reward(seen, self._target, lost)[0])
        information = {"target": self._target[0].copy(), "tip": seen.tip[0], "outcome": self._cranes.outcomes[0]}
        over = self._samples >= self.task.samples
        return self.task.observation(seen, self._target)[0], reward, bool(lost[0]), over, information
