"""An excavator that a motor slews: its torque and oil by hand, and a working cycle of the whole machine."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.results.energy import energy_balance

EXCAVATOR = "sany-sy19e"
POSE = np.deg2rad([0.0, 30.0, 30.0, 10.0])
# m^3 per radian of the joint.
PER_RADIAN = 23.6e-6 * 134.0 / (2.0 * np.pi)


@pytest.fixture(scope="module")
def crane():
    return hc.load_machine(EXCAVATOR)


@pytest.fixture(scope="module")
def cycle(crane):
    """The bucket digs and opens, the machine slews, the boom rises."""
    commands = {
        "bucket": ([0.0, 0.5, 0.75, 1.25, 1.75, 2.0], [0.0, 2e-3, 2e-3, -2e-3, -2e-3, 0.0]),
        "slew": ([0.0, 2.0, 2.5, 4.0, 4.5], [0.0, 0.0, 3e-3, 3e-3, 0.0]),
        "boom": ([0.0, 4.5, 5.0, 5.5, 6.0], [0.0, 0.0, 3e-3, 3e-3, 0.0]),
    }
    joints = dict(zip(crane.joint_names, POSE, strict=True))
    return hc.simulate(hc.Scenario(machine=crane, joints=joints, payload=60.0, commands=commands, duration=8.0))


def test_its_difference_of_pressures_turns_the_joint(crane):
    accelerations = []
    for p1 in (40e5, 90e5):
        state = crane.equilibrium(POSE)
        names = list(crane.state_names)
        state[names.index("cylinder.slew.p1")], state[names.index("cylinder.slew.p2")] = p1, 40e5
        rates = crane.state_derivative(state, np.zeros(4))
        accelerations.append([rates[names.index(f"joint.{joint}.qd")] for joint in crane.joint_names])
    torques = crane.mass_matrix(POSE) @ np.diff(accelerations, axis=0)[0]
    np.testing.assert_allclose(torques, [PER_RADIAN * 50e5, 0.0, 0.0, 0.0], rtol=1e-9, atol=1e-6)


def test_a_cycle_ends_without_warnings_and_its_energy_is_accounted_for(cycle):
    assert cycle.outcome.completed and not cycle.warnings, cycle.warnings
    balance = energy_balance(cycle)
    assert balance.pump > 2e4
    assert abs(balance.residual) < 1e-5 * balance.pump
    assert np.rad2deg(np.ptp(cycle.columns["joint.slew.q"].values)) > 80.0


def test_the_oil_that_it_takes_is_its_way(cycle):
    # Beside the leak and what the oil in its sides gives way.
    data = cycle.columns
    flow, speed = (data[f"cylinder.slew.q{i}"].values for i in (1, 2)), data["joint.slew.qd"].values
    steady = (data["time"].values > 3.5) & (data["time"].values < 4.0)
    for side in flow:
        np.testing.assert_allclose(side[steady], PER_RADIAN * speed[steady], rtol=0.2)
