"""Machines that move in space: what their files may state, what works on them, and what says that it does not."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hydrocrane as hc
from hydrocrane.benchmark import benchmark, random_lines
from hydrocrane.benchmark.fitted_tasks import tuning_cases

NAME = "rottne-f9-forwarder"
POSE = [0.4, 1.9, 2.0, 0.1]


@pytest.fixture(scope="module")
def crane():
    return hc.load_machine(NAME)


@pytest.fixture(scope="module")
def swing():
    return hc.simulate("forwarder-swing")


@pytest.mark.parametrize(
    "overrides, place, message",
    [
        ({"joint.slew.axis": "up"}, "joint.slew.axis", "is no axis"),
        ({"joint.slew.axis": "(0, 0, 0)"}, "joint.slew.axis", "is no axis"),
        ({"joint.slew.axis": "(0, 1)"}, "joint.slew.axis", "is no axis"),
        ({"joint.slew.axis": "(0, nan, 1)"}, "joint.slew.axis", "is no axis"),
        ({"joint.slew.convention": "relative"}, "joint.slew.convention", "in the plane only"),
        ({"joint.extension.axis": "x"}, "joint.extension.axis", "revolute joints only"),
        ({"cylinder.slew.barrel": "pillar.lift-rod"}, "cylinder.slew.barrel", "excludes `rack-radius`"),
        ({"cylinder.slew.closed-length": "1 m"}, "cylinder.slew.closed-length", "excludes `rack-radius`"),
        ({"cylinder.slew.rack-radius": "0 m"}, "cylinder.slew.rack-radius", "greater than zero"),
        ({"cylinder.extension.rack-radius": "0.1 m"}, "cylinder.extension.rack-radius", "a pinion turns"),
        ({"link.boom.inertia-z": "90 kg m^2"}, "link.boom.inertia-x", "no body has such a tensor"),
        ({"link.boom.inertia-xz": "30 kg m^2"}, "link.boom.inertia-x", "no body has such a tensor"),
        ({"ground.height": "-1 m"}, "ground", "knows places x only"),
        ({"link.pillar.point.boom-joint": "(0, 0.1, 0.2, 0.3) m"}, "link.pillar.point.boom-joint", "is not a point"),
    ],
)
def test_what_a_file_may_not_state(overrides, place, message):
    with pytest.raises(hc.MachineFileError, match=message) as error:
        hc.load_machine(NAME, overrides)
    assert error.value.key == place


def test_a_machine_in_space_states_its_inertias(tmp_path):
    head = f'extends = "{NAME}"\nwithout = ["link.boom.inertia-x", "link.boom.inertia-z"]\n'
    (tmp_path / "flat.toml").write_text(head + '[machine]\nname = "flat"\nclass = "assumed"\nsource = "test"\n')
    with pytest.raises(hc.MachineFileError, match="how hard `boom` is to turn about x and z") as error:
        hc.load_machine(tmp_path / "flat.toml")
    assert "give `inertia-x` and `inertia-z`" in str(error.value)


def test_a_product_alone_is_refused():
    with pytest.raises(hc.MachineFileError, match="without `inertia-x` and `inertia-z`"):
        hc.load_machine("rottne-f9-lab", {"link.boom.inertia-xz": "0.1 kg m^2"})


def test_a_crane_straight_ahead_is_that_of_the_plane(crane):
    """Boom, jib and telescope of the machine that it extends, about the same places."""
    flat, q = hc.load_machine("rottne-f9-lab"), np.array(POSE[1:])
    ahead = np.append(0.0, q)
    np.testing.assert_allclose(crane.tip(ahead)[[0, 2]], flat.tip(q), rtol=1e-14)
    assert crane.tip(ahead)[1] == 0.0
    np.testing.assert_allclose(crane.mass_matrix(ahead)[1:, 1:], flat.mass_matrix(q), rtol=1e-12)
    # Slewing couples with nothing else in this pose, and gravity does not turn it.
    assert np.abs(crane.mass_matrix(ahead)[0, 1:]).max() < 1e-12
    rates = np.array([0.3, -0.5, 0.2])
    np.testing.assert_allclose(
        crane.bias_force(ahead, np.append(0.0, rates))[1:], flat.bias_force(q, rates), rtol=1e-12
    )
    np.testing.assert_allclose(crane.static_cylinder_force(ahead)[1:], flat.static_cylinder_force(q), rtol=1e-12)


def test_slewing_turns_the_tip_and_drives_it_outwards(crane):
    radius = np.hypot(*crane.tip(POSE)[:2])
    assert np.arctan2(*crane.tip(POSE)[[1, 0]]) == pytest.approx(POSE[0])
    np.testing.assert_allclose(crane.tip_jacobian(POSE)[:, 0], [-crane.tip(POSE)[1], crane.tip(POSE)[0], 0.0])
    # A mass m at the tip on a circle needs m omega^2 r inwards, whatever carries it there.
    omega, load = 0.5, 100.0
    spin = np.array([omega, 0.0, 0.0, 0.0])
    more = [crane.bias_force(POSE, spin, payload=m) - crane.bias_force(POSE, 0 * spin, payload=m) for m in (load, 0.0)]
    outwards = np.array([np.cos(POSE[0]), np.sin(POSE[0]), 0.0])
    expected = -load * omega**2 * radius * outwards @ crane.tip_jacobian(POSE)
    np.testing.assert_allclose(more[0] - more[1], expected, rtol=1e-9, atol=1e-9)
    # The rack: piston in proportion to the angle, torque to the force.
    assert crane.strokes(POSE)[0] == pytest.approx(0.09 * POSE[0])
    assert crane.stroke_jacobian(POSE)[0, 0] == pytest.approx(0.09)


def test_free_motion_keeps_its_energy(crane):
    """Without forces of cylinders, over 1 s from a push in all joints; relative to the kinetic energy."""
    n, load = len(crane.joint_names), 80.0
    none = np.zeros(len(crane.cylinder_names))

    def rates(_, x):
        return np.append(x[n:], crane.forward_dynamics(x[:n], x[n:], none, payload=load))

    start = np.append(POSE, [0.9, 0.5, -0.7, 0.2])
    path = solve_ivp(rates, (0.0, 1.0), start, method="DOP853", rtol=1e-12, atol=1e-12).y.T
    q, qd = path[:, :n], path[:, n:]
    energy = crane.kinetic_energy(q, qd, payload=load) + crane.potential_energy(q, payload=load)
    assert np.abs(energy - energy[0]).max() < 1e-8 * crane.kinetic_energy(q, qd, payload=load).max()


def test_a_tilted_base_is_turned_gravity(crane):
    """On a slope the weights of all masses act along the turned direction; the rest of the bias stays to the bit."""
    slope, g, load = 0.2, crane.value("environment.gravity").si, 60.0
    tilted = hc.load_machine(NAME, {"environment.slope": slope})
    down = -g * np.array([np.sin(slope), 0.0, np.cos(slope)])
    masses = np.append([crane.value(f"link.{link}.mass").si for link in ("pillar", "boom", "jib", "extension")], load)

    def places(q):
        return np.vstack([crane.centres_of_gravity(q), crane.tip(q)])

    step = 1e-6 * np.eye(4)
    columns = np.array([(places(POSE + d) - places(POSE - d)) / 2e-6 for d in step])
    expected = -np.einsum("jik,k,i->j", columns, down, masses)
    still = np.zeros(4)
    np.testing.assert_allclose(tilted.bias_force(POSE, still, payload=load), expected, rtol=1e-7, atol=1e-5)
    np.testing.assert_array_equal(tilted.mass_matrix(POSE, payload=load), crane.mass_matrix(POSE, payload=load))


def test_a_load_taken_up_keeps_the_momentum(crane):
    """A load at rest takes its momentum from the crane, about each joint's axis; the tip's velocity has three parts."""
    n, load = len(crane.joint_names), 120.0
    state = crane.equilibrium(POSE)
    state[n : 2 * n] = rates = [0.4, 0.2, -0.3, 0.1]
    simulator = hc.Simulator(crane, sample_time=0.01)
    simulator.reset(state=state)
    change = simulator.set_payload(load)
    after = simulator.state[n : 2 * n]
    before, then = (crane.mass_matrix(POSE, payload=m) for m in (0.0, load))
    np.testing.assert_allclose(then @ after, before @ rates, rtol=1e-12)
    for velocity, own in ((change.velocity_before, rates), (change.velocity_after, after)):
        np.testing.assert_allclose(velocity, crane.tip_jacobian(POSE) @ own, atol=1e-14)
    kinetic = [float(crane.kinetic_energy(POSE, own, payload=m)) for own, m in ((rates, 0.0), (after, load))]
    assert change.loss == pytest.approx(kinetic[0] - kinetic[1]) and change.loss > 0.0


def test_a_run(crane, swing):
    assert swing.outcome.kind == "completed" and not swing.warnings
    columns = swing.columns
    angle, path = columns["joint.slew.q"].values, np.column_stack([columns[f"tip.{a}"].values for a in "xyz"])
    assert angle[-1] == pytest.approx(np.pi / 2, abs=0.2)
    end = [columns[f"joint.{joint}.q"].values[-1] for joint in crane.joint_names]
    np.testing.assert_allclose(path[-1], crane.tip(end), atol=1e-12)
    # The summary has all three places, and the way in space.
    way = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert f"way {way:.3f} m" in swing.summary() and f"{path[-1, 1]:.3f}, {path[-1, 2]:.3f}) m" in swing.summary()
    assert "the ledger closes to" in swing.summary()


def test_default_run_is_as_exact_as_promised(swing):
    tight = hc.simulate("forwarder-swing", method="rodas5p", rtol=1e-9)
    ours, exact = ([run.columns[f"tip.{axis}"].values for axis in "xyz"] for run in (swing, tight))
    assert np.linalg.norm(np.subtract(ours, exact), axis=0).max() < 1e-3


def test_steps_batches_and_sensitivities(crane):
    command = [0.02, 0.01, 0.0, 0.0]
    one, many = hc.Simulator(crane, sample_time=0.01), hc.BatchSimulator(crane, 3, 0.01)
    seen, all_seen = one.reset(q=POSE), many.reset(q=np.tile(POSE, (3, 1)))
    assert seen.tip.shape == (3,) and all_seen.tip.shape == (3, 3)
    for _ in range(60):
        seen, all_seen = one.step(command), many.step(np.tile(command, (3, 1)))
    np.testing.assert_allclose(all_seen.tip, np.tile(seen.tip, (3, 1)), atol=1e-3)
    assert np.abs(np.ptp(all_seen.tip, axis=0)).max() == 0.0
    key = "link.boom.inertia-z"
    by = hc.sensitivities("forwarder-swing", [key], duration=3.0)
    value = crane.value(key).si
    ends = [hc.simulate("forwarder-swing", duration=3.0, rtol=1e-9, overrides={key: value + d}) for d in (0.5, -0.5)]
    difference = ends[0].columns["tip.y"].values[-1] - ends[1].columns["tip.y"].values[-1]
    assert float(by.data["tip.y"].isel(time=-1, parameter=0)) == pytest.approx(difference, rel=2e-3)


def test_linear_models_have_the_third_axis(crane):
    model = crane.linearise(POSE, friction="released")
    assert {"tip.x", "tip.y", "tip.z"} <= set(model.output_names)
    pushed = crane.linearise(POSE, inputs=["tip.force.y"], outputs=["joint.slew.qd"], friction="released")
    assert pushed.B.shape == (len(crane.state_names), 1)
    found = hc.modes(crane, POSE)
    assert found.frequency.shape and (found.frequency > 0).all()


def test_episodes_in_space():
    gymnasium = pytest.importorskip("gymnasium")
    import hydrocrane.gym  # noqa: F401, PLC0415

    world = gymnasium.make("hydrocrane/CraneTip-v0", machine=NAME)
    seen, _ = world.reset(seed=3)
    assert seen.shape == world.observation_space.shape == (4 + 4 + 8 + 3,)
    seen, reward, *_ = world.step(world.action_space.sample())
    assert np.isfinite(seen).all() and reward < 0.0


@pytest.mark.parametrize(
    "what",
    [
        lambda crane: crane.inverse_kinematics([2.0, 1.0]),
        lambda crane: tuning_cases(crane),
        lambda crane: benchmark(["lever"], machine=crane),
    ],
)
def test_what_is_worked_out_in_the_plane_only_says_so(crane, what):
    with pytest.raises(hc.InputError, match="in the plane of x and z only"):
        what(crane)


@pytest.mark.parametrize(
    "what", [lambda crane: crane.workspace(), lambda crane: random_lines(crane, 1), hc.load_chart, hc.mode_map]
)
def test_what_is_worked_out_in_the_plane_of_the_boom_needs_a_crane_that_slews(what):
    with pytest.raises(hc.InputError, match="in the plane of x and z only"):
        what(hc.load_machine(NAME, {"joint.slew.axis": "(0, 0.1, 1)"}))


@pytest.mark.parametrize("at", [0.0, 0.7])
def test_a_crane_that_slews_has_workspace_and_load_chart_of_the_plane_of_its_boom(crane, at):
    """Those of the same crane without its slewing gear, wherever it stands."""
    flat = hc.load_machine("rottne-f9-lab")
    poses = np.random.default_rng(1).uniform(*crane.joint_limits.T, (20, 4))
    poses[:, 0] = at
    np.testing.assert_allclose(crane.tip_in_plane(poses), flat.tip(poses[:, 1:]), atol=1e-12)
    for mine, theirs in zip(crane.workspace(), flat.workspace(), strict=True):
        np.testing.assert_allclose(mine, theirs, atol=1e-12)
    chart, expected = (hc.load_chart(machine, samples=5) for machine in (crane, flat))
    np.testing.assert_allclose(chart.payload[0], expected.payload, rtol=1e-9)
    np.testing.assert_array_equal(chart.forbidden[0], expected.forbidden)
    for height in ("best", "worst", 1.0):
        np.testing.assert_allclose(chart.against_reach(height), expected.against_reach(height), rtol=1e-6)
    modes = hc.mode_map(crane, samples=3)
    assert modes.frequency.shape == (1, 3, 3, 3) and np.isfinite(modes.frequency).any()


def test_a_load_of_the_chart_is_held_and_more_is_not():
    crane = hc.load_machine("sany-sy19e")
    chart = hc.load_chart(crane, samples=6)
    payload, poses = chart.payload.ravel(), chart.q.reshape(-1, 4)
    for i in np.flatnonzero((payload > 50.0) & (payload < 2000.0))[::20]:
        assert not crane.rest(poses[i], payload=0.99 * payload[i])[1]
        assert crane.rest(poses[i], payload=1.01 * payload[i])[1]


@pytest.mark.parametrize("controller, overrides", [("tip", {"joint.slew.axis": "(0, 0.1, 1)"}), ("heinze-pid", {})])
def test_controllers_in_the_plane_say_so(controller, overrides):
    stick = hc.Joystick([0.0, 1.0], {"x": [0.0, 1.0]})
    joints = dict(zip(hc.load_machine(NAME).joint_names, POSE, strict=True))
    plan = hc.Scenario(machine=NAME, joints=joints, joystick=stick, controller=controller, duration=1.0)
    with pytest.raises(hc.InputError, match="moves otherwise in space"):
        hc.simulate(plan, overrides=overrides)


def test_pictures(crane, swing, tmp_path):
    """Links are drawn from the side, turned into one plane."""
    kinds = {(kind, name): line for kind, name, line in crane.drawing(POSE)}
    flat = hc.load_machine("rottne-f9-lab")
    np.testing.assert_allclose(
        next(line for (kind, _), line in kinds.items() if kind == "tip")[0], flat.tip(POSE[1:]), rtol=1e-12
    )
    swing.animate(tmp_path / "swing.gif", fps=2)
    assert (tmp_path / "swing.gif").stat().st_size > 1000
