"""The payload and the like have two places; one rule says which of them counts."""

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.machine.keys import Key
from hydrocrane.studies.keys import changed_plan

POSE = {"boom": 1.7, "jib": 1.7, "extension": 0.0}


def plan(**fields):
    return hc.Scenario(machine="rottne-f9-lab", joints=POSE, duration=0.02, **fields)


def carried(scenario, **changes):
    return float(hc.simulate(scenario, **changes).data["payload"].values[0])


def test_what_a_call_gives_counts_before_what_the_scenario_states():
    heavy = plan(payload=50.0)
    assert carried(heavy) == 50.0
    assert carried(heavy, overrides={"payload.mass": "200 kg"}) == 200.0
    assert carried(heavy, payload=0.0) == 0.0
    assert carried(plan(overrides={"payload.mass": 80.0}), payload=20.0) == 20.0


def test_the_scenario_counts_before_its_machine():
    crane = hc.load_machine("rottne-f9-lab", {"payload.mass": 300.0})
    kept = hc.Scenario(machine=crane, joints=POSE, duration=0.02)
    own = hc.Scenario(machine=crane, joints=POSE, duration=0.02, payload=10.0)
    assert (carried(kept), carried(own), carried(own.changed(duration=0.01))) == (300.0, 10.0, 10.0)


@pytest.mark.parametrize(
    "contradiction",
    [
        lambda: plan(payload=50.0, overrides={"payload.mass": 200.0}),
        lambda: plan(payload=50.0).changed(payload=60.0, overrides={"payload.mass": "0.07 t"}),
        lambda: changed_plan(plan(), [Key("payload", "kg"), Key("payload.mass", "kg")], [10.0, 20.0]),
        lambda: plan(controller="tip", period=0.01, overrides={"control.period": "20 ms"}),
    ],
)
def test_two_values_at_once_are_an_error_that_names_both(contradiction):
    with pytest.raises(hc.InputError, match=r"`(payload|period)` is .*`(payload.mass|control.period)` is .*omit one"):
        contradiction()


def test_the_same_value_twice_is_none():
    assert carried(plan(payload=200.0, overrides={"payload.mass": "200 kg"})) == 200.0


def test_a_study_follows_the_rule():
    heavy = plan(payload=50.0)
    assert changed_plan(heavy, [Key("payload.mass", "kg")], [30.0]).payload is None
    swept = changed_plan(heavy.changed(overrides={"payload.mass": 1.0}), [Key("payload", "kg")], [30.0])
    assert (swept.payload, swept.overrides) == (30.0, {})


def test_period_and_full_speed_follow_the_rule():
    stick = hc.Joystick([0.0], {"x": [1.0]}, full_speed=0.2)
    driven = plan(joystick=stick, period=0.02)
    later = driven.changed(overrides={"control.period": 0.01, "control.tip.full-speed": "0.1 m/s"})
    assert later.load_machine().value("control.period").si == 0.01
    assert later.load_machine().value("control.tip.full-speed").si == 0.1
    back = later.changed(period=0.005, joystick=stick)
    assert back.load_machine().value("control.period").si == 0.005
    assert back.load_machine().value("control.tip.full-speed").si == 0.2
    both = changed_plan(driven, [Key("joystick.ramp", "s"), Key("control.tip.full-speed", "m/s")], [0.1, 0.3])
    assert both.load_machine().value("control.tip.full-speed").si == 0.3


def test_a_phase_does_not_change_the_load():
    with pytest.raises(hc.InputError, match="payload_changes"):
        plan(controller="tip", phases=[hc.Phase(0.01, {"payload.mass": 100.0})])


@pytest.mark.parametrize("interval", [1e-308, 4e-9, 5e-324])
def test_an_interval_that_no_file_may_state_is_refused(interval):
    with pytest.raises(hc.InputError, match=r"record_interval: .* beyond any use; usual is 0.1 ms"):
        plan(record_interval=interval)


def test_a_period_too_short_for_any_controller_is_refused():
    with pytest.raises(hc.InputError, match=r"period: 1e-9 s is beyond any use; usual is 0.2 ms to 1 s"):
        plan(controller=lambda obs, command: command, period=1e-9)


def test_a_record_within_bounds_is_not_refused():
    assert plan(record_interval=1e-5).record_times().size == 2001
    assert np.isclose(plan(record_interval=1e3).record_times(), [0.0, 0.02]).all()


def test_a_start_in_degrees_is_answered_in_degrees(tmp_path):
    path = tmp_path / "far.toml"
    path.write_text(
        '[scenario]\nname = "far"\nmachine = "rottne-f9-lab"\nduration = "1 s"\n'
        '[initial.joint]\nboom = "500 deg"\njib = "100 deg"\nextension = "0 m"\n'
    )
    with pytest.raises(
        hc.InputError, match=r"8\.72665 rad, 500 deg: more than a whole turn; its limits are [^;]* deg$"
    ):
        hc.simulate(path)


def test_the_rig_follows_the_rule():
    for given in (
        {"payload": 20.0, "overrides": {"payload.mass": 30.0}},
        {"supply": "90 bar", "overrides": {"supply.pressure": 1e7}},
    ):
        with pytest.raises(hc.InputError, match="both state the same; omit one"):
            hc.rig.run("step", **given)
