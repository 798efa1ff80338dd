"""A scenario driven live: sticks and goals take effect at the next sample, and a drive is repeated to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

START = {"boom": np.deg2rad(100), "jib": np.deg2rad(100), "extension": 0.0}
HOME = np.array(hc.load_machine("rottne-f9-lab").tip(list(START.values())))
PLAN = hc.Scenario(joints=START, controller="tip")


def texts(live: hc.LiveSimulator) -> list[str]:
    return [event.text for event in live.events]


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"sensors": "data-sheet", "seed": 3, "delay": 0.004, "payload": 40.0},
        {"joystick": hc.Joystick([], {}, full_speed=0.2, dead_zone=0.1, ramp=0.3)},
        {"rtol": 1e-6, "period": 0.02},
    ],
)
def test_what_was_driven_is_repeated_to_the_last_bit(changes) -> None:
    live = hc.LiveSimulator(PLAN, **changes)
    live.step(0.3)
    live.set_stick(x=-0.4, z=0.3)
    live.step(0.8)
    live.set_precision(0.5)
    live.step(0.4)
    live.set_stick()
    live.set_precision(1.0)
    live.step(1.0)
    live.go_to(*(HOME + (-0.3, 0.2)), speed=0.2)
    live.step(0.7)
    live.drop_goal()
    live.set_payload(80.0)
    live.step(1.5)
    live.go_to(*HOME)
    live.step(0.61)
    saved = live.scenario(record_interval=live.period)
    run = hc.simulate(saved)
    # The run ends at the last sample, one before the state at hand.
    assert run.outcome.completed and saved.duration == pytest.approx(live.time - live.period)
    assert [event.text for event in run.events if not event.warning] == texts(live)
    again = hc.LiveSimulator(saved)
    again.step(live.time)
    assert (again.state == live.state).all() and again.time == live.time
    assert (again.observation.tip == live.observation.tip).all()


def test_the_run_of_a_saved_drive_passes_through_the_same_states() -> None:
    live = hc.LiveSimulator(PLAN)
    live.set_stick(z=0.3)
    seen = [live.step().tip for _ in range(150)]
    run = hc.simulate(live.scenario(record_interval=live.period))
    ways = np.column_stack([run.columns["tip.x"].values, run.columns["tip.z"].values])
    assert (ways[1:] == seen[: len(ways) - 1]).all() and len(ways) == 150


def test_a_saved_drive_is_a_file(tmp_path) -> None:
    live = hc.LiveSimulator(PLAN)
    live.go_to(*(HOME + (0.0, 0.3)))
    live.step(0.5)
    live.drop_goal()
    live.step(0.5)
    saved = live.scenario()
    read = hc.load_scenario(saved.save(tmp_path / "drive.toml"))
    assert "drop = [" in (tmp_path / "drive.toml").read_text()
    assert read.goals == saved.goals and read.goals[0].until == pytest.approx(0.5)
    ends = [hc.simulate(scenario).columns["tip.z"].values[-1] for scenario in (saved, read)]
    assert ends[0] == ends[1]


def test_a_goal_is_reached_dropped_or_ended_by_a_stick() -> None:
    live = hc.LiveSimulator(PLAN)
    goal = tuple(HOME + (-0.3, 0.0))
    live.go_to(*goal, speed=0.2)
    assert live.goal == goal
    live.step(4.0)
    assert live.goal is None and "has reached its goal" in texts(live)[-1]
    assert np.hypot(*(live.observation.tip - goal)) < 1e-3
    live.go_to(*HOME, speed=0.2)
    live.step(0.8)
    moving = live.set_point
    live.drop_goal()
    assert live.goal is None
    live.step(2.0)
    assert texts(live)[-1].startswith("the goal is cancelled: the tip no longer goes to")
    # It stops within the way that the lags of the stick leave, 2 v/w.
    assert 0 < live.set_point[0] - moving[0] < 2.2 * 0.2 / 15
    stood = live.set_point
    live.step(2.0)
    assert live.set_point == stood
    live.go_to(*HOME)
    live.step(0.3)
    live.set_stick(z=-0.5)
    live.step(0.3)
    assert texts(live)[-1].startswith("the stick takes over")
    with pytest.raises(hc.InputError, match="a stick is deflected; release it first"):
        live.go_to(*HOME)


def test_a_goal_given_and_dropped_between_two_samples_is_none() -> None:
    live = hc.LiveSimulator(PLAN)
    live.step()
    live.go_to(*(HOME + (0.2, 0.0)))
    live.drop_goal()
    live.step(1.0)
    assert live.events == () and live.scenario().goals == ()


def test_a_replay_goes_on_until_somebody_takes_over() -> None:
    plan = PLAN.changed(
        joystick=hc.Joystick([0.2], {"z": [0.5]}, full_speed=0.1),
        goals=[hc.Goal(9.0, *HOME)],
        payload_changes={8.0: 10.0},
    )
    live = hc.LiveSimulator(plan)
    live.step(1.0)
    assert live.observation.tip[1] > HOME[1] + 0.02
    live.set_stick()
    live.step(9.5)
    assert live.goal is None and live.payload == 0 and live.scenario().goals == ()
    assert abs(live.observation.tip[1] - HOME[1] - 0.04) < 0.02, "the stick was released at 1 s"


def test_levers_and_controllers_of_ones_own_are_steered_too() -> None:
    live = hc.LiveSimulator(PLAN.changed(controller="lever"))
    assert live.axes == ("lift", "jib", "extension")
    live.set_stick(jib=-0.4)
    before = live.observation.q
    moved = live.step(1.0).q - before
    assert abs(moved[1]) > 0.02 and abs(moved[0]) < 0.01
    with pytest.raises(hc.InputError, match="only the controller `tip` goes to a goal"):
        hc.LiveSimulator(PLAN.changed(controller="lever")).go_to(*HOME)

    own = hc.LiveSimulator(PLAN.changed(controller=lambda obs, stick: [0.02 * stick.axes[1], 0.0, 0.0]))
    own.set_stick(z=1.0)
    assert own.step(0.5).tip[1] > HOME[1] + 0.01

    def broken(obs, stick):
        raise ValueError("no idea")

    failing = hc.LiveSimulator(PLAN.changed(controller=broken))
    with pytest.raises(hc.SimulationError, match="controller-failed.*no idea"):
        failing.step()
    assert failing.outcome.kind == "controller-failed"
    with pytest.raises(hc.SimulationError, match="begin a new one"):
        failing.step()


@pytest.mark.parametrize(
    ("act", "why"),
    [
        (lambda live: live.set_stick(y=0.1), r"unknown stick axis `y`.*x.*z"),
        (lambda live: live.set_stick(x=1.5), "a stick ends at -1 and 1"),
        (lambda live: live.set_stick(x=np.nan), "finite"),
        (lambda live: live.set_stick(x=[0.1, 0.2]), "must be one number"),
        (lambda live: live.go_to(9.0, 0.3), r"out of reach of the tip; the nearest place within reach is \("),
        (lambda live: live.go_to(2.5, -1.3), "in a keep-out region"),
        (lambda live: live.go_to(np.inf, 0.3), "finite"),
        (lambda live: live.go_to(2.5, 0.3, speed=0.0), "greater than zero"),
        (lambda live: live.set_precision(1.5), "from 0 to 1"),
        (lambda live: live.set_payload(-1.0), "payload"),
        (lambda live: live.step(0.0), "greater than zero"),
        (lambda live: live.step(np.nan), "finite"),
        (lambda live: live.scenario(), "nothing has been driven yet"),
    ],
)
def test_bad_input_is_one_error_and_changes_nothing(act, why) -> None:
    live = hc.LiveSimulator(PLAN)
    with pytest.raises(hc.InputError, match=why):
        act(live)
    live.step(0.5)
    assert np.hypot(*(live.observation.tip - HOME)) < 1e-3 and live.goal is None


@pytest.mark.parametrize(
    ("plan", "why"),
    [
        (PLAN.changed(joints={"boom": 1.7}), "no start value for joint"),
        (PLAN.changed(controller=None, commands={"lift": 0.5}), "demands 500 mm of spool"),
        (PLAN.changed(goals=[hc.Goal(9.0, 9.0, 0.3)]), "out of reach of the tip"),
        (PLAN.changed(phases=[hc.Phase(9.0, {"supply.presure": 1e7})]), "presure"),
    ],
)
def test_a_scenario_that_cannot_be_driven_is_refused(plan, why) -> None:
    with pytest.raises(hc.HydrocraneError, match=why):
        hc.LiveSimulator(plan)


def test_the_first_observation_is_the_start_and_warnings_are_told() -> None:
    live = hc.LiveSimulator(PLAN.changed(payload=3000.0))
    assert live.time == 0 and live.observation.tip == pytest.approx(HOME)
    assert set(live.observation.measured) >= {"joint.boom.q", "cylinder.lift.p1"}
    live.step(2.0)
    assert live.warnings or live.events
