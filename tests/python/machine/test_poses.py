"""Poses in degrees or millimetres are refused by everything that takes a pose; what a search tries is not."""

import numpy as np
import pytest

import hydrocrane as hc

LAB = hc.load_machine("rottne-f9-lab")
GOOD = np.array([np.deg2rad(100.0), np.deg2rad(100.0), 0.0])
BAD = np.array([100.0, 100.0, 0.0])
HOLD = np.zeros(3)

TAKES_Q = {
    "strokes": LAB.strokes,
    "stroke_jacobian": LAB.stroke_jacobian,
    "cylinder_slopes": LAB.cylinder_slopes,
    "centres_of_gravity": LAB.centres_of_gravity,
    "tip": LAB.tip,
    "tip_jacobian": LAB.tip_jacobian,
    "drawing": LAB.drawing,
    "mass_matrix": LAB.mass_matrix,
    "bias_force": lambda q: LAB.bias_force(q, HOLD),
    "forward_dynamics": lambda q: LAB.forward_dynamics(q, HOLD, HOLD),
    "static_cylinder_force": LAB.static_cylinder_force,
    "piston_speeds": LAB.piston_speeds,
    "kinetic_energy": lambda q: LAB.kinetic_energy(q, HOLD),
    "potential_energy": LAB.potential_energy,
    "equilibrium": LAB.equilibrium,
    "linearise": LAB.linearise,
    "pack_state": LAB.pack_state,
    "modes": lambda q: hc.modes(LAB, q),
    "simulator": lambda q: hc.Simulator(LAB, sample_time=0.01).reset(q=q),
    "batch": lambda q: hc.BatchSimulator(LAB, 2).reset(q=q),
}


@pytest.mark.parametrize("name", TAKES_Q)
def test_degrees_are_refused_wherever_a_pose_is_taken(name):
    with pytest.raises(hc.InputError, match="boom is at 100 rad.*did you mean degrees"):
        TAKES_Q[name](BAD)
    TAKES_Q[name](GOOD)


def test_one_wrong_pose_of_a_batch_is_found_and_millimetres_too():
    many = np.tile(GOOD, (4, 1))
    assert LAB.tip(many).shape == (4, 2)
    many[2, 2] = 100.0
    with pytest.raises(hc.InputError, match="extension is at 100 m .*did you mean millimetres"):
        LAB.tip(many)


def test_what_a_search_tries_is_not_refused():
    """Random angles of a full turn, and steps beyond the limits, stay allowed."""
    rng = np.random.default_rng(1)
    q = np.concatenate([rng.uniform(-np.pi, np.pi, (500, 2)), rng.uniform(-1.0, 1.0, (500, 1))], axis=1)
    assert np.isfinite(LAB.mass_matrix(q)).all()
    LAB.tip(LAB.joint_limits[:, 1] + 1.0)
    LAB.tip(LAB.joint_limits[:, 0] - 1.0)
