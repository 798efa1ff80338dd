"""The tip goes to a point by itself: a straight line, a smooth course of speed, within 1 mm, or a reason why not."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

START = {"boom": np.deg2rad(100), "jib": np.deg2rad(100), "extension": 0.0}
HOME = np.array(hc.load_machine("rottne-f9-lab").tip(list(START.values())))


def plan(*goals: hc.Goal, **changes: object) -> hc.Scenario:
    return hc.Scenario(**{"joints": START, "goals": goals, "duration": 6.0, **changes})


def goal(leg: tuple[float, float], time: float = 0.2, speed: float | None = None) -> hc.Goal:
    return hc.Goal(time, *(HOME + leg), speed=speed)


def way_of(run: hc.Run) -> np.ndarray:
    return np.column_stack([run.data["tip.x"], run.data["tip.z"]])


def texts(run: hc.Run) -> list[str]:
    return [event.text for event in run.events if not event.warning]


@pytest.mark.parametrize("payload", [0.0, 150.0])
@pytest.mark.parametrize("speed", [None, 0.1])
@pytest.mark.parametrize("leg", [(0.3, 0.3), (-0.4, 0.0), (0.0, -0.3), (0.005, 0.0)])
def test_the_tip_goes_straight_to_the_goal_and_stays(leg, speed, payload) -> None:
    run = hc.simulate(plan(goal(leg, speed=speed), payload=payload))
    way, length = way_of(run) - HOME, np.hypot(*leg)
    along, aside = way @ leg / length, np.abs(way @ (-leg[1], leg[0])) / length
    assert texts(run) == [f"the tip has reached its goal ({HOME[0] + leg[0]:.3f}, {HOME[1] + leg[1]:.3f}) m"]
    assert np.hypot(*(way[-1] - leg)) < 2e-4
    assert aside.max() < 1e-3 and along.max() < length + 2e-4


def test_the_set_point_starts_and_stops_without_jumps_of_its_acceleration() -> None:
    run = hc.simulate(plan(goal((-0.3, 0.0), speed=0.15)))
    x = run.data["set_point.x"].values
    velocity = np.diff(x) / 0.01
    acceleration = np.diff(velocity) / 0.01
    # The ramp of 4 time constants of the stick's lags, 15 rad/s; behind them jerk is at most 15 rad/s times that.
    most = 0.15 * 15 / 4
    assert -0.15 - 1e-9 < velocity.min() < -0.149
    assert np.abs(acceleration).max() < 1.1 * most
    assert np.abs(np.diff(acceleration)).max() / 0.01 < 1.2 * most * 15


def test_a_slow_way_in_short_samples_begins_and_ends() -> None:
    run = hc.simulate(plan(goal((0.01, 0.0), speed=0.01), period=1e-3, duration=4.0))
    assert "has reached its goal" in texts(run)[0]
    assert np.hypot(*(way_of(run)[-1] - HOME - (0.01, 0.0))) < 2e-4


def test_data_sheet_sensors_end_within_their_errors() -> None:
    run = hc.simulate(plan(goal((-0.3, 0.2)), sensors="data-sheet", seed=3))
    assert "has reached its goal" in texts(run)[0]
    assert np.hypot(*(way_of(run)[-1] - HOME - (-0.3, 0.2))) < 20e-3


def test_soft_oil_takes_longer_and_ends_there_too() -> None:
    """The lowest mode of this crane on its oil has 2 to 12 rad/s."""
    crane = hc.load_machine("hiab-xs031")
    middle = np.array([0.5 * (low + high) for low, high in crane.joint_limits])
    start = np.array(crane.tip(middle))
    goals = [hc.Goal(0.2, *(start + (-0.2, 0.2)), speed=0.2)]
    joints = dict(zip(crane.joint_names, middle, strict=True))
    run = hc.simulate(hc.Scenario(machine="hiab-xs031", joints=joints, goals=goals, duration=14.0))
    assert "has reached its goal" in texts(run)[0]
    assert np.hypot(*(way_of(run)[-1] - start - (-0.2, 0.2))) < 2e-3


def test_one_goal_after_the_other_and_one_that_takes_the_place_of_another() -> None:
    legs = [(0.2, 0.0), (0.2, 0.2), (0.0, 0.0)]
    run = hc.simulate(plan(*(goal(leg, time) for leg, time in zip(legs, (0.0, 4.0, 4.5), strict=True)), duration=9.0))
    assert [text[:28] for text in texts(run)] == ["the tip has reached its goal"] * 2
    assert np.hypot(*(way_of(run)[-1] - HOME)) < 2e-4


def test_a_stick_takes_over_at_once_and_a_goal_under_a_stick_counts_for_nothing() -> None:
    stick = hc.Joystick([1.0, 1.5], {"z": [0.5, 0.0]}, full_speed=0.2)
    run = hc.simulate(plan(goal((0.4, 0.0)), goal((0.0, 0.3), 1.2), joystick=stick))
    took, refused = texts(run)
    assert took.startswith("the stick takes over") and refused.endswith("a stick is deflected; release it first")
    where = run.data["set_point.x"].sel(time=slice(2.5, None)).values
    assert np.ptp(where) < 1e-4 and where[0] < HOME[0] + 0.3, "it does not go on when the stick is released"


def test_a_border_on_the_way_ends_it_with_a_reason() -> None:
    """Behind a wall between here and the goal."""
    x, z = HOME
    corners = ((x + 0.2, z - 1), (x + 0.22, z - 1), (x + 0.22, z + 1), (x + 0.2, z + 1))
    wall = [f"({a}, {b}) m" for a, b in corners]
    keep = {"keep-out.pillar.outline": wall}
    run = hc.simulate(plan(goal((0.5, 0.0)), overrides=keep, duration=12.0))
    assert len(texts(run)) == 1
    assert "the tip stops before its goal" in texts(run)[0] and "a keep-out region lies ahead; give" in texts(run)[0]
    assert way_of(run)[:, 0].max() < x + 0.2 - 0.049


def test_a_load_that_cannot_be_lifted_ends_the_way_with_a_reason() -> None:
    run = hc.simulate(plan(goal((0.0, 0.4)), payload=400.0, overrides={"supply.pressure": "40 bar"}))
    assert len(texts(run)) == 1 and "cylinder `lift` cannot lift this here" in texts(run)[0]
    assert np.hypot(*(way_of(run)[-1] - HOME)) < 10e-3


@pytest.mark.parametrize(
    ("place", "changes", "why"),
    [
        ((9.0, 0.3), {}, r"out of reach of the tip; the nearest place within reach is \("),
        (
            (2.5, -1.3),
            {},
            r"in a keep-out region, or nearer to it than the margin of 0.050 m; \(2.500, -1.160\) m is",
        ),
        ((2.5, 0.3), {"controller": "heinze-pid"}, "only the controller `tip` goes to a goal"),
        ((2.5, 0.3), {"controller": "lever"}, "only the controller `tip` goes to a goal"),
        ((2.5, 0.3), {"phases": [hc.Phase(0.1, controller="lever")]}, "only the controller `tip` goes to a goal"),
    ],
)
def test_a_goal_that_cannot_be_reached_is_refused_before_the_run(place, changes, why) -> None:
    with pytest.raises(hc.InputError, match=rf"cannot go to the goal .* at 0.2 s: .*{why}"):
        hc.simulate(plan(hc.Goal(0.2, *place), **changes))


@pytest.mark.parametrize(
    ("make", "why"),
    [
        (lambda: hc.Goal(-1.0, 2.0, 0.0), "zero seconds or later"),
        (lambda: hc.Goal(1.0, np.nan, 0.0), "`x` of a goal must be finite"),
        (lambda: hc.Goal(1.0, 2.0, 0.0, speed=0.0), "greater than zero"),
        (lambda: hc.Goal(1.0, 2.0, 0.0, until=1.0), "cancelled after it is given"),
        (lambda: plan(hc.Goal(1.0, 2.0, 0.0), hc.Goal(1.0, 2.5, 0.0)), "a different time"),
        (lambda: plan("there"), "must be a list of Goal"),
        (lambda: plan(hc.Goal(1.0, 2.0, 0.0), commands={"lift": 0.01}), "either commands or a controller"),
    ],
)
def test_wrong_goals_are_errors(make, why) -> None:
    with pytest.raises(hc.InputError, match=why):
        make()


FILE = """
[scenario]
name = "goals"
machine = "rottne-f9-lab"
duration = "5 s"

[initial.joint]
boom = "100 deg"
jib = "100 deg"
extension = "0 mm"

[goal]
time = ["0.2 s", "3 s"]
x = ["2.6 m", "2.7 m"]
z = ["-100 mm", "0.1 m"]
speed = ["0.3 m/s", "0.1 m/s"]

[joystick]
time = ["0 s", "4 s"]
precision = [1, 0.5]
"""


def test_a_file_states_goals_and_is_written_back_the_same(tmp_path) -> None:
    path = tmp_path / "goals.toml"
    path.write_text(FILE)
    told = hc.load_scenario(path)
    assert told.goals == (hc.Goal(0.2, 2.6, -0.1, 0.3), hc.Goal(3.0, 2.7, 0.1, 0.1))
    again = hc.load_scenario(told.save(tmp_path / "again.toml"))
    assert again.goals == told.goals and list(again.joystick.precision) == [1.0, 0.5]
    ends = [way_of(hc.simulate(scenario))[-1] for scenario in (told, again)]
    assert (ends[0] == ends[1]).all()


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ('z = ["-100 mm", "0.1 m"]', 'z = ["-100 mm"]', "1 values for 2 times"),
        ('"0.1 m/s"]', '"0 m/s"]', "a speed of 0 m/s reaches no goal"),
        ('["0.2 s", "3 s"]', '["-1 s", "3 s"]', "before the run has begun"),
        ("[joystick]", 'drop = ["0.1 s"]\n[joystick]', "there is no goal to cancel at 0.1 s"),
        ("[joystick]", 'drop = ["1 s", "2 s"]\n[joystick]', "no goal to cancel at 2 s"),
        ("precision = [1, 0.5]", "precision = [1, 1.5]", "not a share of the full speed"),
        ("[joystick]", '[command.lift]\ntime = ["0 s"]\nspool = ["1 mm"]\n[joystick]', "excludes `command`"),
    ],
)
def test_wrong_tables_are_errors_with_a_place(tmp_path, old, new, why) -> None:
    path = tmp_path / "goals.toml"
    path.write_text(FILE.replace(old, new))
    with pytest.raises(hc.MachineFileError, match=why):
        hc.load_scenario(path)


def test_a_goal_is_dropped_where_a_file_says_so(tmp_path) -> None:
    path = tmp_path / "goals.toml"
    path.write_text(FILE.replace("[joystick]", 'drop = ["0.6 s", "3.5 s"]\n[joystick]'))
    told = hc.load_scenario(path)
    assert [goal.until for goal in told.goals] == [0.6, 3.5]
    assert hc.load_scenario(told.save(tmp_path / "again.toml")).goals == told.goals
    run = hc.simulate(told)
    assert [text[:21] for text in texts(run)] == ["the goal is cancelled"] * 2
    x = run.columns["set_point.x"].values
    assert abs(x[-1] - HOME[0]) < 0.2 and np.ptp(x[150:300]) < 1e-6


def test_the_sticks_of_a_run_are_repeated_from_the_run_and_from_its_file(tmp_path) -> None:
    stick = hc.Joystick(
        [0.5, 2.0, 3.0],
        {"x": [0.3, 0.0, 0.2], "z": [-0.2, 0.4, 0.0]},
        dead_zone=0.1,
        ramp=0.2,
        full_speed=0.2,
        precision=[1, 0.5, 1],
    )
    run = hc.simulate(hc.Scenario(joints=START, joystick=stick, duration=4.0))
    for log in (run, run.save(tmp_path / "run.csv")):
        again = hc.Scenario(joints=START, joystick=hc.Joystick.from_log(log, full_speed=0.2), duration=4.0)
        assert (way_of(hc.simulate(again)) == way_of(run)).all()
    levers = hc.simulate(hc.Scenario(joints=START, joystick=hc.Joystick([0.5], {"jib": [0.1]}, "lever"), duration=1.0))
    with pytest.raises(hc.InputError, match=r'levers, lift, jib, extension, .*mode="lever" or "height"'):
        hc.Joystick.from_log(levers)
    assert "jib" in hc.Joystick.from_log(levers, mode="height").axes


def test_precision_slows_the_stick_smoothly_and_the_way_to_a_goal() -> None:
    stick = hc.Joystick([0.2, 2.0], {"x": [-1.0, -1.0]}, full_speed=0.1, precision=[1.0, 0.25])
    run = hc.simulate(hc.Scenario(joints=START, joystick=stick, duration=4.0))
    # The last row of the record has no sample of its own.
    velocity = np.diff(run.data["set_point.x"].values[:-1]) / 0.01
    assert velocity[150] == pytest.approx(-0.1, rel=1e-3) and velocity[-1] == pytest.approx(-0.025, rel=1e-3)
    assert np.abs(np.diff(velocity)).max() < 0.1 * 15 / 2.7 * 0.01, "no faster than the stick's own lags"
    assert stick.at(3.0).velocity == pytest.approx([-0.025, 0.0])
    slow = hc.Joystick([0.0], {}, full_speed=0.2, precision=[0.25])
    run = hc.simulate(plan(goal((-0.2, 0.0)), joystick=slow))
    assert np.abs(np.diff(run.data["set_point.x"].values)).max() / 0.01 == pytest.approx(0.05, rel=1e-3)
    with pytest.raises(hc.InputError, match="a share of the full speed"):
        hc.Joystick([0.0], {}, precision=[2.0])
