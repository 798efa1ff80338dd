"""Exports of machines that nobody tuned them for: chains of 1, 2, 4, 5 and 6 joints with every optional part."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from exported_model import STATES, CModel, agrees, module, needs_compiler, off
from machine_generator import machine

import hydrocrane as hc

# Number of joints by seed. Together they have every part that the generator draws.
JOINTS = {3: 1, 15: 1, 9: 2, 57: 2, 18: 4, 5: 5, 7: 6}
SEEDS = [pytest.param(seed, marks=[pytest.mark.evidence] if count > 2 else []) for seed, count in JOINTS.items()]


def loaded(seed: int, folder: Path) -> hc.Machine:
    crane = machine(seed).load(folder)
    assert len(crane.joint_names) == JOINTS[seed]
    return crane


def test_the_machines_have_every_part():
    assert set().union(*(machine(seed).parts for seed in JOINTS)) >= set().union(*(machine(k).parts for k in range(60)))


@needs_compiler
@pytest.mark.parametrize("seed", SEEDS)
def test_c(seed, random_states, tmp_path):
    crane = loaded(seed, tmp_path)
    model = CModel(hc.export_model(crane, tmp_path / "crane.c", parameters=[]))
    x, u = random_states(crane, STATES, 3)
    n = len(crane.state_names)
    dx, dfdx = model.call("hydrocrane_linearise", x, u, None, n, n * n)
    expected = crane.state_derivative(x, u)
    assert agrees(dx, expected)
    # Mains and tank line sum what cylinders draw in another order where these are in groups.
    same = np.array(["cylinder" in state or "joint" in state for state in crane.state_names])
    assert np.array_equal(dx[:, same], expected[:, same])
    assert off(crane, dfdx.reshape(-1, n, n), crane.jacobian(x, u)) < 1e-12


@pytest.mark.parametrize("seed", SEEDS)
def test_numpy(seed, random_states, tmp_path):
    crane = loaded(seed, tmp_path)
    model = module(hc.export_model(crane, tmp_path / "crane.py", to="numpy"))
    x, u = random_states(crane, STATES, 3)
    dx, dfdx = model.linearise(x, u)
    assert agrees(dx, crane.state_derivative(x, u))
    assert off(crane, dfdx, crane.jacobian(x, u)) < 1e-12
