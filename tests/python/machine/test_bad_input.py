"""Whatever is handed in: an answer or one clear error of this package; never a panic, a NaN, a foreign exception."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hydrocrane as hc

CRANE = hc.load_machine("rottne-f9-lab")
REST = CRANE.equilibrium(CRANE.home)
IDLE = np.zeros(3)


def altered(values, index, value):
    """A copy with one entry replaced."""
    copy = np.array(values, dtype=float)
    copy[index] = value
    return copy


NAN_CALLS = {
    "strokes": lambda: CRANE.strokes([np.nan, 1.0, 0.0]),
    "strokes of a batch": lambda: CRANE.strokes([[1.0, 1.0, 0.0], [1.0, np.inf, 0.0]]),
    "joints_from_strokes": lambda: CRANE.joints_from_strokes([np.nan, 0.0, 0.0]),
    "inverse_kinematics": lambda: CRANE.inverse_kinematics([np.nan, 1.0]),
    "inverse_kinematics, x3": lambda: CRANE.inverse_kinematics([2.0, 1.0], x3=np.nan),
    "bias_force": lambda: CRANE.bias_force(CRANE.home, [0.0, -np.inf, 0.0]),
    "forward_dynamics": lambda: CRANE.forward_dynamics(CRANE.home, IDLE, [np.nan, 0.0, 0.0]),
    "mass_matrix, payload": lambda: CRANE.mass_matrix(CRANE.home, payload=np.inf),
    "orifice_flow": lambda: CRANE.orifice_flow(np.nan, 1e5),
    "friction_map": lambda: CRANE.friction_map([0.0, np.nan]),
    "bulk_modulus": lambda: CRANE.bulk_modulus(np.nan),
    "state_derivative": lambda: CRANE.state_derivative(altered(REST, 7, np.nan), IDLE),
    "jacobian": lambda: CRANE.jacobian(REST, [np.nan, 0.0, 0.0]),
    "equilibrium": lambda: CRANE.equilibrium([np.nan] * 3),
    "reset": lambda: hc.Simulator(CRANE).reset(state=altered(REST, 0, np.nan)),
    "Command": lambda: hc.Command([0.0, np.nan], [0.0, 0.01]),
    "Solver": lambda: hc.Solver(rtol=np.nan),
    "Scenario": lambda: hc.Scenario(duration=np.inf),
}


@pytest.mark.parametrize("call", NAN_CALLS.values(), ids=NAN_CALLS)
def test_numbers_that_are_not_finite(call):
    with pytest.raises(hc.InputError, match="finite"):
        call()


# Call -> words that its error must have: what was wrong, and what would be right.
WRONG_CALLS = {
    "short pose": (lambda: CRANE.tip([1.0, 1.0]), ["(3,)", "boom, jib, extension", "(2,)"]),
    "empty pose": (lambda: CRANE.tip([]), ["(3,)", "(0,)"]),
    "words for a pose": (lambda: CRANE.tip("home"), ["real numbers"]),
    "pose in pieces": (lambda: CRANE.tip([[1.0, 2.0, 0.0], [1.0]]), ["length"]),
    "state without bristles": (lambda: CRANE.jacobian(np.zeros(18), IDLE), ["(21,)", "joint.boom.q", "(18,)"]),
    "command too long": (lambda: CRANE.state_derivative(REST, np.zeros(4)), ["spool_command", "(3,)", "(4,)"]),
    "batches of two sizes": (lambda: CRANE.bias_force(np.ones((2, 3)), np.ones((3, 3))), ["(2, 3)", "(3, 3)"]),
    "tip in space": (lambda: CRANE.inverse_kinematics([1.0, 1.0, 1.0]), ["tip", "(2,)"]),
    "a rod longer than a street": (
        lambda: hc.load_machine("rottne-f9-lab", {"cylinder.extension.rod-length": 900.0}),
        ["extension", "stroke"],
    ),
    "strokes beyond the end": (lambda: CRANE.joints_from_strokes([0.5, 0.0, 0.0]), ["lift", "0.165"]),
    "payload below zero": (lambda: CRANE.mass_matrix(CRANE.home, payload=-1.0), ["payload", "-1"]),
    "unknown mode": (lambda: CRANE.equilibrium(CRANE.home, "holding"), ["holding", "hold"]),
    "unknown cylinder": (lambda: CRANE.friction_map(0.1, "lifft"), ["lifft", "lift"]),
    "unknown machine": (lambda: hc.load_machine("rottne"), ["rottne", "rottne-f9-lab"]),
    "unknown key": (
        lambda: hc.load_machine("rottne-f9-lab", {"supply.presure": 1e7}),
        ["supply.presure", "`pressure`"],
    ),
    "unknown cylinder's key": (
        lambda: hc.load_machine("rottne-f9-lab", {"cylinder.lfit.bore": 0.1}),
        ["lfit", "lift"],
    ),
    "wrong dimension": (
        lambda: hc.load_machine("rottne-f9-lab", {"link.jib.mass": "5 bar"}),
        ["link.jib.mass", "mass (kg)", "pressure"],
    ),
    "unknown unit": (lambda: hc.load_machine("rottne-f9-lab", {"link.jib.mass": "5 kgg"}), ["`kg`"]),
    "unit nearest to one of another dimension": (
        lambda: hc.load_machine("rottne-f9-lab", {"cylinder.lift.bore": "50 mn"}),
        ["`mn`", "did you mean `mm`"],
    ),
    "rod thicker than bore": (
        lambda: hc.load_machine("rottne-f9-lab", {"cylinder.lift.rod-diameter": "120 mm"}),
        ["cylinder.lift", "bore"],
    ),
    "bore below zero": (lambda: hc.load_machine("rottne-f9-lab", {"cylinder.lift.bore": -0.1}), ["cylinder.lift.bore"]),
    "bore not finite": (
        lambda: hc.load_machine("rottne-f9-lab", {"cylinder.lift.bore": np.nan}),
        ["cylinder.lift.bore"],
    ),
    "crossed limits": (
        lambda: hc.load_machine("rottne-f9-lab", {"joint.boom.limits": ["100 deg", "60 deg"]}),
        ["joint.boom.limits"],
    ),
    "linkage that cannot close": (
        lambda: hc.load_machine("rottne-f9-lab", {"cylinder.jib.linkage.rocker-length": "2 mm"}),
        ["cylinder.jib", "close"],
    ),
    "neither as printed nor corrected": (
        lambda: hc.load_machine("rottne-f9-lab", {"errata.gravity-sign": "correct"}),
        ["errata.gravity-sign", "corrected"],
    ),
    "overrides as a list": (lambda: hc.load_machine("rottne-f9-lab", ["supply.pressure"]), ["mapping"]),
    "unknown scenario": (lambda: hc.simulate("vertical-lift"), ["vertical-lift-open-loop"]),
    "unknown method": (lambda: hc.simulate("single-cylinder-step", method="rodas5"), ["rodas5", "rodas5p"]),
    "unknown field": (lambda: hc.simulate("single-cylinder-step", rtoll=1e-3), ["rtoll", "rtol"]),
    "no time": (lambda: hc.simulate("single-cylinder-step", duration=0.0), ["duration"]),
    "tolerance below zero": (lambda: hc.Solver(rtol=-1e-3), ["rtol"]),
    "time backwards": (lambda: hc.Command([0.0, 2.0, 1.0], [0.0, 0.01, 0.0]), ["times", "increase"]),
    "times and spools of two lengths": (lambda: hc.Command([0.0, 1.0], [0.01]), ["(2,)", "(1,)"]),
    "spool in millimetres": (
        lambda: hc.simulate("single-cylinder-step", commands={"test": 20.0}),
        ["test", "50 mm", "metres"],
    ),
    "command of an unknown cylinder": (
        lambda: hc.simulate("single-cylinder-step", commands={"tset": 0.0}),
        ["tset", "test"],
    ),
    "start of one joint only": (
        lambda: hc.simulate("vertical-lift-open-loop", joints={"boom": 1.5}),
        ["jib", "extension"],
    ),
    "step before reset": (lambda: hc.Simulator(CRANE).step(IDLE), ["reset"]),
    "reset without a pose": (lambda: hc.Simulator(CRANE).reset(), ["q", "state"]),
    "number in place of a machine": (lambda: hc.Simulator(7), ["machine"]),
    "sample time backwards": (lambda: hc.Simulator(CRANE, sample_time=-0.01), ["sample_time"]),
    "payload below zero to the simulator": (lambda: hc.Simulator(CRANE, payload=-5.0), ["payload"]),
    "payload below zero to a run": (
        lambda: hc.simulate("single-cylinder-step", payload=-5.0, pressures={"test": (10e5, 10e5)}),
        ["payload", "-5"],
    ),
}


@pytest.mark.parametrize(("call", "words"), WRONG_CALLS.values(), ids=WRONG_CALLS)
def test_error_says_what_and_what_instead(call, words):
    with pytest.raises(hc.HydrocraneError) as caught:
        call()
    message = str(caught.value)
    assert len(message) < 400 and "panic" not in message.lower()
    for word in words:
        assert word in message, message


def test_a_start_outside_the_stroke_is_an_outcome():
    """A run that cannot begin says so and has no rows, it does not raise: a study of many starts goes on."""
    run = hc.simulate("single-cylinder-step", joints={"slide": 0.4}, pressures={"test": (10e5, 10e5)})
    assert run.outcome.kind == "bad-state"
    assert "test" in run.outcome.message and run.data.sizes["time"] == 0


def test_a_simulator_that_cannot_start_says_so():
    with pytest.raises(hc.HydrocraneError, match="lift"):
        hc.Simulator(CRANE).reset(state=altered(REST, 0, 3.1))


NUMBERS = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.floats(min_value=1e-12, max_value=1e12),
    st.sampled_from([0.0, -1.0, 1e-300, 5e-324, 1e300, -0.0]),
)
UNITS = st.sampled_from(["m", "mm", "bar", "kg", "N", "deg", "rad/s", "Hz", "m^3/s", "Pa s", "N s/m", "", "furlong"])
TEXTS = st.one_of(
    st.builds(lambda x, unit: f"{x} {unit}", NUMBERS, UNITS),
    st.builds(lambda x, z: f"({x}, {z}) m", NUMBERS, NUMBERS),
    st.sampled_from(["static", "lugre", "4/3", "as-printed", "", "(", "lift", "boom.jib-joint"]),
    st.text(max_size=12),
)
VALUES = st.one_of(NUMBERS, TEXTS, st.booleans(), st.lists(st.one_of(NUMBERS, TEXTS), max_size=3))
KEYS = st.one_of(
    st.sampled_from(sorted({key for name in hc.bundled_machines() for key, _, _ in hc.load_machine(name).provenance})),
    st.text(alphabet="abcdefghijklmnopqrstuvwxyz-._ \"'[]", max_size=30),
)


@pytest.mark.evidence
@settings(max_examples=400, deadline=None, derandomize=True)
@given(machine=st.sampled_from(hc.bundled_machines()), overrides=st.dictionaries(KEYS, VALUES, min_size=1, max_size=3))
def test_any_override_loads_or_is_refused(machine, overrides):
    """A machine that loads can also be asked: finite numbers, or an error of this package."""
    try:
        crane = hc.load_machine(machine, overrides)
        rest = crane.equilibrium(crane.home)
        rate = crane.state_derivative(rest, np.zeros(len(crane.cylinder_names)))
    except hc.HydrocraneError as error:
        assert str(error)
        return
    assert np.isfinite(crane.joint_limits).all()
    assert np.isfinite(rest).all() and np.isfinite(rate).all(), overrides


@pytest.mark.evidence
@settings(max_examples=300, deadline=None, derandomize=True)
@given(state=st.lists(st.floats(-1e9, 1e9), min_size=7, max_size=7), command=st.floats(-1.0, 1.0))
def test_any_finite_state_has_a_finite_derivative_and_jacobian(state, command):
    crane = hc.load_machine("single-cylinder")
    # Inside the cylinder; all else as wild as it may be.
    state[0] = float(np.clip(state[0], -0.31, 0.31))
    assert np.isfinite(crane.state_derivative(state, [command])).all()
    assert np.isfinite(crane.jacobian(state, [command])).all()


def test_degrees_given_for_radians_are_recognised():
    plan = hc.Scenario(joints={"boom": 100, "jib": 100, "extension": 0.0})
    with pytest.raises(hc.InputError, match=r"joint boom starts at 100 rad.*np.deg2rad\(100\)"):
        hc.simulate(plan)
