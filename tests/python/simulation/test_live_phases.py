"""Scenarios with spool commands, phases, loads and bursts, run live: as planned, and taken over on the way."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

START = {"boom": np.deg2rad(100), "jib": np.deg2rad(100), "extension": 0.2}
UP = hc.Joystick([0.1], {"z": [1.0]}, full_speed=0.1, ramp=0.1)
LEVERS = hc.Joystick([0.0], {"lift": [0.2]}, mode="lever")
COMMANDS = {"lift": hc.Command([0.0, 0.3], [0.0, 0.006], "linear"), "jib": -0.002}
EVEN = hc.Solver("hc-rosenbrock-3", step=1e-3)
BURST = hc.Burst("lift", "piston-side", 0.55, 5e-6)
# Each ends at a sample of its last controller.
PLANS = {
    "spool commands, then sticks of the tip": hc.Scenario(
        joints=START, commands=COMMANDS, phases=[hc.Phase(0.505, joystick=UP)], duration=1.005
    ),
    "spool commands, then levers at rest, with a load before and after": hc.Scenario(
        joints=START,
        commands=COMMANDS,
        payload_changes={0.2: 30.0, 0.9: 10.0},
        phases=[hc.Phase(0.5, controller="lever")],
        duration=1.0,
    ),
    "the tip, levers, and the tip with a weaker supply": hc.Scenario(
        joints=START,
        joystick=UP,
        phases=[
            hc.Phase(0.5, joystick=LEVERS),
            hc.Phase(0.8, {"supply.pressure": "100 bar"}, controller="tip", joystick=UP, sensors="data-sheet"),
        ],
        seed=4,
        duration=1.2,
    ),
    "a hose that bursts, a sensor that fails, a goal and a load": hc.Scenario(
        joints=START,
        controller="tip",
        goals=[hc.Goal(0.1, 2.6, 0.35, 0.2)],
        bursts=[BURST],
        sensor_faults=[hc.SensorFault("cylinder.lift.p1", "freeze", 0.3)],
        payload_changes={0.4: 20.0},
        phases=[hc.Phase(0.7, {"control.tip.full-speed": 0.05})],
        duration=1.0,
    ),
    "a load and sticks that nobody moves": hc.Scenario(
        joints=START, controller="tip", payload_changes={0.3: 40.0}, duration=0.8
    ),
}


def driven(plan: hc.Scenario, until: float) -> hc.LiveSimulator:
    live = hc.LiveSimulator(plan)
    while live.time < until - 1e-9:
        live.step()
    return live


def end_of(run: hc.Run) -> np.ndarray:
    return np.array([run.columns[name].values[-1] for name in run.machine.state_names])


@pytest.mark.parametrize("solver", [hc.Solver(), EVEN], ids=["adaptive", "even"])
@pytest.mark.parametrize("name", PLANS)
def test_nobody_takes_over_and_it_is_the_run_to_the_last_bit(name: str, solver: hc.Solver) -> None:
    plan = PLANS[name].changed(solver=solver)
    live = driven(plan, plan.duration)
    assert live.time == pytest.approx(plan.duration) and live.as_planned
    # Samples of a later phase count from its begin, so that their times are rounded otherwise.
    run = hc.simulate(plan, duration=live.time)
    assert run.outcome.completed
    np.testing.assert_array_equal(live.state, end_of(run))
    assert live.payload == run.columns["payload"].values[-1]
    assert [event.text for event in live.events] == [event.text for event in run.events if not event.warning]


def test_long_steps_lead_through_the_phases_as_single_samples_do() -> None:
    plan = PLANS["the tip, levers, and the tip with a weaker supply"]
    live = hc.LiveSimulator(plan)
    obs = live.step(1.2)
    assert live.time == pytest.approx(1.2) and obs.t == live.time
    np.testing.assert_array_equal(live.state, driven(plan, 1.2).state)


def test_axes_and_sensors_are_those_of_the_phase() -> None:
    plan = PLANS["the tip, levers, and the tip with a weaker supply"]
    live = hc.LiveSimulator(plan)
    seen = []
    while live.time < 1.0:
        live.step()
        seen.append((live.axes, len(live.observation.measured)))
    tip, levers = ("x", "z"), ("lift", "jib", "extension")
    assert [axes for axes, _ in seen[::10]] == [tip] * 5 + [levers] * 3 + [tip] * 2
    measured = [count for _, count in seen]
    assert measured[-1] > measured[0], "sensors of the data sheets read more signals"


def test_whoever_takes_over_from_spool_commands_has_levers() -> None:
    plan = PLANS["spool commands, then levers at rest, with a load before and after"].changed(solver=EVEN)
    live = driven(plan, 0.3)
    assert live.axes == ("lift", "jib", "extension") and live.payload == 30.0
    assert np.isnan(list(live.observation.measured.values())).all()
    live.set_stick(jib=-0.3)
    assert not live.as_planned
    before = live.observation.q
    moved = live.step(0.9).q - before
    # The jib alone moves, the load stays, and neither phase nor load of the plan comes any more.
    assert abs(moved[1]) > 0.02 > abs(moved[0]) and live.payload == 30.0
    saved = live.scenario()
    assert [phase.time for phase in saved.phases] == [pytest.approx(0.3)] and saved.payload_changes == {0.2: 30.0}
    run = hc.simulate(saved)
    np.testing.assert_array_equal(driven(saved, saved.duration).state, end_of(run))
    again = hc.LiveSimulator(saved)
    again.step(live.time)
    np.testing.assert_array_equal(again.state, live.state)


def test_with_adaptive_steps_a_take_over_from_spool_commands_is_repeated_within_the_tolerance() -> None:
    live = driven(PLANS["spool commands, then sticks of the tip"], 0.2)
    live.set_stick(lift=0.2)
    live.step(0.5)
    again = hc.LiveSimulator(live.scenario())
    again.step(live.time)
    assert again.time == live.time
    assert np.abs(again.observation.tip - live.observation.tip).max() < 1e-5


@pytest.mark.parametrize("name", [name for name in PLANS if PLANS[name].phases and not PLANS[name].payload_changes])
@pytest.mark.parametrize("until", [0.7, 0.95])
def test_a_drive_taken_over_in_a_phase_is_repeated_to_the_last_bit(name: str, until: float, tmp_path) -> None:
    plan = PLANS[name].changed(payload_changes={0.6: 15.0, 2.0: 40.0})
    live = driven(plan, until)
    live.set_stick(**{live.axes[-1]: -0.5})
    live.step(0.4)
    live.set_payload(25.0)
    live.step(0.3)
    saved = live.scenario()
    begun = [phase.time for phase in plan.phases if phase.time < until]
    assert [phase.time for phase in saved.phases] == begun and list(saved.payload_changes.values()) == [15.0, 25.0]
    for scenario in (saved, hc.load_scenario(saved.save(tmp_path / "drive.toml"))):
        again = hc.LiveSimulator(scenario)
        again.step(live.time)
        np.testing.assert_array_equal(again.state, live.state)
        run = hc.simulate(scenario)
        np.testing.assert_array_equal(driven(scenario, scenario.duration).state, end_of(run))


def test_hoses_burst_and_phases_begin_after_the_duration_too() -> None:
    plan = PLANS["a hose that bursts, a sensor that fails, a goal and a load"].changed(duration=0.2)
    whole = hc.simulate(plan, duration=1.0)
    np.testing.assert_array_equal(driven(plan, 1.0).state, end_of(whole))


def test_a_phase_that_cannot_begin_ends_the_drive_unless_somebody_takes_over() -> None:
    plan = hc.Scenario(joints=START, joystick=UP, phases=[hc.Phase(0.1, {"friction.lift.model": "static"})])
    live = hc.LiveSimulator(plan)
    with pytest.raises(hc.SimulationError, match="bad-state.*other states"):
        live.step(0.5)
    other = hc.LiveSimulator(plan)
    other.set_stick()
    other.step(0.5)
    assert other.outcome is None


def test_a_run_that_begins_with_spool_commands_goes_on_under_a_controller() -> None:
    plan = PLANS["spool commands, then sticks of the tip"]
    assert not plan.closed_loop and plan.has_controller
    run = hc.simulate(plan)
    data, time = run.data, run.data.time.values
    early = time <= 0.5
    # Its last step is cut where the phase begins.
    alone = hc.simulate(plan, phases=(), duration=plan.phases[0].time)
    early_alone = alone.data.time.values <= 0.5
    for name in ("tip.z", "cylinder.lift.p1", "cylinder.lift.command"):
        np.testing.assert_array_equal(data[name].values[early], alone.data[name].values[early_alone])
    assert np.isnan(data["set_point.z"].values[early]).all() and np.isfinite(data["set_point.z"].values[-1])
    assert data.attrs["controller"] == "tip" and "controller tip" in run.summary()


@pytest.mark.parametrize(
    ("more", "why"),
    [
        ({"phases": ()}, "either commands or a controller"),
        ({"phases": [hc.Phase(0.5, {"supply.pressure": "100 bar"})]}, "or in the first phase"),
    ],
)
def test_spool_commands_with_goals_need_a_controller_later(more, why: str) -> None:
    with pytest.raises(hc.InputError, match=why):
        hc.Scenario(joints=START, commands=COMMANDS, goals=[hc.Goal(0.6, 2.6, 0.35)], **more)


def test_goals_and_faults_of_a_later_controller(tmp_path) -> None:
    plan = hc.Scenario(
        joints=START,
        commands={"lift": 0.002},
        goals=[hc.Goal(0.6, 2.6, 0.35)],
        sensor_faults=[hc.SensorFault("joint.boom.q", "jump", 0.7, size=0.001)],
        phases=[hc.Phase(0.5, controller="tip")],
        duration=1.0,
    )
    read = hc.load_scenario(plan.save(tmp_path / "later.toml"))
    assert (read.goals, list(read.sensor_faults)) == (plan.goals, plan.sensor_faults)
    np.testing.assert_array_equal(end_of(hc.simulate(read)), end_of(hc.simulate(plan)))
    with pytest.raises(hc.InputError, match="spool commands move the crane then"):
        hc.simulate(plan, goals=[hc.Goal(0.3, 2.6, 0.35)])


def test_somebody_can_take_over_before_the_first_step() -> None:
    live = hc.LiveSimulator(hc.Scenario(joints=START, commands=COMMANDS, duration=1.0))
    live.set_stick(lift=0.3)
    # Levers begin with the next step of the solver.
    assert not live.as_planned and 0.0 < live.time < live.period
    before = live.observation.q
    assert abs(live.step(0.5).q - before)[0] > 5e-3
    again = hc.LiveSimulator(live.scenario())
    again.step(live.time)
    assert np.abs(again.observation.tip - live.observation.tip).max() < 1e-5
