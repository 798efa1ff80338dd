"""Tip control of cranes that slew: path, rest, limits, slope, and what says that it cannot be."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

NAME = "rottne-f9-forwarder"
START = {"slew": 0.3, "boom": np.deg2rad(105.0), "jib": np.deg2rad(115.0), "extension": 0.0}


def cylindrical(run: hc.Run, signal: str) -> np.ndarray:
    """Radius about the slewing axis, height and angle (m, 3) of `signal` over time."""
    x, y, z = (run.columns[f"{signal}.{axis}"].values for axis in ("x", "y", "z"))
    return np.column_stack([np.hypot(x, y), z, np.unwrap(np.arctan2(y, x))])


def driven(axes: dict[str, list[float]], time=(0.5, 3.5), duration=9.0, **changes) -> hc.Run:
    stick = hc.Joystick(list(time), axes, full_speed=changes.pop("full_speed", 0.3), ramp=0.3)
    changes.setdefault("joints", START)
    return hc.simulate(hc.Scenario(machine=NAME, joystick=stick, duration=duration, **changes), ledger=False)


def speed_of_tip(run: hc.Run) -> np.ndarray:
    velocity = [np.gradient(run.columns[f"tip.{axis}"].values, run.columns.time) for axis in ("x", "y", "z")]
    return np.linalg.norm(velocity, axis=0)


@pytest.mark.parametrize("payload", [0.0, 150.0])
def test_the_tip_keeps_a_path_along_all_three_axes(payload):
    """A load that the controller is not told; the path is that of radius, height and angle."""
    run = driven({"x": [0.3, 0.0], "z": [0.5, 0.0], "slew": [1.0, 0.0]}, payload=payload)
    assert run.outcome.completed
    wanted, tip = cylindrical(run, "set_point"), cylindrical(run, "tip")
    moved = wanted[-1] - wanted[0]
    assert moved[0] > 0.2 and moved[1] > 0.4 and moved[2] > 0.15
    assert np.abs(tip - wanted)[-1].max() < 5e-3
    assert np.nanmax(run.columns["tip.deviation"].values) < 0.02
    assert speed_of_tip(run)[run.columns.time > 8.0].max() < 1e-3


def test_the_slewing_axis_alone_is_a_circle():
    run = driven({"slew": [-1.0, 0.0]})
    tip, wanted = cylindrical(run, "tip"), cylindrical(run, "set_point")
    assert tip[-1, 2] - tip[0, 2] < -0.15
    assert np.ptp(wanted[:, 0]) < 1e-9 and np.ptp(wanted[:, 1]) < 1e-9
    assert np.ptp(tip[:, :2], axis=0).max() < 5e-3
    assert np.isfinite(run.columns["stick.slew"].values[-1])


def test_on_a_slope_and_with_data_sheet_sensors():
    run = driven(
        {"z": [0.5, 0.0], "slew": [1.0, 0.0]},
        payload=80.0, sensors="data-sheet", overrides={"environment.slope": "8 deg"},
    )  # fmt: skip
    assert run.outcome.completed and not [event for event in run.events if "stands" in event.text]
    assert np.nanmax(run.columns["tip.deviation"].values) < 0.03
    assert np.abs(cylindrical(run, "tip") - cylindrical(run, "set_point"))[-1].max() < 10e-3


def test_at_the_end_of_its_range_the_slewing_joint_stops_and_is_named():
    run = driven({"slew": [1.0, 0.0]}, time=(0.2, 6.0), joints=START | {"slew": 3.0}, duration=8.0, full_speed=0.5)
    high = run.machine.joint_limits[0, 1]
    assert run.columns["joint.slew.q"].values.max() < high
    assert any("out of the range of the joints: joint `slew`" in event.text for event in run.events)


def test_the_pillar_turns_with_the_crane():
    crane = hc.load_machine(NAME)
    beside, clear = crane.clearance([[0.0, 0.1, 0.0], [0.0, 2.2, 0.0]])
    assert beside == pytest.approx(-0.1) and clear == pytest.approx(1.21)
    run = driven(
        {"x": [-1.0, 0.0], "slew": [1.0, 0.0]}, time=(0.2, 10.0), duration=11.0,
        joints=START | {"boom": np.deg2rad(100.0), "jib": np.deg2rad(60.0)},
    )  # fmt: skip
    places = np.column_stack([run.columns[f"tip.{axis}"].values for axis in "xyz"])
    assert crane.clearance(places).min() > 0.0


@pytest.mark.parametrize("seed", [1, 2])
def test_random_sticks_for_a_minute(seed):
    random = np.random.default_rng(seed)
    time = np.cumsum(random.uniform(0.2, 1.5, 60))
    axes = {axis: random.uniform(-1.0, 1.0, time.size) for axis in ("x", "z", "slew")}
    stick = hc.Joystick(time, axes, ramp=0.1)
    load = float(random.uniform(0.0, 150.0))
    plan = hc.Scenario(machine=NAME, joints=START, joystick=stick, duration=60.0, payload=load, sensors="data-sheet")
    run = hc.simulate(plan, ledger=False)
    assert run.outcome.completed, run.outcome
    q = np.column_stack([run.columns[f"joint.{joint}.q"].values for joint in run.machine.joint_names])
    low, high = run.machine.joint_limits.T
    assert np.isfinite(q).all() and (q > low).all() and (q < high).all()
    assert all(np.isfinite(run.columns[f"controller.{c}"].values[1:]).all() for c in run.machine.cylinder_names)


def test_an_operator_takes_over():
    live = hc.LiveSimulator("forwarder-tip")
    assert live.axes == ("x", "z", "slew")
    live.set_stick(slew=-0.5)
    for _ in range(200):
        live.step()
    assert live.set_point[1] < -0.05
    live.set_stick()
    for _ in range(20):
        live.step()
    with pytest.raises(hc.InputError, match="this crane slews"):
        live.go_to(3.0, 0.5)


def test_a_controller_by_name_and_ones_own():
    crane = hc.load_machine(NAME)
    named, plant = hc.NamedController("tip", crane), hc.Simulator(crane)
    obs = plant.reset(q=list(START.values()))
    named.reset(crane, obs)
    named.step(obs, hc.Stick("tip", np.array([0.0, 0.2, 0.5])))
    np.testing.assert_allclose(named.set_point, crane.tip(list(START.values())), atol=1e-3)
    named.step(obs, hc.Stick("tip", np.zeros(2)))
    with pytest.raises(hc.InputError, match="a stick of mode `tip` has 4 axes; this crane takes 3"):
        named.step(obs, hc.Stick("tip", np.zeros(4)))

    class Own:
        set_point = (1.0, 2.0)

        def step(self, obs, command):
            assert command.axes.shape == (3,)
            return np.zeros(4)

    stick = hc.Joystick([0.0], {"slew": [1.0]})
    with pytest.raises(hc.InputError, match=r"must be \(x, y, z\) of the tip"):
        hc.simulate(hc.Scenario(machine=NAME, joints=START, joystick=stick, controller=Own(), duration=0.1))


def test_what_cannot_be_says_so(tmp_path):
    stick = hc.Joystick([0.0, 1.0], {"slew": [0.0, 1.0]})
    plane = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
    with pytest.raises(hc.InputError, match="machine `rottne-f9-lab` does not slew"):
        hc.simulate(hc.Scenario(joints=plane, joystick=stick, duration=1.0))
    with pytest.raises(hc.InputError, match="unknown stick axis `boom`"):
        hc.Joystick([0.0], {"boom": [1.0]})
    goal = hc.Scenario(machine=NAME, joints=START, goals=[hc.Goal(0.5, 3.0, 0.5)], duration=1.0)
    with pytest.raises(hc.InputError, match="this crane slews"):
        hc.simulate(goal)
    # A mast that leans has no plane along the vertical.
    leans = {"joint.slew.axis": "(0, 0.1, 1)"}
    with pytest.raises(hc.InputError, match="moves otherwise in space"):
        hc.simulate(hc.Scenario(machine=NAME, joints=START, joystick=stick, duration=1.0, overrides=leans))


def test_files_hold_the_third_axis(tmp_path):
    plan = hc.load_scenario("forwarder-tip")
    assert set(plan.joystick.axes) == {"x", "z", "slew"}
    plan.save(tmp_path / "again.toml")
    again = hc.load_scenario(tmp_path / "again.toml")
    np.testing.assert_array_equal(again.joystick.axes["slew"], plan.joystick.axes["slew"])
    flat = (
        (tmp_path / "again.toml")
        .read_text()
        .replace("rottne-f9-forwarder", "rottne-f9-lab")
        .replace('slew = "0 deg"', "")
    )
    (tmp_path / "flat.toml").write_text(flat)
    with pytest.raises(hc.HydrocraneError, match="slew"):
        hc.load_scenario(tmp_path / "flat.toml")


def test_an_excavator_moves_its_bucket_along_all_three_axes():
    """Out, up and to the left at once with 60 kg that nobody states, and back; a motor slews."""
    run = hc.simulate("excavator-tip", ledger=False)
    assert run.outcome.completed and not run.events and not run.warnings
    wanted, tip = cylindrical(run, "set_point"), cylindrical(run, "tip")
    there = np.searchsorted(run.columns.time, 6.4)
    assert (wanted[there] - wanted[0] > (0.6, 1.0, 0.65)).all()
    assert np.nanmax(run.columns["tip.deviation"].values) < 10e-3
    for at in (there, -1):
        assert np.linalg.norm((tip - wanted)[at] * (1.0, 1.0, tip[at, 0])) < 5e-3
        assert speed_of_tip(run)[at] < 2e-3


@pytest.mark.parametrize("setting", ["160 bar", "100 bar", "60 bar"])
def test_a_stop_asks_for_no_more_than_the_relief_valves_of_the_motor_hold(setting):
    """A motor whose relief valves open does not stop: at 60 bar the tip came back by 1.4 m, at 100 bar by 0.12 m."""
    overrides = {f"crossover-relief.slew-{side}.setting": setting for side in "ab"}
    stick = hc.Joystick([0.5, 2.5], {"slew": [1.0, 0.0]}, ramp=0.3)
    for joints, radius in ((0.7, 1.05, 0.7), 1.8), ((-0.26, 0.0, -0.35), 4.9):
        start = dict(zip(("slew", "boom", "arm", "bucket"), (-0.8, *joints), strict=True))
        plan = hc.Scenario(
            machine="sany-sy19e", joints=start, joystick=stick, payload=120.0, duration=8.0, overrides=overrides
        )
        run = hc.simulate(plan, ledger=False)
        angle = run.columns["joint.slew.q"].values
        assert radius * (angle.max() - angle[-1]) < 0.015, radius
        assert speed_of_tip(run)[-100:].max() < 3e-3
