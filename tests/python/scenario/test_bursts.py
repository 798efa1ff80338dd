"""Hoses that burst, by every way in: file, Python, command line, study. (The law: crates/sim/tests/suite.)"""

import numpy as np
import pytest
from typer.testing import CliRunner

import hydrocrane as hc
from hydrocrane.app.cli import app
from hydrocrane.results.energy import energy_balance

POSE = {"boom": 1.7, "jib": 1.7, "extension": 0.2}
TORN = hc.Burst("lift", "piston-side", time=0.5, opening=20e-6)
PLAN = hc.Scenario(joints=POSE, bursts=[TORN], duration=1.0)
SCENARIO = """
[scenario]
name = "torn"
machine = "rottne-f9-lab"
duration = "1 s"
[initial.joint]
boom = "1.7 rad"
jib = "1.7 rad"
extension = "0.2 m"
[burst.lift]
cylinder = "lift"
side = "piston-side"
time = "0.5 s"
opening = "20 mm^2"
"""
AGAIN = SCENARIO[SCENARIO.index("[burst.lift]") :].replace("[burst.lift]", "[burst.again]") + "[burst.lift]"
LOST = "cylinder.lift.lost1"


@pytest.fixture(scope="module")
def torn():
    return hc.simulate(PLAN)


def rows(run: hc.Run) -> np.ndarray:
    return np.column_stack([run.columns[name].values for name in (LOST, "tip.x", "tip.z", "cylinder.lift.p1")])


def written(folder, text=SCENARIO):
    (folder / "torn.toml").write_text(text, encoding="utf-8")
    return folder / "torn.toml"


def test_every_way_in_gives_the_same_run(torn, tmp_path):
    file = written(tmp_path)
    again = PLAN.save(tmp_path / "again.toml")
    assert hc.load_scenario(again).bursts == hc.load_scenario(file).bursts == (TORN,)
    done = CliRunner().invoke(app, ["simulate", str(file), "--film", "none", "-o", str(tmp_path / "out")])
    assert done.exit_code == 0 and "of oil left through the hose" in done.output, done.output
    from_command_line = hc.Run.load(tmp_path / "out/torn.nc").data
    np.testing.assert_array_equal(from_command_line[LOST].values, torn.data[LOST].values)
    for run in (hc.simulate(file), hc.simulate(again), hc.simulate(PLAN.changed(bursts=()), bursts=TORN)):
        np.testing.assert_array_equal(rows(run), rows(torn))


def test_oil_and_energy_that_leave_are_told(torn):
    time, lost = torn.columns.time, torn.columns[LOST].values
    assert not lost[time <= 0.5].any() and (lost[time > 0.51] > 0.0).all()
    (told,) = [warning for warning in torn.warnings if warning.kind == "oil-lost"]
    assert float(told.text.split()[0]) == pytest.approx(1e3 * np.trapezoid(lost, time), rel=0.05)
    balance = energy_balance(hc.simulate(PLAN, rtol=1e-8))
    assert balance.residual < 1e-3


def test_until_it_bursts_nothing_differs(torn):
    tight, before = hc.simulate(PLAN, bursts=()), torn.columns.time <= 0.5
    for name in ("tip.x", "tip.z", "cylinder.lift.p1"):
        np.testing.assert_allclose(torn.columns[name].values[before], tight.columns[name].values[before], rtol=1e-6)
    assert tight.columns["tip.z"].values[-1] - torn.columns["tip.z"].values[-1] > 0.01
    assert LOST not in tight.columns


def test_a_study_lets_it_burst():
    data = hc.sweep(PLAN, {"payload": [0.0, 50.0]}, measures=["end(tip.z)", f"max({LOST})"])
    assert (data[f"max({LOST})"].values > 0.0).all()


@pytest.mark.parametrize(
    ("bursts", "message"),
    [
        (hc.Burst("lfit", "piston-side", 0.5, 20e-6), "`lift`"),
        ([TORN, TORN], "bursts twice"),
        ("lift", "list of Burst"),
    ],
)
def test_what_cannot_burst_is_said(bursts, message):
    with pytest.raises(hc.HydrocraneError, match=message):
        hc.simulate(PLAN, bursts=bursts)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (("lift", "rodside", 0.5, 20e-6), "rod-side"),
        (("lift", "rod-side", -0.5, 20e-6), "time"),
        (("lift", "rod-side", 0.5, -20e-6), "opening"),
        (("lift", "rod-side", np.nan, 20e-6), "time"),
    ],
)
def test_wrong_values_are_said_when_they_are_given(values, message):
    with pytest.raises(hc.HydrocraneError, match=message):
        hc.Burst(*values)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('cylinder = "lift"', 'cylinder = "lfit"', "burst.lift.cylinder"),
        ('side = "piston-side"', 'side = "piston"', "piston-side"),
        ('time = "0.5 s"', 'time = "-0.5 s"', "burst.lift.time"),
        ('opening = "20 mm^2"', "", "opening"),
        ('opening = "20 mm^2"', 'opening = "20 mm"', "area"),
        ("[burst.lift]", AGAIN, "bursts twice"),
    ],
)  # fmt: skip
def test_wrong_files_are_said(tmp_path, old, new, message):
    assert old in SCENARIO
    with pytest.raises(hc.HydrocraneError, match=message):
        hc.load_scenario(written(tmp_path, SCENARIO.replace(old, new)))


def test_what_needs_one_machine_throughout_refuses_it():
    with pytest.raises(hc.HydrocraneError, match="a hose bursts"):
        hc.sensitivities(PLAN, "valve.lift.nominal-flow")
    with pytest.raises(hc.HydrocraneError, match="whole runs only"):
        hc.LiveSimulator(PLAN, controller="tip")
