"""Sensors that fail in a scenario, and the monitor that goes on without them or stops the crane."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.app.cli import main

POSE = {"boom": np.deg2rad(100), "jib": np.deg2rad(100), "extension": 0.0}
FILE = """[scenario]
name = "failing"
machine = "rottne-f9-lab"
duration = "5 s"
seed = 1
[initial.joint]
boom = "100 deg"
jib = "100 deg"
extension = "0 mm"
[controller]
sensors = "data-sheet"
[joystick]
time = ["0.2 s", "2 s", "4 s"]
z = [1, 0, 1]
full-speed = "0.2 m/s"
[sensor-fault.boom]
signal = "joint.boom.q"
kind = "freeze"
from = "1 s"
until = "3 s"
"""


def plan(**fields):
    stick = fields.pop("joystick", hc.Joystick([0.2, 2.0], {"z": [1.0, 0.0]}, full_speed=0.2, ramp=0.2))
    return hc.Scenario(joints=POSE, joystick=stick, sensors="data-sheet", **{"duration": 3.0, **fields})


def test_a_file_makes_a_sensor_fail_and_control_returns(tmp_path):
    path = tmp_path / "failing.toml"
    path.write_text(FILE, encoding="utf-8")
    scenario = hc.load_scenario(path)
    assert scenario.sensor_faults == (hc.SensorFault("joint.boom.q", "freeze", time=1.0, until=3.0),)
    run = hc.simulate(scenario)
    assert run.outcome.completed
    frozen, back = run.events
    assert "`joint.boom.q` is frozen" in frozen.text and 1.0 < frozen.time < 1.3
    assert "restarts" in back.text and 3.5 <= back.time < 3.8
    for words in ("`joint.boom.q` is frozen", back.text):
        assert words in run.summary()
    data = run.data
    held = data["controller.lift"].sel(time=slice(frozen.time + 0.12, back.time - 0.01))
    assert (held == 0).all()
    assert float(data["tip.z"][-1] - data["tip.z"].sel(time=4.0, method="nearest")) > 0.1, "it moves again"


@pytest.mark.evidence
def test_the_command_line_tells_of_it(tmp_path, capsys):
    path = tmp_path / "failing.toml"
    path.write_text(FILE, encoding="utf-8")
    with pytest.raises(SystemExit) as ended:
        main(["simulate", str(path), "-o", str(tmp_path), "--film", "none"])
    assert not ended.value.code
    shown = " ".join(capsys.readouterr().out.split())
    assert "`joint.boom.q` is frozen" in shown and "check the sensor and its cable" in shown


@pytest.mark.parametrize(
    ("changed", "into", "said"),
    [
        ("joint.boom.q", "joint.bom.q", "did you mean `joint.boom.q`"),
        ('"freeze"', '"frozen"', "did you mean `freeze`"),
        ('until = "3 s"', 'until = "0.5 s"', "after `from`"),
        ('until = "3 s"', 'size = "3 deg"', "only a jump has a size"),
    ],
)
def test_a_wrong_fault_in_a_file_is_one_clear_error(tmp_path, changed, into, said):
    path = tmp_path / "failing.toml"
    path.write_text(FILE.replace(changed, into), encoding="utf-8")
    with pytest.raises(hc.MachineFileError, match=said) as caught:
        hc.load_scenario(path)
    assert caught.value.line and caught.value.key.startswith("sensor-fault.boom")


def test_a_drop_out_that_lasts_stops_the_crane_and_the_run_goes_to_its_end():
    fault = hc.SensorFault("cylinder.lift.p1", "drop-out", time=1.0)
    run = hc.simulate(plan(sensor_faults=[fault]))
    assert run.outcome.completed and len(run.events) == 1
    tip = run.data["tip.z"].sel(time=slice(1.0, None))
    assert float(abs(tip - tip[0]).max()) < 40e-3
    assert (run.data["controller.lift"].sel(time=slice(2.7, None)) == 0).all()


def test_control_goes_on_through_a_short_drop_out_and_the_run_says_so():
    fault = hc.SensorFault("joint.jib.q", "drop-out", time=1.0, until=1.05)
    whole, torn = hc.simulate(plan()), hc.simulate(plan(sensor_faults=[fault]))
    (event,) = torn.events
    assert "`joint.jib.q` gives no reading" in event.text and "for 50 ms from 1.000 s" in event.text
    assert event.text in torn.summary()
    off = [float(abs(torn.data[name] - whole.data[name]).max()) for name in ("tip.x", "tip.z")]
    assert max(off) < 1e-3


def test_the_file_says_for_how_long_control_goes_on():
    fault = hc.SensorFault("joint.jib.q", "drop-out", time=1.0, until=1.05)
    run = hc.simulate(plan(sensor_faults=[fault], overrides={"control.plausibility.ride-through": "0 ms"}))
    assert run.events[0].time == pytest.approx(1.0) and "the crane stops" in run.events[0].text


def test_without_the_monitor_it_ends_the_run():
    fault = hc.SensorFault("joint.jib.q", "drop-out", time=1.0)
    run = hc.simulate(plan(sensor_faults=[fault], monitor=False))
    assert run.outcome.kind == "controller-failed" and run.outcome.time == pytest.approx(1.09)


def test_a_controller_of_ones_own_is_watched_on_request():
    class Lift:
        starts = 0

        def reset(self, crane, obs):
            self.starts += 1
            assert np.isfinite(obs.q).all()

        def step(self, obs, command):
            return [0.01 * command.axes[1], 0.0, 0.0]

    fault = hc.SensorFault("joint.jib.q", "jump", time=1.0, size=0.1, until=1.5)
    unwatched, watched = Lift(), Lift()
    assert hc.simulate(plan(controller=unwatched, sensor_faults=[fault])).events == ()
    run = hc.simulate(plan(controller=watched, sensor_faults=[fault], monitor=True))
    assert [round(event.time, 2) for event in run.events] == [1.05, 2.2]
    assert (unwatched.starts, watched.starts) == (1, 2)


def test_lever_control_measures_nothing_and_minds_nothing():
    fault = hc.SensorFault("joint.boom.q", "drop-out")
    stick = hc.Joystick([0.2], {"lift": [0.3]}, mode="lever")
    run = hc.simulate(plan(joystick=stick, sensor_faults=[fault], duration=1.0))
    assert run.outcome.completed and run.events == ()


def test_wrong_faults_are_refused():
    with pytest.raises(hc.InputError, match="end after it begins"):
        hc.SensorFault("joint.boom.q", "freeze", time=2.0, until=1.0)
    with pytest.raises(hc.InputError, match="size"):
        hc.SensorFault("joint.boom.q", "jump", size=np.nan)
    with pytest.raises(hc.InputError, match="need a controller"):
        hc.Scenario(joints=POSE, sensor_faults=[hc.SensorFault("joint.boom.q", "freeze")])
    with pytest.raises(hc.InputError, match="monitor must be"):
        plan(monitor="on")
    with pytest.raises(hc.InputError, match="one number"):
        hc.SensorFault("joint.boom.q", "freeze", time=[1.0, 2.0])
