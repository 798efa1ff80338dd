"""What a run never reaches is said: times in ms, or since 1970."""

from __future__ import annotations

import pytest

import hydrocrane as hc

LIFT = "vertical-lift-open-loop"
SPOOL = [0.0, 0.01, 0.02, 0.0]


def said(plan: str | hc.Scenario = LIFT, **changes) -> list[str]:
    run = hc.simulate(plan, duration=changes.pop("duration", 0.2), **changes)
    return [warning.text for warning in run.warnings if warning.kind == "never-happens"]


@pytest.mark.parametrize("times", [[1.7e9 + i for i in range(4)], [-9.0, -8.0, -7.0, -6.0]], ids=["epoch", "before"])
@pytest.mark.parametrize("interpolation", ["hold", "linear"])
def test_commands_wholly_outside(times, interpolation):
    (text,) = said(commands={"lift": hc.Command(times, SPOOL, interpolation)})
    assert "`lift`" in text and " 0 lie within" in text


def test_commands_with_one_time_inside():
    (text,) = said(commands={"lift": hc.Command([0.0, 10.0, 20.0, 30.0], SPOOL)})
    assert "of the 4 times" in text and " 1 lie within" in text


MANY = {
    "jib": hc.Command([0.0, 1.0, 2.0], [0.0, 0.003, 0.0]),
    "extension": hc.Command([0.0, 3.0, 4.0], [0.0, 0.002, 0.0]),
}


@pytest.mark.parametrize(
    ("times", "told"),
    [
        ([0.0, 500.0, 1000.0], "1 lie within"),
        ([0.0, 60.0, 120.0], "1 lie within"),
        ([0.0, 1e-3, 2e-3], "the first 0.002 s"),
    ],
    ids=["ms", "min", "as ms"],
)
def test_one_command_of_several(times, told):
    (text,) = said(duration=5.0, commands={"lift": hc.Command(times, [0.0, 0.01, 0.0]), **MANY})
    assert "`lift`" in text and told in text


def test_a_duration_in_ms():
    texts = said(duration=0.003, commands=MANY, record_interval=0.001)
    assert ["of the 3 times of the command of" in text for text in texts] == [True, True]


def test_a_record_interval_beyond_the_end():
    (text,) = said(commands={"lift": 0.01}, record_interval=10.0)
    assert "record interval of 10 s" in text


def test_spools_in_another_unit():
    (text,) = said(commands={"lift": hc.Command([0.0, 0.1], [0.0, 1e-5]), "jib": 0.003})
    assert "`lift` moves its spool by 0.01 mm at most" in text


def test_check_says_it_without_a_run():
    plan = hc.load_scenario(LIFT).changed(duration=0.006)
    _, doubts = plan.start(plan.load_machine())
    assert {doubt.kind for doubt in doubts} == {"never-happens"}


def test_a_supply_pressure_and_sticks_outside():
    (text,) = said(supply=([1000.0, 2000.0, 3000.0], [140e5, 130e5, 120e5]))
    assert "supply pressure" in text
    stick = hc.Joystick([1000.0, 2000.0], {"z": [1.0, 0.0]})
    (text,) = said("tip-vertical-line", joystick=stick, goals=())
    assert "sticks" in text


def test_events_after_the_end():
    burst = hc.Burst("lift", "piston-side", time=500.0, opening=1e-6)
    assert ["bursts at 500 s" in text for text in said(bursts=[burst])] == [True]
    assert ["load" in text for text in said(payload_changes={2.0: 10.0})] == [True]
    fault = hc.SensorFault("joint.boom.q", "freeze", time=300.0)
    texts = said("tip-vertical-line", sensor_faults=[fault], phases=[hc.Phase(time=900.0, controller="lever")])
    assert any("`joint.boom.q` fails at 300 s" in text for text in texts)
    assert any("begins at 900 s" in text for text in texts)


def test_what_happens_is_not_warned_of():
    assert said(commands={"lift": 0.01}) == []
    assert said(commands={"lift": hc.Command([0.0, 10.0], [0.0, 0.01], "linear")}) == []
    # Runs that were only shortened.
    assert said(commands=MANY, duration=1.5) == said(commands=MANY, duration=0.1) == []
    assert said(commands={"lift": 0.01, "jib": 0.003, "extension": 0.002}) == []
    assert said(commands={"lift": hc.Command([0.0, 0.05, 0.1, 5.0], SPOOL)}, payload_changes={0.1: 10.0}) == []


def test_times_in_minutes():
    minutes = [t / 60.0 for t in (0.0, 0.5, 2.0, 2.5)]
    (text,) = said(duration=3.0, commands={"lift": hc.Command(minutes, [0.0, 0.01, 0.01, 0.0], "linear")})
    assert "within the first 0.0416667 s" in text
    stick = hc.Joystick(minutes, {"z": [0.0, 0.3, 0.3, 0.0]})
    (text,) = said("tip-vertical-line", joystick=stick, goals=(), duration=3.0)
    assert "all 4 times of the sticks" in text
    # What stays open moves until the end, and so does one that others follow.
    assert said(duration=3.0, commands={"lift": hc.Command(minutes, [0.0, 0.01, 0.01, 0.005])}) == []
    assert (
        said(duration=3.0, commands={"lift": hc.Command(minutes, SPOOL), "jib": hc.Command([0.0, 2.0], 2 * [1e-3])})
        == []
    )


@pytest.mark.parametrize("name", ["vertical-lift-open-loop", "tip-vertical-line"])
def test_a_drive_without_an_end_reaches_everything(name):
    live = hc.LiveSimulator(name)
    live.step()
    assert not live.warnings


@pytest.mark.parametrize("changes", [{"payload": 0.1}, {"payload_changes": {0.1: 0.05}}], ids=["t", "g"])
def test_a_load_in_another_unit(changes):
    run = hc.simulate(LIFT, duration=0.2, **changes)
    (warning,) = (warning for warning in run.warnings if warning.kind == "implausible-value")
    assert "kg is small" in warning.text and warning.key == f"scenario.{next(iter(changes)).replace('_', '-')}"
