"""Cranes as a library for learning takes them."""

from __future__ import annotations

import sys
from types import ModuleType

import numpy as np
import pytest


class Base:
    """What stable-baselines3 keeps of an environment."""

    def __init__(self, num_envs, observation_space, action_space):
        self.num_envs, self.observation_space, self.action_space = num_envs, observation_space, action_space


@pytest.fixture
def adapter(monkeypatch):
    """The adapter over `Base`, so that it is tested where PyTorch is not installed."""
    place = "stable_baselines3.common.vec_env"
    for name in ("stable_baselines3", "stable_baselines3.common", place):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    monkeypatch.setattr(sys.modules[place], "VecEnv", Base, raising=False)
    monkeypatch.delitem(sys.modules, "hydrocrane.gym.stable_baselines", raising=False)
    import hydrocrane.gym.stable_baselines as module

    yield module
    sys.modules.pop("hydrocrane.gym.stable_baselines", None)


def test_cranes_pay_for_nearness_and_say_that_time_ran_out(adapter):
    cranes = adapter.Cranes(adapter.CraneTipVectorEnv(3, duration=0.2))
    cranes.seed(5)
    seen = cranes.reset()
    width = cranes.observation_space.shape[0]
    assert seen.shape == (3, width) and seen.dtype == np.float32
    for sample in range(1, 6):
        cranes.step_async(np.zeros((3, 3), dtype=np.float32))
        seen, reward, over, facts = cranes.step_wait()
        if sample < 5:
            own = cranes.task.observation_space.shape[0]
            distance = np.linalg.norm(seen[:, own - 2 : own], axis=1)
            np.testing.assert_allclose(reward, -np.log10(distance + 3e-3), rtol=1e-5)
        assert over.all() == (sample == 4) and over.any() == over.all()
        if sample == 4:
            assert all(fact["TimeLimit.truncated"] for fact in facts)
            np.testing.assert_array_equal([fact["terminal_observation"] for fact in facts], seen)
    # The sample after an end only starts the next episode.
    assert (reward == 0.0).all() and len(cranes.ends) == 3


def test_the_way_of_the_pistons_leads_to_the_target(adapter):
    """By the Jacobians, for a target nearby: moved so, the tip is there to second order."""
    task = adapter.TipTask.of("rottne-f9-lab")
    machine = task.machine
    q = machine.home
    lower, upper = machine.joint_limits.T
    seen = np.zeros((1, task.observation_space.shape[0]), dtype=np.float32)
    seen[0, :3] = (2 * q - lower - upper) / (upper - lower)
    seen[0, -2:] = [0.004, -0.003]
    found = adapter.features(task, seen)
    pistons = 0.1 * found[0, -6:-3].astype(float)
    moved = q + np.linalg.solve(machine.stroke_jacobian(q), pistons)
    np.testing.assert_allclose(machine.tip(moved) - machine.tip(q), [0.004, -0.003], atol=1e-4)
    np.testing.assert_allclose(found[0, -3:], pistons / (np.abs(pistons) + 3e-3), rtol=1e-4)
