"""Modes of small motions: what friction does to them, and what a recording shows of them."""

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane import plots
from hydrocrane.analysis import linear

LAB = "rottne-f9-lab"
STATIC = {f"friction.{cylinder}.model": "static" for cylinder in ("lift", "jib", "extension")}


def kinds(found):
    return [warning.kind for warning in found.warnings]


def links(found):
    """Frequencies and damping ratios of what is not a spool's own."""
    own = [not state.endswith((".xs", ".vs")) for state in found.state]
    return found.frequency[own], found.damping[own]


def without_friction(crane, q):
    """The Jacobian of the crane without friction, by its definition: the equations of motion have none."""
    state = crane.equilibrium(q)
    jacobian = crane.jacobian(state, np.zeros(len(crane.cylinder_names)))
    rates = [i for i, name in enumerate(crane.state_names) if name.endswith(".qd")]
    bristles = [i for i, name in enumerate(crane.state_names) if name.endswith(".z")]
    # Clear of the end stops nothing but friction acts on accelerations through rates at rest.
    jacobian[np.ix_(rates, rates)] = 0.0
    jacobian[np.ix_(rates, bristles)] = 0.0
    return jacobian


@pytest.mark.parametrize("name", [LAB, "hiab-xs031", "single-cylinder", "rig-kalmar"])
def test_released_modes_are_those_of_the_frictionless_equations(name):
    crane = hc.load_machine(name)
    found = hc.modes(crane, crane.home, friction="released")
    values = np.linalg.eigvals(without_friction(crane, crane.home))
    size = np.sort(np.abs(values[values.imag > 1e-9 * np.abs(values).max()])) / (2 * np.pi)
    np.testing.assert_allclose(found.frequency, size, rtol=1e-9)


def test_the_smoothing_of_static_friction_is_no_damping():
    """As it was: one mode with a ratio of 0.47, the other two gone."""
    crane = hc.load_machine(LAB, STATIC)
    smoothed = hc.modes(crane, crane.home, friction="smoothed")
    assert links(smoothed)[1].max() > 0.4 and links(smoothed)[0].size == 1
    assert "static-friction-smoothed" in kinds(smoothed)
    found = hc.modes(crane, crane.home)
    frequency, damping = links(found)
    bristles = links(hc.modes(LAB, crane.home))
    np.testing.assert_allclose(frequency, bristles[0], rtol=0.02)
    assert (damping < 1e-3).all() and (damping < bristles[1]).all()
    warning = next(w for w in found.warnings if w.kind == "static-friction-smoothed")
    assert "lift, jib, extension" in warning.text and "omit" in warning.text and "lugre" in warning.cure


@pytest.mark.parametrize("share", [0.02, 0.97])
def test_end_stops_keep_their_damping(share):
    """In their zones the stops damp too, and that is the crane's own."""
    crane = hc.load_machine(LAB, STATIC)
    low, high = crane.joint_limits.T
    q = low + share * (high - low)
    state = crane.rest(q)[0]
    jacobian = crane.jacobian(state, np.zeros(3))
    slopes = linear._friction_slopes(crane, jacobian, state, None)
    # One side or the other of the map: the forces extending and retracting differ.
    for cylinder, slope in zip(crane.cylinder_names, slopes, strict=True):
        sides = [float(crane.friction_map(v, cylinder)) / v for v in (-1e-9, 1e-9)]
        assert min(sides) * (1 - 1e-4) - 1.0 <= slope <= max(sides) * (1 + 1e-4) + 1.0


def test_bristles_hold_and_nothing_is_left_out():
    crane = hc.load_machine(LAB)
    held, smoothed = (hc.modes(crane, crane.home, friction=friction) for friction in ("held", "smoothed"))
    np.testing.assert_array_equal(held.eigenvalues, smoothed.eigenvalues)
    assert "static-friction-smoothed" not in kinds(held)
    assert held.frequency[0] == pytest.approx(11.08, abs=0.01) and held.damping[0] == pytest.approx(0.0022, abs=1e-4)


def test_a_sign_that_jumps_is_no_smoothing():
    crane = hc.load_machine("heinze-2007")
    assert "static-friction-smoothed" not in kinds(hc.modes(crane, crane.home))


def test_the_recording_that_a_mode_needs():
    crane = hc.load_machine(LAB)
    found = hc.modes(crane, crane.home)
    np.testing.assert_allclose(found.record_interval * found.frequency, 0.1)
    warning = next(w for w in found.warnings if w.kind == "mode-above-recording")
    assert "121" in warning.text and "50 Hz" in warning.text and "record-interval" in warning.cure
    slow = hc.load_machine("hiab-xs031")
    released = hc.modes(slow, slow.home, friction="released")
    assert released.frequency.max() < 50 and "mode-above-recording" not in kinds(released)


def test_the_map_says_what_friction_does():
    crane = hc.load_machine(LAB, STATIC)
    found = hc.mode_map(crane, samples=3)
    assert kinds(found) == ["static-friction-smoothed"] and found.friction == "held"
    note = plots.mode_map(crane, found).get_supxlabel().replace("\n", " ")
    assert "static friction is left out" in note and "acts at rest as a damper" in note
    # Not the smoothing's: 9 Hz and more of the links, hardly damped.
    assert np.nanmax(found.damping) < 0.05


def test_long_lines_slow_the_modes_down_as_their_oil_and_walls_say(tmp_path):
    """A mass on two trapped volumes of oil: the frequency by hand, for three lengths of hose."""
    bore, rod, stroke, hose = 0.05, 0.03, 0.63, 0.012
    areas = np.pi / 4 * np.array([bore**2, bore**2 - rod**2])
    found = []
    for length in (0.5, 5.0, 20.0):
        lines = "".join(
            f"""
            [line.{side}]
            cylinder = "test"
            side = "{side}"
            length = "{length} m"
            inner-diameter = "12 mm"
            compliance = "{0.01 * length} ml/bar"
            """
            for side in ("piston-side", "rod-side")
        )
        path = tmp_path / f"hose-{length}.toml"
        path.write_text(f'extends = "single-cylinder"\n[machine]\nclass = "assumed"\n{lines}')
        crane = hc.load_machine(path)
        q = np.array([0.05])
        state = crane.equilibrium(q)
        x, pressures = crane.strokes(q)[0], state[2:4]
        dead = np.pi / 4 * 0.01**2 * 0.02
        oil = dead + areas * (stroke / 2 + np.array([x, -x])) + np.pi / 4 * hose**2 * length
        widening = 0.01e-6 * length / 1e5
        capacity = (oil + widening * pressures) / crane.bulk_modulus(pressures) + widening
        by_hand = np.sqrt((areas**2 / capacity).sum() / crane.mass_matrix(q)[0, 0]) / (2 * np.pi)
        modes = hc.modes(crane, q, friction="released")
        slowest = modes.frequency.min()
        # Leakage damps a little.
        assert slowest == pytest.approx(by_hand, rel=1e-3), length
        found.append(slowest)
    assert found[0] > 1.3 * found[1] > 1.6 * found[2]


def test_wrong_friction_names_the_choices():
    with pytest.raises(hc.InputError, match="did you mean `released`"):
        hc.modes(LAB, [1.7, 1.7, 0.3], friction="release")


NAMED = {
    "modes": lambda machine, crane: hc.modes(machine, crane.home).frequency,
    "mode_map": lambda machine, crane: hc.mode_map(machine, samples=2).frequency,
    "load_chart": lambda machine, crane: hc.load_chart(machine, samples=4).payload,
    "cite": lambda machine, crane: hc.cite(machine),
    "Simulator": lambda machine, crane: hc.Simulator(machine).reset(q=crane.home).tip,
    "BatchSimulator": lambda machine, crane: hc.BatchSimulator(machine, 2).n,
    "workspace": lambda machine, crane: len(plots.workspace(machine).axes),
    "joint_stroke": lambda machine, crane: len(plots.joint_stroke(machine).axes),
    "flow_law": lambda machine, crane: len(plots.flow_law(machine).axes),
    "friction_maps": lambda machine, crane: len(plots.friction_maps(machine).axes),
}


@pytest.mark.parametrize("call", NAMED.values(), ids=NAMED)
def test_functions_of_a_machine_take_its_name(call):
    crane = hc.load_machine(LAB)
    np.testing.assert_array_equal(call(LAB, crane), call(crane, crane))
    with pytest.raises(hc.HydrocraneError, match="rottne-f9-lab"):
        call("rotne-f9-lab", crane)
    with pytest.raises(hc.InputError, match="name"):
        call(7, crane)
