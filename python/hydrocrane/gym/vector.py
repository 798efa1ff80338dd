"""Many cranes as one vectorised environment."""

from __future__ import annotations

from typing import cast

import numpy as np
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.gym.task import Draw, Numbers, TipTask
from hydrocrane.machine.machine import MachineLike


class CraneTipVectorEnv(VectorEnv[Numbers, NDArray[np.floating], NDArray[np.bool_]]):
    """:class:`~hydrocrane.gym.CraneTipEnv` for many cranes per call, on a :class:`hydrocrane.BatchSimulator`.

    A finished episode restarts at the next step, whose action it ignores and whose reward is zero
    (gymnasium's autoreset mode ``NEXT_STEP``).

    Parameters
    ----------
    num_envs : int
    machine, sample_time, duration, payload
        As in :class:`CraneTipEnv`.
    threads : int, optional
        Default is the number of cores.
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int = 1,
        machine: MachineLike = "rottne-f9-lab",
        sample_time: float = 0.05,
        duration: float = 10.0,
        payload: float | None = None,
        threads: int | None = None,
    ) -> None:
        self.task = TipTask.of(machine, sample_time=sample_time, duration=duration, payload=payload)
        self.num_envs = num_envs
        self.single_action_space = self.task.action_space
        self.single_observation_space = self.task.observation_space
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._cranes = self.task.simulator(num_envs, threads)
        self._random: list[np.random.Generator | None] = [None] * num_envs
        self._target: Array = np.zeros((num_envs, 2))
        self._samples = np.zeros(num_envs, dtype=np.int64)
        self._over = np.zeros(num_envs, dtype=bool)
        # What draws a machine for each crane and episode.
        self.draw: Draw | None = None

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, object] | None = None
    ) -> tuple[Numbers, dict[str, object]]:
        """Start an episode with every crane.

        With the seed s, crane i has the random numbers of a single crane with the seed s + i; without a seed, or with
        None in a list, the numbers go on as those of a single crane do. ``options`` are those of a single crane, for
        every crane one row or the same for all.
        """
        numbers = range(self.num_envs)
        seeds: list[int | None] = [None for _ in numbers]
        if seed is not None:
            seeds = [seed + i for i in numbers] if isinstance(seed, int | np.integer) else list(seed)
        if len(seeds) != self.num_envs:
            raise InputError(f"{len(seeds)} seeds for {self.num_envs} cranes; give one for each, or one whole number")
        for i, own in enumerate(seeds):
            if own is not None or self._random[i] is None:
                self._random[i] = np_random(own)[0]
        self._begin(np.arange(self.num_envs), options)
        return self.task.observation(self._cranes.observe(), self._target), self._information()

    def step(  # type: ignore[override]
        self, actions: NDArray[np.floating]
    ) -> tuple[Numbers, Array, NDArray[np.bool_], NDArray[np.bool_], dict[str, object]]:
        """Hold the spool commands for one sample.

        Where cranes begin a new episode the information is that of a reset, with ``_target`` and ``_parameters``, (n,)
        of bool: which cranes these are.
        """
        anew = self._over.copy()
        seen = self._cranes.step(np.where(anew[:, np.newaxis], 0.0, self.task.commands(actions)))
        self._samples += 1
        information: dict[str, object] = {}
        if anew.any():
            self._begin(np.flatnonzero(anew))
            seen = self._cranes.observe()
            information = self._information()
            information |= {f"_{name}": anew for name in information}
        lost = ~self._cranes.alive
        reward = np.where(anew, 0.0, self.task.reward(seen, self._target, lost))
        late = ~anew & (self._samples >= self.task.samples)
        self._over = lost | late
        return self.task.observation(seen, self._target), reward, lost, late, information

    def _begin(self, cranes: NDArray[np.int64], options: dict[str, object] | None = None) -> None:
        randoms = [cast("np.random.Generator", self._random[i]) for i in cranes]
        self._target[cranes], _ = self.task.begin(self._cranes, cranes, randoms, options, self.draw)
        self._samples[cranes] = 0
        self._over[cranes] = False

    def _information(self) -> dict[str, object]:
        """Of a reset: the targets (n, 2), m, and the values (n,) of machine keys in which cranes differ."""
        parameters = self._cranes.parameters
        return {"target": self._target.copy(), **({"parameters": parameters} if parameters else {})}
