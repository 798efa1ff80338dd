"""What a file leaves open is asked or flagged, and no number is read with another meaning than its file gives it."""

from __future__ import annotations

import json

import h5py
import numpy as np
import pandas as pd
import pytest
import scipy.sparse
import xarray as xr
from scipy.io import savemat

import hydrocrane as hc

N = 60
T = np.arange(N) * 0.02
X = 0.1 * np.sin(T)


def said(log, kind):
    return "; ".join(flag.message for flag in log.flags if flag.kind == kind)


def text(folder, content, name="log.csv"):
    path = folder / name
    path.write_text(content, encoding="utf-8")
    return path


def rows(form):
    return "".join(form(i, t) + "\n" for i, t in enumerate(T))


# --- clocks ---------------------------------------------------------------------------------------------------------


def two_dimensions(folder):
    data = xr.Dataset({"x": ("time", X), "p1": ("b", 50e5 + T)}, {"time": T, "b": T + 7})
    return data if folder is None else (data.to_netcdf(folder / "d.nc"), folder / "d.nc")[1]


def a_group(folder):
    with h5py.File(folder / "g.h5", "w") as stored:
        stored["time"], stored["x"], stored["b/time"], stored["b/p1"] = T, X, T + 7, 50e5 + T
    return folder / "g.h5"


@pytest.mark.parametrize("make", [lambda _: two_dimensions(None), two_dimensions, a_group], ids=["xarray", "nc", "h5"])
def test_a_variable_keeps_the_clock_of_its_dimension_or_group(make, tmp_path):
    source = make(tmp_path)
    log = hc.Log.of(source)
    assert list(log.data.data_vars) == ["x"] and "part of another recording, with times in `b" in said(log, "left-out")
    name, clock = ("b.p1", "b.time") if "group" in make.__name__ else ("p1", "b")
    own = hc.Log.of(source, {"time": {"column": clock}, "signal": {"p1": {"column": name}}})
    np.testing.assert_allclose(own.time, T + 7)
    with pytest.raises(hc.InputError, match="part of another recording"):
        hc.Log.of(source, {"signal": {"p1": {"column": name}}})
    with pytest.raises(hc.InputError, match="part of another recording"):
        hc.Log.of(source, {"time": {"column": clock}, "signal": {"x": {}}})
    shared = hc.Log.of(source, {"signal": {"x": {}, "p1": {"column": name, "time": clock}}}) if T[-1] > 7 else None
    assert shared is None or np.isfinite(shared["p1"]).any()


def test_a_dimension_without_times_has_none_of_another():
    data = xr.Dataset({"x": ("time", X), "p1": ("b", 50e5 + T)}, {"time": T, "b": [f"{i}" for i in range(N)]})
    assert "it is over `b`, of which no variable is the time" in said(hc.Log.of(data), "left-out")


def test_the_only_group_with_times_is_read(tmp_path):
    savemat(tmp_path / "s.mat", {"rig": {"time": T, "x": X}})
    log = hc.read_log(tmp_path / "s.mat")
    np.testing.assert_allclose([log.time, log["rig.x"]], [T, X])


CLOCKS = {"timestamp,T": 0, "T,timestamp": 1, "T,Zeit": 1, "T,t": 1, "TIME,time": 1, "T [degC],t [s]": 1, "T,x": 0}


@pytest.mark.parametrize(("names", "wanted"), CLOCKS.items(), ids=CLOCKS)
def test_a_t_that_may_be_a_temperature_is_no_clock_beside_another(names, wanted, tmp_path):
    cells = [(t, 20 + 1.5 * t)[:: 1 - 2 * wanted] for t in T]
    path = text(tmp_path, f"{names},lift [mm]\n" + "".join(f"{a},{b},{i}\n" for i, (a, b) in enumerate(cells)))
    np.testing.assert_allclose(hc.read_log(path).time, T)
    np.testing.assert_allclose(hc.read_commands(path, "rottne-f9-lab")["lift"].time, T)


@pytest.mark.parametrize("names", ["TIME,Time", "time [s],time [ms]"])
def test_two_clocks_of_one_name_are_asked(names, tmp_path):
    path = text(tmp_path, f"{names},supply [bar]\n" + rows(lambda i, t: f"{t},{20 + i},100"))
    for read in (hc.read_log, hc.read_supply):
        with pytest.raises(hc.InputError, match="log.csv has `.*` and `.*`; say by its full name which is"):
            read(path)
    full = names.split(",")[1]
    assert hc.read_log(path, {"time": {"column": full, "unit": "s"}}).time[0] == 20
    stick = {"time": [0.0, 1.0], "z [%]": [0.0, 50.0], "z (%)": [0.0, 40.0]}
    with pytest.raises(hc.InputError, match="which is `z`"):
        hc.Joystick.from_log(stick)


def test_a_gap_of_another_clock_is_not_bridged(tmp_path):
    text(tmp_path, "time,x [m]\n" + rows(lambda i, t: f"{t},{i}"), "a.csv")
    kept = (T < 0.3) | (T > 0.8)
    text(tmp_path, "time,p1 [bar]\n" + "".join(f"{t},{50 if t < 0.5 else 90}\n" for t in T[kept]), "b.csv")
    log = hc.read_log(tmp_path, {"signal": {"x": {"file": "a.csv"}, "p1": {"file": "b.csv"}}})
    np.testing.assert_array_equal(np.isfinite(log["p1"]), kept)
    assert "34 of 60 have a value, 26 are in gaps of more than 5 of its usual intervals" in said(log, "resampled")


def test_days_from_zero_are_no_seconds(tmp_path):
    pd.DataFrame({"time": T / 86400, "x [m]": X}).to_excel(tmp_path / "d.xlsx", index=False)
    with pytest.raises(hc.InputError, match='say .time. unit = "d"'):
        hc.read_log(tmp_path / "d.xlsx")
    np.testing.assert_allclose(hc.read_log(tmp_path / "d.xlsx", {"time": {"unit": "d"}}).time, T, atol=1e-9)


@pytest.mark.parametrize("clock", ["Time", "Uhrzeit"])
@pytest.mark.parametrize("suffix", ["csv", "xlsx"])
def test_dates_and_times_of_day_belong_together(suffix, clock, tmp_path):
    days = pd.to_datetime(["2024-05-13"] * 30 + ["2024-05-14"] * 30)
    cells = pd.DataFrame({"Date": days, clock: [f"10:00:{t:05.2f}" for t in T], "x [m]": X})
    if suffix == "xlsx":
        cells.to_excel(tmp_path / "d.xlsx", index=False)
    else:
        cells.assign(Date=days.strftime("%d.%m.%Y")).to_csv(tmp_path / "d.csv", index=False)
    for mapping in (None, {"time": {"column": clock}, "signal": {"x": {}}}):
        log = hc.read_log(tmp_path / f"d.{suffix}", mapping)
        np.testing.assert_allclose(log.time, T + 86400 * (np.arange(N) >= 30), atol=1e-6)
    assert list(log.data.data_vars) == ["x"]


def test_times_of_day_beside_undecided_dates_are_refused(tmp_path):
    path = text(tmp_path, "Date;Time;x\n" + rows(lambda i, t: f"0{1 + 3 * (i >= 30)}/05/2024;10:00:{t:05.2f};{i}"))
    with pytest.raises(hc.InputError, match="a time of day beside the dates in `Date`, .* say .time. date-order"):
        hc.read_log(path)
    assert hc.read_log(path, {"time": {"date-order": "day-month"}}).time[30] == pytest.approx(3 * 86400 + 0.6)


# --- columns --------------------------------------------------------------------------------------------------------


def test_a_number_of_a_column_counts_those_of_the_file(tmp_path):
    path = text(tmp_path, "time,state,a,b,c\n" + rows(lambda i, t: f"{t},OK,{60 + i},20,5"))
    held = {"time": T, "state": ["OK"] * N, "a": 60.0 + np.arange(N), "b": [f"{i},5" for i in range(N)], "c": T}
    for source in (path, pd.DataFrame(held), held):
        log = hc.Log.of(source, {"time": {"column": 1}, "signal": {"p1": {"column": 3, "unit": "bar"}}})
        assert log["p1"][0] == 60e5
        for number, why in ((2, "words, not numbers|begins with `OK`"), (6, "columns count from 1 to 5")):
            with pytest.raises(hc.InputError, match=why):
                hc.Log.of(source, {"signal": {"p1": {"column": number}}})


def test_sparse_matrices_and_cells_are_left_out_with_the_reason(tmp_path):
    content = {"time": T, "x": X, "p1": scipy.sparse.csc_matrix(T), "p2": np.array([*T], dtype=object)}
    savemat(tmp_path / "s.mat", content)
    with h5py.File(tmp_path / "s.h5", "w") as stored:
        stored["time"], stored["x"], stored["p1/data"] = T, X, T[1:]
        stored["p1"].attrs["MATLAB_sparse"] = np.uint64(N)
        stored["p1/ir"] = stored["p1/jc"] = np.arange(N)
    for name in ("s.mat", "s.h5"):
        log = hc.read_log(tmp_path / name)
        assert list(log.data.data_vars) == ["x"] and "`p1` left out: a sparse matrix" in said(log, "left-out")
        assert not [fact for fact in log.data.attrs if fact.startswith("file_")]
    assert "`p2` left out: a cell array of single numbers" in said(hc.read_log(tmp_path / "s.mat"), "left-out")


# --- units ----------------------------------------------------------------------------------------------------------


def test_units_in_attributes_of_any_case(tmp_path):
    with h5py.File(tmp_path / "u.h5", "w") as stored:
        stored["time"], stored["x"] = T, 1e3 * X
        stored["x"].attrs["Units"] = "mm"
    pyarrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    fields = [pyarrow.field("time", "float64"), pyarrow.field("x", "float64", metadata={"Unit": "mm"})]
    parquet.write_table(pyarrow.table([T, 1e3 * X], schema=pyarrow.schema(fields)), tmp_path / "u.parquet")
    dataset = xr.Dataset({"x": ("time", 1e3 * X, {"UNITS": "mm"})}, {"time": T})
    for source in (tmp_path / "u.h5", tmp_path / "u.parquet", dataset):
        np.testing.assert_allclose(hc.Log.of(source)["x"], X)


def test_a_factor_that_is_written_as_text_counts_or_is_told(tmp_path):
    with h5py.File(tmp_path / "f.h5", "w") as stored:
        stored["time"], stored["x"], stored["y"] = T, 1e3 * X, T
        stored["x"].attrs["scale_factor"], stored["y"].attrs["scale_factor"] = "0.001", "a thousandth"
    log = hc.read_log(tmp_path / "f.h5")
    np.testing.assert_allclose(log["x"], X)
    assert "`y` left out: its attribute `scale_factor` is no number" in said(log, "left-out")


def test_a_unit_behind_in(tmp_path):
    content = "time in ms,x in mm,valve in use\n" + rows(lambda i, t: f"{1e3 * t},{1e3 * X[i]},1")
    for source in (text(tmp_path, content), pd.DataFrame({"time in ms": 1e3 * T, "x in mm": 1e3 * X})):
        log = hc.Log.of(source)
        np.testing.assert_allclose([log.time, log["x"]], [T, X])
    assert "valve in use" in hc.read_log(tmp_path / "log.csv")


def test_a_unit_in_the_description_of_an_mcap_channel(tmp_path):
    writer = pytest.importorskip("mcap.writer")
    about = {"type": "object", "properties": {"angle": {"type": "number", "description": "angle in deg"}}}
    with (tmp_path / "a.mcap").open("wb") as stream:
        stored = writer.Writer(stream)
        stored.start()
        schema = stored.register_schema("joint", "jsonschema", json.dumps(about).encode())
        channel = stored.register_channel("/boom", "json", schema)
        for i in range(N):
            stored.add_message(channel, 20_000_000 * i, json.dumps({"angle": 90.0}).encode(), 20_000_000 * i)
        stored.finish()
    np.testing.assert_allclose(hc.read_log(tmp_path / "a.mcap")["/boom.angle"], np.pi / 2)


def test_percent_of_excel(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["time [s]", "u [%]", "v"])
    for t in T:
        book.active.append([t, 0.25, 0.25])
        for cell in book.active[book.active.max_row][1:]:
            cell.number_format = "0.0 %"
    book.save(tmp_path / "p.xlsx")
    log = hc.read_log(tmp_path / "p.xlsx")
    assert log["u"][0] == log["v"][0] == 0.25


# --- values ---------------------------------------------------------------------------------------------------------


def test_a_pressure_below_vacuum_is_flagged():
    for unit, low, flagged in (("bar", -5.0, True), ("bar", -1.0, False), ("bara", -0.1, True), ("bara", 0.0, False)):
        log = hc.Log.of({"time": T, "x": X, f"p1 [{unit}]": low + 50 * T})
        assert ("below vacuum" in said(log, "wrong-unit")) == flagged
        assert not log.fatal


def test_a_mark_of_missing_values_among_readings_is_told(tmp_path):
    path = text(tmp_path, "time,x [mm],n\n" + rows(lambda i, t: f"{t},{-9999 if i in (7, 8) else i},{999 - i}"))
    log = hc.read_log(path)
    assert said(log, "missing-mark").startswith("`x` reads -9999 in 2 samples and 0 to 59 in all others")


def test_whole_numbers_above_points_of_thousands_are_asked_for(tmp_path):
    path = text(
        tmp_path, "time,p1 [kPa]\n" + "".join(f"{i},{f'{900 + 10 * i:,}'.replace(',', '.')}\n" for i in range(N))
    )
    with pytest.raises(hc.InputError, match="may mean decimals or thousands"):
        hc.read_log(path, {"signal": {"p1": {}}})
    assert hc.read_log(path, number_format="1.234,5")["p1"][-1] == pytest.approx(1490e3)


def test_a_blank_cell_between_blanks_shifts_no_other(tmp_path):
    content = "time p1 p3\ns bar bar\n" + rows(lambda i, t: f"{t:8.2f}{'' if i == 20 else 50 + i:>12}{20 + i:12}")
    log = hc.read_log(text(tmp_path, content, "log.txt"))
    assert np.isnan(log["p1"][20]) and np.isfinite(np.delete(log["p1"], 20)).all()
    np.testing.assert_allclose(log["p3"], 1e5 * (20 + np.arange(N)))
