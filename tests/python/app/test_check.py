"""``hydrocrane check`` prints what lets people see a wrong value, and names what the plant shows to be wrong."""

from pathlib import Path

import numpy as np
import pytest
from command_line import run

import hydrocrane as hc
from hydrocrane.analysis.figures import doubts, figures
from hydrocrane.state_space.oscillations import oscillations

ROOT = Path(__file__).parents[3]
MINI = ROOT / "crates/machine/tests/suite/mini.toml"
SMALL, MANY = (ROOT / f"tests/data/{name}.toml" for name in ("small-excavator", "many-parts"))
TWO = ROOT / "tests/data/two-slides.toml"

BURST = {
    "hose-burst.lift.cylinder": "lift",
    "hose-burst.lift.side": "piston-side",
    "hose-burst.lift.nominal-flow": "60 l/min",
    "hose-burst.lift.nominal-pressure-drop": "2 bar",
}

# Base, wrong values, what `check` says.
WRONG = [
    ("rottne-f9-lab", {"supply.pressure": "5 bar"}, "cylinder.lift needs 10"),
    ("hiab-xs031", {"supply.pressure": "19 bar"}, "it cannot lift"),
    ("hiab-xs031", {"supply.pressure": "35 bar"}, "cylinder.tilt needs 93"),
    ("rottne-f9-ls", {"joint.boom.limits": ["30 rad", "116 rad"]}, "write them in deg, in which these numbers fit"),
    (MINI, {"joint.arm.limits": ["-2.4 deg", "-1 deg"]}, "write them in rad, in which these numbers fit"),
    (MINI, {"supply.pressure": "35 bar", "payload.mass": "300 kg"}, "it cannot lift"),
    (MINI, {"payload.mass": "30 t"}, "it cannot lift"),
    (MINI, {"environment.gravity": "98.1 m/s^2"}, "it cannot lift"),
    (MINI, {"cylinder.boom.bore": "35 mm", "cylinder.boom.rod-diameter": "20 mm"}, "it cannot lift"),
    (MINI, {"joint.arm.limits": ["-2.57 deg", "-0.51 deg"]}, "cylinder"),
    (SMALL, {"cylinder.arm.stroke": "51 mm"}, "cylinder `arm` has 51 mm of stroke, which are"),
    ("rottne-f9-forwarder", {"cylinder.slew.rack-radius": "90 cm"}, "joint.slew.limits are"),
    ("rottne-f9-forwarder", {"cylinder.slew.stroke": "62 mm"}, "cylinder `slew` has 62 mm of stroke"),
    ("hiab-xs031", {"cylinder.lift.stroke": "59 mm"}, "cylinder `lift` has 59 mm of stroke"),
    (
        SMALL,
        {"cylinder.arm.stroke": "51 mm", "joint.arm.limits": ["-140 deg", "-120 deg"]},
        "nowhere inside these limits",
    ),
    (SMALL, {"cylinder.bucket.linkage.side": "right"}, "with the linkage on its other side by 209 deg"),
    (SMALL, {"cylinder.boom.closed-length": "1305 mm"}, "of the 400 mm stroke of cylinder `boom`"),
    (SMALL, {"valve.boom.nominal-edge-pressure-drop": "35 MPa"}, "usual is 0.5 bar to 120 bar"),
    ("rottne-f9-lab", {"cylinder.lift.port-diameter": "10 cm"}, "wider than half the bore"),
    ("rottne-f9-lab", {"control.period": "1 s"}, "usual is 0.2 ms to 0.2 s"),
    ("rottne-f9-mobile", {"valve.lift.nominal-flow": "12 ml/s"}, "large beside the 0.720 l/min of valve.lift"),
    ("rottne-f9-mobile", {"counterbalance.lift.nominal-flow": "0.4 l/min"}, "small beside the"),
    (MANY, {"port-relief.cylinder2-piston.nominal-flow": "227 ml/min"}, "small beside the"),
    (MANY, {"crossover-relief.cylinder2.setting": "20 bar"}, "cylinder.cylinder2 needs"),
    ("rottne-f9-lab", {"sensor.lift-p1.accuracy": "0.3"}, "usual is 0 to 0.025"),
    ("rottne-f9-lab", {"sensor.lift-force.linearity": "0.25"}, "usual is 0 to 0.025"),
    ("rottne-f9-lab", {"sensor.lift-force.range": "50 N"}, "the sensor reads -0.050 kN to 0.050 kN"),
    ("rottne-f9-lab", {"sensor.lift-p1.noise": "0.03"}, "usual is 0 to 0.025"),
    ("rottne-f9-lab", {"sensor.lift-force.range": "50 MN"}, "wide: the sensor reads"),
    ("rottne-f9-lab", {"sensor.lift-p1.range": "4000 bar"}, "wide: the sensor reads"),
    ("rottne-f9-lab", {"sensor.extension-length.range": "125 m"}, "wide: the sensor reads"),
    (
        "rottne-f9-lab",
        {"sensor.lift-p1.measures": "joint.boom.q"},
        "a pressure-transmitter cannot measure `joint.boom.q`",
    ),
    ("rottne-f9-lab", {"sensor.boom-angle.measures": "joint.extension.q"}, "an incremental-encoder cannot measure"),
    ("rottne-f9-lab", {"sensor.extension-length.measures": "joint.jib.q"}, "a wire-potentiometer cannot measure"),
    ("rottne-f9-lab", {"sensor.lift-p2.measures": "cylinder.lift.p1"}, "which another sensor measures too"),
    (MANY, {"line.cylinder2-piston.nominal-flow": "1 l/min"}, "small beside the"),
    (TWO, {"cylinder.first.closed-length": "9 m"}, "long for a stroke of 600 mm"),
    (SMALL, {"cylinder.boom.stroke": "40 mm"}, "joint.boom moves by 8"),
    (SMALL, {"cylinder.boom.stroke": "200 mm"}, "long for a stroke of 200 mm"),
    (SMALL, {"valve.boom.nominal-flow": "0.45 l/min"}, "for its stroke, and the others"),
    ("rottne-f9-mobile", {"counterbalance.lift.side": "rod-side"}, "rests on the piston-side in all poses"),
    ("rottne-f9-pump", {"pump.main.torque-limit": "5 N m"}, "pump.main.torque-limit is small"),
    ("rottne-f9-lab", {"sensor.lift-p1.rise-time": "4 s"}, 'did you mean "4 ms"?'),
    ("rottne-f9-lab", {"sensor.lift-p1.bits": "1"}, "usual is 6 to 32"),
    ("rottne-f9-lab", {"sensor.boom-angle.pulses": "1"}, "1 pulses a turn have counts of 90.0000 deg"),
    ("rottne-f9-lab", {"sensor.boom-angle.resolution": "0.09 rad"}, "1000 pulses a turn have counts of 0.0900 deg"),
    (MINI, {"joint.arm.limits": ["-60 deg", "-58 deg"]}, "joint.arm moves by 2 deg only"),
    (MINI, {"cylinder.boom.stroke": "20 mm", "cylinder.boom.end-stop.zone": "5 mm"}, "joint.boom moves by"),
    (MINI, {"fluid.bulk-modulus": "12 MPa", "payload.mass": "500 kg"}, "would let the tip give way"),
    (TWO, {"joint.first.direction": "1.57 deg"}, "the cylinder stands across the slide"),
    (TWO, {"joint.second.direction": "0 deg"}, "the cylinder stands across the slide"),
    ("rottne-f9-lab", {**BURST, "hose-burst.lift.closing-flow": "5 l/min"}, "it stops this motion"),
    (MINI, {"link.bucket.mass": "53 t", "link.bucket.inertia": "3021 kg m^2"}, "it cannot lift"),
]


@pytest.mark.parametrize(("base", "values", "said"), WRONG)
def test_what_the_plant_shows_is_named(base, values, said):
    try:
        machine = hc.load_machine(base, values)
    except hc.MachineFileError as error:
        assert said in str(error)
        return
    assert said in " ".join(str(doubt) for doubt in (*machine.warnings, *doubts(machine, figures(machine))))


@pytest.mark.parametrize("base", [*hc.bundled_machines(), MINI])
def test_right_machines_are_not_blamed(base):
    machine = hc.load_machine(base)
    assert machine.warnings == doubts(machine, figures(machine)) == ()


def test_a_hose_burst_valve_above_all_wanted_flows_is_not_blamed():
    machine = hc.load_machine("rottne-f9-lab", {**BURST, "hose-burst.lift.closing-flow": "100 l/min"})
    assert machine.warnings == doubts(machine, figures(machine)) == ()


def test_one_screen_says_loads_speeds_and_the_lowest_mode():
    done = run("check", MINI)
    told = ("at rest with 0 kg at boom", "full valve, mm/s", "lowest natural frequency", "46 cSt", "no errors found")
    for words in told:
        assert words in done.stdout, words
    assert len(done.stdout.splitlines()) <= 30
    wrong = run("check", MINI, "--set", "supply.pressure=5 bar")
    assert "warning: cylinder.boom needs" in wrong.stdout and "no errors, 5 warnings" in wrong.stdout


def test_slope_and_cylinders_in_parallel_are_told():
    done = run("check", MINI, "--set", "environment.slope=-8 deg", "--set", "cylinder.boom.count=2")
    assert "slope -8 deg" in done.stdout and "2 x boom" in done.stdout
    assert "slope" not in run("check", MINI).stdout


def test_a_result_of_a_pose_says_its_pose(tmp_path):
    done = run("modes", "single-cylinder", "--at", "slide=100 mm", "--samples", 0, folder=tmp_path)
    assert "pose: slide 100 mm" in done.stdout


def test_a_start_that_the_supply_cannot_hold_is_named_without_a_run():
    done = run("check", "vertical-lift-open-loop", "--set", "payload.mass=900 kg")
    assert "warning: " in done.stdout and "no errors found" not in done.stdout
    assert "no errors found" in run("check", "vertical-lift-open-loop").stdout


@pytest.mark.parametrize(
    ("boom", "told"), [(3.0, "is at 171.89 deg, outside its limits"), (100.0, 'did you mean "100 deg"?')]
)
def test_a_start_outside_the_limits_is_named_at_its_place(tmp_path, boom, told):
    plan = hc.load_scenario("vertical-lift-open-loop").changed(joints={"boom": boom, "jib": 1.7, "extension": 0.0})
    file = plan.save(tmp_path / "far.toml")
    for command in ("check", "simulate"):
        message = " ".join(run(command, file, folder=tmp_path).stderr.split())
        assert f"{file}:13:8: initial.joint.boom: joint boom" in message and told in message


def test_a_key_of_scenarios_is_no_key_of_the_machine():
    told = run("check", "vertical-lift-open-loop", "--set", "duration=3 s").stderr
    assert "`scenario.duration` is a key of scenario files: change it there" in told


def test_rounding_is_no_damping():
    turned = np.linalg.qr(np.random.default_rng(1).normal(size=(4, 4)))[0]
    swings = np.array([[0.0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 9], [0, 0, -9, 0]])
    assert not oscillations(turned @ swings @ turned.T, "abcd").damping.any()


def test_drift_by_leakage_is_no_oscillation():
    crane = hc.load_machine("hiab-xs031")
    pose = crane.home.copy()
    pose[0] = 0.26
    assert hc.modes(crane, pose, friction="released").frequency.min() > 0.1
    shortened = hc.load_machine("hiab-xs031", {"joint.lift.limits": ["-9.2 deg", "40 deg"]})
    assert not doubts(shortened, figures(shortened))


def test_a_house_that_slews_may_be_larger_than_its_pins_say():
    house = {"inertia": "900 kg m^2", "inertia-x": "900 kg m^2", "inertia-z": "900 kg m^2"}
    machine = hc.load_machine("rottne-f9-forwarder", {f"link.pillar.{key}": value for key, value in house.items()})
    assert not machine.warnings
