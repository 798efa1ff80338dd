"""Loads that come and go in scenarios and in the stepping loop, and what is told of them."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane import plots
from hydrocrane.results.energy import energy_balance

POSE = {"boom": np.deg2rad(100), "jib": np.deg2rad(100), "extension": 0.0}
CRANE = hc.load_machine("rottne-f9-lab")
LIFT = {"lift": ([0.0, 1.2], [0.02, 0.0])}


def plan(**fields):
    return hc.Scenario(**{"joints": POSE, "commands": LIFT, "duration": 1.5, "name": "lift", **fields})


@pytest.fixture(scope="module")
def run():
    """Takes up 150 kg while the tip rises, lets 120 kg of them go; recorded finely, for a velocity jumps on the way."""
    return hc.simulate(plan(payload_changes={0.8: 30.0, 0.5035: 150.0}), rtol=1e-10, record_interval=5e-4)


def rows(run, kind):
    return np.column_stack([run.data[f"joint.{j}.{kind}"].values for j in run.joint_names])


def test_a_run_tells_its_changes_in_order(run):
    up, down = run.payload_changes
    assert (up.time, up.before, up.after) == (0.5035, 0.0, 150.0)
    assert (down.time, down.before, down.after, down.loss) == (0.8, 150.0, 30.0, 0.0)
    assert down.velocity_before == down.velocity_after
    assert np.hypot(*up.velocity_after) < 0.5 * np.hypot(*up.velocity_before)
    assert [event.time for event in run.events] == [0.5035, 0.8]
    assert "picks up 150 kg" in run.events[0].text and "releases 120 kg" in run.events[1].text
    assert "picks up 150 kg" in run.summary() and "impacts of loads" not in run.summary()


def test_the_event_keeps_the_momentum_at_every_joint(run):
    """M (q'- - q'+) = J^T m v+ with the mass matrix of the unladen crane, at the pose of the rows around the change."""
    change = run.payload_changes[0]
    q = np.array([np.interp(change.time, run.data.time, column) for column in rows(run, "q").T])
    before, after = (
        np.linalg.lstsq(CRANE.tip_jacobian(q), np.array(v), rcond=None)[0]
        for v in (change.velocity_before, change.velocity_after)
    )
    # Only the tip's motion is known of the event; whatever the joints do besides, its inertia there is (J M^-1 J^T)^-1.
    jacobian = CRANE.tip_jacobian(q)
    mobility = jacobian @ np.linalg.solve(CRANE.mass_matrix(q, payload=0.0), jacobian.T)
    braked = jacobian @ (before - after)
    np.testing.assert_allclose(braked, mobility @ (150.0 * np.array(change.velocity_after)), rtol=1e-4, atol=1e-7)


def test_a_row_at_the_instant_has_the_state_before(run):
    payload, time = run.data["payload"].values, run.data.time.values
    assert set(payload) == {0.0, 150.0, 30.0}
    assert payload[time <= 0.5035].max() == 0.0
    assert payload[np.isclose(time, 0.8)] == 150.0 and (payload[time > 0.805] == 30.0).all()
    potential = CRANE.potential_energy(rows(run, "q"), payload=0.0)
    heights = run.data["tip.z"].values
    np.testing.assert_allclose(run.data["energy.potential"].values, potential + 9.81 * payload * heights, rtol=1e-12)


def test_the_ledger_accounts_for_the_loads(run):
    balance = energy_balance(run)
    scale = balance.pump + sum(balance.lost.values())
    assert balance.residual < 1e-9 * scale
    up, down = run.payload_changes
    heights = np.interp([up.time, down.time], run.data.time, run.data["tip.z"])
    brought = 9.81 * (150.0 * heights[0] - 120.0 * heights[1]) - 60.0 * np.hypot(*down.velocity_before) ** 2
    assert balance.loads == pytest.approx(brought, rel=1e-4)
    assert balance.lost["impacts of loads"] == up.loss > 0.005


def test_runs_without_changes_have_one_payload():
    run = hc.simulate(plan(payload=40.0, duration=0.1))
    assert (run.data["payload"].values == 40.0).all() and run.payload_changes == ()
    assert not run.data["ledger.payload.load"].any() and not run.data["ledger.payload.impact"].any()


@pytest.mark.evidence
def test_changes_survive_a_file(run, tmp_path):
    again = hc.load_run(run.save(tmp_path / "run.nc"))
    assert again.payload_changes == run.payload_changes and again.events == run.events


def test_stepping_with_loads_is_the_run(run):
    simulator = hc.Simulator(CRANE, 0.01, rtol=1e-8)
    simulator.reset(q=list(POSE.values()))
    reference = hc.simulate(plan(payload_changes={0.5: 150.0}, duration=1.0), rtol=1e-8)
    for _ in range(50):
        simulator.step([0.02, 0.0, 0.0])
    change = simulator.set_payload(150.0)
    for _ in range(50):
        simulator.step([0.02, 0.0, 0.0])
    (there,) = reference.payload_changes
    assert (change.time, change.after) == (pytest.approx(0.5), 150.0) and simulator.payload == 150.0
    assert change.loss == pytest.approx(there.loss, rel=1e-4)
    last = [float(reference.data[name][-1]) for name in CRANE.state_names]
    np.testing.assert_allclose(simulator.state[:6], last[:6], atol=1e-6)
    simulator.reset(q=list(POSE.values()))
    assert simulator.payload == 0.0


def test_a_controller_lifts_what_it_does_not_know_of():
    joystick = hc.Joystick([0.2, 3.0], {"z": [1.0, 0.0]}, full_speed=0.05, ramp=0.2)
    run = hc.simulate(plan(commands={}, joystick=joystick, duration=4.0, payload_changes={1.0: 100.0, 2.0: 0.0}))
    assert run.outcome.completed and len(run.payload_changes) == 2
    assert run.data["tip.deviation"].values.max() < 0.02
    assert run.data["tip.z"].values[-1] - run.data["tip.z"].values[0] == pytest.approx(0.05 * 2.8, abs=0.02)


def test_the_bundled_scenario_shows_it(tmp_path):
    run = hc.simulate("tip-log-pick-and-place")
    assert run.outcome.completed and [change.after for change in run.payload_changes] == [100.0, 0.0]
    assert run.data["tip.deviation"].values.max() < 0.03
    figure = plots.tip_charts(run)
    labels = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert "picks up 100 kg" in labels and "releases 100 kg" in labels
    assert len(figure.axes) == 4
    drawn = figure.axes[2].lines[0].get_ydata()
    np.testing.assert_array_equal(drawn, run.data["payload"].values)


WRONG = {
    "not a mapping": (lambda: plan(payload_changes=([1.0], [100.0])), "must map times"),
    "at the start": (lambda: plan(payload_changes={0.0: 100.0}), "above zero"),
    "not a number": (lambda: plan(payload_changes={1.0: np.nan}), "finite"),
    "below zero": (lambda: plan(payload_changes={1.0: -5.0}), "zero or more"),
    "in words": (lambda: plan(payload_changes={"soon": 5.0}), "real numbers"),
    "stepping, below zero": (lambda: hc.Simulator(CRANE).set_payload(-1.0), "reset"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_changes_are_one_clear_error(name):
    call, words = WRONG[name]
    with pytest.raises(hc.HydrocraneError, match=words):
        call()


def test_the_simulator_refuses_a_payload_that_cannot_be():
    simulator = hc.Simulator(CRANE)
    simulator.reset(q=list(POSE.values()))
    with pytest.raises(hc.InputError, match="payload: must be zero or greater"):
        simulator.set_payload(-1.0)
