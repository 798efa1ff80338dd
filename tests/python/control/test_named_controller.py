"""Controllers by name, stepped by a program: the same as in a scenario, to the bit."""

import numpy as np
import pytest

import hydrocrane as hc

START = np.array([np.deg2rad(100.0), np.deg2rad(100.0), 0.0])
JOINTS = dict(zip(("boom", "jib", "extension"), START.tolist(), strict=True))
UP = hc.Joystick([0.0, 0.3, 1.0], {"x": [0.0, 0.2, 0.0], "z": [0.0, 0.5, 0.0]})


@pytest.mark.parametrize("name", ["tip", "heinze-pid"])
@pytest.mark.parametrize("sensors", ["ideal", "data-sheet"])
def test_a_scenario_runs_it_as_it_runs_the_name(name, sensors):
    joystick = hc.Joystick([0.0, 0.3, 1.0], {"x": [0.0, 0.2, 0.0], "z": [0.0, 0.5, 0.0]}, full_speed=None)
    common = {"joints": JOINTS, "joystick": joystick, "duration": 1.5, "sensors": sensors, "period": 0.01}
    overrides = {"control.period": "10 ms"}
    named = hc.simulate(hc.Scenario(controller=name, **common))
    crane = hc.load_machine("rottne-f9-lab", overrides=overrides)
    stepped = hc.NamedController(name, crane)
    own = hc.simulate(hc.Scenario(controller=stepped, **common))
    assert stepped.fault is None and stepped.period == 0.01
    for signal in ("tip.x", "tip.z", "cylinder.lift.p1"):
        assert np.array_equal(named.data[signal].values, own.data[signal].values), signal


def test_it_drives_a_simulator_and_tells_its_set_point():
    crane = hc.load_machine("rottne-f9-lab")
    plant, controller = hc.Simulator(crane), hc.NamedController("tip", crane)
    obs = plant.reset(q=START)
    controller.reset(crane, obs)
    start = obs.tip
    for k in range(200):
        stick = hc.Stick("tip", np.array([0.0, 0.2 if k < 100 else 0.0]))
        obs = plant.step(controller.step(obs, stick))
    assert np.linalg.norm(obs.tip - np.array(controller.set_point)) < 1e-3
    assert obs.tip[1] - start[1] > 0.05


def test_what_it_reads_are_the_sensors():
    crane = hc.load_machine("rottne-f9-lab")
    plant, controller = hc.Simulator(crane, sensors="data-sheet", seed=3), hc.NamedController("tip", crane)
    obs = plant.reset(q=START)
    controller.reset(crane, obs)
    missing = {**obs.measured, "joint.boom.q": np.nan}
    broken = hc.Observation(t=obs.t, q=obs.q, qd=obs.qd, p=obs.p, tip=obs.tip, measured=missing)
    centred = hc.Stick("tip", np.zeros(2))
    controller.step(obs, centred)
    for k in range(1, 30):
        now = hc.Observation(t=k * 0.01, q=obs.q, qd=obs.qd, p=obs.p, tip=obs.tip, measured=broken.measured)
        controller.step(now, centred)
    assert any("joint.boom.q" in text for text in controller.notices), controller.notices


def test_wrong_use_is_told():
    crane = hc.load_machine("rottne-f9-lab")
    with pytest.raises(hc.InputError, match="tip"):
        hc.NamedController("tipp")
    with pytest.raises(hc.InputError, match="delay"):
        hc.NamedController("tip", delay=-1.0)
    obs = hc.Simulator(crane).reset(q=START)
    with pytest.raises(hc.SimulationError, match="reset"):
        hc.NamedController("tip").step(obs, hc.Stick("tip", np.zeros(2)))
    with pytest.raises(hc.SimulationError, match="machine"):
        _ = hc.NamedController("tip").period
    controller = hc.NamedController("tip")
    controller.reset(crane, obs)
    with pytest.raises(hc.InputError, match="3 axes"):
        controller.step(obs, hc.Stick("tip", np.zeros(3)))
    assert controller.step(obs, hc.Stick("lever", np.zeros(3))) == [0.0, 0.0, 0.0]
    assert "tip" in controller.fault
    with pytest.raises(hc.InputError, match="1 joint"):
        controller.reset("single-cylinder", obs)
