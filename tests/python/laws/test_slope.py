"""A base on a slope: gravity turns in its frame, and with it weights, energies, equilibria, load charts and exports."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

SLOPE = np.deg2rad(12.0)
PAYLOAD = 250.0
NAMES = ("rottne-f9-lab", "hiab-xs031")


def raised(name: str, slope: float, **more: object) -> hc.Machine:
    return hc.load_machine(name, {"environment.slope": slope, **more})


def test_the_moment_at_the_boom_is_that_of_all_masses_by_hand():
    """Masses at their centres of gravity, each with the lever x cos - z sin about the boom's joint at (0, 0.73) m."""
    crane = raised("rottne-f9-lab", SLOPE)
    for q in (crane.home, [1.6, 1.2, 0.1]):
        places = np.vstack([crane.centres_of_gravity(q), crane.tip(q)]) - [0.0, 0.73]
        masses = np.array([68.2, 27.54, 10.11, PAYLOAD])
        moment = 9.81 * masses @ (places[:, 0] * np.cos(SLOPE) - places[:, 1] * np.sin(SLOPE))
        assert crane.bias_force(q, np.zeros(3), payload=PAYLOAD)[0] == pytest.approx(moment, rel=1e-12)
        # The cylinder that carries it pushes with that moment over its lever arm.
        force = crane.static_cylinder_force(q, payload=PAYLOAD)[0]
        assert force * crane.stroke_jacobian(q)[0, 0] == pytest.approx(moment, rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_it_is_the_level_crane_in_turned_gravity(name, random_poses):
    """Gravity is linear: that along x is what a slope of 90 deg would have, here from two small slopes."""
    level = hc.load_machine(name)
    q = random_poses(level, 20, seed=2)
    still = np.zeros_like(q)
    weights = {slope: raised(name, slope).bias_force(q, still, payload=PAYLOAD) for slope in (0.1, -0.1, 0.4)}
    along_x = (weights[0.1] - weights[-0.1]) / (2.0 * np.sin(0.1))
    along_z = (weights[0.1] + weights[-0.1]) / (2.0 * np.cos(0.1))
    np.testing.assert_allclose(along_z, level.bias_force(q, still, payload=PAYLOAD), rtol=1e-11, atol=1e-9)
    expected = along_x * np.sin(0.4) + along_z * np.cos(0.4)
    np.testing.assert_allclose(weights[0.4], expected, rtol=1e-10, atol=1e-8)
    assert (np.abs(along_x) > 10.0).any()
    np.testing.assert_array_equal(
        raised(name, 0.0).bias_force(q, still, payload=PAYLOAD), level.bias_force(q, still, payload=PAYLOAD)
    )


def test_a_hanging_rod_weighs_less_by_the_cosine_and_nothing_along_the_slope():
    """One cylinder along z: its weight is m g cos, whichever end is raised."""
    level = hc.load_machine("single-cylinder")
    force = level.static_cylinder_force(level.home, payload=100.0)
    for slope in (SLOPE, -SLOPE):
        held = raised("single-cylinder", slope).static_cylinder_force(level.home, payload=100.0)
        np.testing.assert_allclose(held, np.cos(SLOPE) * force, rtol=1e-12)


def test_energy_of_free_motion_is_conserved(random_poses):
    """No force of a cylinder: the crane falls along the slope, and what it loses in height it gains in speed."""
    crane = raised("rottne-f9-lab", SLOPE)
    q, qd, step = crane.home.copy(), np.zeros(3), 1e-4
    level = hc.load_machine("rottne-f9-lab")

    def energy(machine, q, qd):
        return machine.kinetic_energy(q, qd, payload=PAYLOAD) + machine.potential_energy(q, payload=PAYLOAD)

    def rate(q, qd):
        return qd, crane.forward_dynamics(q, qd, np.zeros(3), payload=PAYLOAD)

    before, of_level = energy(crane, q, qd), energy(level, q, qd)
    for _ in range(1500):
        k = [rate(q, qd)]
        for share in (0.5, 0.5, 1.0):
            k.append(rate(q + share * step * k[-1][0], qd + share * step * k[-1][1]))
        q, qd = (
            value + step / 6.0 * (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]) for i, value in enumerate((q, qd))
        )
    kinetic = crane.kinetic_energy(q, qd, payload=PAYLOAD)
    assert kinetic > 100.0
    assert energy(crane, q, qd) == pytest.approx(before, abs=1e-8 * kinetic)
    # On level ground the same motion would not conserve it.
    assert abs(energy(level, q, qd) - of_level) > 1e-2 * kinetic


def test_a_run_and_its_ledger_close():
    run = hc.simulate("vertical-lift-open-loop", overrides={"environment.slope": "12 deg"}, ledger=True, duration=1.0)
    assert run.outcome.completed
    assert not [warning for warning in run.warnings if warning.kind == "energy-balance"]


def test_a_raised_front_carries_more_above_the_pillar_s_height_and_a_lowered_one_less():
    """By hand for a boom of length L at the elevation e: the moment of a load is m g L cos(e + slope)."""
    charts = {
        slope: hc.load_chart(raised("rottne-f9-lab", np.deg2rad(slope)), samples=9) for slope in (-10.0, 0.0, 10.0)
    }
    # Where the tip is far out and above the joint of the boom, raising the front brings it nearer to the plumb line.
    tip = charts[0.0].tip
    above = (tip[..., 0] > 2.0) & (tip[..., 1] > 1.5) & (charts[0.0].payload > 0.0)
    assert above.sum() > 10
    lever = {s: tip[..., 0] * np.cos(np.deg2rad(s)) - (tip[..., 1] - 0.73) * np.sin(np.deg2rad(s)) for s in charts}
    assert (lever[10.0] < lever[0.0])[above].all() and (lever[-10.0] > lever[0.0])[above].all()
    by_boom = above & np.all([chart.limiting == 0 for chart in charts.values()], axis=0)
    assert by_boom.sum() > 5
    assert (charts[10.0].payload > charts[0.0].payload)[by_boom].all()
    assert (charts[-10.0].payload < charts[0.0].payload)[by_boom].all()


def test_both_right_hand_sides_turn_gravity(random_states):
    for name in (*NAMES, "single-cylinder"):
        crane = raised(name, -0.2)
        x, u = random_states(crane, 50, 7)
        found, expected = (
            of(x, u, payload=PAYLOAD) for of in (crane.state_derivative, crane.reference_state_derivative)
        )
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("slope", [SLOPE, -0.3])
def test_mujoco_has_the_same_weights(slope, tmp_path, random_poses):
    mujoco = pytest.importorskip("mujoco")
    crane = raised("rottne-f9-lab", slope)
    model = mujoco.MjModel.from_xml_path(str(hc.export_mjcf(crane, tmp_path / "crane.xml", payload=PAYLOAD)))
    data = mujoco.MjData(model)
    for q in random_poses(crane, 10, seed=5):
        data.qpos[:], data.qvel[:] = q, 0.3
        mujoco.mj_forward(model, data)
        ours = crane.bias_force(q, np.full(3, 0.3), payload=PAYLOAD)
        np.testing.assert_allclose(data.qfrc_bias, ours, rtol=1e-6, atol=1e-6 * np.abs(ours).max())
    assert "stands on a slope" in hc.export_urdf(crane, tmp_path / "crane.urdf").read_text()
    assert "along -z" in hc.export_urdf("rottne-f9-lab", tmp_path / "level.urdf").read_text()


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("60 deg", ["60 deg or more", "10 deg"]),
        ("-75 deg", ["60 deg or more", "10 deg"]),
        ("3 m", ["angle"]),
        ("steep", ["environment.slope"]),
    ],
)
def test_what_is_no_slope_is_refused(value, words):
    with pytest.raises(hc.MachineFileError) as error:
        hc.load_machine("rottne-f9-lab", {"environment.slope": value})
    for word in ("environment.slope", *words):
        assert word in str(error.value)
