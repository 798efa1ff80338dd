"""Tip control without pressure sensors: lines, rest, the load that nobody told, and pressures that are not read."""

from __future__ import annotations

import numpy as np
import pytest
from tip_after_driving import lines_after_driving
from tip_stops import random_stop

import hydrocrane as hc
from hydrocrane.benchmark import START, Case, Condition, random_lines, run_case, scenario_of, tasks

LAB, LOADER = "rottne-f9-lab", "hiab-xs031"
ESTIMATED = {"control.tip.pressures": "estimated"}
LOADER_START = {"lift": 0.939, "tilt": -1.279, "extension": 0.55}


def crane(name: str, **values: object) -> hc.Machine:
    return hc.load_machine(name, ESTIMATED | values)


def deviations(machine: hc.Machine, condition: Condition, count: int = 8) -> np.ndarray:
    runs = [run_case(machine, "tip", case) for case in random_lines(machine, count, seed=2, condition=condition)]
    assert all(run.outcome.completed and run.metrics is not None for run in runs)
    return np.array([run.metrics.path_max for run in runs if run.metrics is not None])


@pytest.mark.parametrize(
    ("name", "payload", "sensors", "most"),
    [
        (LAB, 0.0, "ideal", 0.5e-3),
        (LAB, 200.0, "ideal", 5e-3),
        (LAB, 80.0, "data-sheet", 5e-3),
        (LOADER, 0.0, "ideal", 10e-3),
    ],
)
def test_random_lines_are_followed_without_pressures(name, payload, sensors, most):
    assert deviations(crane(name), Condition(payload=payload, sensors=sensors)).max() < most


def test_a_load_that_the_file_states_is_carried_from_the_first_line_on():
    told = crane(LOADER, **{"payload.mass": 80.0})
    condition = Condition(payload=80.0)
    known, unknown = deviations(told, condition), deviations(crane(LOADER), condition)
    assert np.median(known) < 3e-3 < 5e-3 < np.median(unknown) and known.max() < 25e-3 < unknown.max()


@pytest.mark.parametrize(
    ("name", "start", "payload", "most"),
    [(LAB, START, 200.0, 0.5e-3), (LOADER, LOADER_START, 80.0, 30e-3)],
)
def test_a_load_that_nobody_told_is_found_by_driving(name, start, payload, most):
    after = lines_after_driving(crane(name), {"payload.mass": payload}, 1, start=start)
    assert after.deviation < most


@pytest.mark.parametrize("payload", [0.0, 200.0])
def test_the_tip_comes_to_rest_and_stays_there(payload):
    stops = [random_stop(crane(LAB), seed, payload=payload) for seed in range(5)]
    found = [stop for stop in stops if stop is not None]
    assert len(found) >= 4
    assert max(stop.settling for stop in found) < 3.0
    assert max(stop.quiet for stop in found) < 1e-3 and max(stop.drift for stop in found) < 2e-3


def test_no_pressure_is_read():
    line = Case(tasks.lines()[1])
    plan = scenario_of(crane(LAB), "tip", line)
    pressures = [f"cylinder.{c}.p{side}" for c in plan.load_machine().cylinder_names for side in (1, 2)]
    torn = [hc.SensorFault(signal, "drop-out", 0.0) for signal in pressures]
    run, blind = hc.simulate(plan), hc.simulate(plan.changed(sensor_faults=torn))
    assert blind.outcome.completed and not blind.events
    for signal in ("tip.x", "tip.z"):
        np.testing.assert_array_equal(run.data[signal].values, blind.data[signal].values)


def test_a_joint_sensor_that_drops_out_is_ridden_through():
    found = run_case(crane(LAB), "tip", Case(tasks.lines()[1], Condition(drop_out=0.05)))
    assert found.metrics is not None
    assert found.metrics.reached > 0.99 and found.metrics.path_max < 1e-3


def test_a_load_that_the_supply_pressure_cannot_hold_is_not_let_down():
    """Lift pressures above the supply's from the start; an open valve would let the load fall."""
    machine = crane(LOADER)
    plan = hc.Scenario(
        machine=machine.source,
        overrides=machine.overrides,
        joints={"lift": 0.55, "tilt": -0.4, "extension": 0.6},
        payload=250.0,
        duration=16.0,
        joystick=hc.Joystick([0.0, 1.0], {"x": [0.0, 0.0], "z": [-1.0, 0.0]}, full_speed=0.1),
    )
    run = hc.simulate(plan)
    z = run.data["tip.z"].values
    assert any("moves away from its rest position" in event.text for event in run.events)
    assert abs(z[-1] - z[run.data.time.values > 8.0][0]) < 0.02


def test_the_bad_choice_is_named_with_the_good_ones():
    with pytest.raises(hc.HydrocraneError) as caught:
        hc.load_machine(LAB, {"control.tip.pressures": "guessed"})
    told = str(caught.value)
    assert "control.tip.pressures" in told and "measured" in told and "estimated" in told


def test_data_sheet_sensors_without_those_of_pressures_are_told_of_the_key():
    def cures(machine: hc.Machine) -> list[tuple[str, str]]:
        plan = scenario_of(
            machine, "tip", Case(tasks.lines()[1], Condition(sensors="data-sheet"), start=(0.9, -1.2, 0.5))
        )
        return [
            (w.text, w.cure)
            for w in hc.simulate(plan.changed(duration=0.2)).warnings
            if w.kind == "signal-without-sensor"
        ]

    ((text, cure),) = cures(hc.load_machine(LOADER))
    assert "joint.lift.q" in text and 'control.tip.pressures = "estimated"' in cure
    ((text, cure),) = cures(crane(LOADER))
    assert "2 other signals" in text and "control.tip.pressures" not in cure
