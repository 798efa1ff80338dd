"""The public interface as outside programs use it: names, shapes, batches, and the stepping interface."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc


def arguments(crane):
    """Valid arguments by the name they have in a signature."""
    n = len(crane.joint_names)
    state = crane.equilibrium(crane.home)
    return {
        "q": crane.home,
        "qd": np.full(n, 0.1),
        "x": crane.strokes(crane.home),
        "force": np.full(n, 1e3),
        "state": state,
        "command": 0.1 * crane.spool_strokes,
    }


# Method, its arguments, shape of the answer for one case (n joints and cylinders, s states), takes a payload.
METHODS = [
    ("strokes", ("q",), "n", False),
    ("joints_from_strokes", ("x",), "n", False),
    ("stroke_jacobian", ("q",), "nn", False),
    ("tip", ("q",), "2", False),
    ("tip_jacobian", ("q",), "2n", False),
    ("mass_matrix", ("q",), "nn", True),
    ("bias_force", ("q", "qd"), "n", True),
    ("forward_dynamics", ("q", "qd", "force"), "n", True),
    ("static_cylinder_force", ("q",), "n", True),
    ("state_derivative", ("state", "command"), "s", True),
    ("jacobian", ("state", "command"), "ss", True),
    ("equilibrium", ("q",), "s", True),
]


@pytest.mark.filterwarnings("ignore::hydrocrane.result_warning.DoubtfulResult")
@pytest.mark.parametrize(("name", "takes", "shape", "loaded"), METHODS, ids=[m[0] for m in METHODS])
def test_shapes_of_single_cases_and_batches(corrected, name, takes, shape, loaded):
    sizes = {"n": len(corrected.joint_names), "s": len(corrected.state_names), "2": 2}
    single = tuple(sizes[letter] for letter in shape)
    values = [arguments(corrected)[label] for label in takes]
    method = getattr(corrected, name)
    one = method(*values)
    many = method(*(np.tile(v, (5, 1)) for v in values))
    assert isinstance(one, np.ndarray) and one.dtype == np.float64 and one.shape == single
    assert many.shape == (5, *single)
    np.testing.assert_array_equal(many, np.broadcast_to(one, many.shape))
    if loaded:
        np.testing.assert_array_equal(method(*values, payload=corrected.payload_mass), one)
        assert np.isfinite(method(*values, payload=250.0)).all()


def test_state_names_are_the_contract(corrected):
    """All joint positions, all rates, then cylinder by cylinder."""
    names = [f"joint.{j}.q" for j in corrected.joint_names] + [f"joint.{j}.qd" for j in corrected.joint_names]
    for cylinder in corrected.cylinder_names:
        names += [f"cylinder.{cylinder}.{kind}" for kind in ("p1", "p2", "xs", "vs", "z")]
    assert sorted(corrected.state_names) == sorted(names)
    assert isinstance(corrected.state_names, tuple)


def test_laboratory_crane_has_21_states_and_18_with_static_friction():
    crane = hc.load_machine("rottne-f9-lab")
    assert (crane.joint_names, crane.cylinder_names) == (("boom", "jib", "extension"), ("lift", "jib", "extension"))
    assert len(crane.state_names) == 21
    static = hc.load_machine("rottne-f9-lab", {f"friction.{c}.model": "static" for c in crane.cylinder_names})
    assert set(crane.state_names) - set(static.state_names) == {f"cylinder.{c}.z" for c in crane.cylinder_names}
    assert len(hc.load_machine("heinze-2007").state_names) == 18


def test_other_members_of_the_interface(corrected):
    n = len(corrected.joint_names)
    assert corrected.joint_limits.shape == (n, 2)
    assert (corrected.joint_limits[:, 0] < corrected.joint_limits[:, 1]).all()
    assert corrected.orifice_flow(corrected.spool_strokes[0], 10e5) > 0.0
    for curve in corrected.workspace():
        assert curve.ndim == 2 and curve.shape[1] == 2 and len(curve) > 1


def test_run_has_every_promised_variable_with_its_unit():
    run = hc.simulate("vertical-lift-open-loop", duration=0.5)
    expected = {*run.machine.state_names, "tip.x", "tip.z", "supply.flow", "supply.power"}
    for c in run.cylinder_names:
        expected |= {f"cylinder.{c}.{kind}" for kind in ("x", "v", "force", "friction", "q1", "q2", "command")}
    assert expected <= set(run.data)
    for name in expected:
        assert run.data[name].dims == ("time",)
        assert {"units", "long_name"} <= set(run.data[name].attrs)
    assert (run.outcome.kind, run.outcome.time) == ("completed", 0.5)
    np.testing.assert_allclose(run.data.time, np.arange(51) * 0.01, atol=1e-15)


def test_recorded_outputs_are_those_of_the_recorded_states():
    run = hc.simulate("hiab-lift", duration=1.0)
    crane = run.machine
    q = np.stack([run.data[f"joint.{j}.q"] for j in crane.joint_names], axis=-1)
    np.testing.assert_array_equal(np.stack([run.data["tip.x"], run.data["tip.z"]], axis=-1), crane.tip(q))
    for i, cylinder in enumerate(crane.cylinder_names):
        np.testing.assert_array_equal(run.data[f"cylinder.{cylinder}.x"], crane.strokes(q)[:, i])


def test_observation_of_the_stepping_interface(corrected):
    sim = hc.Simulator(corrected, sample_time=0.01)
    first = sim.reset(q=corrected.home)
    seen = sim.step(np.zeros(len(corrected.cylinder_names)))
    n = len(corrected.joint_names)
    assert (first.t, seen.t) == (0.0, pytest.approx(0.01))
    assert (seen.q.shape, seen.qd.shape, seen.p.shape, seen.tip.shape) == ((n,), (n,), (n, 2), (2,))
    np.testing.assert_array_equal(seen.tip, corrected.tip(seen.q))
    assert set(seen.measured) <= set(corrected.state_names)
    assert all(seen.measured[f"joint.{j}.q"] == seen.q[i] for i, j in enumerate(corrected.joint_names))
    assert sim.state.shape == (len(corrected.state_names),)


@pytest.mark.parametrize("method", ["rodas5p", "hc-exponential-4", "tsit5"])
def test_stepping_equals_simulating_the_same_commands(method):
    """A hundred samples of 10 ms with a command that changes every sample."""
    crane = hc.load_machine("rottne-f9-lab")
    times = np.arange(100) * 0.01
    spools = 0.02 * np.sin(np.outer(times, [3.0, 5.0, 7.0]))
    joints = dict(zip(crane.joint_names, crane.home, strict=True))
    plan = hc.Scenario(joints=joints, commands=(times, spools), duration=1.0, solver=hc.Solver(method, rtol=1e-9))
    run = hc.simulate(plan, ledger=False)
    sim = hc.Simulator(crane, sample_time=0.01, method=method, rtol=1e-9)
    sim.reset(q=crane.home)
    for k, spool in enumerate(spools):
        seen = sim.step(spool)
        np.testing.assert_allclose(seen.t, run.data.time[k + 1], rtol=1e-12)
        expected = np.array([run.data[name][k + 1] for name in crane.state_names])
        scale = np.array([1e7 if n.endswith((".p1", ".p2")) else 1.0 for n in crane.state_names])
        np.testing.assert_allclose(sim.state / scale, expected / scale, rtol=0, atol=1e-6)


def test_reset_to_a_state_continues_as_if_nothing_had_happened():
    crane = hc.load_machine("rottne-f9-lab")
    sim, twin = hc.Simulator(crane, rtol=1e-9), hc.Simulator(crane, rtol=1e-9)
    sim.reset(q=crane.home)
    for _ in range(20):
        sim.step([0.02, -0.01, 0.01])
    seen = twin.reset(state=sim.state)
    np.testing.assert_array_equal(twin.state, sim.state)
    assert seen.t == 0.0
    for _ in range(20):
        sim.step([-0.01, 0.01, 0.0])
        twin.step([-0.01, 0.01, 0.0])
    scale = np.abs(sim.state) + 1e-3
    assert (np.abs(twin.state - sim.state) / scale).max() < 1e-6


def test_runs_are_repeatable_to_the_last_bit():
    one, two = (hc.simulate("single-cylinder-step") for _ in range(2))
    for name in one.data:
        np.testing.assert_array_equal(one.data[name], two.data[name])


def test_a_batch_of_states_equals_its_rows_whatever_its_size(corrected, random_states):
    x, u = random_states(corrected, 50, seed=71)
    whole = corrected.state_derivative(x, u)
    np.testing.assert_array_equal(whole, [corrected.state_derivative(a, b) for a, b in zip(x, u, strict=True)])


def test_the_outcome_of_stepping_is_that_of_runs(corrected):
    sim = hc.Simulator(corrected)
    assert sim.outcome is None
    sim.reset(q=corrected.home)
    assert isinstance(sim.outcome, hc.Outcome) and sim.outcome.completed and sim.outcome.time == 0.0
