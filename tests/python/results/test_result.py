"""Scenarios, runs, their files and comparisons, and the stepping interface."""

import dataclasses
import pickle
import re
import signal
import threading

import h5py
import numpy as np
import pandas as pd
import pytest
import scipy.io
import xarray as xr

import hydrocrane as hc
from hydrocrane.files.netcdf import write_netcdf
from hydrocrane.results.energy import energy_balance

LAB = "rottne-f9-lab"


@pytest.fixture(scope="module")
def crane():
    return hc.load_machine(LAB)


@pytest.fixture(scope="module")
def plan():
    """Half a second with the boom rising and the jib moving."""
    return hc.Scenario(
        machine=LAB,
        name="short",
        joints={"boom": np.radians(100), "jib": np.radians(100), "extension": 0.0},
        commands={"lift": ([0.0, 0.3], [0.02, 0.0]), "jib": hc.Command([0.1], [-0.02])},
        duration=0.5,
    )


@pytest.fixture(scope="module")
def run(plan):
    return hc.simulate(plan)


def test_a_run_is_labelled_when_its_data_is_asked_for(plan, run):
    fresh = hc.simulate(plan)
    assert (fresh.outcome, fresh.warnings, fresh.cylinder_names) == (run.outcome, run.warnings, run.cylinder_names)
    assert "short on rottne-f9-lab" in repr(fresh)
    assert "data" not in vars(fresh)
    copied = pickle.loads(pickle.dumps(fresh))
    for other in (fresh, copied):
        assert other.data is other.data
        xr.testing.assert_equal(other.data, run.data)
        assert other.data.attrs["outcome"] == other.outcome.kind == "completed"
    # What somebody writes there counts.
    fresh.data.attrs["events"] = '[[0.1, "noted"]]'
    assert fresh.events[0].text == "noted"


def test_the_columns_of_a_run_are_its_data_without_labels(plan, tmp_path):
    fresh = hc.simulate(plan, controller="tip", joystick=hc.Joystick([0.0], {"x": [0.5], "z": [0.0]}), commands={})
    columns, summary = fresh.columns, fresh.summary()
    unlabelled = fresh.save(tmp_path / "unlabelled.nc").read_bytes()
    assert "data" not in vars(fresh)
    assert list(columns) == list(fresh.data.variables) and columns.rows == fresh.data.sizes["time"]
    for name, column in columns.items():
        assert column.dims == fresh.data[name].dims and column.attrs == fresh.data[name].attrs
        np.testing.assert_array_equal(column.values, fresh.data[name].values)
    assert fresh.save(tmp_path / "labelled.nc").read_bytes() == unlabelled and fresh.summary() == summary
    # What somebody writes into the data counts from then on.
    fresh.data["tip.x"] = 2.0 * fresh.data["tip.x"]
    np.testing.assert_array_equal(fresh.columns["tip.x"].values, 2.0 * columns["tip.x"].values)


def test_the_data_of_a_run_needs_no_file_any_more(plan, tmp_path):
    """Phases read their machine anew, and a file may change or go before the data is asked for."""
    file = tmp_path / "crane.toml"
    file.write_text(f'extends = "{LAB}"\n[machine]\nname = "own"\nclass = "assumed"\n')
    levers = hc.Joystick([0.0], {"lift": [0.5]}, mode="lever")
    later = hc.Phase(0.1, {"supply.pressure": "100 bar"})
    run = hc.simulate(hc.Scenario(machine=file, joints=plan.joints, joystick=levers, phases=[later], duration=0.2))
    file.unlink()
    assert run.data.attrs["machine"] == "own"
    assert np.isfinite(run.data["energy.oil"]).all()


# --- the data of a run ----------------------------------------------------------------------------------------------


def test_run_holds_every_promised_variable(run, crane):
    names = set(crane.state_names) | {"tip.x", "tip.z", "supply.flow", "supply.power"}
    names |= {
        f"cylinder.{c}.{k}"
        for c in crane.cylinder_names
        for k in ("x", "v", "force", "friction", "q1", "q2", "command")
    }
    assert names <= set(run.data.data_vars)
    assert any(str(name).startswith("ledger.") for name in run.data.data_vars)
    for name, variable in run.data.variables.items():
        assert "units" in variable.attrs, name
        assert variable.attrs["long_name"], name
        assert np.isfinite(variable.values).all(), name


def test_run_ends_as_planned(run):
    assert run.outcome == hc.Outcome("completed", 0.5, run.outcome.message)
    assert run.outcome.completed
    np.testing.assert_allclose(run.data.time.values, np.arange(51) * 0.01, atol=1e-12)


def test_recorded_outputs_follow_from_the_states(run, crane):
    q = np.column_stack([run.data[f"joint.{j}.q"] for j in crane.joint_names])
    np.testing.assert_allclose(np.column_stack([run.data["tip.x"], run.data["tip.z"]]), crane.tip(q), atol=1e-12)
    strokes = np.column_stack([run.data[f"cylinder.{c}.x"] for c in crane.cylinder_names])
    np.testing.assert_allclose(strokes, crane.strokes(q), atol=1e-12)


def test_commands_are_recorded_as_held(run):
    time, lift = run.data.time.values, run.data["cylinder.lift.command"].values
    assert (lift[(time > 0.005) & (time < 0.295)] == 0.02).all()
    assert (lift[time > 0.305] == 0.0).all()
    assert (run.data["cylinder.extension.command"].values == 0.0).all()


def test_the_boom_rises(run):
    """A positive spool command extends the lift cylinder and raises the boom."""
    assert run.data["cylinder.lift.x"].values[-1] > run.data["cylinder.lift.x"].values[0] + 1e-3


def test_without_ledger(plan):
    data = hc.simulate(plan, ledger=False, duration=0.05).data
    assert not [n for n in data.data_vars if str(n).startswith("ledger.")]


def test_ledger_closes(plan):
    """Pump work is stored or lost; the terms are integrated by the method itself, so the gap follows its tolerance."""
    balance = energy_balance(hc.simulate(plan, rtol=1e-9))
    assert balance.pump > 100.0
    assert balance.residual < 1e-6 * balance.pump
    assert balance.lost["metering edges"] > 0
    assert balance.pump == pytest.approx(balance.stored + sum(balance.lost.values()), abs=1e-6 * balance.pump)


def test_summary_says_what_happened(run):
    text = run.summary()
    for word in (
        "short on rottne-f9-lab: completed at 0.5 s",
        "hc-exponential-4 (chosen: auto)",
        "x real time",
        "lift",
        "bar",
        "tip",
    ):
        assert word in text


def test_a_summary_writes_what_rounds_to_zero_as_zero():
    assert not re.search(r"-0\.0+\b", hc.simulate("tip-vertical-line", duration=0.2).summary())


# --- changing a scenario --------------------------------------------------------------------------------------------


def test_changes_reach_the_run(plan):
    run = hc.simulate(plan, duration=0.05, record_interval=0.02, payload=120.0, method="tsit5", rtol=1e-5)
    np.testing.assert_allclose(run.data.time.values, [0, 0.02, 0.04, 0.05])
    assert run.data.attrs["payload"] == 120.0
    assert run.data.attrs["solver_method"] == "tsit5"


def test_overrides_add_up(plan):
    run = hc.simulate(
        dataclasses.replace(plan, overrides={"payload.mass": 50.0}),
        duration=0.02,
        overrides={"supply.pressure": "90 bar"},
    )
    assert run.machine.supply_pressure == pytest.approx(90e5)
    assert run.machine.payload_mass == 50.0


def test_a_loaded_machine_can_stand_in(plan):
    other = hc.load_machine(LAB, {"supply.pressure": "77 bar"})
    assert hc.simulate(plan, machine=other, duration=0.02).machine is other


def test_a_scenario_takes_a_loaded_machine(plan):
    other = hc.load_machine(LAB, {"supply.pressure": "77 bar"})
    run = hc.simulate(dataclasses.replace(plan, machine=other), duration=0.02)
    assert run.machine.supply_pressure == pytest.approx(77e5)


def test_commands_as_one_array(plan, run):
    table = np.zeros((3, 3))
    table[0, 0] = table[1, 0] = 0.02
    table[1:, 1] = -0.02
    same = hc.simulate(plan, commands=([0.0, 0.1, 0.3], table))
    xr.testing.assert_allclose(same.data["tip.z"], run.data["tip.z"])


def test_linear_commands_are_joined(plan):
    run = hc.simulate(plan, commands={"lift": hc.Command([0.0, 0.5], [0.0, 0.02], "linear")})
    np.testing.assert_allclose(run.data["cylinder.lift.command"], 0.04 * run.data.time, atol=1e-12)


def test_given_pressures_start_the_run(plan, crane):
    pressures = dict.fromkeys(crane.cylinder_names, (20e5, 30e5))
    data = hc.simulate(plan, pressures=pressures, duration=0.01).data
    assert float(data["cylinder.jib.p1"][0]) == 20e5
    assert float(data["cylinder.jib.p2"][0]) == 30e5


@pytest.mark.parametrize("name", hc.bundled_scenarios())
def test_bundled_scenarios_start(name):
    run = hc.simulate(name, duration=0.05)
    assert run.outcome.completed, run.outcome
    assert run.data.attrs["scenario"] == name


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"duraton": 1.0}, "did you mean `duration`"),
        ({"duration": -1.0}, "duration: must be greater than zero, found -1; give a time"),
        ({"method": "rodas"}, "did you mean `rodas5p`"),
        ({"joints": {"boom": 1.7, "jib": 1.7}}, "no start value for joint extension"),
        ({"joints": {"bom": 1.7}}, "did you mean `boom`"),
        ({"commands": {"lft": 0.01}}, "did you mean `lift`"),
        ({"commands": {"lift": 20.0}}, "its valve has 50 mm"),
        ({"commands": {"lift": ([0.0, 0.0], [0.0, 0.01])}}, "times of a command must increase"),
        ({"commands": {"lift": ([0.0, 1.0], [0.0])}}, "as many times as spool values"),
        ({"commands": ([0.0], np.zeros((1, 2)))}, r"spool must have shape \(1, 3\)"),
        ({"pressures": "equilibrum"}, "did you mean `equilibrium`"),
        ({"pressures": {"lift": (0, 0)}}, "no start pressures for cylinder jib"),
        ({"overrides": {"supply.presure": 1.0}}, "pressure"),
    ],
)
def test_wrong_scenarios_are_explained(plan, changes, words):
    with pytest.raises(hc.HydrocraneError, match=words):
        hc.simulate(plan, **changes)


def test_holding_and_joining_do_not_mix(plan):
    commands = {"lift": hc.Command([0, 1], [0, 0.01]), "jib": hc.Command([0, 1], [0, 0.01], "linear")}
    with pytest.raises(hc.InputError, match="share one interpolation"):
        hc.simulate(plan, commands=commands)


def test_ctrl_c_ends_a_loop_of_runs_and_keeps_what_was_computed(plan):
    """The signal arrives while the core integrates; the exception has the run until then."""
    long = plan.changed(duration=20000.0, record_interval=1.0, commands={})
    before = signal.getsignal(signal.SIGINT)
    timer = threading.Timer(0.5, signal.raise_signal, [signal.SIGINT])
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt, match="stopped at t") as stopped:
            for _ in range(3):
                hc.simulate(long)
    finally:
        timer.cancel()
    run = stopped.value.run
    assert run.outcome.kind == "interrupted"
    assert 0 < run.data.sizes["time"] < 20001
    assert signal.getsignal(signal.SIGINT) is before


# --- files ----------------------------------------------------------------------------------------------------------


@pytest.mark.evidence
def test_netcdf_comes_back_whole(run, tmp_path):
    again = hc.load_run(run.save(tmp_path / "deep" / "run.nc"))
    xr.testing.assert_identical(again.data, run.data)
    assert again.outcome == run.outcome
    assert again.machine.name == LAB
    assert again.summary() == run.summary()


def test_matlab_file(run, tmp_path):
    content = scipy.io.loadmat(run.save(tmp_path / "run.mat"), simplify_cells=True)
    np.testing.assert_array_equal(content["cylinder_lift_p1"], run.data["cylinder.lift.p1"])
    np.testing.assert_array_equal(content["time"], run.data.time)
    assert content["units"]["cylinder_lift_p1"] == "Pa"
    assert content["names"]["joint_boom_q"] == "joint.boom.q"


@pytest.mark.parametrize(("suffix", "read"), [("csv", pd.read_csv), ("parquet", pd.read_parquet)])
def test_tables(run, tmp_path, suffix, read):
    table = read(run.save(tmp_path / f"run.{suffix}"))
    if suffix == "csv":
        assert table.columns[0] == "time [s]" and "cylinder.lift.p1 [Pa]" in table.columns
        table.columns = [name.split(" [")[0] for name in table.columns]
    assert table.columns[0] == "time"
    assert set(table.columns) == {"time", *map(str, run.data.data_vars)}
    np.testing.assert_allclose(table["joint.boom.q"], run.data["joint.boom.q"], rtol=1e-15)


def test_unknown_suffix(run, tmp_path):
    with pytest.raises(hc.ResultFileError, match="choose from|did you mean"):
        run.save(tmp_path / "run.xls")


def test_files_that_are_no_runs(tmp_path):
    with pytest.raises(hc.ResultFileError, match="no such file"):
        hc.load_run(tmp_path / "none.nc")
    (tmp_path / "junk.nc").write_bytes(b"\x00junk" * 10)
    with pytest.raises(hc.ResultFileError, match="not a NetCDF file"):
        hc.load_run(tmp_path / "junk.nc")
    xr.Dataset({"a": ("x", [1.0])}).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    with pytest.raises(hc.ResultFileError, match="not a run saved by hydrocrane"):
        hc.load_run(tmp_path / "other.nc")


# --- comparing ------------------------------------------------------------------------------------------------------


@pytest.mark.evidence
def test_a_run_equals_itself_in_every_form(run, tmp_path):
    logs = [run, run.data, run.data.to_dataframe(), run.save(tmp_path / "a.csv"), str(run.save(tmp_path / "a.nc"))]
    for log in logs:
        comparison = run.compare(log)
        assert len(comparison) == len(run.data.data_vars)
        assert max(comparison.rms.values()) == pytest.approx(0.0, abs=1e-9)


def test_a_known_difference_is_found(run):
    time = np.array([0.1, 0.2, 0.3, 0.4])
    log = {"t": time, "alpha": np.interp(time, run.data.time, run.data["joint.boom.q"]) + [0.0, 0.03, 0.0, -0.04]}
    result = run.compare(log, {"alpha": "joint.boom.q"})
    found = result["joint.boom.q"]
    assert found.rms == pytest.approx(0.025)
    assert found.maximum == pytest.approx(0.04)
    assert found.maximum_time == pytest.approx(0.4)
    assert found.unit == "rad"
    assert len(result.figure.axes) == 1
    assert "joint.boom.q" in result.summary()


def test_shift_gaps_and_overhang_of_a_log(run):
    """Samples outside the run and gaps in the log are left out."""
    time = np.linspace(9.0, 11.0, 201)
    values = np.interp(time - 10.0, run.data.time, run.data["joint.boom.q"])
    values[105] = np.nan
    found = run.compare(pd.DataFrame({"time": time, "joint.boom.q": values}), shift=-10.0)["joint.boom.q"]
    assert found.maximum == pytest.approx(0.0, abs=1e-12)
    assert found.time.size == 50


@pytest.mark.parametrize(
    ("log", "columns", "words"),
    [
        ({"joint.boom.q": [1.0]}, None, "no time column"),
        ({"time": [0.0, 0.1], "angle": [1.0, 1.0]}, None, "state the pairs"),
        ({"time": [0.0, 0.1], "a": [1.0, 1.0]}, {"a": "joint.bom.q"}, "did you mean `joint.boom.q`"),
        ({"time": [0.0, 0.1], "alpha": [1.0, 1.0]}, {"alpa": "joint.boom.q"}, "did you mean `alpha`"),
        ({"time": [5.0, 6.0], "joint.boom.q": [1.0, 1.0]}, None, "no overlap"),
        ({"time": [0.0, 0.1], "joint.boom.q": [1.0]}, None, "1 values for 2 times"),
        ({"time": [0.0, 0.1], "joint.boom.q": [np.nan, np.nan]}, None, "no finite value"),
        (42, None, "a log is"),
    ],
)
def test_wrong_logs_are_explained(run, log, columns, words):
    with pytest.raises(hc.HydrocraneError, match=words):
        run.compare(log, columns)


# --- the stepping interface -----------------------------------------------------------------------------------------


def test_stepping_follows_the_run(plan, crane):
    """The same held commands give the same motion, stepped or simulated at once."""
    run = hc.simulate(plan, rtol=1e-8)
    simulator = hc.Simulator(crane, sample_time=0.01, rtol=1e-8)
    seen = simulator.reset(q=[plan.joints[j] for j in crane.joint_names])
    assert seen.t == 0.0
    assert seen.p.shape == (3, 2)
    for k in range(50):
        seen = simulator.step([0.02 if k < 30 else 0.0, -0.02 if k >= 10 else 0.0, 0.0])
    assert seen.t == pytest.approx(0.5)
    end = [float(run.data["tip.x"][-1]), float(run.data["tip.z"][-1])]
    np.testing.assert_allclose(seen.tip, end, atol=1e-6)
    assert seen.measured["joint.boom.q"] == seen.q[0]
    assert simulator.state.shape == (21,)


def test_reset_to_a_state(crane):
    simulator = hc.Simulator(crane)
    state = crane.equilibrium(crane.home)
    simulator.reset(state=state)
    np.testing.assert_array_equal(simulator.state, state)


def test_simulator_explains_misuse(crane):
    simulator = hc.Simulator(crane)
    with pytest.raises(hc.SimulationError, match="call reset"):
        simulator.step([0, 0, 0])
    with pytest.raises(hc.InputError, match="either q"):
        simulator.reset()
    simulator.reset(q=crane.home)
    with pytest.raises(hc.InputError, match="spool_command must have shape"):
        simulator.step([0.0])
    with pytest.raises(hc.InputError, match="finite"):
        simulator.step([np.nan, 0, 0])
    with pytest.raises(hc.InputError, match="sample_time"):
        hc.Simulator(crane, sample_time=0.0)
    with pytest.raises(hc.InputError, match="a bundled name or a path"):
        hc.Simulator(7)


# --- credit ---------------------------------------------------------------------------------------------------------


def test_cite_names_what_the_run_used(run):
    text = hc.cite(run)
    for key in (
        "heinze2007",
        "canudas1995",
        "luan2017",
        "by hc-exponential-4, a method of hydrocrane that is based on",
        "rottne-f9-lab",
    ):
        assert key in text
    assert "tsitouras" not in text and "steinebach" not in text
    assert text.count("{") == text.count("}")


def test_netcdf_keeps_values_of_every_kind_and_what_is_said_of_them(tmp_path):
    """As h5netcdf writes them; what it writes is what netCDF itself reads."""
    data = xr.Dataset(
        {
            "pressure": (("time", "side"), np.ones((2, 2)), {"units": "Pa"}),
            "closed": ("time", np.array([True, False])),
            "who": ("time", np.array(["lever", "µ"])),
            "count": ((), 3),
        },
        coords={"time": ("time", np.array(["2024-01-01", "2024-01-02"], dtype="datetime64[ns]"))},
        attrs={"text": "µ", "empty": "", "numbers": [1.5, 2.5], "seed": 7, "names": ["a", "b"]},
    )
    ours, theirs = tmp_path / "ours.nc", tmp_path / "theirs.nc"
    write_netcdf(data, ours)
    data.to_netcdf(theirs, engine="h5netcdf")
    with xr.open_dataset(ours, engine="h5netcdf") as one, xr.open_dataset(theirs, engine="h5netcdf") as other:
        xr.testing.assert_identical(one.load(), other.load())
        assert list(one.variables) == list(other.variables)
    with h5py.File(ours) as one, h5py.File(theirs) as other:
        for name in other:
            assert [len(scales) for scales in one[name].dims] == [len(scales) for scales in other[name].dims]
            assert one[name].is_scale == other[name].is_scale
