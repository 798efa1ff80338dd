"""Equal cylinders in parallel are one of twice the size: load chart, modes, sensitivities, exported model, circuit."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.analysis.sensitivity import Experiment, solve
from hydrocrane.machine import circuit
from hydrocrane.plots.circuit_parts import cylinder_labels
from hydrocrane.signals.friction import RigParameters

NAMES = ("lift", "tilt", "extension")
# What two cylinders together have more of than one, by this factor.
FACTORS = {
    "bore": 2**0.5, "rod-diameter": 2**0.5, "dead-volume": 2.0, "internal-leakage": 2.0, "external-leakage": 2.0,
    "end-stop.stiffness": 2.0, "end-stop.damping": 2.0, "coulomb": 2.0, "breakaway": 2.0, "viscous": 2.0,
    "bristle-stiffness": 2.0, "bristle-damping": 2.0,
}  # fmt: skip
COUNTS = {f"cylinder.{name}.count": 2 for name in NAMES}


@pytest.fixture(scope="module")
def pair() -> tuple[hc.Machine, hc.Machine]:
    """Two of each cylinder of a crane, and one of each of twice the size."""
    crane = hc.load_machine("hiab-xs031")
    larger = {}
    for key in crane.keys:
        table, _, rest = key.partition(".")
        factor = FACTORS.get(rest.partition(".")[2])
        if table in ("cylinder", "friction") and factor is not None:
            value = factor * np.asarray(crane.value(key).si)
            larger[key] = value.tolist()
    return hc.load_machine("hiab-xs031", COUNTS), hc.load_machine("hiab-xs031", larger)


def test_figures_that_are_derived_are_the_same(pair):
    two, one = pair
    np.testing.assert_allclose(two.piston_areas, one.piston_areas, rtol=1e-14)
    np.testing.assert_allclose(two.piston_speeds(two.home), one.piston_speeds(one.home), rtol=1e-9)
    ours, theirs = (hc.load_chart(crane, samples=8) for crane in pair)
    for name in ("payload", "tip"):
        np.testing.assert_allclose(getattr(ours, name), getattr(theirs, name), rtol=1e-9)
    ours, theirs = (hc.modes(crane, crane.home, payload=150.0) for crane in pair)
    np.testing.assert_allclose(ours.frequency, theirs.frequency, rtol=1e-6)
    single = hc.load_chart("hiab-xs031", samples=8)
    assert np.nanmax(hc.load_chart(two, samples=8).payload) > 1.5 * np.nanmax(single.payload)


def test_an_exported_model_has_all_of_them(pair, tmp_path, random_states):
    two, one = pair
    x, u = random_states(two, 20, 3)
    expected = two.state_derivative(x, u)
    np.testing.assert_allclose(one.state_derivative(x, u), expected, rtol=1e-8, atol=1e-8)
    file = hc.export_model(two, tmp_path / "crane.py", to="numpy")
    space: dict[str, object] = {}
    exec(compile(file.read_text(), file, "exec"), space)
    found = space["derivative"](x, u)
    assert np.abs(found - expected).max(axis=0) == pytest.approx(0.0, abs=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("key", ["cylinder.test.bore", "cylinder.test.leakage-gap", "friction.test.coulomb[0]"])
def test_sensitivities_by_values_of_one_of_them_are_exact(key):
    plan = hc.load_scenario("single-cylinder-step").changed(
        commands={"test": hc.Command([0.0, 0.1, 0.3, 0.5], [0.002, 0.01, 0.01, 0.004], "linear")},
        overrides={"cylinder.test.count": 2}, duration=0.5, record_interval=0.01,
    )  # fmt: skip
    slopes = solve(Experiment(plan, key, method="tsit5", rtol=1e-10)).sensitivities[:, :, 0]
    alone = Experiment(plan, key, method="tsit5", rtol=1e-10, resolve_sensitivities=False)
    value, share = alone.values[0], 1e-3
    ends = [solve(alone, [value * (1.0 + sign * share)]).y for sign in (1.0, -1.0)]
    largest = np.abs(slopes).max(axis=0)
    found = np.abs((ends[0] - ends[1]) / (2.0 * share * value) - slopes).max(axis=0)
    assert (largest > 0.0).sum() >= 12
    size = np.maximum(largest, 1e-3 * np.abs(ends[0]).max(axis=0) / value)
    assert (found[largest > 0.0] < 1e-3 * size[largest > 0.0]).all()


def test_the_circuit_diagram_counts_them(pair):
    labels = [cylinder_labels(section)[1] for section in circuit.read(pair[0]).sections]
    assert all(label.startswith("2 × Ø") for label in labels), labels


def test_a_rig_of_several_is_refused():
    rig = hc.load_machine("rig-rottne", {"cylinder.test.count": 2})
    with pytest.raises(hc.InputError, match=r"has 2 in parallel.*cylinder\.test\.count = 1"):
        RigParameters.of(rig)
