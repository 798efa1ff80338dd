"""``hydrocrane check`` prints what lets people see a wrong value, and names what the plant shows to be wrong."""

from pathlib import Path

import pytest
from command_line import run

import hydrocrane as hc
from hydrocrane.analysis.figures import doubts, figures

MINI = Path(__file__).parents[3] / "crates/machine/tests/suite/mini.toml"

# Base, wrong values, what `check` says.
WRONG = [
    ("rottne-f9-lab", {"supply.pressure": "5 bar"}, "cylinder.lift needs 10"),
    ("hiab-xs031", {"supply.pressure": "19 bar"}, "it cannot lift"),
    ("hiab-xs031", {"supply.pressure": "35 bar"}, "cylinder.tilt needs 93"),
    (MINI, {"supply.pressure": "35 bar", "payload.mass": "300 kg"}, "it cannot lift"),
    (MINI, {"payload.mass": "30 t"}, "it cannot lift"),
    (MINI, {"environment.gravity": "98.1 m/s^2"}, "it cannot lift"),
    (MINI, {"cylinder.boom.bore": "35 mm", "cylinder.boom.rod-diameter": "20 mm"}, "it cannot lift"),
    (MINI, {"joint.arm.limits": ["-2.57 deg", "-0.51 deg"]}, "cylinder"),
    (MINI, {"joint.arm.limits": ["-60 deg", "-58 deg"]}, "joint.arm moves by 2 deg only"),
    (MINI, {"cylinder.boom.stroke": "20 mm", "cylinder.boom.end-stop.zone": "5 mm"}, "joint.boom moves by"),
    (MINI, {"fluid.bulk-modulus": "12 MPa", "payload.mass": "500 kg"}, "would let the tip give way"),
    (MINI, {"link.bucket.mass": "53 t", "link.bucket.inertia": "3021 kg m^2"}, "it cannot lift"),
]


@pytest.mark.parametrize(("base", "values", "said"), WRONG)
def test_what_the_plant_shows_is_named(base, values, said):
    try:
        machine = hc.load_machine(base, values)
    except hc.MachineFileError as error:
        assert said in str(error)
        return
    assert said in " ".join(str(doubt) for doubt in doubts(machine, figures(machine)))


@pytest.mark.parametrize("base", [*hc.bundled_machines(), MINI])
def test_right_machines_are_not_blamed(base):
    machine = hc.load_machine(base)
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
