"""Hoses that burst, by every way in: file, Python, command line, study. (The law: crates/sim/tests/suite.)"""

import numpy as np
import pytest
from typer.testing import CliRunner

import hydrocrane as hc
from hydrocrane.analysis.sensitivity import Experiment, solve
from hydrocrane.app.cli import app
from hydrocrane.app.live import drive_request
from hydrocrane.identification.values.models import replayed
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


OPENING = "hose-leak.burst-lift-piston-side.opening"
DISCHARGE = "hose-leak.burst-lift-piston-side.discharge-coefficient"
# The piston of the jib goes one way, so that differences do not straddle a reversal.
LOWERED = PLAN.changed(
    commands={
        name: hc.Command([0.0, 0.2, 1.0], [0.1 * most, most, most], "linear")
        for name, most in {"lift": -0.008, "jib": 0.01, "extension": 0.006}.items()
    },
    bursts=[TORN, hc.Burst("jib", "rod-side", time=0.7, opening=2e-6)],
    record_interval=0.025,
)


def test_a_burst_is_no_jump_of_the_sensitivities():
    plan = LOWERED.changed(overrides={DISCHARGE: 0.7})
    signals = [name for name in Experiment(plan, OPENING).machine.state_names if not name.endswith(".z")]
    keys = (OPENING, DISCHARGE, "supply.pressure")

    def solved(key, resolve=False, **given):
        experiment = Experiment(plan, key, signals=signals, method="tsit5", rtol=1e-11, resolve_sensitivities=resolve)
        return solve(experiment, given.get("values"))

    found = solved(keys, resolve=True)
    before = found.times <= TORN.time
    for i, key in enumerate(keys):
        value = Experiment(plan, key).values[0]

        def difference(share, key=key, value=value):
            up, down = (solved(key, values=[value * (1 + sign * share)]).y for sign in (1, -1))
            return (up - down) / (2 * share * value)

        quotients = (4 * difference(2e-3) - difference(4e-3)) / 3
        derivatives = found.sensitivities[:, :, i]
        size = np.maximum(np.abs(derivatives).max(axis=0), 1e-3 * np.abs(found.y).max(axis=0) / value)
        assert (np.abs(quotients - derivatives) / size).max() < 2e-4, key
        assert derivatives[before].any() == (key not in (OPENING, DISCHARGE)), key
    # Opening and discharge coefficient enter by their product.
    by_opening, by_discharge = found.sensitivities[:, :, 0], found.sensitivities[:, :, 1]
    np.testing.assert_allclose(
        by_opening * TORN.opening, by_discharge * 0.7, rtol=1e-6, atol=1e-9 * np.abs(by_opening).max() * TORN.opening
    )


def test_with_steps_by_the_states_the_run_is_that_of_simulate_to_the_last_bit():
    found = hc.sensitivities(LOWERED, [OPENING, "payload.mass"], method="rodas5p", resolve_sensitivities=False)
    run = hc.simulate(LOWERED, method="rodas5p", ledger=False)
    for name in run.data:
        np.testing.assert_array_equal(found.run.data[name].values, run.data[name].values, err_msg=str(name))
    assert found.run.data.attrs["solver_steps"] == run.data.attrs["solver_steps"]
    assert [warning.text for warning in found.run.warnings] == [warning.text for warning in run.warnings]
    # Outputs have derivatives from the burst on; the row at the burst is before it.
    time, lost = found.data.time.values, found.data[LOST].sel(parameter=OPENING).values
    assert not lost[time <= TORN.time].any() and lost[time > TORN.time][0] != 0.0


def test_a_hose_that_leaks_from_the_start_does_not_burst():
    leak = {"cylinder": "lift", "side": "piston-side", "opening": 1e-6}
    own = {f"hose-leak.lift-piston-side.{key}": value for key, value in leak.items()}
    with pytest.raises(hc.MachineFileError, match="`lift` has one on this side already"):
        hc.simulate(PLAN, overrides=own)


def test_a_hose_that_bursts_after_the_end_is_no_parameter():
    with pytest.raises(hc.InputError, match="opening` does not enter"):
        hc.sensitivities(LOWERED, OPENING, duration=0.4)


def test_what_is_driven_live_is_repeated_to_the_last_bit(tmp_path):
    live = hc.LiveSimulator(LOWERED, commands={}, controller="tip", sensors="data-sheet", seed=2)
    live.step(0.3)
    live.set_stick(z=0.3)
    live.step(0.3)
    assert "oil-lost" in {warning.kind for warning in live.warnings}
    live.set_stick(x=-0.2)
    live.step(0.4)
    saved = live.scenario(record_interval=live.period)
    assert saved.bursts == LOWERED.bursts
    assert hc.load_scenario(saved.save(tmp_path / "drive.toml")).bursts == saved.bursts
    run = hc.simulate(saved)
    again = hc.LiveSimulator(saved)
    while again.time < saved.duration - 1e-9:
        again.step()
    last = [run.columns[name].values[-1] for name in live.machine.state_names]
    np.testing.assert_array_equal(again.state, last)
    tight = hc.simulate(saved, bursts=())
    assert tight.columns["tip.z"].values[-1] - run.columns["tip.z"].values[-1] > 0.005


def test_the_page_is_asked_to_let_them_burst(tmp_path):
    asked = tmp_path / "asked.toml"
    asked.write_text(str(drive_request(str(written(tmp_path)), {"payload.mass": 20.0})["scenario"]), encoding="utf-8")
    read = hc.load_scenario(asked)
    assert [burst.entry for burst in read.bursts] == [("lift", "piston-side", 0.5, 20e-6)]
    assert read.overrides == {"payload.mass": "20.0 kg"}


def test_an_fmu_states_no_burst(tmp_path):
    with pytest.raises(hc.InputError, match="hoses that burst against time"):
        hc.export_fmu(PLAN, tmp_path / "torn.fmu")


def test_a_log_that_begins_later_has_them_on_its_clock():
    machine = PLAN.load_machine()
    log = hc.Log.of({"time": np.linspace(0.2, 1.0, 81), "joint.boom.q": np.full(81, 1.7)})
    assert [burst.time for burst in replayed(PLAN, machine, log, "linear").plan.bursts] == [pytest.approx(0.3)]
