"""The sensor monitor leaves machines in order alone, whatever their size and supply, and finds what it is for."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

PUMP = """extends = "hiab-xs031"
[machine]
name = "hiab-ls"
class = "assumed"
source = "a test"
[pump.main]
type = "load-sensing"
displacement = "60 ml"
speed = "2000 rpm"
volumetric-efficiency = 0.95
hydromechanical-efficiency = 0.92
control-range = "10 bar"
time-constant = "80 ms"
ls-margin = "20 bar"
[mains]
volume = "2 l"
[valve.lift]
compensator = "behind-spool"
[valve.tilt]
compensator = "behind-spool"
[valve.extension]
compensator = "behind-spool"
"""
#: A converter whose steps are as wide as its noise: a reading repeats as often as not.
COARSE = """extends = "rottne-f9-lab"
[machine]
name = "coarse"
class = "assumed"
source = "a test"
""" + "".join(
    f'[sensor.{c}-p{side}]\nmeasures = "cylinder.{c}.p{side}"\nkind = "pressure-transmitter"\n'
    'range = "600 bar"\nbits = 10\nnoise = 0.0005\n'
    for c in ("lift", "jib", "extension")
    for side in (1, 2)
)
SHORT = """extends = "hiab-xs031"
[machine]
name = "wired"
class = "assumed"
source = "a test"
[sensor.length]
measures = "joint.extension.q"
kind = "wire-potentiometer"
range = "{range}"
{offset}
"""
POSE = {"boom": np.deg2rad(100), "jib": np.deg2rad(100), "extension": 0.0}


def written(folder, text: str) -> str:
    path = folder / "machine.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def stops(run) -> list[str]:
    return [str(warning) for warning in run.warnings if warning.kind == "sensor-stop"]


def sticks(seed: int, duration: float, speed: float) -> hc.Joystick:
    rng = np.random.default_rng(seed)
    times = np.arange(0.5, duration, 1.0)
    x, z = (rng.uniform(-1, 1, times.size) for _ in range(2))
    x[-1] = z[-1] = 0
    return hc.Joystick(times, {"x": x, "z": z}, full_speed=speed)


@pytest.mark.parametrize(("seed", "speed"), [(4, 0.6), (3, 1.0)])
def test_a_machine_on_a_load_sensing_pump_is_not_stopped(tmp_path, seed, speed):
    start = {"lift": np.deg2rad(30), "tilt": np.deg2rad(-60), "extension": 0.3}
    machine = written(tmp_path, PUMP)
    run = hc.simulate(hc.Scenario(machine=machine, joints=start, joystick=sticks(seed, 8.0, speed), duration=8.0))
    assert run.outcome.completed and not stops(run), stops(run)


def test_readings_that_repeat_by_chance_are_not_called_frozen(tmp_path):
    machine = written(tmp_path, COARSE)
    up = hc.Joystick([0.2, 3.0], {"z": [1.0, 0.0]}, full_speed=0.5, ramp=0.2)
    plan = hc.Scenario(machine=machine, joints=POSE, joystick=up, duration=4.0, sensors="data-sheet")
    for seed in range(4):
        run = hc.simulate(plan.changed(seed=seed))
        assert run.outcome.completed and not stops(run), stops(run)


def test_a_supply_that_is_turned_down_leaves_ratings_and_sensors_as_they_are():
    hold = hc.Joystick([0.5, 1.5], {"z": [0.0, 0.0]}, full_speed=0.1)
    down = hc.Phase(time=0.5, overrides={"supply.pressure": "40 bar"})
    run = hc.simulate(hc.Scenario(joints=POSE, joystick=hold, duration=2.0, sensors="data-sheet", phases=[down]))
    assert run.outcome.completed and not stops(run), stops(run)
    assert not [w for w in run.warnings if w.kind == "pressure-above-rating"], run.warnings


def test_what_is_out_of_range_is_called_what_it_is():
    wild = hc.SensorFault("cylinder.lift.p1", "jump", time=0.5, size=600e5)
    still = hc.Joystick([0.2], {"z": [0.0]}, full_speed=0.1)
    plan = hc.Scenario(joints=POSE, joystick=still, duration=1.0, sensors="data-sheet", sensor_faults=[wild])
    (text,) = stops(hc.simulate(plan))
    assert "the machine cannot have this pressure" in text and "<name>" not in text


def test_a_range_that_lies_elsewhere_is_named_and_an_offset_mends_it(tmp_path):
    low, high = hc.load_machine("hiab-xs031").joint_limits[2]
    wide = f"{1.05 * (high - low):.4f} m"
    (warning,) = hc.load_machine(written(tmp_path, SHORT.format(range=wide, offset=""))).warnings
    assert "joint.extension.q" in str(warning) and "offset" in warning.cure
    middle = f'offset = "{0.5 * (low + high):.4f} m"'
    assert not hc.load_machine(written(tmp_path, SHORT.format(range=wide, offset=middle))).warnings
    (warning,) = hc.load_machine(written(tmp_path, SHORT.format(range="0.1 m", offset=middle))).warnings
    assert "range of" in warning.cure
    crane = hc.load_machine(written(tmp_path, SHORT.format(range=wide, offset=middle)))
    plan = hc.Scenario(machine=crane, joints={"lift": 0.35, "tilt": -1.22, "extension": float(high) - 0.05})
    still = plan.changed(joystick=hc.Joystick([0.1], {"z": [0.0]}, full_speed=0.1), sensors="data-sheet", duration=0.3)
    run = hc.simulate(still)
    assert float(run.data["measured.joint.extension.q"][-1]) == pytest.approx(float(high) - 0.05, abs=5e-3)


@pytest.mark.parametrize("seed", [1, 4, 6])
def test_a_controller_that_takes_over_a_moving_crane_accuses_no_sensor(seed: int) -> None:
    """Each phase has a controller of its own, whose monitor sent nothing before; the supply is turned down."""
    rng, duration = np.random.default_rng(seed), 6.0
    times = np.arange(0.3, duration - 0.5, 0.7)
    x, z = rng.uniform(-1.0, 1.0, (2, len(times)))
    stick = hc.Joystick([*times, duration - 0.5], {"x": [*x, 0.0], "z": [*z, 0.0]}, ramp=0.05)
    turned = {3.0: {"supply.pressure": 0.4 * hc.load_machine("hiab-xs031").supply_pressure}}
    phases = [
        hc.Phase(time, overrides=turned.get(time, {}), controller="tip", joystick=stick) for time in (1.6, 3.0, 4.4)
    ]
    start = {"lift": 0.35, "tilt": -1.22, "extension": 0.3}
    run = hc.simulate(
        hc.Scenario(
            machine="hiab-xs031", joints=start, controller="tip", joystick=stick, phases=phases, duration=duration
        )
    )
    assert not [event.text for event in run.events if "no other reading confirms" in event.text]


ENCODER = """extends = "hiab-xs031"
[machine]
name = "counted"
class = "assumed"
source = "a test"
[sensor.lift]
measures = "joint.lift.q"
kind = "incremental-encoder"
pulses = 5000
"""


def accused(machine: str, acceleration: float, step: float) -> list[str]:
    """What `tip` says when both pressures of the lift cylinder read nothing for 0.1 s.

    Its joint then has a share of the `acceleration` of a free fall, read in whole steps (rad; 0: exactly).
    """
    crane, q0 = hc.load_machine(machine), np.array([0.1, -0.4, 0.5])
    obs = hc.Simulator(crane).reset(q=q0)
    lever = np.diff(crane.strokes(np.array([q0, q0 + [1e-6, 0.0, 0.0]]))[:, 0])[0] / 1e-6
    falls = -crane.static_cylinder_force(q0)[0] * lever / crane.mass_matrix(q0)[0, 0]
    controller = hc.NamedController("tip", monitor=True)
    controller.reset(crane, obs)
    for t in 0.01 * np.arange(41):
        lift = q0[0] + 0.5 * acceleration * falls * max(t - 0.3, 0.0) ** 2
        q, p = np.array([step * np.round(lift / step) if step else lift, *q0[1:]]), obs.p.copy()
        p[0] *= t < 0.3
        seen = hc.Observation(t=t, q=q, qd=np.zeros(3), p=p, tip=crane.tip(q), measured={})
        controller.step(seen, hc.Stick("tip", np.zeros(2)))
    return [notice for notice in controller.notices if "reads nothing" in notice]


def test_chambers_that_read_nothing_are_believed_while_the_crane_falls(tmp_path):
    counted, step = written(tmp_path, ENCODER), np.pi / 10000
    assert accused("hiab-xs031", 1.0, 0.0) == accused(counted, 1.0, step) == []
    for found in (accused("hiab-xs031", 0.3, 0.0), accused("hiab-xs031", 0.0, 0.0), accused(counted, 0.0, step)):
        assert ["the crane stops" in text for text in found] == [True, True]
