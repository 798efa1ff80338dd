"""Linear models against the simulator, against the modes, and against python-control."""

from __future__ import annotations

import builtins
import json

import numpy as np
import pytest
from scipy.io import loadmat

import hydrocrane as hc
from hydrocrane.linear import linearise
from hydrocrane.linear.outputs import known_outputs

LAB = "rottne-f9-lab"
POSE = np.array([1.7, 1.9, 0.05])


@pytest.fixture(scope="module")
def crane():
    return hc.load_machine(LAB)


def moved(machine, q, commands, sample_time):
    """States (m + 1, n_states) of a tight simulation from rest under commands (m, n_cyl)."""
    simulator = hc.Simulator(machine, sample_time=sample_time, method="rodas5p", rtol=1e-11)
    simulator.reset(q=q)
    states = [simulator.state]
    for command in commands:
        simulator.step(command)
        states.append(simulator.state)
    return np.array(states)


def deviation(machine, q, commands, sample_time):
    """What the commands change of the states, against closed valves: leakage moves the crane as well."""
    return moved(machine, q, commands, sample_time) - moved(machine, q, np.zeros_like(commands), sample_time)


def worst(found, expected):
    """Largest error of each column, relative to the largest of the column."""
    scale = np.abs(expected).max(axis=0)
    moving = scale > 1e-9 * scale.max()
    return (np.abs(found - expected).max(axis=0)[moving] / scale[moving]).max()


@pytest.mark.parametrize("side", ["extend", "retract"])
@pytest.mark.parametrize(("name", "cylinder", "bound"), [(LAB, "extension", 0.02), ("hiab-xs031", "tilt", 0.01)])
def test_step_responses_are_those_of_small_steps(name, cylinder, side, bound):
    """A closed valve has another gain to either side, so each side has its own model."""
    machine = hc.load_machine(name)
    q = POSE if name == LAB else machine.home
    index = machine.cylinder_names.index(cylinder)
    command = np.zeros((50, len(machine.cylinder_names)))
    command[:, index] = 2e-4 * machine.spool_strokes[index] * (1 if side == "extend" else -1)
    found = deviation(machine, q, command, 0.002)
    model = machine.linearise(q, inputs=f"cylinder.{cylinder}.command", outputs=machine.state_names, side=side)
    expected = model.step(np.arange(51) * 0.002, size=command[0, index]).y[..., 0]
    assert worst(found, expected) < bound
    other = machine.linearise(
        q, inputs=model.input_names, outputs=machine.state_names, side="retract" if side == "extend" else "extend"
    )
    if np.linalg.norm(other.A - model.A) > 0.1 * np.linalg.norm(model.A):
        assert worst(found, other.step(np.arange(51) * 0.002, size=command[0, index]).y[..., 0]) > 5 * bound


def test_the_error_of_a_step_falls_with_its_size():
    """What is left is of second order."""
    machine = hc.load_machine("hiab-xs031")
    errors = []
    for share in (1e-3, 1e-4):
        command = np.zeros((50, 3))
        command[:, 1] = share * machine.spool_strokes[1]
        model = machine.linearise(machine.home, outputs=machine.state_names)
        expected = model.step(np.arange(51) * 0.002, size=command[0]).y[..., 1]
        errors.append(worst(deviation(machine, machine.home, command, 0.002), expected))
    assert errors[1] < 0.12 * errors[0]


def test_a_force_on_the_tip_acts_as_a_load_does(crane):
    """Statically: the deflection of the oil under a force is that under the weight of a small load."""
    load = 1e-3
    model = crane.linearise(POSE, inputs=["tip.force.z"], outputs=["joint.boom.qd", "joint.jib.qd"])
    state = crane.equilibrium(POSE)
    none, loaded = (crane.state_derivative(state, np.zeros(3), payload=mass) for mass in (0.0, load))
    rates = [crane.state_names.index(f"joint.{joint}.qd") for joint in crane.joint_names]
    # The load also is inertia, but at rest it accelerates from nothing.
    mass = crane.mass_matrix(POSE, payload=load)
    expected = np.linalg.solve(crane.mass_matrix(POSE), mass @ (loaded - none)[rates]) / (-load * 9.81)
    np.testing.assert_allclose(model.B[rates, 0], expected, rtol=1e-6)


@pytest.mark.parametrize("friction", ["smoothed", "held", "released"])
@pytest.mark.parametrize("name", [n for n in hc.bundled_machines() if n != "heinze-2007"])
def test_poles_are_those_of_the_modes(name, friction):
    machine = hc.load_machine(name)
    model = machine.linearise(machine.home, friction=friction)
    expected = hc.modes(machine, machine.home, friction=friction)
    for value in expected.eigenvalues:
        assert np.abs(model.poles() - value).min() < 1e-5 * max(abs(value), 1.0)
    np.testing.assert_allclose(model.oscillations.frequency, expected.frequency, rtol=1e-6)


@pytest.mark.evidence
def test_a_sine_of_the_simulator_has_the_gain_of_the_model():
    """One cylinder in steady motion through an open valve: below and above its resonance at 40 Hz."""
    machine = hc.load_machine("single-cylinder")
    opened = 0.02 * float(machine.spool_strokes[0])
    settling = hc.Simulator(machine, sample_time=1.0, method="rodas5p", rtol=1e-8)
    settling.reset(q=machine.home - 0.2)
    for _ in range(60):
        settling.step([opened])
    base, names = settling.state, ("joint.slide.qd", "cylinder.test.p1")
    places = [machine.state_names.index(name) for name in names]
    period, amplitude = 5e-4, 0.01 * opened
    times = (np.arange(3000) + 1) * period

    def swing(hertz, size):
        simulator = hc.Simulator(machine, sample_time=period, method="rodas5p", rtol=1e-10)
        simulator.reset(state=base)
        found = []
        for time in times:
            # A held command lags by half a sample.
            simulator.step([opened + size * np.sin(2 * np.pi * hertz * (time - period / 2))])
            found.append(simulator.state[places])
        return np.array(found)

    model = machine.linearise(state=base, outputs=names)
    for hertz, bound in ((2.0, 0.005), (20.0, 0.005), (80.0, 0.02)):
        found = (swing(hertz, amplitude) - swing(hertz, -amplitude)) / (2 * amplitude)
        phase = 2 * np.pi * hertz * times
        # The piston travels on: a line beside the sine.
        basis = np.stack([np.sin(phase), np.cos(phase), np.ones_like(times), times], axis=-1)[2000:]
        sine, cosine, *_ = np.linalg.lstsq(basis, found[2000:], rcond=None)[0]
        ratio = (sine + 1j * cosine) / model.frequency_response(2 * np.pi * hertz)[:, 0]
        np.testing.assert_allclose(ratio, 1.0, atol=bound)


@pytest.mark.parametrize("name", [LAB, "rottne-f9-pump", "hiab-xs031"])
def test_rows_of_outputs_are_derivatives(name):
    """Along random directions, against plain differences of the outputs; exact rows have no error."""
    machine = hc.load_machine(name)
    names = [n for n in known_outputs(machine) if n != "energy.oil"]
    state = machine.equilibrium(machine.home)
    rng = np.random.default_rng(5)
    for i, label in enumerate(machine.state_names):
        state[i] += {"qd": 0.3, "xs": 2e-4, "p1": 3e5, "p2": 2e5, "z": 2e-5}.get(label.rsplit(".", 1)[-1], 0.0)
    model = machine.linearise(state=state, outputs=names)
    assert model.output_error.max() < 1e-4
    exact = [n for n in names if n in machine.state_names or n.endswith((".x", ".z", ".command"))]
    assert not model.output_error[[names.index(n) for n in exact]].any()
    steps = np.array([1e2 if n.endswith((".p1", ".p2", "mains.p")) else 1e-7 for n in machine.state_names])
    for _ in range(3):
        way = rng.normal(size=state.size) * steps
        found = [machine.outputs(state + side * way, model.u) for side in (1, -1)]
        for row, label in zip(model.C, names, strict=True):
            if label in found[0]:
                slope = (found[0][label] - found[1][label]) / 2
                scale = np.abs(row * way).sum() + 1e-9 * abs(found[0][label])
                assert abs(row @ way - slope) <= 2e-3 * scale, label


@pytest.mark.evidence
def test_python_control_has_the_same_answers(crane):
    control = pytest.importorskip("control")
    model = crane.linearise(POSE, outputs=["tip.z", "joint.jib.q"], friction="released")
    theirs = model.to_control()
    assert theirs.input_labels == [f"cylinder_{c}_command" for c in crane.cylinder_names]
    assert theirs.output_labels == ["tip_z", "joint_jib_q"] and theirs.state_labels[0] == "joint_boom_q"
    omega = np.geomspace(1.0, 1e3, 20)
    ours = np.moveaxis(model.frequency_response(omega), 0, -1)
    np.testing.assert_allclose(ours, theirs(1j * omega), rtol=1e-5)
    times = np.linspace(0, 0.5, 501)
    expected = control.step_response(theirs, times).outputs
    found = np.moveaxis(model.step(times).y, 0, -1)
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())


def test_without_python_control_the_cure_is_said(crane, monkeypatch):
    real = builtins.__import__

    def refuse(name, *rest):
        if name == "control":
            raise ImportError(name)
        return real(name, *rest)

    model = crane.linearise(POSE)
    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(hc.InputError, match=r"hydrocrane\[control\]"):
        model.to_control()


def test_files_hold_the_matrices_with_names_and_units(crane, tmp_path):
    model = crane.linearise(POSE, inputs="cylinder.lift.command", outputs=["tip.z", "cylinder.lift.force"])
    text = json.loads(model.save(tmp_path / "x.json").read_text(encoding="utf-8"))
    cells = loadmat(model.save(tmp_path / "x.mat"), simplify_cells=True)
    for stored in (text, cells):
        for name in ("A", "C"):
            np.testing.assert_array_equal(stored[name], getattr(model, name))
        np.testing.assert_array_equal(np.ravel(stored["B"]), model.B[:, 0])
        assert tuple(stored["state_names"]) == model.state_names
        assert list(stored["output_units"]) == ["m", "N"]
        assert stored["about"]["machine"] == LAB
    with pytest.raises(hc.ResultFileError, match="did you mean"):
        model.save(tmp_path / "x.jsn")


def test_a_notebook_shows_it_in_little_room(crane):
    html = crane.linearise(POSE)._repr_html_()
    assert "joint.boom.qd" in html and "tip.z [m]" in html and len(html) < 20_000
    assert repr(crane.linearise(POSE)) == f"<LinearModel of {LAB}: 21 states, 3 inputs, 5 outputs>"


def kinds(model):
    return {warning.kind for warning in model.warnings}


def test_what_the_matrices_do_not_show_is_said(crane):
    assert kinds(crane.linearise(POSE)) == {"valve-gain-jumps"}
    opened = crane.linearise(POSE, command=0.1 * crane.spool_strokes)
    assert kinds(opened) == {"not-in-equilibrium"}
    mobile = hc.load_machine("rottne-f9-mobile")
    closed = mobile.linearise(mobile.home)
    assert "valve-in-dead-band" in kinds(closed) and not closed.A[6:8, 8].any()
    assert "valve-in-dead-band" not in kinds(mobile.linearise(mobile.home, command=0.9 * mobile.spool_strokes))
    printed = hc.load_machine("heinze-2007")
    jumping = printed.linearise(printed.home, outputs=["cylinder.lift.friction"])
    assert "output-kink" in kinds(jumping) and jumping.output_error[0] > 0.1
    smooth = hc.load_machine(LAB, {f"friction.{c}.model": "static" for c in crane.cylinder_names})
    assert "static-friction-smoothed" in kinds(smooth.linearise(POSE))
    late = hc.load_machine(LAB, {"valve.lift.delay": "20 ms"})
    warning = next(w for w in late.linearise(POSE).warnings if w.kind == "command-path-left-out")
    assert "lift" in warning.text and "20 ms" in warning.text
    assert "command-path-left-out" not in kinds(late.linearise(POSE, inputs="tip.force.x"))
    limited = hc.load_machine(LAB, {"valve.lift.acceleration-limit": "1 m/s^2"})
    state = limited.equilibrium(POSE)
    far = limited.linearise(state=state, command=[0.5 * limited.spool_strokes[0], 0.0, 0.0])
    assert "spool-limited" in kinds(far) and not far.B[:, 0].any()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({}, "either q"),
        ({"q": POSE, "state": np.zeros(21)}, "either q"),
        ({"q": np.tile(POSE, (2, 1))}, "batch"),
        ({"q": POSE, "outputs": ["tip.y"]}, "did you mean `tip.z`"),
        ({"q": POSE, "outputs": []}, "at least one output"),
        ({"q": POSE, "outputs": ["tip.x", "tip.x"]}, "named twice"),
        ({"q": POSE, "inputs": "cylinder.lift.comand"}, "did you mean `cylinder.lift.command`"),
        ({"q": POSE, "side": "extent"}, "did you mean `extend`"),
        ({"q": POSE, "friction": "none"}, "unknown friction"),
        ({"q": [9.0, 1.7, 0.0]}, "boom"),
        ({"q": [np.nan, 1.7, 0.0]}, "finite"),
        ({"q": POSE, "payload": -1.0}, "payload"),
        ({"q": POSE, "command": [0.0]}, "command"),
        ({"state": np.full(21, 0.1), "friction": "released"}, "at rest"),
    ],
)
def test_wrong_input_is_one_clear_error(crane, arguments, words):
    with pytest.raises(hc.HydrocraneError, match=words):
        linearise(crane, **arguments)


def test_wrong_times_and_frequencies(crane):
    model = crane.linearise(POSE)
    for times in ([0.0], [1.0, 2.0], [0.0, 1.0, 3.0], [0.0, -1.0]):
        with pytest.raises(hc.InputError, match="times of a step response"):
            model.step(times)
    with pytest.raises(hc.InputError, match="finite"):
        model.frequency_response([np.inf])
    with pytest.raises(hc.InputError, match=r"model\.select"):
        hc.bode(model)
    with pytest.raises(hc.InputError, match="greater than zero"):
        hc.bode(model.select(outputs="tip.z"), [0.0, 1.0])
