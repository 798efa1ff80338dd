"""Sensitivities of runs in which loads are picked up and released: the tangents jump as the state does."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.analysis.sensitivity import Experiment, solve
from hydrocrane.identification.values.models import replayed

PICKED, DROPPED, AGAIN, END = 0.15, 0.3, 0.4, 0.5
AFTER = 1e-9
CRANE = hc.load_scenario("vertical-lift-open-loop").changed(
    commands={
        name: hc.Command([0.0, 0.2, 0.5, 0.8], [0.1 * most, most, most, 0.5 * most], "linear")
        for name, most in {"lift": 0.02, "jib": 0.02, "extension": 0.012}.items()
    },
    duration=END,
    record_interval=0.02,
    payload=100.0,
    payload_changes={PICKED: 250.0, DROPPED: 60.0, AGAIN: 90.0},
)
# Rows before and just after each change, and on the way.
TIMES = [0.1, PICKED, PICKED + AFTER, 0.2, DROPPED, DROPPED + AFTER, 0.35, AGAIN, AGAIN + AFTER, 0.45, END]
KEYS = (
    "payload.mass",
    "link.boom.mass",
    "link.extension.mass",
    "cylinder.jib.linkage.rocker-length",
    "friction.lift.coulomb[0]",
    "supply.pressure",
)


@functools.cache
def found():
    return solve(Experiment(CRANE, KEYS, times=TIMES, method="tsit5", rtol=1e-12))


def row(time: float) -> int:
    return TIMES.index(time)


@pytest.mark.parametrize("key", KEYS)
def test_they_are_those_of_differences_of_high_order(key: str) -> None:
    alone = Experiment(CRANE, key, times=TIMES, method="tsit5", rtol=1e-12, resolve_sensitivities=False)
    value = alone.values[0]

    def difference(share: float) -> np.ndarray:
        high, low = (solve(alone, [value * (1 + s)]).y for s in (share, -share))
        return (high - low) / (2 * share * value)

    # Order six: the errors of second and fourth order cancel.
    step = 4e-3
    differences = (64 * difference(step / 4) - 20 * difference(step / 2) + difference(step)) / 45
    slopes = found().sensitivities[:, :, KEYS.index(key)]
    largest = np.abs(slopes).max(axis=0)
    moved = largest > 0
    assert moved.sum() >= 12
    size = np.maximum(largest, 1e-2 * np.abs(found().y).max(axis=0) / abs(value))
    assert (np.abs(differences - slopes)[:, moved] / size[moved]).max() < 2e-4
    rates = [i for i, name in enumerate(alone.known_signals) if name.endswith(".qd")]
    after = row(PICKED + AFTER)
    np.testing.assert_allclose(differences[after, rates], slopes[after, rates], rtol=1e-6)


def test_joint_rates_alone_jump_and_only_at_a_pick_up() -> None:
    states = CRANE.load_machine().state_names
    slopes = found().sensitivities[:, : len(states)]
    scale = np.abs(slopes).max(axis=0)
    for time, jumps in ((PICKED, True), (DROPPED, False), (AGAIN, True)):
        jump = np.abs(slopes[row(time + AFTER)] - slopes[row(time)]) / np.where(scale > 0, scale, 1.0)
        rates = np.array([name.endswith(".qd") for name in states])
        # A nanosecond of their rates of change is all that the others have.
        assert jump[~rates].max() < 1e-5
        assert (jump[rates].max(axis=0) > 1e-3).all() if jumps else jump.max() < 1e-5, time


def test_what_is_put_down_does_not_depend_on_the_load_of_the_start() -> None:
    """The potential energy falls by m g z from the row before to the row after, and so do its derivatives."""
    names = list(Experiment(CRANE, KEYS).known_signals)
    height, potential = names.index("tip.z"), names.index("energy.potential")
    before, after = row(DROPPED), row(DROPPED + AFTER)
    weight = (250.0 - 60.0) * 9.81
    y, slopes = found().y, found().sensitivities
    assert y[before, potential] - y[after, potential] == pytest.approx(weight * y[before, height], rel=1e-5)
    change = slopes[before, potential] - slopes[after, potential]
    np.testing.assert_allclose(change, weight * slopes[before, height], rtol=1e-4)


@pytest.mark.parametrize("method", ["tsit5", "rodas5p", "hc-exponential-4"])
def test_with_steps_by_the_states_the_run_is_that_of_simulate_to_the_last_bit(method: str) -> None:
    plan = CRANE.changed(bursts=hc.Burst("lift", "piston-side", 0.25, 5e-6), method=method, rtol=1e-5)
    by = hc.sensitivities(plan, ["supply.pressure", "payload.mass"], resolve_sensitivities=False)
    run = hc.simulate(plan, ledger=False)
    for name in run.data:
        np.testing.assert_array_equal(by.run.data[name].values, run.data[name].values, err_msg=str(name))
    assert by.run.payload_changes == run.payload_changes and len(run.payload_changes) == 3
    assert by.run.data.attrs["solver_steps"] == run.data.attrs["solver_steps"]


def test_methods_agree_and_a_sensitivity_does_not_depend_on_what_else_is_differentiated() -> None:
    together = solve(Experiment(CRANE, KEYS, times=TIMES, method="rodas5p", resolve_sensitivities=False))
    for i in (0, 4):
        alone = solve(Experiment(CRANE, KEYS[i], times=TIMES, method="rodas5p", resolve_sensitivities=False))
        np.testing.assert_array_equal(together.sensitivities[:, :, i], alone.sensitivities[:, :, 0])
    tight = solve(Experiment(CRANE, KEYS, times=TIMES, method="rodas5p", rtol=1e-9))
    scale = np.abs(found().sensitivities).max(axis=0)
    error = np.abs(tight.sensitivities - found().sensitivities)
    assert (error[:, scale > 0] / scale[scale > 0]).max() < 1e-4


def test_a_controller_in_a_phase_is_refused() -> None:
    with pytest.raises(hc.InputError, match="controller.*commands="):
        hc.sensitivities(CRANE, "payload.mass", phases=[hc.Phase(0.2, controller="lever")])


def test_a_log_that_begins_later_has_the_loads_on_its_clock() -> None:
    machine = CRANE.load_machine()

    def plan(begin: float) -> hc.Scenario:
        log = hc.Log.of({"time": np.linspace(begin, 0.5, 51), "joint.boom.q": np.full(51, 1.7)})
        return replayed(CRANE, machine, log, "linear").plan

    early, late = plan(0.1), plan(0.35)
    assert early.payload == 100.0 and late.payload == 60.0
    assert list(early.payload_changes) == pytest.approx([0.05, 0.2, 0.3])
    assert list(late.payload_changes.items()) == [(pytest.approx(0.05), 90.0)]
