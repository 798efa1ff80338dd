"""Logs moved by a modelled operator: the operator does what is stated, and sticks answer to their motion."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from log_loading import (
    GAINS,
    HOME,
    INSIDE,
    PASS,
    STAKE,
    LogTask,
    loading_cycle,
    log_task,
    tune_operator,
    tuned_operator,
)
from modelled_operator import CONTENT, GLANCE, INTERFACES, PERIOD, Driver, Operator, Waypoint
from operator_loop import drive

import hydrocrane as hc
from hydrocrane.benchmark.tuning import pattern_search

ROOT = Path(__file__).resolve().parents[3]
NEAR = (Waypoint((1.6, 0.4), 0.03, stop=True),)


@pytest.fixture(scope="module")
def crane():
    return hc.load_machine("rottne-f9-lab")


@pytest.fixture(scope="module")
def start(crane):
    return crane.inverse_kinematics(HOME)[0]


def plan_of(crane, start):
    return hc.Scenario(machine=crane, joints=dict(zip(crane.joint_names, start, strict=True)), payload=0.0)


# --- the operator ---------------------------------------------------------------------------------------------------


def test_a_tip_stick_points_to_the_place_and_moves_no_faster_than_the_hand(crane, start):
    operator = Operator(hand_step=0.001)
    driver = Driver(crane, "tip", operator, [Waypoint((2.1, 1.3), 0.05, stop=True)], 0)
    first = driver.decide(np.array(HOME), np.zeros(2), start)
    assert np.abs(first).max() <= operator.hand_rate * PERIOD + 1e-12
    for _ in range(10):
        sticks = driver.decide(np.array(HOME), np.zeros(2), start)
    assert sticks == pytest.approx([0.6, 0.8], abs=operator.hand_step)


@pytest.mark.parametrize("levers", [1, 2, 3])
def test_levers_without_an_error_ask_for_the_wanted_direction(crane, start, levers):
    """The velocity that piston speeds in proportion to the deflections give, by the crane's own Jacobians."""
    operator = Operator(levers=levers, picture_error=0.0, hand_step=1e-6, hand_rate=100.0)
    driver = Driver(crane, "lever", operator, [Waypoint((2.1, 1.3), 0.05, stop=True)], 0)
    sticks = driver.decide(np.array(HOME), np.zeros(2), start)
    assert np.count_nonzero(sticks) == levers
    speeds = sticks * np.abs(crane.piston_speeds(start)).mean(axis=1)
    velocity = crane.tip_jacobian(start) @ np.linalg.solve(crane.stroke_jacobian(start), speeds)
    aside = abs(velocity @ [-0.8, 0.6]) / np.hypot(*velocity)
    assert velocity @ [0.6, 0.8] > 0.0
    assert aside < 1e-4 or levers == 1


def test_a_content_operator_rests_and_a_grapple_takes_its_time(crane, start):
    operator = Operator()
    driver = Driver(crane, "tip", operator, [Waypoint(HOME, 0.05, 80.0)], 0)
    inside = np.array(HOME) + [0.0, 0.9 * CONTENT * 0.05]
    decisions = 0
    while not driver.done:
        assert not driver.decide(inside, np.zeros(2), start).any()
        decisions += 1
    assert driver.payload == 80.0
    assert decisions == 1 + round(operator.grapple_time / PERIOD)


@pytest.mark.parametrize(
    ("bad", "told"),
    [
        ({"reaction": 0.0}, "reaction"),
        ({"levers": 4}, "1, 2 or 3"),
        ({"gain": -1.0}, "gain"),
        ({"picture_error": math.nan}, "picture_error"),
        ({"gian": 1.0}, "did you mean `gain`"),
    ],
)
def test_a_wrong_ability_is_named(bad, told):
    with pytest.raises(hc.InputError, match=told):
        Operator().changed(**bad)


def test_wrong_wishes_are_named():
    with pytest.raises(hc.InputError, match="lever"):
        loading_cycle(log_task(1), "levers")
    with pytest.raises(hc.InputError, match="lever"):
        tuned_operator("sticks")
    with pytest.raises(hc.InputError, match="logs"):
        log_task(1, logs=0)
    with pytest.raises(hc.InputError, match="boom, jib, extension"):
        loading_cycle(log_task(1), "tip", machine="hiab-xs031")
    far = LogTask("far", (Waypoint((9.0, 0.0), 0.1),), False, 1, 0)
    with pytest.raises(hc.InputError, match=r"\(9.0, 0.0\)"):
        loading_cycle(far, "tip")
    with pytest.raises(hc.InputError, match="one task"):
        tune_operator("tip", Operator(), [])


# --- tasks and search -----------------------------------------------------------------------------------------------


def test_unloading_brings_the_same_logs_back():
    loading, unloading = (
        [point for point in log_task(7, unloading=back, logs=3).waypoints if point.payload is not None]
        for back in (False, True)
    )
    taken, laid = loading[::2], loading[1::2]
    assert len(taken) == 3 and {point.payload for point in laid} == {0.0}
    assert [p.place for p in unloading[::2]] == [p.place for p in laid]
    assert [p.place for p in unloading[1::2]] == [p.place for p in taken]
    assert [p.payload for p in unloading[::2]] == [p.payload for p in taken]
    assert log_task(7, logs=3) == log_task(7, logs=3) and log_task(8) != log_task(7)


def test_a_pattern_search_finds_the_least_and_never_keeps_what_is_no_choice():
    calls = []

    def cost(values):
        calls.append(values)
        return math.inf if values["a"] > 5.0 else math.log(values["a"] / 4.0) ** 2 + math.log(values["b"] / 0.3) ** 2

    best, before, least = pattern_search(cost, {"a": 1.0, "b": 1.0}, trials=60, factors=(2.0, 1.01))
    assert best == pytest.approx({"a": 4.0, "b": 0.3}, rel=0.02)
    assert before == cost({"a": 1.0, "b": 1.0}) and least == cost(best)
    assert len(calls) <= 62


def stored(interface):
    """Rows of the validation's table for the default operator."""
    named = Operator()
    with (ROOT / "docs/validation/loading-cycle/cycles.csv").open(encoding="utf-8", newline="") as file:
        return [
            row
            for row in csv.DictReader(file)
            if row["interface"] == interface
            and float(row["reaction"]) == named.reaction
            and int(row["levers"]) == named.levers
            and math.radians(float(row["picture_error"])) == pytest.approx(named.picture_error, rel=0.01)
        ]


@pytest.mark.parametrize("interface", INTERFACES)
def test_the_gains_of_an_interface_are_those_that_the_stored_search_found(interface):
    found = [[float(row[name]) for name in GAINS] for row in stored(interface)]
    assert len(found) == 40 and np.ptp(found, axis=0).max() == 0.0
    assert [getattr(tuned_operator(interface), name) for name in GAINS] == pytest.approx(found[0], rel=0.005)


@pytest.mark.evidence
@pytest.mark.parametrize("interface", INTERFACES)
def test_the_stored_figures_are_those_of_the_present_code(interface):
    """Gains are stored and stated with few digits, which may move a decision by some periods."""
    for row in (row for row in stored(interface) if row["seed"] == "12"):
        cycle = loading_cycle(log_task(12, unloading=row["task"] == "unloading"), interface)
        assert cycle.time == pytest.approx(float(row["time"]), abs=0.3)
        assert cycle.way == pytest.approx(float(row["way"]), rel=0.01)
        assert cycle.energy == pytest.approx(float(row["energy"]), rel=0.01)


# --- the loop -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("interface", INTERFACES)
def test_the_sticks_answer_to_the_motion_that_they_make(crane, start, interface):
    """A second operator who sees the motion of the finished drive decides the same, to the last bit."""
    operator = Operator()
    found = drive(plan_of(crane, start), Driver(crane, interface, operator, NEAR, 3), 15.0)
    assert found.finished
    run = hc.simulate(found.scenario, ledger=False)
    tip = np.column_stack([run.columns[name].values for name in ("tip.x", "tip.z")])
    q = np.column_stack([run.columns[f"joint.{name}.q"].values for name in crane.joint_names])
    again = Driver(crane, interface, operator, NEAR, 3)
    for k, sticks in enumerate(found.sticks):
        late, earlier = operator.seen_at(k)
        decided = again.decide(tip[late], (tip[late] - tip[earlier]) / GLANCE, q[late])
        # Levers are stepped: the solver starts anew at each decision, which costs some last digits.
        assert np.abs(decided - sticks).max() <= (0.0 if interface == "tip" else operator.hand_step + 1e-9)
    assert again.done
    assert np.hypot(*(tip[-1] - NEAR[0].place)) < NEAR[0].tolerance


def test_a_stake_in_the_way_is_struck_and_counted():
    (left, right), top = STAKE
    low = top - 0.3
    through = (Waypoint((left - 0.3, low), 0.05, stop=True), Waypoint((right + 0.3, low), 0.05, stop=True))
    cycle = loading_cycle(LogTask("through the stake", through, False, 1, 0), "tip")
    assert cycle.finished and cycle.strikes == 1 and cycle.faults == 1
    assert cycle.cost > cycle.time


@pytest.mark.evidence
def test_what_takes_too_long_is_given_up():
    slow = loading_cycle(log_task(1), "lever", Operator(speed=0.001))
    assert not slow.finished and math.isnan(slow.time) and slow.cost >= 90.0


@pytest.mark.evidence
@pytest.mark.parametrize(("interface", "logs"), [("lever", 2), ("tip", 1)])
@pytest.mark.parametrize("unloading", [False, True])
def test_logs_get_where_they_belong(interface, logs, unloading):
    """Nothing is struck or missed, no way is shorter than straight, no lift is free, equal seeds give equal numbers."""
    task = log_task(5, unloading=unloading, logs=logs)
    cycle = loading_cycle(task, interface)
    assert cycle.finished and not cycle.faults
    places = np.array([HOME, *(point.place for point in task.waypoints)])
    straight = np.hypot(*np.diff(places, axis=0).T).sum() - 2.0 * sum(point.tolerance for point in task.waypoints)
    assert cycle.way > straight
    assert cycle.time > 2.0 * logs * cycle.operator.grapple_time
    changes = cycle.run.payload_changes
    assert [change.after for change in changes] == [p.payload for p in task.waypoints if p.payload is not None]
    # Every log goes over the stake; what lowering gives back does not reach the pump.
    picked = [point for point in task.waypoints if point.payload]
    lifts = [9.81 * p.payload * (INSIDE[1] - PASS - p.place[1] - p.tolerance) for p in picked]
    assert cycle.energy > sum(lifts)
    again = loading_cycle(task, interface)
    assert (again.time, again.way, again.energy) == (cycle.time, cycle.way, cycle.energy)


@pytest.mark.evidence
def test_the_search_makes_no_operator_worse():
    task, operator = log_task(101), Operator(gain=0.4)
    better = tune_operator("lever", operator, [task], trials=6)
    assert loading_cycle(task, "lever", better).cost < loading_cycle(task, "lever", operator).cost
