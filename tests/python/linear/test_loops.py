"""Loops of the cylinders against python-control, shapes of modes, and their pictures."""

from __future__ import annotations

import numpy as np
import pytest
from command_line import run

import hydrocrane as hc
from hydrocrane import linear, plots
from hydrocrane.linear import PidGains

LAB = "rottne-f9-lab"


@pytest.fixture(scope="module")
def crane():
    return hc.load_machine(LAB)


def test_gains_are_those_of_the_thesis(crane):
    """Section 7.2, found by stepping the controller."""
    found = linear.pid_gains(crane)
    for i, cylinder in enumerate(crane.cylinder_names):
        gains = found[cylinder]
        expected = (1.0, 1e-4 if i == 0 else 5e-3, 0.01)
        np.testing.assert_allclose((gains.proportional, gains.integral, gains.derivative), expected, rtol=1e-7)


def weak(crane):
    """Loops that are stable without friction: proportional alone, a thousandth of the thesis's."""
    return {c: PidGains(1e-3, 0.0, 0.0) for c in crane.cylinder_names}


@pytest.mark.evidence
@pytest.mark.parametrize(("gains", "delay"), [("thesis", 0.0), ("weak", 0.004), ("thesis", 0.013)])
def test_poles_and_loop_gains_are_those_of_python_control(crane, gains, delay):
    control = pytest.importorskip("control")
    period, q = 0.01, crane.home
    chosen = linear.pid_gains(crane) if gains == "thesis" else weak(crane)
    loops = linear.cylinder_loops(crane, q, gains=chosen, period=period, delay=delay)
    model = crane.linearise(q, outputs=[f"joint.{j}.q" for j in crane.joint_names], friction="released")
    # Their sampling knows no delay: the plant is sampled as finely as the delay asks, with a chain of late commands.
    fine = 0.001
    plant = control.sample_system(model.to_control(), fine, "zoh")
    late = round(delay / fine)
    states, held = plant.nstates, round(period / fine)
    moved, driven = np.eye(states), np.zeros((states, 3 * 3))
    for k in range(held):
        sample = 2 + (k - late) // held  # Which of u[k-2], u[k-1], u[k] has arrived.
        now = np.zeros((states, 9))
        now[:, 3 * sample : 3 * sample + 3] = plant.B
        moved, driven = plant.A @ moved, plant.A @ driven + now
    a = np.zeros((states + 6, states + 6))
    a[:states, :states], a[:states, states:] = moved, driven[:, :6]
    a[states : states + 3, states + 3 :] = np.eye(3)
    b = np.vstack([driven[:, 6:], np.zeros((3, 3)), np.eye(3)])
    sampled = control.ss(a, b, np.hstack([plant.C, np.zeros((3, 6))]), np.zeros((3, 3)), period)
    signs = np.sign(np.diag(crane.stroke_jacobian(q)))
    pids = []
    for sign, g in zip(signs, chosen.values(), strict=True):
        kp, ki, kd = g.proportional, g.integral, g.derivative
        pids.append(control.tf2ss(sign * control.tf([kp + ki + kd, -kp - 2 * kd, kd], [1, -1, 0], period)))
    pid = control.append(*pids)
    closed = control.feedback(sampled * pid, control.ss([], [], [], np.eye(3), period))
    assert loops[0].radius == pytest.approx(np.abs(closed.poles()).max(), rel=1e-6)
    assert loops[0].stable is bool(np.abs(closed.poles()).max() < 1 + 1e-9)
    # One command opened, the others closed.
    for i, loop in enumerate(loops):
        others = np.diag([float(k != i) for k in range(3)])
        part = control.feedback(sampled, pid * control.ss([], [], [], others, period))
        some = np.linspace(0, loop.omega.size - 1, 40).astype(int)
        z = np.exp(1j * loop.omega[some] * period)
        expected = pid(z)[i, i] * part(z)[i, i]
        np.testing.assert_allclose(loop.gain[some], expected, rtol=1e-3, atol=1e-6 * np.abs(expected).max())


@pytest.mark.evidence
def test_margins_are_where_the_loop_becomes_unstable(crane):
    """Scaling one controller by its gain margin, from just below to just above it, ends stability."""
    gains, q = weak(crane), crane.home
    loops = linear.cylinder_loops(crane, q, gains=gains, period=0.01)
    assert all(0 < loop.margins.phase < np.pi and loop.margins.phase_at > 1e-6 for loop in loops)
    assert all(loop.stable and loop.margins.gain > 1 and abs(loop.growth) < 1e-6 for loop in loops)
    for loop in loops:
        for factor, stable in ((0.99, True), (1.01, False)):
            changed = {**gains, loop.cylinder: PidGains(1e-3 * factor * loop.margins.gain, 0.0, 0.0)}
            again = linear.cylinder_loops(crane, q, gains=changed, period=0.01)
            assert again[0].stable is stable, (loop.cylinder, factor)


def test_loops_that_there_are_not(crane):
    with pytest.raises(hc.InputError, match="measures nothing"):
        linear.cylinder_loops(crane, crane.home, controller="lever")
    with pytest.raises(hc.InputError, match="plans, learns"):
        linear.cylinder_loops(crane, crane.home, controller="tip")
    with pytest.raises(hc.InputError, match="two revolute"):
        linear.cylinder_loops("single-cylinder", [0.0])
    mobile = hc.load_machine("rottne-f9-mobile")
    with pytest.raises(hc.InputError, match="loop gain is zero"):
        linear.cylinder_loops(mobile, mobile.home)
    with pytest.raises(hc.InputError, match="lack the cylinder jib"):
        linear.cylinder_loops(crane, crane.home, gains={"lift": PidGains(1.0, 0.0, 0.0)})
    late = hc.load_machine(LAB, {f"valve.{c}.delay": "20 ms" for c in crane.cylinder_names})
    # Stable loops of a long period: what makes others stable would be sought among hundreds of eigenvalues.
    both = linear.cylinder_loops(late, crane.home, gains=weak(crane), delay=0.001)
    assert both[0].delay == pytest.approx(0.021) and both[0].stable
    with pytest.raises(hc.InputError, match="different delays"):
        linear.cylinder_loops(hc.load_machine(LAB, {"valve.lift.delay": "20 ms"}), crane.home)
    with pytest.raises(hc.InputError, match="signal chain of lift"):
        linear.cylinder_loops(hc.load_machine(LAB, {"valve.lift.command.gain": 0.8}), crane.home)
    with pytest.raises(hc.InputError, match="delay"):
        linear.cylinder_loops(crane, crane.home, delay=-1.0)


def test_shapes_are_eigenvectors_of_the_mechanics(crane):
    """Undamped: the shapes diagonalise mass matrix and stiffness of the oil alike, and are real."""
    found = linear.mode_shapes(crane, crane.home, friction="released")
    expected = hc.modes(crane, crane.home, friction="released")
    np.testing.assert_allclose(found.frequency, expected.frequency[[0, 1, 2]], rtol=1e-9)
    real = found.joints.real
    assert np.abs(found.joints.imag).max() < 2e-3 * np.abs(real).max()
    weighted = real @ crane.mass_matrix(crane.home) @ real.T
    size = np.sqrt(np.diag(weighted))
    np.testing.assert_allclose(weighted / np.outer(size, size), np.eye(3), atol=1e-3)
    np.testing.assert_allclose(np.abs(found.tip).max(axis=1), 1.0)


def test_damping_along_a_joint_is_that_of_the_modes(crane):
    found = linear.damping_curves(crane, "boom", samples=5)
    q = crane.home.copy()
    q[0] = found.coordinate[2]
    own = [i for i, s in enumerate(hc.modes(crane, q).state) if not s.endswith((".xs", ".vs"))]
    np.testing.assert_array_equal(found.damping[2], hc.modes(crane, q).damping[own])
    assert np.isfinite(found.frequency).all() and found.unit == "rad"
    with pytest.raises(hc.InputError, match="unknown joint"):
        linear.damping_curves(crane, "bom")


@pytest.mark.evidence
def test_pictures(crane):
    model = crane.linearise(crane.home, outputs="tip.z")
    assert len(hc.bode({"empty": model, "also": model}).axes[0].get_legend().get_texts()) == 6
    shapes = linear.mode_shapes(crane, crane.home)
    assert len(plots.mode_shapes(crane, shapes).axes) == 3
    assert len(plots.damping_curves(linear.damping_curves(crane, "jib", samples=3)).axes) == 2
    loops = linear.cylinder_loops(crane, crane.home, gains=weak(crane))
    texts = [text.get_text() for text in plots.loop_gains(loops).axes[0].get_legend().get_texts()]
    assert len(texts) == 3 and all("phase" in text for text in texts)
    with pytest.raises(hc.InputError, match="at least one loop"):
        plots.loop_gains([])


def test_the_old_module_still_has_its_names():
    from hydrocrane.analysis import linear as old

    assert linear.modes is old.modes and linear.mode_map is old.mode_map


@pytest.mark.evidence
def test_commands(tmp_path):
    done = run("linearise", LAB, "--at", "boom=100 deg", "-o", "x.mat", folder=tmp_path)
    assert done.returncode == 0 and "joint.boom.qd" in done.stdout and "the other side" in done.stderr
    done = run("bode", LAB, "--from", "cylinder.lift.command", "-o", "b.png", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    done = run("bode", LAB, "--loops", "-o", "l.png", folder=tmp_path)
    assert done.returncode == 0 and "unstable" in done.stdout
    assert {p.name for p in tmp_path.iterdir()} == {"x.mat", "b.png", "l.png"}
    for words in (["linearise", LAB, "-o", "x.txt"], ["linearise", LAB, "-o", "x.mat", "--to", "tip.y"],
                  ["bode", LAB, "--loops", "--to", "tip.z"], ["bode", "vertical-lift-open-loop"]):  # fmt: skip
        done = run(*words, folder=tmp_path)
        assert done.returncode == 2 and done.stderr.startswith("error:") and not done.stdout
