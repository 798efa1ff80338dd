"""The same content in any container gives the same signals, in SI, or is refused with its cause; nothing is guessed."""

from __future__ import annotations

import warnings
from datetime import UTC, datetime, timedelta

import h5py
import numpy as np
import pandas as pd
import pytest
import scipy.io
import xarray as xr

import hydrocrane as hc
from hydrocrane.result_warning import DoubtfulResult

N = 30
T = np.arange(N) * 0.02


def kinds(log):
    return {flag.kind for flag in log.flags}


def messages(log, kind):
    return "; ".join(flag.message for flag in log.flags if flag.kind == kind)


def text(folder, head, cells, name="log.csv"):
    path = folder / name
    path.write_text(head + "\n" + "\n".join(cells) + "\n", encoding="utf-8")
    return path


# --- decimal marks and marks of thousands ---------------------------------------------------------------------------

# By delimiter: two forms of a pressure that is 998.5 kPa, then 1001 kPa, with the time as decimals.
PRESSURES = {
    "comma, then point of thousands": (";", "{:.2f}", ",", "998,5", "1.001"),
    "point, then comma of thousands": (",", '"{:.2f}"', ".", '"998.5"', '"1,001"'),
    "tab": ("\t", "{:.2f}", ",", "998,5", "1.001"),
    "points and semicolons": (";", "{:.2f}", ".", "998.5", "1,001"),
    "blanks": (" ", "{:.2f}", ",", "998,5", "1.001"),
    "narrow gaps": (";", "{:.2f}", ",", "998,5", "1\u202f001"),
    "apostrophes": (",", "{:.2f}", ".", "998.5", "1'001"),
}


@pytest.mark.parametrize(("delimiter", "clock", "mark", "low", "high"), PRESSURES.values(), ids=PRESSURES)
def test_every_cell_of_a_column_is_evidence(delimiter, clock, mark, low, high, tmp_path):
    rows = [delimiter.join([clock.format(t).replace(".", mark), low if t < 0.3 else high]) for t in T]
    path = text(tmp_path, delimiter.join(["time[s]", "p1[kPa]"]), rows)
    np.testing.assert_allclose(hc.read_log(path)["p1"][[0, -1]], [998500.0, 1001000.0])


def test_what_nothing_decides_is_refused_until_it_is_said(tmp_path):
    path = text(tmp_path, "time;p1 [kPa]", [f"{i};1.{i + 100}" for i in range(N)])
    with pytest.raises(hc.HydrocraneError, match=r"`p1.*may mean decimals or thousands"):
        hc.read_log(path)["p1"]
    assert "may mean decimals or thousands" in messages(hc.read_log(path), "left-out")
    with pytest.raises(hc.InputError, match=r"number_format"):
        hc.read_log(path, {"signal": {"p1": {"column": "p1"}}})
    for given, first in (("1,234.5", 1100.0), ("1.234,5", 1100e3)):
        assert hc.read_log(path, number_format=given)["p1"][0] == pytest.approx(first)
        assert hc.read_log(path, {"number-format": given})["p1"][0] == pytest.approx(first)
    with pytest.raises(hc.InputError, match="number-format is one of"):
        hc.read_log(path, number_format="english")
    mixed = text(tmp_path, "time;x", [f"{i};{i},5" if i < 20 else f"{i};{i}.5" for i in range(N)], "mixed.csv")
    assert "different decimal marks" in messages(hc.read_log(mixed), "left-out")


def test_texts_in_memory_are_read_like_those_of_a_file():
    held = {"time": T, "p1 [kPa]": ["998,5"] * 15 + ["1.001"] * 15, "p2": T}
    for data in (held, pd.DataFrame(held)):
        np.testing.assert_allclose(hc.Log.of(data)["p1"][[0, -1]], [998500.0, 1001000.0])
        np.testing.assert_allclose(hc.Log.of(data, {"signal": {"x": {"column": 2, "unit": "mm"}}})["x"][-1], 1.001)
    # The times say what the mark of the pressure means.
    texts = pd.DataFrame({"p1 [kPa]": ["1.001"] * N, "time": [f"{t:.2f}".replace(".", ",") for t in T]})
    assert hc.Log.of(texts)["p1"][0] == 1001000.0


COMMANDS = {
    "semicolons": ("t [s];u [um]", ["0;0", "0.5;2,500", "1.0;-1,250", "1.5;10,000"]),
    "quotes": ("t [s],u [um]", ["0,0", '0.5,"2,500"', '1.0,"-1,250"', '1.5,"10,000"']),
    "points of thousands": ("t [s];u [um]", ["0;0", "0,5;2.500", "1,0;-1.250", "1,5;10.000"]),
    "tab": ("t [ms]\tu [um]", ["0\t0", "500.0\t2,500", "1000.0\t-1,250", "1500.0\t10,000"]),
}


@pytest.mark.parametrize(("head", "rows"), COMMANDS.values(), ids=COMMANDS)
def test_commands_and_supplies_are_read_by_the_same_rules(head, rows, tmp_path):
    path = text(tmp_path, head, rows)
    with pytest.warns(DoubtfulResult, match="marks of thousands"):
        command = hc.read_commands(path, "rottne-f9-lab", columns={"lift": "u"})["lift"]
    np.testing.assert_allclose(command.time, [0.0, 0.5, 1.0, 1.5])
    np.testing.assert_allclose(command.spool, [0.0, 2.5e-3, -1.25e-3, 1e-2])
    # The core reads the log of a scenario file with the same rule.
    scenario = tmp_path / "s.toml"
    scenario.write_text(
        '[scenario]\nname = "s"\nmachine = "rottne-f9-lab"\nduration = "0.1 s"\n[initial.joint]\nboom = "1.7 rad"\n'
        'jib = "1.7 rad"\nextension = "0 m"\n[command]\nlog = "log.csv"\n[command.lift]\ncolumn = "u"\n'
    )
    np.testing.assert_array_equal(hc.load_scenario(scenario).commands["lift"].spool, command.spool)
    supply = text(tmp_path, head.replace("u [um]", "p [kPa]"), [row.replace("-", "") for row in rows], "p.csv")
    with pytest.warns(DoubtfulResult, match="marks of thousands"):
        assert hc.read_supply(supply, column="p").pressure[-1] == pytest.approx(10e6)
    undecided = text(tmp_path, "t;u [um]", ["0;1,000", "1;2,500"], "u.csv")
    with pytest.raises(hc.InputError, match=r"`1,000` may mean"):
        hc.read_commands(undecided, "rottne-f9-lab", columns={"lift": "u"})
    scenario.write_text(scenario.read_text().replace("log.csv", "u.csv"))
    with pytest.raises(hc.HydrocraneError, match=r"`1,000` may mean"):
        hc.load_scenario(scenario)


# What loggers write for times 0 and 0.5 s and 2 and -1.5 mm.
WRITTEN = {
    "Latin-1": ("time [s];lift [µm]\n0,0;2000,0\n0,5;-1500,0\n", "latin-1"),
    "UTF-16": ("time\tlift\ns\tmm\n0.0\t2.0\n0.5\t-1.5\n", "utf-16"),
    "UTF-16 of another byte order": ("\ufefftime\tlift\ns\tmm\n0.0\t2.0\n0.5\t-1.5\n", "utf-16-be"),
    "a mark before UTF-8": ("time,lift (mm)\n0,2\n0.5,-1.5\n", "utf-8-sig"),
    "a stated delimiter": ("sep=;\ntime;lift [mm]\n0;2\n0,5;-1,5\n", "utf-8"),
    "ends of old lines": ("time,lift [mm]\r0,2\r0.5,-1.5\r", "utf-8"),
    "titles": ("Rig 7;;\n;;\ntime;lift [mm];\n0;2;\n0.5;-1.5;\n", "utf-8"),
    "quotes": ('"time","lift [um]"\n"0.0","2,000"\n"0.5","-1,500"\n', "utf-8"),
    "dates": ("lift [mm],when\n2,2024-05-01T12:30:00.25Z\n-1.5,2024-05-01T14:30:00.75+02:00\n", "utf-8"),
    "a time of day": ("time;lift [mm]\n23:59:59,75;2\n00:00:00,25;-1.5\n", "utf-8"),
    "a column that begins late": ("note\ttime\tlift [mm]\n\t0.0\t2.0\n\t0.5\t-1.5\n", "utf-8"),
    "a comment as header": ("# made by hand\n% time lift\n0.0 2e-3\n0.5 -1.5e-3\n", "utf-8"),
}


@pytest.mark.parametrize(("content", "encoding"), WRITTEN.values(), ids=WRITTEN)
def test_what_python_reads_a_scenario_file_reads(content, encoding, tmp_path):
    (tmp_path / "log.csv").write_bytes(content.encode(encoding))
    log = hc.read_log(tmp_path / "log.csv")
    np.testing.assert_allclose([log.time, log["lift"]], [[0.0, 0.5], [2e-3, -1.5e-3]])
    scenario = tmp_path / "s.toml"
    scenario.write_text(
        '[scenario]\nname = "s"\nmachine = "rottne-f9-lab"\nduration = "0.1 s"\n[initial.joint]\nboom = "1.7 rad"\n'
        'jib = "1.7 rad"\nextension = "0 m"\n[command]\nlog = "log.csv"\n'
    )
    command = hc.load_scenario(scenario).commands["lift"]
    np.testing.assert_array_equal([command.time, command.spool], [log.time, log["lift"]])


def test_commands_come_from_any_log():
    log = {"time": pd.to_timedelta([0, 500], unit="ms"), "lift [mm]": [1.0, 2.0]}
    for data in (log, pd.DataFrame(log), hc.Log.of(log)):
        command = hc.read_commands(data, "rottne-f9-lab")["lift"]
        np.testing.assert_allclose([command.time, command.spool], [[0.0, 0.5], [1e-3, 2e-3]])
    with pytest.raises(hc.InputError, match="`bar` is not a unit of"):
        hc.read_commands({"time": [0.0, 1.0], "lift [bar]": [0.0, 1.0]}, "rottne-f9-lab")
    with pytest.raises(hc.InputError, match="no value .* at sample 2"):
        hc.read_commands({"time": [0.0, 1.0], "lift": [0.0, np.nan]}, "rottne-f9-lab")
    supply = hc.read_supply({"time": [0.0, 1.0], "supply": [101.01325, 91.01325]}, unit="bara")
    np.testing.assert_allclose(supply.pressure, [100e5, 90e5])


# --- missing samples ------------------------------------------------------------------------------------------------

BAD = np.arange(N) % 5 == 0
WAY = np.where(BAD, -999.0, T)


def masked_frame():
    return pd.DataFrame({"time": T, "x": pd.array(WAY, dtype="Float64")}).mask(BAD[:, None] & [[False, True]])


def packed(attributes):
    return {"x": ("time", np.where(BAD, -999, 1000 * T).astype("i2"), attributes)}


MASKED = {
    "masked array": lambda folder: {"time": T, "x": np.ma.masked_where(BAD, WAY)},
    "nullable frame": lambda folder: masked_frame(),
    "undecoded data set": lambda folder: xr.Dataset(
        packed({"units": "m", "missing_value": -999, "scale_factor": 1e-3}), coords={"time": T}
    ),
    "valid range": lambda folder: xr.Dataset(
        packed({"units": "mm", "valid_range": np.array([0, 5000])}), coords={"time": T}
    ),
    "netCDF": lambda folder: written(folder / "m.nc", packed({"units": "mm", "_FillValue": np.int16(-999)})),
    "HDF5": lambda folder: in_hdf5(folder / "m.h5", {"units": "mm", "_FillValue": np.int16(-999)}),
    "HDF5 in a group": lambda folder: in_hdf5(
        folder / "g.h5", {"unit": "m", "missing_value": np.int16([-999]), "scale_factor": np.float32(1e-3)}
    ),
    "HDF5 with a range": lambda folder: in_hdf5(
        folder / "r.h5", {"units": "mm", "valid_range": np.array([0, 5000], "i2")}
    ),
    "parquet": lambda folder: parquet(folder / "m.parquet"),
}


def written(path, variables):
    xr.Dataset(variables, coords={"time": T}).to_netcdf(path)
    return path


def in_hdf5(path, attributes):
    with h5py.File(path, "w") as stored:
        stored["time"] = T
        stored["x"] = packed({})["x"][1]
        stored["x"].attrs.update(attributes)
    return path


def parquet(path):
    masked_frame().to_parquet(path)
    return path


@pytest.mark.parametrize("make", MASKED.values(), ids=MASKED)
def test_samples_that_a_source_marks_as_invalid_are_missing(make, tmp_path):
    log = hc.Log.of(make(tmp_path))
    np.testing.assert_array_equal(np.isnan(log["x"]), BAD)
    np.testing.assert_allclose(log["x"][~BAD], T[~BAD], atol=1e-6)
    assert "6 samples missing" in log.summary()


def test_how_many_samples_are_marked_is_said():
    found = messages(hc.Log.of({"time": T, "x": np.ma.masked_where(BAD, WAY)}), "masked")
    assert "6 of 30 samples that its source marks as invalid" in found


def test_packed_numbers_of_hdf5(tmp_path):
    with h5py.File(tmp_path / "p.h5", "w") as stored:
        stored["time"] = T
        stored["x"] = (np.arange(N) * 10).astype("i2")
        stored["x"].attrs.update({"units": "mm", "scale_factor": 0.1, "add_offset": 5.0, "_FillValue": np.int16(20)})
    np.testing.assert_allclose(hc.read_log(tmp_path / "p.h5")["x"][:4], [0.005, 0.006, np.nan, 0.008])


# --- channels of MDF ------------------------------------------------------------------------------------------------


def mdf(path, *groups):
    asammdf = pytest.importorskip("asammdf")
    with asammdf.MDF(version="4.10") as stored:
        for signals in groups:
            stored.append([asammdf.Signal(**signal) for signal in signals])
        stored.save(path, overwrite=True)
    return path


def test_invalidation_bits_of_mdf(tmp_path):
    pressure = {"samples": np.where(BAD, 0.0, 60.0), "timestamps": T, "name": "p1", "unit": "bar"}
    path = mdf(tmp_path / "i.mf4", [pressure | {"invalidation_bits": BAD}])
    log = hc.read_log(path)
    np.testing.assert_array_equal(np.isnan(log["p1"]), BAD)
    assert "6 of 30" in messages(log, "masked")


def test_the_longest_raster_is_the_clock(tmp_path):
    slow, burst = np.arange(100) * 1.0, 5.0 + np.arange(200) * 1e-3
    path = mdf(
        tmp_path / "b.mf4",
        [{"samples": slow, "timestamps": slow, "name": "x", "unit": "mm"}],
        [{"samples": np.sin(burst), "timestamps": burst, "name": "acc", "unit": "m/s^2"}],
    )
    log = hc.read_log(path)
    assert log.time[-1] == 99.0 and np.isfinite(log["acc"]).sum() == 1
    assert "Most of its samples are lost" in messages(log, "resampled")
    own = hc.read_log(path, {"time": {"column": "time.2"}, "signal": {"acc": {}}})
    np.testing.assert_allclose(own["acc"], np.sin(burst))


# --- clocks ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("zero", [739000.5, 45000.25], ids=["MATLAB", "Excel"])
def test_serial_days_are_no_seconds(zero, tmp_path):
    days = zero + T / 86400
    scipy.io.savemat(tmp_path / "s.mat", {"time": days, "x": T})
    with pytest.raises(hc.InputError, match='count d; say .time. unit = "d"'):
        hc.read_log(tmp_path / "s.mat")
    with pytest.raises(hc.InputError, match="count d;"):
        hc.Log.of({"time": days, "x": T})
    log = hc.read_log(tmp_path / "s.mat", {"time": {"column": "time", "unit": "d"}})
    np.testing.assert_allclose(np.diff(log.time), 0.02, atol=2e-5)
    late = hc.Log.of({"time": 45000.0 + np.arange(N), "x": T})
    assert late.time[1] - late.time[0] == 1.0


DATES = {
    "day first, over midnight": ["12/01/2024 23:59:59.5", "13/01/2024 00:00:00.5"],
    "month first, over midnight": ["01/12/2024 23:59:59.5", "01/13/2024 00:00:00.5"],
    "one date goes on": ["02/03/2024 23:59:59.5", "03/03/2024 00:00:00.5"],
    "end of a month": ["31-12-2024 23:59:59.5", "01-01-2025 00:00:00.5"],
    "end of February": ["02/29/2024 23:59:59.5", "03/01/2024 00:00:00.5"],
    "one day alone": ["02/03/2024 12:00:00.5", "02/03/2024 12:00:01.5"],
}


@pytest.mark.parametrize("stamps", DATES.values(), ids=DATES)
def test_the_order_of_day_and_month_is_decided_once(stamps, tmp_path):
    cells = [f"{stamp}{k},{i}" for i, stamp in enumerate(stamps) for k in range(6)]
    log = hc.read_log(text(tmp_path, "timestamp,x [m]", cells))
    np.testing.assert_allclose(log.time[[0, 5, 6]], [0.0, 0.05, 1.0], atol=1e-6)
    held = hc.Log.of(pd.DataFrame({"timestamp": [cell.split(",")[0] for cell in cells], "x": np.arange(12.0)}))
    np.testing.assert_allclose(held.time, log.time)


def test_an_undecided_order_is_asked(tmp_path):
    path = text(tmp_path, "timestamp,x [m]", [f"0{d}/0{d + 2}/2024 12:00:0{k}.0,1" for d in (1, 4) for k in range(6)])
    with pytest.raises(hc.InputError, match="date-order"):
        hc.read_log(path)
    for order, days in (("day-month", 92 - 1), ("month-day", 91 + 2)):
        log = hc.read_log(path, {"time": {"date-order": order}})
        expected = {"day-month": datetime(2024, 6, 4) - datetime(2024, 3, 1)}.get(
            order, datetime(2024, 4, 6) - datetime(2024, 1, 3)
        )
        assert log.time[6] == expected.total_seconds(), days


def test_times_with_zones_and_durations():
    start = datetime(2024, 3, 31, 0, 59, 59, tzinfo=UTC)
    stamps = pd.DatetimeIndex([start + timedelta(seconds=0.1 * i) for i in range(N)]).tz_convert("Europe/Stockholm")
    for data in (
        pd.DataFrame({"time": stamps, "x": T}),
        pd.DataFrame({"x": T}, index=stamps),
        {"time": stamps.to_pydatetime(), "x": T},
        pd.DataFrame({"time": stamps - stamps[0], "x": T}),
        pd.DataFrame({"x": T}, index=stamps - stamps[0]),
    ):
        np.testing.assert_allclose(hc.Log.of(data).time, 0.1 * np.arange(N), atol=1e-6)


# --- units ----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def run():
    return hc.simulate("single-cylinder-step", duration=0.5)


def test_a_comparison_is_in_the_run_s_units(run, tmp_path):
    t, z = run.columns.time, run.columns["tip.z"].values
    data = xr.Dataset(
        {"tip.z": ("time", z * 1e3, {"units": "mm"})}, coords={"time": ("time", t * 1e3, {"units": "ms"})}
    )
    data.to_netcdf(tmp_path / "d.nc")
    frame = pd.DataFrame({"time [ms]": t * 1e3, "tip.z (mm)": z * 1e3})
    frame.to_parquet(tmp_path / "d.parquet")
    frame.to_excel(tmp_path / "d.xlsx", index=False)
    attributes = pd.DataFrame({"time": t * 1e3, "tip.z": z * 1e3})
    attributes.attrs["units"] = {"time": "ms", "tip.z": "mm"}
    held = {"time [ms]": t * 1e3, "tip.z [mm]": z * 1e3}
    for log in (data, tmp_path / "d.nc", frame, tmp_path / "d.parquet", tmp_path / "d.xlsx", attributes, held):
        found = run.compare(log)
        assert found["tip.z"].left_out == 0 and found.rms["tip.z"] < 1e-9
    with pytest.raises(hc.InputError, match="`bar` is not a unit of `tip.z`"):
        run.compare({"time": t, "tip.z [bar]": z})
    with pytest.raises(hc.InputError, match="`furlong` of column .* must be one of m"):
        run.compare({"time": t, "tip.z [furlong]": z})
    with pytest.raises(hc.InputError, match="its clock restarts"):
        run.compare({"time": np.r_[t, t], "tip.z": np.r_[z, z]})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DoubtfulResult)
        masked = run.compare({"time": t, "tip.z": np.ma.masked_where(t > 0.2, np.where(t > 0.2, -999.0, z))})
    assert masked.rms["tip.z"] == 0.0 and masked["tip.z"].left_out == int((t > 0.2).sum())


def test_sticks_are_in_their_units():
    for log in (
        {"time [ms]": [0.0, 1000.0], "stick.z [%]": [0.0, 50.0]},
        pd.DataFrame({"t (ms)": [0.0, 1000.0], "z (%)": ["0,0", "50,0"]}),
    ):
        stick = hc.Joystick.from_log(log)
        np.testing.assert_allclose([stick.time, stick.axes["z"]], [[0.0, 1.0], [0.0, 0.5]])
    with pytest.raises(hc.InputError, match="is not a unit of"):
        hc.Joystick.from_log({"time": [0.0, 1.0], "stick.z [mm]": [0.0, 1.0]})


@pytest.mark.parametrize("suffix", ["parquet", "xlsx", "csv", "nc", "mat"])
def test_a_saved_run_is_a_log(run, suffix, tmp_path):
    again = run.compare(run.save(tmp_path / f"run.{suffix}"), {"tip.z": "tip.z"} if suffix == "mat" else None)
    assert again.rms["tip.z"] < 1e-12
