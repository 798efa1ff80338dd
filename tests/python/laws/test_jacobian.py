"""The exact Jacobian against differences, and the right-hand side against its readable restatement."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

# A change of each kind of state that matters to the crane: makes the columns of the Jacobian comparable.
SCALES = {"q": 1.0, "qd": 1.0, "p1": 1e6, "p2": 1e6, "xs": 1e-2, "vs": 1.0, "z": 1e-3}
STEP = 1e-6
STATIC = {f"friction.{c}.model": "static" for c in ("lift", "jib", "extension")}


def scales(crane):
    return np.array([SCALES[name.rsplit(".", 1)[1]] for name in crane.state_names])


def differences(crane, x, u, step):
    """Scaled Jacobians (m, ns, ns) by fourth-order central differences."""
    moves = np.diag(scales(crane)) * step
    at = {k: crane.state_derivative(x[:, None, :] + k * moves, u[:, None, :]) for k in (-2, -1, 1, 2)}
    columns = (8 * (at[1] - at[-1]) - (at[2] - at[-2])) / (12 * step)
    return np.swapaxes(columns, -1, -2)


def error(crane, x, u):
    """Largest difference in each row, relative to the row's largest scaled entry: (m, ns)."""
    exact = crane.jacobian(x, u) * scales(crane)
    largest = np.abs(exact).max(axis=-1)
    # Rows of states with a constant rate have no entries; they are compared absolutely.
    return np.abs(exact - differences(crane, x, u, STEP)).max(axis=-1) / np.where(largest > 0, largest, 1.0)


def test_jacobian_at_random_states(corrected, random_states):
    """Whole workspace and end stops, both signs of velocity, flow and pressure."""
    x, u = random_states(corrected, 300, seed=41)
    assert (x[:, [n.endswith((".p1", ".p2")) for n in corrected.state_names]] < 0).any()
    assert error(corrected, x, u).max() < 1e-6


def test_jacobian_deep_in_the_end_stops(corrected):
    """Every piston in turn in either stop, 1 % of the joint's range from its end, fast and slow."""
    kinds = [name.rsplit(".", 1)[1] for name in corrected.state_names]
    usual = np.array(
        [{"qd": 2e-3, "p1": 100e5, "p2": 60e5, "xs": 2e-3, "vs": 0.0, "z": 1e-4}.get(k, 0.0) for k in kinds]
    )
    states = []
    for i, (low, high) in enumerate(corrected.joint_limits):
        for near_the_end in (low + 0.01 * (high - low), high - 0.01 * (high - low)):
            for velocity in (-0.3, -1e-3, 1e-3, 0.3):
                state = usual.copy()
                state[[k == "q" for k in kinds]] = corrected.home
                state[corrected.state_names.index(f"joint.{corrected.joint_names[i]}.q")] = near_the_end
                state[corrected.state_names.index(f"joint.{corrected.joint_names[i]}.qd")] = velocity
                states.append(state)
    commands = np.zeros((len(states), len(corrected.cylinder_names)))
    assert error(corrected, np.array(states), commands).max() < 1e-6


def test_jacobian_with_static_friction(random_states):
    crane = hc.load_machine("rottne-f9-lab", STATIC)
    x, u = random_states(crane, 300, seed=42)
    assert error(crane, x, u).max() < 1e-6


def test_jacobian_at_the_centred_spool_lies_between_both_sides(corrected):
    """Where the edges change over the law has a corner; its slope there must be that of a side or in between."""
    x, u = corrected.equilibrium(corrected.home), np.zeros(len(corrected.cylinder_names))
    step = 1e-7
    for cylinder in corrected.cylinder_names:
        spool = corrected.state_names.index(f"cylinder.{cylinder}.xs")
        move = step * (np.arange(x.size) == spool)
        at = [corrected.state_derivative(x + k * move, u) for k in (-1, 0, 1)]
        for chamber in ("p1", "p2"):
            row = corrected.state_names.index(f"cylinder.{cylinder}.{chamber}")
            sides = sorted([(at[1][row] - at[0][row]) / step, (at[2][row] - at[1][row]) / step])
            slack = 1e-5 * np.abs(sides).max()
            assert sides[0] - slack <= corrected.jacobian(x, u)[row, spool] <= sides[1] + slack


def test_reference_model_equals_the_right_hand_side(corrected, random_states):
    """The one-function model, written from the equations without the machinery, to rounding."""
    x, u = random_states(corrected, 2000, seed=43)
    for payload in (None, 300.0):
        assert_equal_to_reference(corrected, x, u, payload)


def test_reference_model_with_static_friction(random_states):
    crane = hc.load_machine("rottne-f9-lab", STATIC)
    assert_equal_to_reference(crane, *random_states(crane, 2000, seed=44))


def test_reference_model_says_that_it_knows_corrected_laws_only(random_states):
    crane = hc.load_machine("rottne-f9-lab", {"errata.orifice-law": "as-printed"})
    x, u = random_states(crane, 1, seed=45)
    with pytest.raises(hc.InputError, match="only the corrected laws"):
        crane.reference_state_derivative(x, u)


def assert_equal_to_reference(crane, x, u, payload=None):
    """Equal in every component to 1e-11 of its size, or of its usual size where it nearly cancels."""
    ours = crane.state_derivative(x, u, payload=payload)
    theirs = crane.reference_state_derivative(x, u, payload=payload)
    scale = np.abs(theirs) + np.median(np.abs(theirs), axis=0)
    assert (np.abs(ours - theirs) / np.where(scale > 0, scale, 1.0)).max() < 1e-11
