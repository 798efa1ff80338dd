"""Environments for learning controllers, for `gymnasium <https://gymnasium.farama.org>`_ (the extra ``gym``).

Importing this registers ``hydrocrane/CraneTip-v0``, one crane or many::

    import gymnasium
    import hydrocrane.gym

    one = gymnasium.make("hydrocrane/CraneTip-v0")
    many = gymnasium.make_vec("hydrocrane/CraneTip-v0", num_envs=1000)
"""

from __future__ import annotations

import gymnasium

from hydrocrane.gym.environment import CraneTipEnv
from hydrocrane.gym.random_machine import RandomMachine, RandomMachines
from hydrocrane.gym.task import TipTask
from hydrocrane.gym.vector import CraneTipVectorEnv

__all__ = ["CraneTipEnv", "CraneTipVectorEnv", "RandomMachine", "RandomMachines", "TipTask"]

gymnasium.register(
    id="hydrocrane/CraneTip-v0",
    entry_point="hydrocrane.gym.environment:CraneTipEnv",
    vector_entry_point="hydrocrane.gym.vector:CraneTipVectorEnv",
)
