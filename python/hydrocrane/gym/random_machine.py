"""Machines drawn anew at each episode, so that a controller learns for all of them (domain randomisation)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import cast

import gymnasium
import numpy as np
from gymnasium.vector import VectorWrapper
from numpy.typing import NDArray

from hydrocrane.errors import InputError
from hydrocrane.gym.environment import CraneTipEnv
from hydrocrane.gym.task import Numbers
from hydrocrane.gym.vector import CraneTipVectorEnv
from hydrocrane.machine.keys import Key, machine_key, si_value
from hydrocrane.machine.machine import Machine
from hydrocrane.simulation.crane_parameters import CraneValue
from hydrocrane.studies.design import drawn_values, samples_of


@dataclass(frozen=True)
class DrawnParameters:
    """Machine keys with what their values are drawn from, as in a study."""

    keys: Sequence[Key]
    ranges: Sequence[object]

    @classmethod
    def of(cls, machine: Machine, ranges: Mapping[str, object]) -> DrawnParameters:
        if not isinstance(ranges, Mapping) or not ranges:
            raise InputError('give machine keys with their ranges, such as {"supply.pressure": ["130 bar", "140 bar"]}')
        keys = [machine_key(name, samples_of(name, spec), machine) for name, spec in ranges.items()]
        return cls(keys, list(ranges.values()))

    def __call__(self, randoms: Sequence[np.random.Generator]) -> dict[str, CraneValue]:
        """A value of every key for each crane, by its own random numbers."""
        shares = np.array([random.uniform(size=len(self.keys)) for random in randoms])
        together = zip(self.keys, self.ranges, shares.T, strict=True)
        drawn = {key.name: drawn_values(key.name, spec, share, partial(si_value, key)) for key, spec, share in together}
        return {name: cast("CraneValue", values) for name, values in drawn.items()}


class RandomMachine(gymnasium.Wrapper[Numbers, NDArray[np.floating], Numbers, NDArray[np.floating]]):
    """One crane that is another machine in each episode.

    At each reset the values are drawn by the environment's random numbers, so that a seed gives the same machines. What
    was drawn is in the information of the reset under ``parameters``, SI. Values in the reset's
    ``options={"parameters": ...}`` count before drawn ones.

    Parameters
    ----------
    env : CraneTipEnv
        Itself or in other wrappers.
    ranges : mapping of str to range
        Machine keys with ``(low, high)``, ``{"low": ..., "high": ..., "log": True}``, ``{"values": [...]}`` or a
        distribution, as in a sweep that draws (:func:`hydrocrane.sweep`); numbers are SI, texts have units.

    Raises
    ------
    InputError, MachineFileError
        If there is no such key, or it is not one number.

    Examples
    --------
    >>> from hydrocrane.gym import CraneTipEnv, RandomMachine
    >>> env = RandomMachine(CraneTipEnv(), {"payload.mass": (0.0, 100.0), "supply.pressure": ["130 bar", "140 bar"]})
    >>> found = [env.reset(seed=seed)[1]["parameters"]["payload.mass"] for seed in (1, 2, 1)]
    >>> print(found[0] == found[2], found[0] == found[1])
    True False
    """

    def __init__(self, env: gymnasium.Env[Numbers, NDArray[np.floating]], ranges: Mapping[str, object]) -> None:
        super().__init__(env)
        crane = env.unwrapped
        if not isinstance(crane, CraneTipEnv):
            raise _other_environment("CraneTipEnv", crane)
        crane.draw = DrawnParameters.of(crane.task.machine, ranges)


class RandomMachines(VectorWrapper):
    """Many cranes, each of which is another machine in each episode; all else as in :class:`RandomMachine`.

    Crane i of a batch with the seed s is the machine of one crane with the seed s + i.

    Parameters
    ----------
    env : CraneTipVectorEnv
    ranges : mapping of str to range

    Examples
    --------
    >>> from hydrocrane.gym import CraneTipVectorEnv, RandomMachines
    >>> many = RandomMachines(CraneTipVectorEnv(4), {"link.boom.mass": {"low": 67.0, "high": 70.0}})
    >>> seen, information = many.reset(seed=1)
    >>> print(information["parameters"]["link.boom.mass"].shape)
    (4,)
    """

    def __init__(self, env: CraneTipVectorEnv, ranges: Mapping[str, object]) -> None:
        super().__init__(env)
        cranes = env.unwrapped
        if not isinstance(cranes, CraneTipVectorEnv):
            raise _other_environment("CraneTipVectorEnv", cranes)
        cranes.draw = DrawnParameters.of(cranes.task.machine, ranges)


def _other_environment(wanted: str, given: object) -> InputError:
    return InputError(f"machines are drawn for a {wanted}, itself or in other wrappers; got a {type(given).__name__}")
