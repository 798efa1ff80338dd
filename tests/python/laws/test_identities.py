"""Identities that hold for any mechanism, whatever its numbers."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hydrocrane as hc

COUNT = 300
# Central difference of eighth order: weights of f(x + k h) - f(x - k h), k = 1..4.
STENCIL = (4 / 5, -1 / 5, 4 / 105, -1 / 280)


def slope(function, x, h):
    """d(function)/ds at s = 0 of function(x + s), to about h^8."""
    return sum(w * (function(x + k * h) - function(x - k * h)) for k, w in enumerate(STENCIL, start=1)) / h


def gradient(function, q, h=2e-3):
    """Derivatives by each joint coordinate, stacked in the last axis."""
    steps = np.eye(q.shape[-1])
    return np.stack([slope(lambda s, e=e: function(q + s * e), 0.0, h) for e in steps], axis=-1)


@pytest.fixture
def motions(corrected, random_poses):
    """Poses and rates (COUNT, n)."""
    q = random_poses(corrected, COUNT, seed=21)
    return q, np.random.default_rng(22).normal(size=q.shape)


def test_generalized_force_is_the_stroke_jacobian_transposed_times_the_force(corrected, random_states):
    """Virtual work on whole states: what M q'' + h leaves to the cylinders is J_l^T f."""
    x, u = random_states(corrected, COUNT, seed=23)
    q, qd, qdd = (
        joints(corrected, x, "q"),
        joints(corrected, x, "qd"),
        joints(corrected, corrected.state_derivative(x, u), "qd"),
    )
    outputs = corrected.outputs(x, u)
    force = np.stack([outputs[f"cylinder.{c}.force"] for c in corrected.cylinder_names], axis=-1)
    inertial = np.einsum("mij,mj->mi", corrected.mass_matrix(q), qdd)
    bias = corrected.bias_force(q, qd)
    driven = np.einsum("mcj,mc->mj", corrected.stroke_jacobian(q), force)
    size = np.abs(inertial).max(axis=1) + np.abs(bias).max(axis=1) + np.abs(driven).max(axis=1)
    assert (np.abs(inertial + bias - driven).max(axis=1) / size).max() < 1e-12


def test_cylinder_power_is_force_times_piston_velocity(corrected, random_states):
    """Q^T q' = f^T v: the piston velocities of a state are those of its joints through the same Jacobian."""
    x, u = random_states(corrected, COUNT, seed=24)
    q, qd = joints(corrected, x, "q"), joints(corrected, x, "qd")
    outputs = corrected.outputs(x, u)
    for i, cylinder in enumerate(corrected.cylinder_names):
        terms = corrected.stroke_jacobian(q)[:, i] * qd
        size = np.abs(terms).sum(axis=1)
        assert (np.abs(outputs[f"cylinder.{cylinder}.v"] - terms.sum(axis=1)) <= 1e-12 * size).all()
        np.testing.assert_array_equal(outputs[f"cylinder.{cylinder}.x"], corrected.strokes(q)[:, i])


def test_stroke_jacobian_is_the_slope_of_the_strokes(corrected, random_poses):
    q = random_poses(corrected, COUNT, seed=25)
    np.testing.assert_allclose(corrected.stroke_jacobian(q), gradient(corrected.strokes, q), rtol=0, atol=1e-10)


def test_tip_jacobian_is_the_slope_of_the_tip(corrected, random_poses):
    q = random_poses(corrected, COUNT, seed=26)
    np.testing.assert_allclose(corrected.tip_jacobian(q), gradient(corrected.tip, q), rtol=0, atol=1e-10)


def test_drawn_linkage_closes_and_drawn_cylinders_have_the_length_of_their_strokes(random_poses):
    """Laboratory crane: torque links of 182 and 194 mm; pins apart by the lengths at mid-stroke plus the stroke."""
    crane = hc.load_machine("rottne-f9-lab")
    middle = np.array([0.05 + 0.265 + 0.31 + 0.01, 0.035 + 0.2725 + 0.31 + 0.095, 0.04 + 0.395 + 0.71 + 0.04])
    for q in random_poses(crane, 50, seed=27):
        lines = {(kind, name): points for kind, name, points in crane.drawing(q)}
        linkage = lines["torque-link", "jib"]
        np.testing.assert_allclose(np.linalg.norm(np.diff(linkage, axis=0), axis=1), [0.182, 0.194], rtol=1e-12)
        np.testing.assert_allclose(lines["cylinder-rod", "jib"][-1], linkage[1], rtol=1e-12)
        for i, cylinder in enumerate(crane.cylinder_names):
            apart = np.linalg.norm(lines["cylinder-rod", cylinder][-1] - lines["cylinder-barrel", cylinder][0])
            assert apart == pytest.approx(middle[i] + crane.strokes(q)[i], rel=1e-12)


def test_mass_matrix_is_symmetric_and_positive_definite(corrected, random_poses):
    for payload in (0.0, 500.0):
        m = corrected.mass_matrix(random_poses(corrected, COUNT, seed=28), payload=payload)
        np.testing.assert_array_equal(m, np.swapaxes(m, -1, -2))
        assert np.linalg.eigvalsh(m).min() > 0.0


def test_kinetic_energy_is_the_form_of_the_mass_matrix(corrected, motions):
    q, qd = motions
    form = 0.5 * np.einsum("mi,mij,mj->m", qd, corrected.mass_matrix(q, payload=70.0), qd)
    np.testing.assert_allclose(corrected.kinetic_energy(q, qd, payload=70.0), form, rtol=1e-12)


def test_bias_at_rest_is_the_slope_of_the_potential_energy(corrected, motions):
    def potential(q):
        return corrected.potential_energy(q, payload=70.0)

    bias = corrected.bias_force(motions[0], np.zeros_like(motions[0]), payload=70.0)
    scale = np.abs(bias).max()
    np.testing.assert_allclose(bias / scale, gradient(potential, motions[0]) / scale, rtol=0, atol=1e-10)


def test_coriolis_forces_do_the_work_of_the_changing_mass_matrix(corrected, motions):
    """q'^T c(q, q') = 1/2 q'^T M' q', with M' along the motion: without it energy would not be conserved."""
    q, qd = motions
    coriolis = corrected.bias_force(q, qd) - corrected.bias_force(q, np.zeros_like(qd))
    change = slope(lambda s: corrected.mass_matrix(q + s * qd), 0.0, 2e-3)
    work = np.einsum("mi,mi->m", qd, coriolis)
    expected = 0.5 * np.einsum("mi,mij,mj->m", qd, change, qd)
    scale = np.abs(qd * coriolis).sum(axis=1) + np.abs(corrected.kinetic_energy(q, qd))
    assert (np.abs(work - expected) / scale).max() < 1e-10


def test_free_motion_keeps_its_energy(corrected):
    """The chain falling freely, cylinders without force: T + V stays while T changes manyfold."""
    n = len(corrected.joint_names)

    def motion(_t, y):
        return np.concatenate([y[n:], corrected.forward_dynamics(y[:n], y[n:], np.zeros(n))])

    start = np.concatenate([corrected.home, np.full(n, 0.2)])
    path = solve_ivp(motion, (0.0, 0.8), start, method="DOP853", rtol=1e-12, atol=1e-12)
    q, qd = path.y[:n].T, path.y[n:].T
    kinetic = corrected.kinetic_energy(q, qd)
    energy = kinetic + corrected.potential_energy(q)
    assert kinetic.max() > 10 * kinetic[0]
    assert np.ptp(energy) < 1e-10 * kinetic.max()


def joints(crane, x, kind):
    return x[:, [crane.state_names.index(f"joint.{j}.{kind}") for j in crane.joint_names]]
