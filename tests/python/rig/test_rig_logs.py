"""Logs of the rig: what the sensors read, how it is repeatable, where it is saved, and how wrong input is answered."""

from __future__ import annotations

import csv

import h5py
import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp
from scipy.io import loadmat

import hydrocrane as hc
from hydrocrane import rig
from hydrocrane.app.cli import main

SHORT = {"cycles": 1, "interval": 2e-3}
SIGNALS = {"x": "joint.slide.q", "p1": "cylinder.test.p1", "p2": "cylinder.test.p2", "force": "cylinder.test.force"}


@pytest.fixture(scope="module")
def run():
    return hc.simulate(rig.scenario("rig-rottne", "small-sine", **SHORT), ledger=False)


# --- sensors on recorded data ---------------------------------------------------------------------------------------


def test_ideal_sensors_read_the_record(run):
    readings = run.machine.measure(run, sensors="ideal")
    assert set(readings.data_vars) == set(SIGNALS.values())
    for name in readings.data_vars:
        assert (readings[name].values == run.data[name].values).all()
        assert readings[name].attrs["units"] == run.data[name].attrs["units"]


def test_one_run_serves_many_seeds_and_a_seed_repeats(run):
    crane = run.machine
    by_seed = [crane.measure(run, seed=seed) for seed in range(20)]
    assert by_seed[7].identical(crane.measure(run.data, seed=7))
    zeros = {float((r["cylinder.test.p1"] - run.data["cylinder.test.p1"]).mean()) for r in by_seed}
    assert len(zeros) == 20


def test_readings_stay_within_the_data_sheets_and_use_them(run):
    largest = dict.fromkeys(SIGNALS, 0.0)
    for seed in range(60):
        readings = run.machine.measure(run, seed=seed)
        for name, signal in SIGNALS.items():
            error = np.abs((readings[signal] - run.data[signal]).values[20:])
            largest[name] = max(largest[name], float(error.max()))
    # Linearity, repeatability, six deviations of noise, half a code; transmitters also lag by 4 ms / ln 9.
    lag = 4e-3 / np.log(9) * float(np.abs(run.data["cylinder.test.p1"].differentiate("time")).max())
    bounds = {
        "x": 1.25 * (0.0025 + 0.0003 + 6 * 4e-5),
        "p1": 400e5 * (0.003 + 6e-4) + lag,
        "force": 5e3 * (0.002 + 6e-4),
    }
    for name, bound in bounds.items():
        assert 0.4 * bound < largest[name] < 1.01 * bound, name


def test_transmitters_lag_as_their_rise_time_says(run):
    """Against the lag integrated here for the same straight lines between records."""
    quiet = {f"sensor.{s}.{key}": 1e-12 for s in ("p1", "p2") for key in ("accuracy", "noise")} | {
        f"sensor.{s}.bits": 32 for s in ("p1", "p2")
    }
    readings = hc.load_machine("rig-rottne", quiet).measure(run)
    p, time = run.data["cylinder.test.p1"].values, run.data.time.values
    fastest = int(np.abs(np.diff(p)).argmax())
    tau, until = 4e-3 / np.log(9), time[fastest]
    lag = solve_ivp(lambda t, y: (np.interp(t, time, p) - y) / tau, (0, until), p[:1], rtol=1e-9, max_step=5e-4)
    lagged = lag.y[0, -1]
    assert readings["cylinder.test.p1"].values[fastest] == pytest.approx(lagged, abs=10.0)
    assert abs(p[fastest] - lagged) > 1000.0


def test_the_position_reads_differently_on_the_way_back():
    """The hysteresis of the wire potentiometer: one size per seed, either sign, no more than the data sheet says."""
    quiet = {"sensor.position.noise": 1e-12, "sensor.position.linearity": 1e-12, "sensor.position.bits": 32}
    log = rig.run("constant-velocity", levels=[0.05], overrides=quiet, sensors="ideal")
    crane, (out, back) = log.run.machine, log.segments
    offsets = []
    for seed in range(40):
        read = crane.measure(log.run, seed=seed)["joint.slide.q"] - log.run.data["joint.slide.q"]
        away, home = (read.sel(time=slice(s.start + 0.5, s.end - 0.1)).values for s in (out, back))
        assert np.ptp(away) < 1e-8 and np.ptp(home) < 1e-8
        assert away[0] == pytest.approx(-home[0], abs=1e-8)
        offsets.append(away[0])
    assert 0.9 * 3.75e-4 < np.abs(offsets).max() <= 3.75e-4
    assert 8 < np.sum(np.array(offsets) < 0) < 32


def test_the_converters_are_of_16_bits_and_of_12_on_demand():
    for bits in (16, 12):
        log = rig.run("small-sine", bits=bits, **SHORT)
        for name, span in (("x", 1.25), ("p1", 500e5), ("force", 1e4)):
            steps = np.diff(np.unique(log.data[name].values)) * (2**bits - 1) / span
            assert steps == pytest.approx(np.round(steps), abs=1e-3) and steps.min() == pytest.approx(1.0, abs=1e-3)


def test_a_failing_sensor_of_a_record(run):
    fault = hc.SensorFault("cylinder.test.p2", "freeze", 2.0)
    readings = run.machine.measure(run, faults=[fault])["cylinder.test.p2"]
    assert np.ptp(readings.sel(time=slice(2.0, None)).values) == 0.0 < np.ptp(readings.sel(time=slice(0, 1.9)).values)


# --- logs -----------------------------------------------------------------------------------------------------------


def test_a_calibration_reads_the_zero_of_the_pressure_sensors():
    """What a sensor reads at zero pressure is its error there, of either sign; taking it away leaves the span's."""
    zeros = []
    for seed in range(12):
        log = rig.run("small-sine", seed=seed, calibration=1.0, **SHORT)
        start = log.data.attrs["calibration"]
        assert start == 1.0 and log.segments[0].start == pytest.approx(2.0)
        rest = log.data.sel(time=slice(0, start - 1e-9))
        truth = log.truth.sel(time=slice(0, start - 1e-9))
        assert rest.sizes["time"] == 500 and (truth.p1 == 0).all() and (truth.force == 0).all()
        assert np.ptp(truth.x.values) == 0 and (rest.command == 0).all()
        zero = float(rest.p1.mean())
        later = slice(start + 0.5, None)
        error = (log.data.p1 - log.truth.p1).sel(time=later)
        # The span's error grows with pressure, 0.15 % of full scale at 200 bar.
        assert float(np.abs(error - zero).mean()) < 0.003 * float(log.truth.p1.sel(time=later).max()) + 4e3
        zeros.append(zero)
    assert min(zeros) < -1e4 and max(zeros) > 1e4


def test_truth_does_not_depend_on_seed_sensors_or_calibration():
    one = rig.run("small-sine", seed=1, **SHORT)
    two = rig.run("small-sine", seed=2, sensors="ideal", calibration=0.5, **SHORT)
    later = two.truth.sel(time=slice(0.5, None))
    assert (one.truth.friction.values == later.friction.values).all()
    assert np.abs(two.data.x - two.truth.x).max() < 1e-12 < np.abs(one.data.x - one.truth.x).min()


def test_a_log_says_what_was_run():
    log = rig.run("small-sine", "rig-kalmar", payload=20.0, supply="35 bar", seed=4, load_cell=False, **SHORT)
    about = log.data.attrs
    told = [about[key] for key in ("experiment", "machine", "payload", "supply", "seed", "sensors", "outcome")]
    assert told == ["small-sine", "rig-kalmar", 20.0, 35e5, 4, "data-sheet", "completed"]
    assert list(log.data.data_vars) == ["x", "p1", "p2", "command"] and log.data.p1.attrs["units"] == "Pa"
    (segment,) = log.segments
    assert segment.name == "sine" and log.part(segment).sizes["time"] > 2000
    assert "20 kg" in repr(log)


@pytest.mark.parametrize("suffix", ["csv", "mat", "nc", "h5"])
def test_a_saved_log_holds_what_was_read(suffix, tmp_path):
    log = rig.run("small-sine", seed=1, **SHORT)
    path = log.save(tmp_path / f"deep/log.{suffix}")
    names = ["time", "x", "p1", "p2", "force", "command"]
    if suffix == "csv":
        with path.open(encoding="utf-8", newline="") as file:
            rows = [row for row in csv.reader(file) if not row[0].startswith("#")]
        assert rows[:2] == [names, ["s", "m", "Pa", "Pa", "N", "m"]]
        found = dict(zip(names, np.array(rows[2:], dtype=float).T, strict=True))
    elif suffix == "mat":
        found = loadmat(path, squeeze_me=True, simplify_cells=True)
        assert found["units"]["p1"] == "Pa" and found["about"]["experiment"] == "small-sine"
    else:
        with h5py.File(path) as stored:
            found = {name: stored[name][()] for name in names}
            assert stored.attrs["seed"] == 1
    back = hc.read_log(path)
    assert not back.flags and back.data.attrs == {**log.data.attrs, "source": str(path)}
    for name in names:
        assert (back.data[name].values == log.data[name].values).all()
        assert found[name] == pytest.approx(log.data[name].values, rel=1e-8, abs=1e-12), name


# --- wrong input ----------------------------------------------------------------------------------------------------

WRONG = {
    "experiment": (lambda: rig.run("ramps"), ["ramps", "`ramp`"]),
    "rig": (lambda: rig.run("ramp", "rottne-f9-lab"), ["rottne-f9-lab", "rig-rottne"]),
    "option": (lambda: rig.run("ramp", sped=1.0), ["ramp", "`sped`", "`speed`"]),
    "option below zero": (lambda: rig.run("small-sine", frequency=-1.0), ["frequency", "-1.0"]),
    "levels": (lambda: rig.run("constant-velocity", levels=[0.0, 0.1]), ["levels"]),
    "level twice": (lambda: rig.run("constant-velocity", levels=[0.1, 0.1]), ["levels", "once"]),
    "too fast": (lambda: rig.run("constant-velocity", levels=[0.5]), ["rig-rottne", "0.5 m/s", "supply.pressure"]),
    "too long": (lambda: rig.run("constant-velocity", levels=[0.1], seconds=30), ["stroke", "3000 mm"]),
    "one level": (lambda: rig.run("constant-velocity", levels=0.1), ["levels", "numbers", "0.1"]),
    "two frequencies": (lambda: rig.run("small-sine", frequency=[0.1, 0.2]), ["frequency", "one number"]),
    "too quick": (lambda: rig.run("small-sine", frequency=1e4), ["slower"]),
    "no motion": (lambda: rig.steady_motion(hc.load_machine("rig-rottne"), 0.0), ["velocity"]),
    "sensors": (lambda: rig.run("ramp", sensors="datasheet"), ["datasheet", "data-sheet"]),
    "seed": (lambda: rig.run("small-sine", seed=-1, **SHORT), ["seed", "-1"]),
    "calibration": (lambda: rig.run("ramp", calibration=-1.0), ["calibration", "-1.0"]),
    "load cell": (lambda: rig.run("ramp", "single-cylinder"), ["single-cylinder", "load_cell=False"]),
    "bits": (lambda: rig.run("ramp", bits=0), ["bits"]),
    "varied": (lambda: rig.series("load-variation", payload=20.0), ["payload", "omit it"]),
    "table": (lambda: rig.loaded_friction("rig-rotne"), ["rig-rotne", "rig-rottne"]),
    "table's load": (lambda: rig.loaded_friction("rig-rottne", 20), ["20", "115"]),
    "damping": (lambda: rig.bristle_damping(0.0, 5.0, 100.0), ["stiffness", "0.0"]),
    "record": (lambda: hc.load_machine("rig-rottne").measure("run"), ["run", "str"]),
    "another machine's record": (
        lambda: hc.load_machine("rottne-f9-lab").measure(hc.simulate("rig-step")),
        ["joint.boom.q", "rottne-f9-lab"],
    ),
}


@pytest.mark.parametrize(("call", "words"), WRONG.values(), ids=WRONG)
def test_wrong_input_is_one_clear_error(call, words):
    with pytest.raises(hc.HydrocraneError) as raised:
        call()
    assert all(word in str(raised.value) for word in words), raised.value


# --- command line ---------------------------------------------------------------------------------------------------


def command(*arguments):
    """Exit status of the command line."""
    with pytest.raises(SystemExit) as ended:
        main(["rig", *arguments])
    return ended.value.code or 0


def test_the_command_line_runs_an_experiment(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert command("list") == 0
    shown = capsys.readouterr().out
    assert all(name in shown for name in (*rig.experiments(), "rig-kalmar"))
    how = ["--payload", "20", "--supply", "100 bar", "--seed", "3", "--set", "sensor.p1.noise=0.05 %"]
    assert command("run", "step", *how, "-o", "log.nc") == 0
    assert "log.nc" in capsys.readouterr().out
    expected = rig.run("step", payload=20.0, supply="100 bar", seed=3, overrides={"sensor.p1.noise": "0.05 %"}).data
    with xr.open_dataset("log.nc", engine="h5netcdf", decode_times=False) as stored:
        assert all((stored[name].values == expected[name].values).all() for name in expected.data_vars)


def test_the_command_line_writes_one_file_per_load(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert command("run", "load-variation", "-o", "log.nc") == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["log-0kg.nc", "log-115kg.nc", "log-20kg.nc"]
    assert command("run", "load-variation", "--payload", "20", "-o", "one.nc") == 0
    assert (tmp_path / "one.nc").is_file()
    capsys.readouterr()


def test_the_command_line_answers_mistakes_before_it_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for arguments, word in (
        (["rampe"], "ramp"),
        (["ramp", "-o", "log.xls"], ".csv"),
        (["ramp", "--rig", "rig"], "no bundled machine `rig`"),
    ):
        assert command("run", *arguments) == 2
        assert word in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
