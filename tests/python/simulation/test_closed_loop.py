"""Controllers in scenarios and in the stepping loop: sampling, sticks, sensors, faults."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat

import hydrocrane as hc
from hydrocrane.results.samples import distance_to_path

POSE = {"boom": np.deg2rad(100), "jib": np.deg2rad(100), "extension": 0.0}


def plan(**fields):
    return hc.Scenario(joints=POSE, **{"duration": 0.5, **fields})


class Servo:
    """Holds the pistons where they were; raises the lift's by the stick."""

    gain = 3.0

    def reset(self, crane, obs):
        self.crane, self.wanted = crane, crane.strokes(obs.q)
        self.seen = []

    def step(self, obs, command):
        self.seen.append(obs)
        if command.mode == "tip":
            self.wanted[0] += 0.01 * 0.05 * command.axes[1]
        return self.gain * (self.wanted - self.crane.strokes(obs.q))


# --- one's own controller in a scenario -------------------------------------------------------------------------------


def test_an_object_runs_in_a_scenario_and_leaves_its_samples():
    law = Servo()
    run = hc.simulate(plan(controller=law, joystick=hc.Joystick([0.1], {"z": [1.0]}), duration=1.0))
    assert run.outcome.completed, run.outcome
    data = run.data
    assert len(law.seen) == 100
    np.testing.assert_allclose([obs.t for obs in law.seen], np.arange(100) * 0.01, atol=1e-12)
    assert data["stick.z"].values[5] == 0.0 and data["stick.z"].values[50] == 1.0
    # Ideal sensors read the state of their own sample, which the record holds until the next one.
    np.testing.assert_allclose(data["measured.joint.boom.q"], np.append(data["joint.boom.q"][:-1], law.seen[-1].q[0]))
    assert data["cylinder.lift.x"].values[-1] > data["cylinder.lift.x"].values[0] + 0.005
    for name in ("measured.cylinder.lift.p1", "controller.lift", "stick.x"):
        assert data[name].attrs["units"] and data[name].attrs["long_name"]
    assert data.attrs["controller"] == "Servo" and run.events == ()


def test_a_scenario_and_a_loop_of_ones_own_give_the_same():
    joystick = hc.Joystick([0.1], {"z": [1.0]})
    run = hc.simulate(plan(controller=Servo(), joystick=joystick, duration=1.0))
    crane = hc.load_machine("rottne-f9-lab")
    simulator = hc.Simulator(crane, 0.01)
    obs = simulator.reset(q=list(POSE.values()))
    law = Servo()
    law.reset(crane, obs)
    for _ in range(100):
        obs = simulator.step(law.step(obs, joystick.at(obs.t)))
    last = [float(run.data[name][-1]) for name in crane.state_names]
    np.testing.assert_allclose(simulator.state[:3], last[:3], atol=2e-6)


def test_a_function_is_a_controller_too():
    def lift(obs, command):
        return [0.02 * command.axes[1], 0.0, 0.0]

    run = hc.simulate(plan(controller=lift, joystick=hc.Joystick([0.0], {"z": [0.5]}, ramp=0.2)))
    assert run.outcome.completed and run.data.attrs["controller"] == "lift"
    assert run.data["controller.lift"].values[-1] == pytest.approx(0.01)
    np.testing.assert_allclose(run.data["stick.z"].values[:11], np.minimum(np.arange(11) * 0.05, 0.5), atol=1e-12)


def test_period_and_delay_are_kept():
    times = []

    def step(obs, command):
        times.append(obs.t)
        return [0.01, 0.0, 0.0]

    run = hc.simulate(plan(controller=step, period=0.02, delay=0.015, duration=0.1, record_interval=0.001))
    np.testing.assert_allclose(times, [0.0, 0.02, 0.04, 0.06, 0.08], atol=1e-12)
    command = run.data["cylinder.lift.command"].values
    assert (command[:15] == 0).all() and (command[16:] == 0.01).all()


def test_a_set_point_gives_the_deviation_from_its_way():
    class Still:
        def reset(self, crane, obs):
            self.set_point = obs.tip + [0.03, 0.04]

        def step(self, obs, command):
            return np.zeros(3)

    data = hc.simulate(plan(controller=Still(), duration=0.1)).data
    np.testing.assert_allclose(data["tip.deviation"], 0.05, atol=1e-5)
    np.testing.assert_allclose(data["set_point.z"] - data["tip.z"], 0.04, atol=1e-5)


def test_distance_to_a_path():
    path = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 0.0], [2.0, 1.0], [np.nan, 0.0]])
    points = np.array([[1.0, 0.5], [3.0, 0.5], [-3.0, -4.0], [2.0, 1.0]])
    np.testing.assert_allclose(distance_to_path(points, path), [0.5, 1.0, 5.0, 0.0])


# --- faults -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        ([np.nan, 0, 0], "not a finite number"),
        ([0.0], "1 spool commands for 3 cylinders"),
        ("garbage", "ValueError"),
        (None, "TypeError"),
    ],
)
def test_garbage_closes_the_valves_and_ends_the_run(answer, said):
    garbage = plan(controller=lambda obs, command: [0.02, 0, 0] if obs.t < 0.095 else answer)
    run = hc.simulate(garbage, on_error="neutral")
    assert run.outcome.kind == "controller-failed" and said in run.outcome.message
    assert run.outcome.time == pytest.approx(0.19)
    assert run.events[0].time == pytest.approx(0.1) and "neutral" in run.events[0].text
    data = run.data
    assert data["controller.lift"].values[-1] == 0.0 and data.time.values[-1] == pytest.approx(0.19)
    assert all(np.isfinite(data[name]).all() for name in data.data_vars)


def test_an_exception_that_passes_is_an_event_and_the_run_goes_on():
    def step(obs, command):
        if 0.095 < obs.t < 0.125:
            raise ArithmeticError("lost it")
        return [0.01, 0.0, 0.0]

    run = hc.simulate(plan(controller=step), on_error="neutral")
    assert run.outcome.completed
    assert [round(event.time, 6) for event in run.events] == [0.1, 0.13]
    assert "0.100 s" in run.summary() and "lost it" in run.summary()
    assert "lost it" in run.events[0].text and "again after 3 samples" in run.events[1].text


class Unwilling:
    def reset(self, crane, obs):
        raise RuntimeError("no model of this crane")

    def step(self, obs, command):
        return np.zeros(3)


class Misplaced:
    """Its set-point is no point."""

    set_point = "here"

    def step(self, obs, command):
        return np.zeros(3)


def lost(obs, command):
    if obs.t > 0.195:
        raise ArithmeticError("lost it")
    return [0.01, 0.0, 0.0]


def test_an_exception_is_raised_again_with_its_traceback_and_the_run():
    with pytest.raises(ArithmeticError, match="lost it") as caught:
        hc.simulate(plan(controller=lost))
    assert caught.traceback[-1].name == "lost" and str(caught.traceback[-1].path) == __file__
    assert "t = 0.2 s" in caught.value.__notes__[0] and "`run`" in caught.value.__notes__[0]
    run = caught.value.run
    assert run.outcome.kind == "controller-failed" and run.outcome.time == pytest.approx(0.2)
    assert run.data.time.values[-1] == pytest.approx(0.2)
    assert float(run.data["cylinder.lift.x"][-1]) > float(run.data["cylinder.lift.x"][0])


def test_an_exception_can_end_the_run_with_its_place():
    run = hc.simulate(plan(controller=lost), on_error="stop")
    assert run.outcome.kind == "controller-failed" and run.outcome.time == pytest.approx(0.2)
    line = lost.__code__.co_firstlineno + 2
    assert run.outcome.message == f"ArithmeticError: lost it ({__file__}, line {line}, in lost)"
    assert [(event.time, event.text) for event in run.events] == [
        (pytest.approx(0.2), f"{run.outcome.message}; the run ends")
    ]


def test_the_place_of_an_exception_in_the_package_does_not_tell_where_it_is_installed():
    crane = hc.load_machine("rottne-f9-lab")
    run = hc.simulate(plan(controller=lambda obs, command: crane.tip(np.nan * obs.q)), on_error="stop")
    assert "(hydrocrane/arrays.py, line " in run.outcome.message


@pytest.mark.parametrize(
    ("controller", "error", "said"),
    [
        (Unwilling(), RuntimeError, "no model of this crane"),
        (Misplaced(), hc.InputError, r"set_point of the controller must be \(x, z\) of the tip"),
        (lambda obs, command: [0.0], hc.InputError, r"1 spool commands for 3 cylinders \(lift, jib, extension\)"),
        (lambda obs, command: "garbage", hc.InputError, "not a list of 3 spool commands in m"),
    ],
)
def test_whatever_a_controller_gets_wrong_is_raised(controller, error, said):
    with pytest.raises(error, match=said):
        hc.simulate(plan(controller=controller))
    run = hc.simulate(plan(controller=controller), on_error="stop")
    assert run.outcome.kind == "controller-failed" and run.outcome.time == 0.0


def test_an_exception_after_a_phase_is_raised_too():
    phases = [hc.Phase(0.2, controller=lost)]
    with pytest.raises(ArithmeticError, match="lost it"):
        hc.simulate(plan(controller=Servo(), phases=phases))


def test_on_error_must_be_a_known_choice():
    with pytest.raises(hc.InputError, match="did you mean `raise`"):
        hc.simulate(plan(controller=lost), on_error="rise")


def test_events_survive_a_file(tmp_path):
    run = hc.simulate(plan(controller=lambda obs, command: [np.nan] * 3))
    path = run.save(tmp_path / "run.nc")
    assert hc.load_run(path).events == run.events != ()


# --- sensors ----------------------------------------------------------------------------------------------------------


def readings(seed, **more):
    simulator = hc.Simulator(hc.load_machine("rottne-f9-lab"), sensors="data-sheet", seed=seed, **more)
    simulator.reset(q=list(POSE.values()))
    return [simulator.step([0.02, 0.0, 0.0]).measured for _ in range(20)]


def test_measured_values_come_from_the_sensors_of_the_machine():
    one, again, other = readings(1), readings(1), readings(2)
    assert one == again and one != other
    counts = np.array([row["joint.boom.q"] for row in one]) / np.deg2rad(0.09)
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    assert {"cylinder.lift.force", "joint.extension.q", "cylinder.jib.p2"} <= set(one[0])


def test_a_reset_repeats_the_readings():
    simulator = hc.Simulator(hc.load_machine("rottne-f9-lab"), sensors="data-sheet", seed=5)

    def drive():
        simulator.reset(q=list(POSE.values()))
        return [simulator.step([0.02, 0.0, 0.0]).measured for _ in range(5)]

    assert drive() == drive()


def test_ideal_sensors_read_the_state():
    crane = hc.load_machine("rottne-f9-lab")
    simulator = hc.Simulator(crane)
    obs = simulator.reset(q=list(POSE.values()))
    for _ in range(5):
        obs = simulator.step([0.02, 0.01, -0.01])
        for name, value in obs.measured.items():
            if name in crane.state_names:
                assert value == simulator.state[crane.state_names.index(name)]


def test_sensors_fail_when_told_to():
    fault = hc.SensorFault("joint.boom.q", "drop-out", time=0.1)
    boom = [row["joint.boom.q"] for row in readings(0, sensor_faults=[fault])]
    assert np.isfinite(boom[:9]).all() and np.isnan(boom[9:]).all()
    law = Servo()
    run = hc.simulate(plan(controller=law, sensor_faults=[fault]), on_error="neutral")
    assert run.outcome.kind == "controller-failed", "the servo makes nothing of NaN"
    assert run.outcome.time == pytest.approx(0.19)


# --- sticks -----------------------------------------------------------------------------------------------------------


def test_lever_control_opens_each_spool_by_its_axis():
    joystick = hc.Joystick([0.0], {"lift": [0.5], "extension": [-0.2]}, mode="lever")
    data = hc.simulate(plan(joystick=joystick)).data
    assert data.attrs["controller"] == "lever"
    assert data["controller.lift"].values[0] == pytest.approx(0.025)
    assert data["controller.extension"].values[0] == pytest.approx(-0.01)
    assert (data["controller.jib"] == 0).all()


@pytest.mark.parametrize("suffix", [".csv", ".mat"])
def test_a_stick_from_a_log(tmp_path, suffix):
    path = tmp_path / f"stick{suffix}"
    table = {"time": [0.0, 1.0, 2.0], "x": [0.0, 0.5, 0.5], "z": [0.0, -1.0, 1.0], "voltage": [5.0, 5.0, 5.0]}
    if suffix == ".mat":
        savemat(path, {name: np.array(values) for name, values in table.items()})
    else:
        rows = ["time,x,z,voltage", *(",".join(map(str, row)) for row in zip(*table.values(), strict=True))]
        path.write_text("\n".join(rows), encoding="utf-8")
    joystick = hc.Joystick.from_log(path, full_speed=0.1)
    np.testing.assert_allclose(joystick.at(0.5).axes, [0.25, -0.5])
    np.testing.assert_allclose(joystick.at(1.5).velocity, [0.05, 0.0])


def test_a_scenario_file_with_levers_and_a_log(tmp_path):
    (tmp_path / "sticks.csv").write_text("time,lift,jib\n0,0,0\n0.2,0.4,-0.2\n", encoding="utf-8")
    (tmp_path / "own.toml").write_text(
        '[scenario]\nname = "own"\nmachine = "rottne-f9-lab"\nduration = "0.5 s"\nseed = 3\n'
        '[initial.joint]\nboom = "100 deg"\njib = "100 deg"\nextension = "0 m"\n'
        '[controller]\nperiod = "20 ms"\ndelay = "2 ms"\nsensors = "data-sheet"\n'
        '[joystick]\nmode = "lever"\nlog = "sticks.csv"\n',
        encoding="utf-8",
    )
    scenario = hc.load_scenario(tmp_path / "own.toml")
    assert (scenario.controller, scenario.period, scenario.sensors) == ("lever", 0.02, "data-sheet")
    run = hc.simulate(scenario)
    assert run.outcome.completed
    assert run.data["stick.lift"].values[-1] == pytest.approx(0.4)
    assert run.data["controller.jib"].values[-1] == pytest.approx(-0.01)


@given(st.lists(st.tuples(st.floats(0.01, 3.0), *[st.floats(-1, 1)] * 3), min_size=1, max_size=40), st.integers(0, 99))
@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_no_sequence_of_sticks_makes_a_nan(moves, seed):
    """A simulated minute of lever control with the sensors of the data sheets."""
    time = np.cumsum([move[0] for move in moves])
    names = ("lift", "jib", "extension")
    axes = {name: [move[i] for move in moves] for i, name in enumerate(names, start=1)}
    joystick = hc.Joystick(time, axes, mode="lever", ramp=0.2)
    minute = plan(joystick=joystick, sensors="data-sheet", seed=seed, duration=60.0, record_interval=0.05)
    run = hc.simulate(minute, ledger=False)
    assert run.outcome.completed, run.outcome
    assert all(np.isfinite(run.data[name]).all() for name in run.data.data_vars)


def test_rounding_never_shuts_the_spools():
    """A row a rounding error after the sample that it is meant for, and deflections a rounding error beyond the end."""
    begin = 0.1 + 0.2
    assert begin > 30 * 0.01
    axes = {"x": [0.0, 1.0, -1.0, 0.0], "z": [0.0, *np.nextafter([-1.0, 1.0], [-2.0, 2.0]), 0.0]}
    joystick = hc.Joystick([0.1, begin, begin + 0.01, 0.6], axes, interpolation="linear", full_speed=0.05)
    assert max(np.abs(joystick.at(t).axes).max() for t in np.arange(100) * 0.01) <= 1.0
    run = hc.simulate(plan(controller="tip", joystick=joystick, duration=1.0), ledger=False)
    assert run.events == () and float(np.abs(run.data["stick.z"]).max()) <= 1.0


# --- bad input --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"controller": "tipp"}, "did you mean `tip`"),
        ({"controller": Servo}, r"give an instance, Servo\(\)"),
        ({"controller": 3}, "a controller is a name"),
        ({"controller": "tip", "commands": {"lift": 0.01}}, "not both"),
        ({"controller": "tip", "sensors": "real"}, "unknown kind of sensors"),
        ({"controller": "tip", "delay": -1.0}, "delay"),
        ({"controller": "tip", "period": 0.0}, "period"),
        ({"controller": "lever", "joystick": hc.Joystick([0.0], {"x": [1.0]})}, "does not support the stick mode"),
    ],
)
def test_a_wrong_loop_is_refused(fields, said):
    with pytest.raises(hc.InputError, match=said):
        plan(**fields)


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"axes": {"y": [0.0]}}, "unknown stick axis `y`"),
        ({"axes": {"x": [1.5]}}, "a stick ends at 1"),
        ({"axes": {"x": [0.0, 1.0]}}, "for 1 times"),
        ({"mode": "tipp"}, "did you mean `tip`"),
        ({"dead_zone": 1.0}, "dead_zone"),
        ({"full_speed": 0.0}, "full_speed"),
        ({"ramp": -1.0}, "ramp"),
    ],
)
def test_a_wrong_joystick_is_refused(fields, said):
    with pytest.raises(hc.InputError, match=said):
        hc.Joystick([0.0], **fields)


def test_a_fault_of_an_unknown_signal_names_the_known_ones():
    with pytest.raises(hc.InputError, match=r"joint\.bom\.q.*joint\.boom\.q"):
        hc.simulate(plan(controller=Servo(), sensor_faults=[hc.SensorFault("joint.bom.q", "freeze")]))


# --- controllers of the package ---------------------------------------------------------------------------------------


def test_tip_control_from_a_file_moves_the_tip_as_the_stick_says(tmp_path):
    """2.8 s of full stick, less half a ramp at its begin and as much more at its end, at 0.1 m/s: 280 mm up."""
    (tmp_path / "up.toml").write_text(
        '[scenario]\nname = "up"\nmachine = "rottne-f9-lab"\nduration = "5 s"\n'
        '[initial.joint]\nboom = "100 deg"\njib = "100 deg"\nextension = "0 m"\n'
        '[controller]\nname = "tip"\nperiod = "20 ms"\n'
        '[joystick]\ntime = ["0.2 s", "3 s"]\nz = [1, 0]\nfull-speed = "0.1 m/s"\nramp = "0.2 s"\n',
        encoding="utf-8",
    )
    run = hc.simulate(tmp_path / "up.toml")
    assert run.outcome.completed and run.events == ()
    data = run.data
    assert float(data["set_point.z"][-1] - data["set_point.z"][0]) == pytest.approx(0.28, abs=2e-3)
    assert float(data["tip.z"][-1] - data["tip.z"][0]) == pytest.approx(0.28, abs=5e-3)
    assert float(data["tip.deviation"].max()) < 5e-3
    assert data.attrs["controller"] == "tip" and "control.period" in data.attrs["machine_overrides"]


@pytest.mark.parametrize("name", ["tip", "heinze-pid"])
def test_full_speed_scales_the_way(name):
    ways = []
    for speed in (0.02, 0.04):
        joystick = hc.Joystick([0.1, 0.9], {"z": [1.0, 0.0]}, full_speed=speed)
        data = hc.simulate(plan(controller=name, joystick=joystick, duration=2.0, period=0.01), ledger=False).data
        ways.append(float(data["set_point.z"][-1] - data["set_point.z"][0]))
    assert ways[1] == pytest.approx(2 * ways[0], rel=0.02)
    assert ways[0] == pytest.approx(0.016, rel=0.05)
