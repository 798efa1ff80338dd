"""The public Python interface to a machine: names, shapes, batches, payload, and clear errors."""

import pickle
import subprocess
import sys

import numpy as np
import pytest

import hydrocrane as hc

MACHINES = hc.bundled_machines()


@pytest.fixture(scope="module")
def crane():
    return hc.load_machine("rottne-f9-lab")


@pytest.fixture(scope="module")
def q():
    return np.array([np.radians(100.0), np.radians(100.0), 0.05])


def some_poses(crane, count, seed=1):
    """Random poses in the inner 80 % of the joint limits."""
    low, high = crane.joint_limits.T
    return low + (high - low) * np.random.default_rng(seed).uniform(0.1, 0.9, (count, len(low)))


# --- import and names -----------------------------------------------------------------------------------------------


def test_import_is_light():
    code = (
        "import sys, hydrocrane; print(sorted({'numpy', 'matplotlib', 'xarray', 'scipy', 'pandas'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_public_name_resolves():
    for name in hc.__all__:
        assert getattr(hc, name) is not None


@pytest.mark.evidence
def test_simulate_stays_a_function_when_its_module_is_imported():
    code = "import hydrocrane.simulation.running, hydrocrane as hc; assert callable(hc.simulate)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_names_of_the_laboratory_crane(crane):
    assert crane.joint_names == ("boom", "jib", "extension")
    assert crane.cylinder_names == ("lift", "jib", "extension")
    assert len(crane.state_names) == len(set(crane.state_names)) == len(crane.state_units) == 21
    expected = {f"joint.{j}.{k}" for j in crane.joint_names for k in ("q", "qd")}
    expected |= {f"cylinder.{c}.{k}" for c in crane.cylinder_names for k in ("p1", "p2", "xs", "vs", "z")}
    assert set(crane.state_names) == expected


def test_overrides_reach_the_machine():
    assert hc.load_machine("rottne-f9-lab", {"supply.pressure": "100 bar"}).supply_pressure == pytest.approx(100e5)
    assert hc.load_machine("rottne-f9-lab", {"supply.pressure": np.float32(9e6)}).supply_pressure == pytest.approx(9e6)


def test_regions_to_keep_out_of(crane):
    assert list(crane.keep_out) == ["ground", "pillar"]
    assert crane.keep_out["pillar"].shape == (4, 2) and crane.keep_out["ground"][:, 1].max() == pytest.approx(-1.21)
    without = hc.load_machine("rottne-f9-lab", {"keep-out.ground.status": "inactive"})
    assert list(without.keep_out) == ["pillar"]
    assert not hc.load_machine("heinze-2007").keep_out


def test_provenance_tally_counts_every_value(crane):
    assert sum(crane.provenance_tally.values()) == len(crane.provenance) > 50


def test_a_machine_survives_pickling():
    crane = hc.load_machine("rottne-f9-lab", {"payload.mass": 150.0})
    again = pickle.loads(pickle.dumps(crane))
    assert again.payload_mass == 150.0
    assert again.name == crane.name


# --- values and shapes ----------------------------------------------------------------------------------------------


@pytest.mark.filterwarnings("ignore::hydrocrane.result_warning.DoubtfulResult")
@pytest.mark.parametrize("name", MACHINES)
def test_batches_equal_single_calls(name):
    crane = hc.load_machine(name)
    n = len(crane.joint_names)
    poses = some_poses(crane, 6).reshape(2, 3, n)
    rates = np.random.default_rng(2).normal(size=(3, n)) * 0.1
    force = np.full(n, 1000.0)
    state = crane.equilibrium(poses)
    command = np.full(n, 0.1) * crane.spool_strokes
    calls = {
        "strokes": lambda i: crane.strokes(poses[i]),
        "stroke_jacobian": lambda i: crane.stroke_jacobian(poses[i]),
        "tip": lambda i: crane.tip(poses[i]),
        "tip_jacobian": lambda i: crane.tip_jacobian(poses[i]),
        "mass_matrix": lambda i: crane.mass_matrix(poses[i]),
        "bias_force": lambda i: crane.bias_force(poses[i], rates[i[1:]]),
        "forward_dynamics": lambda i: crane.forward_dynamics(poses[i], rates[i[1:]], force),
        "static_cylinder_force": lambda i: crane.static_cylinder_force(poses[i]),
        "kinetic_energy": lambda i: crane.kinetic_energy(poses[i], rates[i[1:]]),
        "potential_energy": lambda i: crane.potential_energy(poses[i]),
        "equilibrium": lambda i: crane.equilibrium(poses[i]),
        "state_derivative": lambda i: crane.state_derivative(state[i], command),
        "jacobian": lambda i: crane.jacobian(state[i], command),
    }
    for label, call in calls.items():
        whole = call(())
        assert whole.shape[:2] == (2, 3), label
        for i in np.ndindex(2, 3):
            np.testing.assert_array_equal(call(i), whole[i], err_msg=f"{name}: {label}")


@pytest.mark.parametrize("name", MACHINES)
def test_strokes_and_joints_are_inverse(name):
    crane = hc.load_machine(name)
    poses = some_poses(crane, 50)
    np.testing.assert_allclose(crane.joints_from_strokes(crane.strokes(poses)), poses, atol=1e-9)


@pytest.mark.parametrize("name", [name for name in MACHINES if hc.load_machine(name).joint_units[0] == "rad"])
def test_inverse_kinematics_reaches_the_tip(name):
    crane = hc.load_machine(name)
    if "y" in crane.tip_axes:
        with pytest.raises(hc.InputError, match="in the plane"):
            crane.inverse_kinematics([2.0, 1.0])
        return
    low, high = crane.joint_limits.T
    hit = 0
    for pose in some_poses(crane, 20):
        target = crane.tip(pose)
        found = crane.inverse_kinematics(target, x3=pose[-1])
        hit += len(found)
        for candidate in found:
            np.testing.assert_allclose(crane.tip(candidate), target, atol=1e-9)
            assert ((candidate >= low - 1e-9) & (candidate <= high + 1e-9)).all()
    assert hit >= 20


def test_inverse_kinematics_needs_two_turning_joints():
    with pytest.raises(hc.InputError, match="two revolute joints"):
        hc.load_machine("single-cylinder").inverse_kinematics([0.0, 0.0])


def test_inverse_kinematics_is_empty_out_of_reach(crane):
    assert crane.inverse_kinematics([30.0, 0.0]) == []
    nested = crane.inverse_kinematics([[30.0, 0.0], crane.tip(crane.home)])
    assert len(nested) == 2
    assert nested[0] == []


def test_equilibrium_is_at_rest(crane, q):
    state = crane.equilibrium(q)
    rate = crane.state_derivative(state, np.zeros(3))
    accelerations = [i for i, name in enumerate(crane.state_names) if name.endswith(".qd")]
    assert np.abs(rate[accelerations]).max() < 1e-9


def test_payload_keyword_defaults_to_the_machine(q):
    loaded = hc.load_machine("rottne-f9-lab", {"payload.mass": 200.0})
    empty = hc.load_machine("rottne-f9-lab", {"payload.mass": 0.0})
    np.testing.assert_array_equal(loaded.static_cylinder_force(q), empty.static_cylinder_force(q, payload=200.0))
    assert not np.allclose(loaded.mass_matrix(q), loaded.mass_matrix(q, payload=0.0))


def test_static_force_balances_the_bias(crane):
    """At rest J_l^T f = h."""
    poses = some_poses(crane, 30)
    force = crane.static_cylinder_force(poses, payload=80.0)
    torque = np.einsum("mij,mi->mj", crane.stroke_jacobian(poses), force)
    np.testing.assert_allclose(torque, crane.bias_force(poses, np.zeros(3), payload=80.0), rtol=1e-10, atol=1e-8)


def test_piston_areas_are_those_of_the_bores(crane):
    """Bores 100, 90, 50 mm and rods 40, 45, 30 mm (thesis 7.3)."""
    bore, rod = np.array([0.1, 0.09, 0.05]), np.array([0.04, 0.045, 0.03])
    np.testing.assert_allclose(crane.piston_areas[:, 0], np.pi / 4 * bore**2, rtol=1e-6)
    np.testing.assert_allclose(crane.piston_areas[:, 1], np.pi / 4 * (bore**2 - rod**2), rtol=1e-6)


def test_orifice_flow_broadcasts_and_is_odd(crane):
    dp = np.linspace(-100e5, 100e5, 11)
    flow = crane.orifice_flow(np.array([[0.01], [0.05]]), dp)
    assert flow.shape == (2, 11)
    np.testing.assert_allclose(flow, -flow[:, ::-1], atol=1e-18)
    np.testing.assert_allclose(flow[1], 5 * flow[0], rtol=1e-12, atol=1e-18)
    assert np.ndim(crane.orifice_flow(0.05, 75e5)) == 0
    assert crane.orifice_flow(0.05, 75e5, "jib") == pytest.approx(1e-4, rel=1e-6)


def test_friction_map_opposes_motion(crane):
    v = np.linspace(0.001, 0.3, 40)
    for cylinder in crane.cylinder_names:
        assert (crane.friction_map(v, cylinder) > 0).all()
        assert (crane.friction_map(-v, cylinder) < 0).all()


def test_load_chart_payload_brings_one_cylinder_to_its_limit(crane):
    chart = hc.load_chart(crane, samples=6)
    assert chart.payload.shape == chart.limiting.shape == chart.q.shape[:-1] == chart.tip.shape[:-1]
    held = np.isfinite(chart.payload) & (chart.limiting >= 0)
    assert held.sum() > 20
    for pose, payload, limiting in zip(chart.q[held], chart.payload[held], chart.limiting[held], strict=True):
        force = crane.static_cylinder_force(pose, payload=payload)
        room = np.where(force > 0, crane.piston_areas[:, 0], crane.piston_areas[:, 1]) * crane.supply_pressure
        share = np.abs(force) / room
        assert share.max() == pytest.approx(1.0, rel=1e-6)
        assert share[limiting] == pytest.approx(1.0, rel=1e-6)


def test_modes_hold_the_spools_of_all_valves(crane, q):
    """The spool pairs have the data sheet's natural frequency of 1012.8 rad/s."""
    found = hc.modes(crane, q)
    spools = [f for f, s in zip(found.frequency, found.state, strict=True) if s.endswith((".xs", ".vs"))]
    np.testing.assert_allclose(spools, 1012.8 / (2 * np.pi), rtol=2e-3)
    assert len(spools) == 3
    assert (np.diff(found.frequency) >= 0).all()


# --- errors ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        ([1.0, 2.0], ["(3,)", "boom, jib, extension", "(2,)"]),
        (1.0, ["(3,)", "()"]),
        ([1.0, 2.0, np.nan], ["finite", "nan"]),
        ([1.0, np.inf, 0.0], ["finite", "inf"]),
        (["a", "b", "c"], ["real numbers"]),
        ([1j, 0, 0], ["real numbers"]),
        ([[1.0, 2.0], [1.0]], ["differ in length"]),
    ],
)
def test_wrong_q_says_what_is_expected(crane, bad, words):
    with pytest.raises(hc.InputError) as caught:
        crane.strokes(bad)
    assert str(caught.value).startswith("q ")
    for word in words:
        assert word in str(caught.value)


def test_leading_axes_that_do_not_broadcast(crane):
    with pytest.raises(hc.InputError, match="do not broadcast"):
        crane.bias_force(np.zeros((2, 3)), np.zeros((4, 3)))


def test_wrong_state_shape_names_the_states(crane):
    with pytest.raises(hc.InputError, match=r"state must have shape \(21,\)"):
        crane.state_derivative(np.zeros(18), np.zeros(3))


@pytest.mark.parametrize("payload", [-1.0, np.nan, [1.0, 2.0], "heavy"])
def test_bad_payload(crane, q, payload):
    with pytest.raises(hc.InputError, match="payload"):
        crane.mass_matrix(q, payload=payload)


def test_unknown_cylinder_and_mode_name_the_nearest(crane, q):
    with pytest.raises(hc.InputError, match="did you mean `lift`"):
        crane.orifice_flow(0.01, 1e5, "lif")
    with pytest.raises(hc.InputError, match="did you mean `steady`"):
        crane.equilibrium(q, "stead")


def test_strokes_out_of_reach(crane):
    with pytest.raises(hc.OutOfReachError):
        crane.joints_from_strokes([0.5, 0.0, 0.0])


def test_unknown_override_names_the_nearest_key():
    with pytest.raises(hc.MachineFileError) as caught:
        hc.load_machine("rottne-f9-lab", {"supply.presure": "100 bar"})
    assert caught.value.slug == "unknown-key"
    assert "pressure" in str(caught.value)
    assert isinstance(caught.value, ValueError)


def test_wrong_dimension_in_an_override():
    with pytest.raises(hc.MachineFileError) as caught:
        hc.load_machine("rottne-f9-lab", {"supply.pressure": "100 kg"})
    assert caught.value.slug


@pytest.mark.parametrize("value", [None, {"a": 1}, object()])
def test_override_of_a_strange_type(value):
    with pytest.raises(hc.InputError, match=r"override `supply.pressure`"):
        hc.load_machine("rottne-f9-lab", {"supply.pressure": value})


def test_unknown_machine_names_the_bundled_ones():
    with pytest.raises(hc.MachineFileError, match="rottne-f9-lab"):
        hc.load_machine("rotne-f9-lab")


def test_a_changed_machine_keeps_the_overrides_it_had():
    one = hc.load_machine("rig-rottne", {"supply.pressure": "100 bar"})
    other = one.changed({"payload.mass": "20 kg"})
    assert (other.supply_pressure, other.payload_mass) == (pytest.approx(100e5), 20.0)
    assert one.payload_mass == 0.0 and one.changed({}) is one
    assert other.changed({"supply.pressure": "40 bar"}).supply_pressure == pytest.approx(40e5)
    with pytest.raises(hc.HydrocraneError, match="paylod"):
        one.changed({"paylod.mass": 1.0})


def test_limits_are_those_of_the_machine_whatever_was_built_before():
    """Limits of a geometry are remembered: what they follow from is all of it."""
    crane = hc.load_machine("rottne-f9-lab")
    first = crane.joint_limits
    for key in ("cylinder.lift.barrel-length", "cylinder.lift.rod-length", "cylinder.jib.linkage.rocker-length"):
        other = crane.changed({key: 0.99 * crane.value(key).si})
        assert not np.array_equal(other.joint_limits, first), key
    np.testing.assert_array_equal(crane.changed({"cylinder.lift.bore": 0.101}).joint_limits, first)


@pytest.mark.parametrize("name", hc.bundled_machines())
def test_drawn_links_go_through_the_pins(name):
    crane = hc.load_machine(name)
    lines = crane.drawing(crane.home)
    links = [np.asarray(line) for kind, _, line in lines if kind in ("link", "torque-link")]
    sides = np.concatenate([np.stack((line[:-1], line[1:]), axis=1) for line in links])
    start, side = sides[:, 0], sides[:, 1] - sides[:, 0]
    ends = {"cylinder-barrel": 0, "cylinder-rod": -1}
    pins = [line[ends[kind]] for kind, _, line in lines if kind in ends]
    assert pins
    for pin in pins:
        along = np.clip(((pin - start) * side).sum(axis=1) / (side**2).sum(axis=1), 0.0, 1.0)
        assert np.linalg.norm(pin - start - along[:, None] * side, axis=1).min() < 1e-6
