"""Poses in degrees or millimetres are refused by everything that takes a pose; what a motion may reach is not."""

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


# What a motion without end stops needs; everything else takes poses of the crane.
MOTION = ("mass_matrix", "bias_force", "forward_dynamics", "kinetic_energy", "potential_energy")


@pytest.mark.parametrize("name", [name for name in TAKES_Q if name not in MOTION])
def test_a_pose_lies_at_most_half_a_range_outside(name):
    low, high = LAB.joint_limits.T
    for side, sign in ((low, -1.0), (high, 1.0)):
        for joint in range(3):
            q = LAB.home.copy()
            q[joint] = side[joint] + sign * 0.51 * (high - low)[joint]
            with pytest.raises(hc.InputError, match=f"joint {LAB.joint_names[joint]} is at .*did you mean"):
                TAKES_Q[name](q)


def test_a_reading_with_a_wrong_zero_is_a_pose():
    low, high = LAB.joint_limits.T
    for q in (low - 0.49 * (high - low), high + 0.49 * (high - low)):
        assert np.isfinite(LAB.tip(q)).all() and np.isfinite(LAB.tip_jacobian(q)).all()


def test_small_degrees_and_decimetres_are_refused():
    """Less than a turn outside the ranges, as many angles in degrees are."""
    loader = hc.load_machine("hiab-xs031")
    for take in (loader.tip, loader.strokes, loader.static_cylinder_force, loader.piston_speeds):
        with pytest.raises(hc.InputError, match="lift is at 5 rad .*did you mean degrees"):
            take([5.0, -3.0, 0.5])
        with pytest.raises(hc.InputError, match="extension is at 12 m .*did you mean millimetres"):
            take([1.0, -1.0, 12.0])


def test_where_a_motion_leads_is_not_refused():
    """Random angles of a full turn, and beyond the ends of a telescope."""
    rng = np.random.default_rng(1)
    q = np.concatenate([rng.uniform(-np.pi, np.pi, (500, 2)), rng.uniform(-1.0, 1.0, (500, 1))], axis=1)
    for name in MOTION:
        assert np.isfinite(TAKES_Q[name](q)).all()
    states = np.tile(LAB.equilibrium(GOOD), (500, 1))
    states[:, :3] = q
    assert np.isfinite(LAB.state_derivative(states, HOLD)).all()


@pytest.mark.parametrize("batch", [False, True])
def test_a_state_that_no_motion_reaches_is_refused(batch):
    state = LAB.equilibrium(GOOD)
    state[:2] = 80.0, 90.0
    states = np.stack([LAB.equilibrium(GOOD), state]) if batch else state
    takes = [LAB.state_derivative, LAB.reference_state_derivative, LAB.jacobian, LAB.outputs]
    takes.append(lambda x, _: hc.BatchSimulator(LAB, 2).reset(state=x))
    if not batch:
        takes.append(lambda x, _: hc.Simulator(LAB, sample_time=0.01).reset(state=x))
        takes.append(lambda x, _: LAB.linearise(state=x))
    for take in takes:
        with pytest.raises(hc.InputError, match="state: joint boom is at 80 rad .*did you mean degrees"):
            take(states, HOLD)


def test_a_reading_may_lie_anywhere():
    """A sensor with a fault gives no error in the loop: the controller gets the tip by what is read."""
    seen = []

    def control(obs, stick):
        seen.append(obs.tip)
        return HOLD

    fault = hc.SensorFault("joint.boom.q", "jump", 0.05, size=20.0)
    start = dict(zip(LAB.joint_names, GOOD, strict=True))
    plan = hc.Scenario(joints=start, duration=0.1, controller=control, sensor_faults=[fault])
    assert hc.simulate(plan).outcome.completed
    assert np.isfinite(seen).all()
