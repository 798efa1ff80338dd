"""A measured supply pressure, by every way in: file, Python, command line, study, fit. (The page: crates/web/tests.)"""

import numpy as np
import pytest
from typer.testing import CliRunner

import hydrocrane as hc
from hydrocrane.app.cli import app
from hydrocrane.app.live import drive_request
from hydrocrane.results.energy import energy_balance

POSE = {"boom": 1.7, "jib": 1.7, "extension": 0.2}
MOVES = {"lift": ([0.0, 0.4, 1.5], [0.0, 0.03, 0.02]), "jib": ([0.0, 0.2, 1.5], [0.0, -0.02, 0.015])}
PLAN = hc.Scenario(joints=POSE, commands={c: hc.Command(*m, "linear") for c, m in MOVES.items()}, duration=2.0)
TIMES = np.linspace(0.0, 2.0, 21)
PRESSURE = 140e5 - 50e5 * np.sin(1.5 * TIMES) ** 2
SCENARIO = """
[scenario]
name = "weak"
machine = "rottne-f9-lab"
duration = "2 s"
[initial.joint]
boom = "1.7 rad"
jib = "1.7 rad"
extension = "0.2 m"
[command.lift]
time = ["0 s", "0.4 s", "1.5 s"]
spool = ["0 mm", "30 mm", "20 mm"]
interpolation = "linear"
[command.jib]
time = ["0 s", "0.2 s", "1.5 s"]
spool = ["0 mm", "-20 mm", "15 mm"]
interpolation = "linear"
[supply]
log = "drive.csv"
column = "p_s"
time-column = "clock"
"""


@pytest.fixture
def folder(tmp_path):
    rows = "".join(f"{1e3 * t!r};{1e-5 * p!r}\n" for t, p in zip(TIMES.tolist(), PRESSURE.tolist(), strict=True))
    (tmp_path / "drive.csv").write_text("clock [ms];p_s [bar]\n" + rows, encoding="utf-8")
    (tmp_path / "weak.toml").write_text(SCENARIO, encoding="utf-8")
    return tmp_path


@pytest.fixture(scope="module")
def stated():
    """The same pressure by numbers."""
    return hc.simulate(PLAN, supply=(TIMES, PRESSURE))


def apart(one: hc.Run, other: hc.Run, names: tuple[str, ...] = ("joint.boom.q", "joint.jib.q", "mains.p")) -> float:
    """Largest difference of some signals, as a share of their largest value."""
    pairs = [(one.columns[name].values, other.columns[name].values) for name in names]
    return max(float(np.max(np.abs(a - b)) / np.max(np.abs(a))) for a, b in pairs)


def test_every_way_in_gives_the_same_run(folder, stated):
    read = hc.read_supply(folder / "drive.csv", column="p_s", unit="bar", time="clock")
    np.testing.assert_allclose(read.pressure, PRESSURE, rtol=1e-12)
    assert apart(hc.simulate(PLAN, supply=read), stated) < 1e-5
    assert apart(hc.simulate(folder / "weak.toml"), stated) < 1e-5
    written = PLAN.changed(supply=(TIMES, PRESSURE)).save(folder / "again.toml")
    assert apart(hc.simulate(written), stated) == 0.0


def test_the_pressure_is_the_one_that_was_given(stated):
    given = np.interp(stated.columns.time, TIMES, PRESSURE)
    np.testing.assert_allclose(stated.columns["mains.p"].values, given, atol=1.0)
    assert apart(stated, hc.simulate(PLAN), ("joint.boom.q", "joint.jib.q")) > 1e-3


def test_the_energy_of_the_supply_is_its_pressure_times_its_flow(stated):
    tight = hc.simulate(PLAN, supply=(TIMES, PRESSURE), rtol=1e-8)
    assert energy_balance(tight).residual < 1e-3
    power = tight.columns["supply.flow"].values * np.interp(tight.columns.time, TIMES, PRESSURE)
    np.testing.assert_allclose(tight.columns["supply.power"].values, power, rtol=1e-6, atol=1e-3)
    assert not stated.warnings


def test_steps_of_the_pressure_are_phases_with_other_values():
    """With sticks on the valves, where a phase can change the machine's own constant pressure."""
    stick = hc.Joystick([0.0, 0.5, 2.0], {"lift": [0.0, 0.5, 0.3], "jib": [0.0, -0.4, 0.2]}, "lever")
    plan = hc.Scenario(joints=POSE, joystick=stick, duration=2.5)
    phases = [hc.Phase(1.0, {"supply.pressure": "90 bar"}), hc.Phase(2.0, {"supply.pressure": "120 bar"})]
    steps = hc.SupplyPressure([0.0, 1.0, 2.0], [140e5, 90e5, 120e5], "hold")
    one, other = hc.simulate(plan, phases=phases, rtol=1e-7), hc.simulate(plan, supply=steps, rtol=1e-7)
    assert apart(one, other, ("joint.boom.q", "joint.jib.q", "cylinder.lift.p1")) < 1e-6


@pytest.mark.parametrize("method", ["rodas5p", "hc-exponential-4", "hc-rosenbrock-3", "tsit5"])
def test_every_method_takes_it(stated, method):
    run = hc.simulate(PLAN, supply=(TIMES, PRESSURE), method=method, rtol=1e-6)
    assert apart(run, stated) < 1e-4


def test_derivatives_are_those_of_the_run():
    keys = ["valve.lift.nominal-flow", "friction.lift.coulomb[0]"]
    exact = hc.sensitivities(PLAN, keys, supply=(TIMES, PRESSURE), rtol=1e-8)
    for i, (path, other) in enumerate([("valve.lift.nominal-flow", None), ("friction.lift.coulomb", 490.0)]):
        value = exact.parameters[i].value
        ends = []
        for moved in (value * (1 + 1e-3), value * (1 - 1e-3)):
            over = {path: moved if other is None else [moved, other]}
            ends.append(hc.simulate(PLAN, supply=(TIMES, PRESSURE), overrides=over, rtol=1e-11, ledger=False))
        for name in ("joint.boom.q", "cylinder.lift.p1"):
            slope = (ends[0].columns[name].values - ends[1].columns[name].values) / (2e-3 * value)
            assert np.max(np.abs(exact.data[name].values[:, i] - slope)) < 1e-4 * np.max(np.abs(slope))
        assert not exact.data["mains.p"].values[:, i].any()
    with pytest.raises(hc.HydrocraneError, match="does not enter the run"):
        hc.sensitivities(PLAN, "supply.pressure", supply=(TIMES, PRESSURE))


def test_a_run_that_was_saved_as_csv_feeds_another(tmp_path):
    pumped = hc.simulate(PLAN, machine="rottne-f9-pump")
    saved = pumped.save(tmp_path / "run.csv")
    again = hc.simulate(PLAN, supply=hc.read_supply(saved))
    assert apart(pumped, again) < 1e-3


def test_the_command_line_takes_a_log(folder, tmp_path):
    plain = folder / "plain.csv"
    plain.write_text("time,supply.pressure [bar]\n0,140\n0.2,100\n", encoding="utf-8")
    arguments = ["simulate", "vertical-lift-open-loop", "--supply-log", str(plain), "--duration", "0.2"]
    done = CliRunner().invoke(app, [*arguments, "--film", "none", "-o", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    run = hc.Run.load(tmp_path / "out/vertical-lift-open-loop.nc")
    assert run.data["mains.p"].values[[0, -1]] == pytest.approx([140e5, 100e5])
    assert run.machine.state_names[-1] == "mains.p"
    assert "[supply]" in str(drive_request(str(folder / "weak.toml"), {})["scenario"])


def test_a_study_varies_the_log(folder):
    logs = []
    for name, low in (("one", 60), ("two", 120)):
        (folder / name).with_suffix(".csv").write_text(f"time,supply [bar]\n0,140\n2,{low}\n", encoding="utf-8")
        logs.append(str(folder / f"{name}.csv"))
    data = hc.sweep(PLAN, {"supply.log": logs}, measures=["end(cylinder.lift.x)"])
    moved = data["end(cylinder.lift.x)"].values
    assert np.isfinite(moved).all() and abs(moved[0] - moved[1]) > 1e-4


def test_a_live_drive_follows_it(stated):
    stick = hc.Joystick([0.0, 0.3], {"lift": [0.0, 0.5]}, "lever")
    plan = hc.Scenario(joints=POSE, joystick=stick, duration=1.0, supply=(TIMES, PRESSURE))
    run, live = hc.simulate(plan), hc.LiveSimulator(plan)
    for _ in range(20):
        live.step(0.05)
    names = live.machine.state_names
    np.testing.assert_array_equal(live.state, [run.columns[name].values[-1] for name in names])
    assert live.state[names.index("mains.p")] == pytest.approx(np.interp(1.0, TIMES, PRESSURE), abs=1.0)
    assert apart(hc.simulate(live.scenario(duration=1.0)), run, ("joint.boom.q", "mains.p")) < 1e-6


@pytest.mark.parametrize(
    ("supply", "words"),
    [
        (([0.0, 1.0], [1e7]), "as many times"),
        (([1.0, 0.0], [1e7, 1e7]), "must increase"),
        (([0.0, 1.0], [1e7, np.nan]), r"nan at index \[1\]"),
        (([0.0, 1.0], [1e7, -2e5]), "at 1 s is -2.000 bar, below vacuum"),
        ("drive.csv", "read_supply"),
    ],
)
def test_what_is_wrong_is_told(supply, words):
    with pytest.raises(hc.HydrocraneError, match=words):
        hc.simulate(PLAN, supply=supply)


def test_a_pump_and_a_unit_that_cannot_be_are_told():
    with pytest.raises(hc.HydrocraneError, match="the pump determines the pressure"):
        hc.simulate(PLAN, machine="rottne-f9-pump", supply=(TIMES, PRESSURE))
    run = hc.simulate(PLAN, supply=(TIMES, 1e-5 * PRESSURE), duration=0.1)
    assert any("0.0014 bar at most" in warning.text and "unit" in warning.cure for warning in run.warnings)


def test_a_constant_pressure_beside_it_is_told(folder):
    beside = hc.simulate(PLAN, supply=(TIMES, PRESSURE), overrides={"supply.pressure": "100 bar"}, duration=0.1)
    assert "override-without-effect" in {warning.kind for warning in beside.warnings}
    checked = CliRunner().invoke(app, ["check", str(folder / "weak.toml")])
    low = 1e-5 * PRESSURE.min()
    assert f"measured supply pressure {low:.4g} to 140 bar, 21 times, joined linearly" in checked.output


def test_stated_chamber_pressures_leave_the_mains_of_a_pump_at_rest():
    pressures = dict.fromkeys(("lift", "jib", "extension"), (3000000.0, 2000000.0))
    still = hc.Scenario(machine="rottne-f9-pump", joints=POSE, pressures=pressures, duration=0.05)
    assert hc.simulate(still).columns["mains.p"].values[0] == pytest.approx(139.6e5, rel=1e-2)


@pytest.mark.parametrize(("stated", "measured", "words"), [(140, 20, "measured supply has 20 bar"), (20, 140, None)])
def test_a_start_is_judged_by_the_pressure_that_was_measured(stated, measured, words):
    """Not by the one that the machine states: 100 kg need 39 bar in the lift cylinder."""
    overrides = {"supply.pressure": f"{stated} bar"}
    supply = ([0.0, 1.0], [1e5 * measured] * 2)
    run = hc.simulate(PLAN, duration=0.1, payload=100.0, overrides=overrides, supply=supply)
    texts = [warning.text for warning in run.warnings if warning.kind == "start-not-held"]
    assert bool(texts) == bool(words) and all(words in text for text in texts)
