"""Slopes of a run by keys of its machine: against differences, closed solutions and each other; wrong keys."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.analysis.sensitivity import Experiment, solve

# The pistons go one way, so that differences do not straddle a reversal.
RIG = hc.load_scenario("single-cylinder-step").changed(
    commands={"test": hc.Command([0.0, 0.1, 0.3, 0.5], [0.002, 0.01, 0.01, 0.004], "linear")},
    duration=0.5,
    record_interval=0.01,
)
CRANE = hc.load_scenario("vertical-lift-open-loop").changed(
    commands={
        name: hc.Command([0.0, 0.2, 0.5, 0.8], [0.1 * most, most, most, 0.5 * most], "linear")
        for name, most in {"lift": 0.02, "jib": 0.02, "extension": 0.012}.items()
    },
    duration=0.5,
    record_interval=0.02,
    payload=100.0,
)
KINKED = hc.load_scenario("single-cylinder-step").changed(duration=2.5, record_interval=0.05)

RIG_KEYS = (
    "friction.test.bristle-stiffness",
    "friction.test.bristle-damping",
    "friction.test.bristle-damping-velocity",
    "friction.test.coulomb[0]",
    "friction.test.viscous[0]",
    "friction.test.viscous-exponent",
    "friction.test.stribeck-exponent[0]",
    "link.mass.body.load.mass",
    "supply.pressure",
    "environment.gravity",
    "valve.test.nominal-flow",
    "valve.test.natural-frequency",
    "valve.test.damping-ratio",
    "fluid.bulk-modulus-max",
    "fluid.bulk-c1",
    "cylinder.test.bore",
    "cylinder.test.leakage-gap",
    "equilibrium.back-pressure",
)
CRANE_KEYS = (
    "friction.lift.bristle-stiffness",
    "friction.jib.coulomb[0]",
    "payload.mass",
    "supply.pressure",
    "fluid.bulk-modulus-max",
    "valve.lift.nominal-flow",
    "cylinder.jib.linkage.rocker-length",
    "link.boom.mass",
)


@functools.cache
def all_slopes(name, keys, rtol):
    """One solution by all keys serves the tests of each."""
    plan = {RIG.name: RIG, CRANE.name: CRANE}[name]
    return solve(Experiment(plan, keys, method="tsit5", rtol=rtol))


def worst_mismatch(plan, keys, key, *, step, rtol, floor):
    """Largest error against difference quotients of tight runs, relative to the largest sensitivity of each signal.

    Sensitivities below `floor` of (signal / parameter) count as that large: the solver's noise hides smaller ones.
    `step` is relative to the parameter.
    """
    found = all_slopes(plan.name, keys, rtol)
    alone = Experiment(plan, key, method="tsit5", rtol=rtol, resolve_sensitivities=False)
    value = alone.values[0]

    def difference(share):
        return (solve(alone, [value * (1 + share)]).y - solve(alone, [value * (1 - share)]).y) / (2 * share * value)

    differences = (4 * difference(step / 2) - difference(step)) / 3
    slopes = found.sensitivities[:, :, keys.index(key)]
    largest = np.abs(slopes).max(axis=0)
    # A spool moves by its command alone; its slopes by other keys are zero to the last bit.
    moved = largest > 0
    assert moved.sum() >= 12
    size = np.maximum(largest, floor * np.abs(found.y).max(axis=0) / abs(value))
    return (np.abs(differences - slopes)[:, moved] / size[moved]).max()


@pytest.mark.parametrize("key", RIG_KEYS)
def test_slopes_on_the_rig_are_those_of_differences(key):
    assert worst_mismatch(RIG, RIG_KEYS, key, step=1e-3, rtol=1e-11, floor=1e-3) < 1e-5


@pytest.mark.parametrize("key", CRANE_KEYS)
def test_slopes_on_the_crane_are_those_of_differences(key):
    assert worst_mismatch(CRANE, CRANE_KEYS, key, step=4e-3, rtol=1e-12, floor=1e-2) < 2e-4


def test_a_spool_depends_on_frequency_and_time_by_their_product_alone():
    """Second-order response: dxs/d(omega) = t/omega vs, and vs in closed form."""
    frequency, damping, step = 900.0, 0.481, 0.01
    overrides = {"valve.test.natural-frequency": frequency}
    found = hc.sensitivities(
        RIG, "valve.test.natural-frequency", overrides=overrides, commands={"test": step}, rtol=1e-10, duration=0.02,
        record_interval=1e-3,
    )  # fmt: skip
    t = found.data.time.values
    turned = frequency * np.sqrt(1 - damping**2)
    velocity = step * frequency**2 / turned * np.exp(-damping * frequency * t) * np.sin(turned * t)
    slope = found.data["cylinder.test.xs"].values[:, 0]
    np.testing.assert_allclose(slope, t / frequency * velocity, atol=1e-8 * np.abs(slope).max())


@pytest.mark.parametrize("method", ["tsit5", "rodas5p"])
def test_with_steps_by_the_states_the_run_is_that_of_simulate_to_the_last_bit(method):
    found = hc.sensitivities(KINKED, ["supply.pressure", "payload.mass"], method=method, resolve_sensitivities=False)
    run = hc.simulate(KINKED, method=method, ledger=False)
    for name in run.data:
        np.testing.assert_array_equal(found.run.data[name].values, run.data[name].values, err_msg=str(name))
    assert found.run.data.attrs["solver_steps"] == run.data.attrs["solver_steps"]


@pytest.mark.parametrize("method", ["tsit5", "rodas5p"])
def test_a_slope_does_not_depend_on_what_else_is_differentiated(method):
    keys = [key for key in RIG_KEYS if "exponent" not in key][:7]
    together = solve(Experiment(KINKED, keys, method=method, resolve_sensitivities=False))
    for i, key in enumerate(keys):
        alone = solve(Experiment(KINKED, key, method=method, resolve_sensitivities=False))
        np.testing.assert_array_equal(together.sensitivities[:, :, i], alone.sensitivities[:, :, 0], err_msg=key)


@pytest.mark.parametrize("method", ["rodas5p", "hc-exponential-4"])
def test_small_values_are_differentiated_as_well_as_large_ones(method):
    """By a leakage of 1e-14 m^3/(s Pa) derivatives reach 1e18 Pa: wrong where two of them are multiplied."""
    key = "valve.lift.leakage"
    plan = CRANE.changed(overrides={key: 1e-14}, duration=0.6, commands=hc.load_scenario(CRANE.name).commands)
    exact = hc.sensitivities(plan, key, method="tsit5", rtol=1e-8)
    found = hc.sensitivities(plan, key, method=method, resolve_sensitivities=False)
    assert found.run.outcome.kind == "completed"
    for name in ("cylinder.lift.p1", "cylinder.lift.p2", "tip.z"):
        slope = exact.data[name].values
        assert np.abs(found.data[name].values - slope).max() < 1e-2 * np.abs(slope).max(), name


# Command steps, reversals, bristles that slip, the spool's zero crossing; end stops; the steep static map.
HARD = {
    "crane": (
        hc.load_scenario("vertical-lift-open-loop").changed(duration=1.2, record_interval=0.05),
        ["friction.extension.bristle-stiffness", "payload.mass", "cylinder.jib.linkage.rocker-length"],
    ),
    "reversal": (KINKED, ["friction.test.coulomb[1]", "link.mass.body.load.mass", "fluid.bulk-modulus-max"]),
    "end stop": (
        KINKED.changed(joints={"slide": 0.27}, commands={"test": ([0.0, 1.0], [0.04, -0.04])}, duration=1.5),
        ["cylinder.test.end-stop.stiffness", "cylinder.test.end-stop.damping", "supply.pressure"],
    ),
    "static map": (
        KINKED.changed(overrides={"friction.test.model": "static"}, duration=0.8),
        ["friction.test.smoothing-velocity", "friction.test.coulomb[0]", "supply.pressure"],
    ),
}


@pytest.mark.evidence
@pytest.mark.parametrize("case", HARD)
def test_two_methods_agree_where_laws_have_kinks(case):
    plan, keys = HARD[case]
    explicit = solve(Experiment(plan, keys, method="tsit5", rtol=1e-8))
    implicit = solve(Experiment(plan, keys, method="rodas5p", rtol=1e-8))
    assert explicit.outcome.completed and implicit.outcome.completed
    moved = np.abs(explicit.sensitivities).max(axis=0)
    assert (np.count_nonzero(moved, axis=0) >= 12).all()
    mismatch = np.abs(explicit.sensitivities - implicit.sensitivities).max(axis=0)
    # Where the explicit method finds exactly zero, the implicit one's linear solves leave rounding.
    assert (mismatch <= 1e-3 * moved)[moved > 0].all()


def test_resolved_slopes_converge_where_those_by_the_states_are_rough():
    keys = ["link.mass.body.load.mass", "fluid.bulk-modulus-max"]
    exact = solve(Experiment(KINKED, keys, method="tsit5", rtol=1e-10)).sensitivities
    size = np.abs(exact).max(axis=0) + 1e-300

    def error(rtol, resolve):
        slopes = solve(Experiment(KINKED, keys, method="tsit5", rtol=rtol, resolve_sensitivities=resolve)).sensitivities
        return (np.abs(slopes - exact) / size).max()

    assert error(1e-6, True) < 1e-2 < error(1e-6, False)
    assert error(1e-8, True) < 1e-3


def test_the_start_at_rest_depends_on_the_load_and_a_given_one_on_nothing():
    crane = RIG.load_machine()
    at_rest = hc.sensitivities(RIG, ["link.mass.body.load.mass", "equilibrium.back-pressure"])
    piston, rod = crane.piston_areas[0]
    start = at_rest.data.isel(time=0)
    # The mass hangs on the rod side: p2 A2 = p1 A1 + m g with p1 at the back pressure.
    np.testing.assert_allclose(start["cylinder.test.p2"], [9.81 / rod, piston / rod], rtol=1e-9)
    np.testing.assert_allclose(start["cylinder.test.p1"], [0.0, 1.0], atol=1e-12)
    given = hc.sensitivities(RIG, "link.mass.body.load.mass", pressures={"test": (10e5, 30e5)})
    assert not given.data["cylinder.test.p2"].values[0].any() and given.data["cylinder.test.p2"].values[-1].all()


def test_dataset_names_units_and_relative_slopes():
    plain = hc.sensitivities(RIG, "friction.test.bristle-stiffness")
    assert plain.data["cylinder.test.p1"].attrs["units"] == "Pa per N/m"
    assert plain.data["cylinder.test.p1"].dims == ("time", "parameter")
    assert "energy.oil" not in plain.data and "tip.z" in plain.data
    assert plain.outcome.completed and plain.run.data.attrs["machine"] == "single-cylinder"
    relative = hc.sensitivities(RIG, ["friction.test.bristle-stiffness", "supply.pressure"], relative=True)
    assert relative.data["cylinder.test.p1"].attrs["units"] == "Pa"
    np.testing.assert_array_equal(relative.data["parameter_value"], [1.1e5, 140e5])
    expected = 1.1e5 * plain.data["tip.z"].values[:, 0]
    np.testing.assert_allclose(relative.data["tip.z"].values[:, 0], expected, atol=0.02 * np.abs(expected).max())


def test_values_times_and_signals_of_an_experiment():
    experiment = Experiment(RIG, ["friction.test.coulomb[0]", "supply.pressure"], signals=["tip.z"], times=[0.1, 0.4])
    assert [p.unit for p in experiment.parameters] == ["N", "Pa"]
    np.testing.assert_array_equal(experiment.values, [170.0, 140e5])
    changed = solve(experiment, {"supply.pressure": 100e5})
    assert changed.y.shape == (2, 1) and changed.sensitivities.shape == (2, 1, 2)
    loaded = solve(Experiment(RIG, "supply.pressure", signals=["tip.z"], times=[0.1, 0.4],
                              overrides={"supply.pressure": "100 bar"}))  # fmt: skip
    np.testing.assert_allclose(changed.y, loaded.y, rtol=1e-6)
    np.testing.assert_array_equal(solve(experiment).y, solve(experiment, [170.0, 140e5]).y)


def test_a_shared_value_is_the_sum_of_its_two():
    plan = KINKED.changed(rtol=1e-9, method="tsit5")
    parts = solve(Experiment(plan, ["friction.test.viscous-exponent[0]", "friction.test.viscous-exponent[1]"]))
    whole = solve(Experiment(plan, "friction.test.viscous-exponent"))
    total = parts.sensitivities.sum(axis=2)
    np.testing.assert_allclose(
        whole.sensitivities[:, :, 0], total, atol=1e-5 * np.abs(total).max(axis=0).max(), rtol=1e-4
    )


def test_a_run_that_breaks_off_keeps_its_slopes_and_progress_is_told():
    told = []
    kept = hc.sensitivities(KINKED, "supply.pressure", progress=lambda t, end: told.append((t, end)))
    assert told and all(0 < t <= end == 2.5 for t, end in told) and kept.outcome.completed
    # As-printed stops are too weak to hold the piston.
    weak = {"errata.end-stop": "as-printed", "cylinder.test.end-stop.stiffness": 1e3}
    beyond = {"joints": {"slide": 0.3}, "pressures": {"test": (140e5, 0)}}
    broken = hc.sensitivities(KINKED, "supply.pressure", overrides=weak, **beyond)
    assert broken.outcome.kind == "stroke-limit"
    assert 0 < broken.data.sizes["time"] < 51 and np.isfinite(broken.data["tip.z"].values).all()
    torn = hc.sensitivities(KINKED, "supply.pressure", joints={"slide": 0.4}, pressures={"test": (10e5, 10e5)})
    assert torn.outcome.kind == "bad-state" and torn.data.sizes["time"] == 0


WRONG = {
    "unknown key": ("supply.presure", ["supply.presure", "`pressure`"]),
    "unknown name": ("friction.tets.coulomb[0]", ["tets", "`test`"]),
    "a choice": ("friction.test.model", ["friction.test.model", "not one number"]),
    "a table": ("friction.test", ["friction.test", "not one number"]),
    "a name": ("machine.tip", ["machine.tip", "not one number"]),
    "no brackets": ("friction.test.coulomb", ["two values", "coulomb[0]"]),
    "a dot for brackets": ("friction.test.coulomb.1", ["coulomb[1]"]),
    "third of two": ("friction.test.coulomb[2]", ["coulomb[0]", "coulomb[1]"]),
    "brackets of one": ("supply.pressure[0]", ["one number", "brackets"]),
    "not in the file": ("valve.test.overlap", ["no value", "override"]),
    "no law": ("sensor.p1.range", ["sensor.p1.range", "does not enter"]),
    "twice": (["supply.pressure", "supply.pressure"], ["twice"]),
    "whole and half": (["friction.test.viscous-exponent", "friction.test.viscous-exponent[0]"], ["twice"]),
    "no key": ([], ["one or more keys"]),
    "not a text": ([1.0], ["keys"]),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_keys_are_one_clear_error(case):
    keys, words = WRONG[case]
    with pytest.raises(hc.HydrocraneError) as caught:
        hc.sensitivities(RIG, keys)
    assert len(str(caught.value)) < 400
    for word in words:
        assert word in str(caught.value)


def test_times_of_commands_are_no_parameters():
    with pytest.raises(hc.HydrocraneError, match="does not enter.*commands that arrive"):
        hc.sensitivities(RIG, "valve.test.delay", overrides={"valve.test.delay": "5 ms"})


def test_wrong_values_signals_and_times():
    experiment = Experiment(RIG, ["supply.pressure", "friction.test.coulomb[0]"])
    for values, words in (
        ([np.nan, 1.0], "finite"),
        ([1e7], r"\(2,\)"),
        ({"supply.presure": 1e7}, "did you mean `supply.pressure`"),
        ([1e7, -5.0], "friction.test.coulomb"),
    ):
        with pytest.raises(hc.HydrocraneError, match=words):
            solve(experiment, values)
    with pytest.raises(hc.InputError, match=r"did you mean `tip\.z`"):
        Experiment(RIG, "supply.pressure", signals=["tip.zz"])
    with pytest.raises(hc.InputError, match="increases"):
        Experiment(RIG, "supply.pressure", times=[0.1, 0.9])
    with pytest.raises(hc.InputError, match="zero"):
        hc.sensitivities(RIG, "supply.tank-pressure", relative=True)


def test_a_controller_in_the_loop_is_refused_with_the_way_out():
    with pytest.raises(hc.InputError, match="controller.*commands="):
        hc.sensitivities("tip-vertical-line", "payload.mass")
