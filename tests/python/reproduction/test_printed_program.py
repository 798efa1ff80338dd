"""hydrocrane's `heinze-2007` against an independent restatement of the thesis's program."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import printed_controller as controller
from oracles import printed_program as program

import hydrocrane as hc

pytestmark = pytest.mark.evidence

TOLERANCE = 1e-11
POSE = np.array([np.deg2rad(100.0), np.deg2rad(100.0), 0.0])


@pytest.fixture(scope="module")
def crane():
    return hc.load_machine("heinze-2007")


@pytest.fixture(scope="module")
def order(crane):
    """Position of each of the thesis's states in hydrocrane's state vector."""
    assert sorted(crane.state_names) == sorted(program.STATE_NAMES)
    return np.array([crane.state_names.index(name) for name in program.STATE_NAMES])


def random_states(count: int, seed: int) -> np.ndarray:
    """States (count, 18) in the thesis's order: whole stroke, pressures -20..200 bar, fast and slow."""
    rng = np.random.default_rng(seed)
    y = np.empty((count, 3, 6))
    # From below the dead centre of cylinder 1 to the last centimetre of every stroke.
    y[:, :, 0] = rng.uniform([0.35, 0.02, -0.31], [2.35, 3.12, 0.31], (count, 3))
    y[:, :, 1] = rng.normal(size=(count, 3)) * 10.0 ** rng.uniform(-4, 0, (count, 3))
    y[:, :, 2:4] = rng.uniform(-20e5, 200e5, (count, 3, 2))
    y[:, :, 4] = rng.uniform(-0.06, 0.06, (count, 3))
    y[:, :, 5] = rng.normal(scale=5.0, size=(count, 3))
    return y


def assert_equal(crane, order, states: np.ndarray, commands: np.ndarray) -> None:
    """Both right-hand sides agree in every component, measured by the component's own scale."""
    states = states.reshape(-1, 18)
    theirs = np.array([program.state_derivative(y, u) for y, u in zip(states, commands)])
    arranged = np.empty_like(states)
    arranged[:, order] = states
    ours = np.asarray(crane.state_derivative(arranged, commands))[:, order]
    scale = np.abs(theirs) + np.median(np.abs(theirs), axis=0)
    error = np.abs(ours - theirs) / np.where(scale > 0, scale, 1.0)
    worst = np.unravel_index(error.argmax(), error.shape)
    assert error.max() < TOLERANCE, (
        f"{program.STATE_NAMES[worst[1]]}: {ours[worst]!r} against {theirs[worst]!r} in state {worst[0]}"
    )


def commands_for(states: np.ndarray, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-0.05, 0.05, (len(states), 3))


def test_random_states(crane, order):
    states = random_states(4000, seed=1)
    assert_equal(crane, order, states, commands_for(states, 2))


def test_orifice_thresholds(crane, order):
    """Pressure drops at, just below and just above 2, 3 and 4 bar, both flow directions, every port."""
    drops = np.array([s * (b * 1e5 + d) for s in (1, -1) for b in (0, 1, 2, 3, 4, 5) for d in (-1.0, 0.0, 1.0)])
    states = []
    for base in (program.SUPPLY, program.TANK):
        for drop in drops:
            for sign in (1, -1):
                y = random_states(1, seed=3)[0]
                y[:, 1] = 0.0  # at rest the connector drop is zero and the thresholds are met exactly
                y[:, 2:4] = base - drop
                y[:, 4] = sign * 0.02
                states.append(y)
    assert_equal(crane, order, np.array(states), np.zeros((len(states), 3)))


def test_signs_at_rest(crane, order):
    """sign(0) = 0: no friction at rest, no flow at a closed spool, a positive spool at exactly zero."""
    states = random_states(300, seed=4)
    states[:, :, 1] = 0.0
    states[::2, :, 4] = 0.0
    assert_equal(crane, order, states, commands_for(states, 5))


def test_stick_slip_speeds(crane, order):
    """Joint rates from 1e-12 to 1e-3, through the steep part of the Stribeck curve, both ways."""
    states = random_states(300, seed=6)
    rates = 10.0 ** np.linspace(-12, -3, 300)[:, None]
    states[:, :, 1] = rates * np.where(np.arange(300)[:, None] % 2, 1.0, -1.0)
    assert_equal(crane, order, states, commands_for(states, 7))


def test_end_stops(crane, order):
    """Pistons inside both end stops, where only a spring acts."""
    states = random_states(400, seed=8)
    rng = np.random.default_rng(9)
    states[:, 0, 0] = rng.uniform(np.deg2rad(129.5), np.deg2rad(135.5), 400)
    states[:, 1, 0] = rng.uniform(np.deg2rad(1.0), np.deg2rad(29.0), 400)
    states[:, 2, 0] = rng.uniform(0.285, 0.314, 400) * np.where(np.arange(400) % 2, 1, -1)
    assert (np.abs([program.strokes(q)[0] for q in states[:, :, 0]]) > [0.1435, 0.15025, 0.2795]).all()
    assert_equal(crane, order, states, commands_for(states, 10))


def test_published_start_state(crane, order):
    """The thesis starts with every pressure at zero."""
    assert_equal(crane, order, controller.START[None], np.zeros((1, 3)))


def test_oracle_mechanics_follow_from_the_lagrangian():
    """The oracle's own mass matrix, rate and gravity terms from energies, by finite differences."""
    rng = np.random.default_rng(11)
    step = 1e-5

    def centres(q):
        boom = np.exp(1j * (q[0] - np.pi / 2))
        jib = boom * np.exp(1j * (q[1] - np.pi))
        knee = program.PILLAR_JOINT + boom * program.JIB_JOINT
        return np.array(
            [
                program.PILLAR_JOINT + boom * program.CENTRES[0],
                knee + jib * program.CENTRES[1],
                knee + jib * (program.beam_offset(q[2]) + program.CENTRES[2]),
            ]
        )

    def slope(function, q):
        return np.array([(function(q + step * e) - function(q - step * e)) / (2 * step) for e in np.eye(3)])

    for _ in range(20):
        q, qd = rng.uniform([0.5, 0.2, -0.3], [2.3, 3.0, 0.3]), rng.normal(size=3)
        mass, rate, gravity = program.mechanics(q, qd)
        jac = slope(centres, q).T
        omega = np.array([[1, 0, 0], [1, 1, 0], [1, 1, 0]])
        expected = np.einsum("k,ki,kj->ij", program.MASSES, jac.conj(), jac).real + np.einsum(
            "k,ki,kj->ij", program.INERTIAS, omega, omega
        )
        np.testing.assert_allclose(mass, expected, rtol=1e-8, atol=1e-8)
        gradient = slope(lambda p: program.mechanics(p, qd)[0], q)
        lagrange = -np.einsum("kij,k,j->i", gradient, qd, qd) + 0.5 * np.einsum("kij,i,j->k", gradient, qd, qd)
        np.testing.assert_allclose(rate, lagrange, rtol=1e-6, atol=1e-6)
        height = slope(lambda p: program.MASSES @ centres(p).imag, q)
        np.testing.assert_allclose(gravity, program.GRAVITY * height, rtol=1e-8, atol=1e-6)


def test_oracle_reproduces_the_published_heights():
    """The thesis states tip heights of 1.1 m, and of -0.6 m and -0.3 m, for its two tasks."""
    time, states = controller.published_run(program.state_derivative, "vertical")
    assert abs(controller.tip_height(time, states, 5.0) - 1.1) < 0.05
    time, states = controller.published_run(program.state_derivative, "horizontal")
    assert abs(controller.tip_height(time, states, 3.0) + 0.6) < 0.05
    assert abs(controller.tip_height(time, states, 5.0) + 0.3) < 0.05
