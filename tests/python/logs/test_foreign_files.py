"""Files of loggers that this project did not make: each column is read or its loss is said."""

from __future__ import annotations

import gzip
import re

import h5py
import numpy as np
import pytest
import xarray as xr
from scipy.io import savemat

import hydrocrane as hc
from hydrocrane import _core
from hydrocrane.logs import Log
from hydrocrane.logs.signals import ATMOSPHERE
from hydrocrane.result_warning import DoubtfulResult

N = 60
ROW = np.arange(N)


def log_of(folder, text, mapping=None, name="log.csv"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return hc.read_log(path, mapping)


def rows(form):
    return "".join(form(i) + "\n" for i in range(N))


def messages(log, kind):
    return "; ".join(flag.message for flag in log.flags if flag.kind == kind)


def kinds(log):
    return {flag.kind for flag in log.flags}


# --- texts ----------------------------------------------------------------------------------------------------------


BLANKS = {
    "one blank": ("time x p\n", lambda i: f"{i / 100} {i / 1000} {i}"),
    "aligned": ("time [s]    x [m]       p\n", lambda i: f"  {i / 100:8.3f} {i / 1000:12.4f}   {i:6d}"),
    "names parted by commas": ("#time(s),x(m),p\n", lambda i: f"  {i / 100:.2f} {i / 1000} {i}"),
    "names in a comment": ("# made by hand\n# time x p\n", lambda i: f"{i / 100} {i / 1000} {i}"),
    "decimal commas": ("time x p\n", lambda i: f"{i / 100} {i / 1000:.4f} {i}".replace(".", ",")),
}


@pytest.mark.parametrize(("head", "row"), BLANKS.values(), ids=BLANKS)
@pytest.mark.parametrize("suffix", ["txt", "exp", "exp.gz"])
def test_columns_parted_by_blanks(head, row, suffix, tmp_path):
    path = tmp_path / f"log.{suffix}"
    data = (head + rows(row)).encode()
    path.write_bytes(gzip.compress(data) if suffix.endswith("gz") else data)
    log = hc.read_log(path)
    np.testing.assert_allclose(log.time, ROW / 100, atol=1e-12)
    np.testing.assert_allclose(log["x"], ROW / 1000, atol=1e-12)
    np.testing.assert_allclose(log["p"], ROW)


def test_packed_files_that_are_damaged_or_binary(tmp_path):
    path = tmp_path / "log.csv.gz"
    path.write_bytes(gzip.compress(b"time,x\n" + b"0,1\n" * 500)[:-20])
    with pytest.raises(hc.ResultFileError, match="cannot be unpacked"):
        hc.read_log(path)
    (tmp_path / "log.mat.gz").write_bytes(gzip.compress(b"x"))
    with pytest.raises(hc.ResultFileError, match="unpack it first"):
        hc.read_log(tmp_path / "log.mat.gz")


@pytest.mark.parametrize("title", ["Rig 7;;;\n", "Rig 7;;;\n;;;\nSample rate;1000;;\nOperator;Ann;;\n", "Rig 7\n\n"])
def test_titles_above_the_header(title, tmp_path):
    log = log_of(tmp_path, title + "time;x;q;n\ns;mm;bar;-\n" + rows(lambda i: f"{i / 100};{i};{i};{i}"))
    assert list(log.data.data_vars) == ["x", "q", "n"] and not log.flags
    np.testing.assert_allclose(log["x"], ROW / 1000)
    np.testing.assert_allclose(log["q"], ROW * 1e5)


def test_decimal_commas_that_begin_late(tmp_path):
    log = log_of(tmp_path, "time;x\n" + rows(lambda i: f"{i};{i if i < 55 else str(i) + ',5'}"))
    np.testing.assert_allclose(log["x"], ROW + 0.5 * (ROW >= 55))


THOUSANDS = {
    "points": ("{0:,.2f}", lambda text: text.replace(",", "_").replace(".", ",").replace("_", "."), ";"),
    "commas": ("{0:,.2f}", lambda text: text, ";"),
    "quoted commas": ("{0:,.2f}", lambda text: f'"{text}"', ","),
}


@pytest.mark.parametrize(("form", "change", "delimiter"), THOUSANDS.values(), ids=THOUSANDS)
def test_marks_of_thousands(form, change, delimiter, tmp_path):
    values = 1234567.25 + 1000.0 * ROW
    lines = [delimiter.join([str(i), change(form.format(v))]) for i, v in enumerate(values)]
    log = log_of(tmp_path, delimiter.join(["time", "p"]) + "\n" + "\n".join(lines))
    np.testing.assert_allclose(log["p"], values)
    assert "left-out" not in kinds(log) and "number-format" not in kinds(log)


def test_whole_numbers_that_may_have_decimals_are_told(tmp_path):
    """1.234 beside 0,5 is one thousand and more; nothing in its own column says so."""
    log = log_of(tmp_path, "time;x;p\n" + rows(lambda i: f"0,{i:02d};0,5;{900 + i if i < 20 else f'1.{200 + i}'}"))
    np.testing.assert_allclose(log["p"], np.where(ROW < 20, 900 + ROW, 1200 + ROW))
    assert "`1.220`, which is read with marks of thousands" in messages(log, "number-format")
    points = log_of(tmp_path, "time,p\n" + rows(lambda i: f"0.{i:02d},1.{200 + i}"))
    np.testing.assert_allclose(points["p"], 1.2 + ROW / 1000)


def test_decimal_commas_between_commas_are_told(tmp_path):
    log = log_of(tmp_path, "time,x\n" + rows(lambda i: f"{i},0,{i},5"))
    assert "60 rows have more cells than the 2 of the header" in messages(log, "ragged-rows")
    assert "Export with semicolons" in messages(log, "ragged-rows")


def test_rows_that_grow_late_lose_nothing(tmp_path):
    log = log_of(tmp_path, "time;x\n" + rows(lambda i: f"{i / 100};{i}" + (";7" if i >= 55 else "")))
    assert np.nansum(log["column 3"]) == 35.0 and "5 rows have more cells" in messages(log, "ragged-rows")


def test_equal_names_are_kept_apart(tmp_path):
    log = log_of(tmp_path, "time,p [bar],p [bar],p,p\n" + rows(lambda i: f"{i / 100},1,2,3,{i}"))
    found = sorted(float(np.max(log[str(name)])) for name in log.data.data_vars)
    assert found == [3.0, 59.0, 1e5, 2e5] and len(messages(log, "renamed").split("; ")) >= 2


def test_every_column_that_is_left_out_is_said(tmp_path):
    log = log_of(tmp_path, "time,x,state,note\n" + rows(lambda i: f"{i / 100},{i},on,"))
    assert "`state`" in messages(log, "left-out") and "words" in messages(log, "left-out")
    held = {"time": ROW * 0.01, "x": ROW * 1.0, "name": np.array(["a"] * N)}
    assert "`name`" in messages(Log.of(xr.Dataset({k: ("time", v) for k, v in held.items()})), "left-out")
    chosen = hc.read_log(tmp_path / "log.csv", {"signal": {"x": {"unit": "mm"}}})
    assert "left-out" not in kinds(chosen)


@pytest.mark.parametrize(
    "stamp",
    ["31.12.2024 23:59:{0:02d},500", "2024/12/31 23:59:{0:02d}", "12/31/2024 11:59:{0:02d} PM", "11:59:{0:02d} pm"],
)
def test_times_of_other_countries(stamp, tmp_path):
    log = log_of(tmp_path, "when;x\n" + rows(lambda i: f"{stamp.format(i)};{i}"))
    np.testing.assert_allclose(log.time, ROW)


# --- MATLAB and HDF5 ------------------------------------------------------------------------------------------------


def capture(factor, times):
    y = [("Length", times * factor), ("Pressure", times * 3)]
    return {"X": {"Data": times}, "Y": np.array(y, dtype=[("Name", object), ("Data", object)])}


def test_two_captures_in_one_file(tmp_path):
    t = np.arange(30) * 0.01
    later = np.arange(30) * 0.01 + 0.005
    path = tmp_path / "two.mat"
    savemat(path, {"first": capture(1, t), "second": capture(5, later)})
    log = hc.read_log(path)
    np.testing.assert_allclose(log["Length"], t)
    assert "second.Length" not in log
    text = messages(log, "left-out")
    assert all(name in text for name in ("`second.time`", "`second.Length`", "`second.Pressure`"))
    other = hc.read_log(path, {"time": {"column": "second.time"}, "signal": {"x": {"column": "second.Length"}}})
    np.testing.assert_allclose(other.time, later)
    np.testing.assert_allclose(other["x"], 5 * later)
    with pytest.raises(hc.InputError, match=r"part of another recording.*second.time"):
        hc.read_log(path, {"signal": {"x": {"column": "second.Length"}}})
    both = hc.read_log(path, {"signal": {"x": {"column": "second.Length", "time": "second.time"}}})
    np.testing.assert_allclose(both["x"][1:], 5 * t[1:])
    assert np.isnan(both["x"][0]) and "resampled" in kinds(both)


def test_signals_of_two_rates_with_times_of_their_own(tmp_path):
    fast, slow = np.arange(1000) * 1e-3, np.arange(100) * 1e-2
    savemat(tmp_path / "rates.mat", {"time": fast, "p1": fast * 1e7, "ts": slow, "x": slow * 0.1})
    log = hc.read_log(tmp_path / "rates.mat")
    assert "x" not in log and "100 values for 1000 times; its times may be in `ts`" in messages(log, "left-out")
    mapping = {"signal": {"p1": {}, "x": {"time": "ts"}}}
    both = hc.read_log(tmp_path / "rates.mat", mapping)
    inside = fast <= slow[-1]
    np.testing.assert_allclose(both["x"][inside], 0.1 * fast[inside], atol=1e-12)
    with pytest.raises(hc.InputError, match="100 values for 1000 times"):
        hc.read_log(tmp_path / "rates.mat", {"signal": {"x": {}}})
    with pytest.raises(hc.InputError, match="its times `p1` have 1000 values, it has 100"):
        hc.read_log(tmp_path / "rates.mat", {"signal": {"x": {"time": "p1"}}})


def test_single_numbers_are_facts(tmp_path):
    """Foreign ones never pass for those that identification acts on, such as `supply` in Pa."""
    savemat(
        tmp_path / "s.mat", {"time": ROW * 0.01, "x": ROW * 1e-3, "Ts": 0.01, "supply": 200.0, "rig": {"bore": 63.0}}
    )
    log = hc.read_log(tmp_path / "s.mat")
    about = log.data.attrs
    assert (about["file_Ts"], about["file_supply"], about["file_rig_bore"]) == (0.01, 200.0, 63.0)
    assert "supply" not in about and list(log.data.data_vars) == ["x"]
    assert hc.read_log(log.save(tmp_path / "again.mat")).data.attrs["file_Ts"] == 0.01


def test_what_is_no_column_of_a_binary_file_is_said(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as stored:
        stored["time"], stored["x"] = ROW * 0.01, ROW * 1.0
        stored["cube"], stored["waves"] = np.ones((3, 4, 5)), np.ones(N) * 1j
    text = messages(hc.read_log(tmp_path / "a.h5"), "left-out")
    assert "`cube`" in text and "3 dimensions" in text and "`waves`" in text


def test_numbered_columns_of_a_matrix_have_no_unit(tmp_path):
    savemat(tmp_path / "m.mat", {"time": ROW * 0.01, "p": np.stack([ROW, 2 * ROW], axis=1) * 1e5})
    log = hc.read_log(tmp_path / "m.mat", {"signal": {"p1": {"column": "p[1]"}, "p2": {"column": "p[2]"}}})
    np.testing.assert_allclose(log["p2"], 2e5 * ROW)
    assert not log.fatal


@pytest.mark.parametrize("suffix", [".csv", ".mat"])
def test_plain_columns_say_what_was_left_out(suffix, tmp_path):
    """A log of sticks and one that is laid over a run are read without a mapping, too."""
    path = tmp_path / f"sticks{suffix}"
    if suffix == ".csv":
        path.write_text("time,x,z,note\n0,0,0,start\n1,0.5,-1,\n2,0.5,1,stop\n", encoding="utf-8")
        lost = "column `note` left out: words, not numbers"
    else:
        times = {"time": [0.0, 1.0, 2.0], "x": [0.0, 0.5, 0.5], "z": [0.0, -1.0, 1.0]}
        savemat(path, {**{k: np.array(v) for k, v in times.items()}, "cube": np.ones((3, 4, 5))})
        lost = "column `cube` left out: 3 dimensions"
    with pytest.warns(DoubtfulResult, match=re.escape(f"sticks{suffix}: {lost}")):
        joystick = hc.Joystick.from_log(path, full_speed=0.1)
    np.testing.assert_allclose(joystick.at(0.5).axes, [0.25, -0.5])
    # Who names columns has chosen.
    assert set(hc.Joystick.from_log(path, columns={"x": "x"}, full_speed=0.1).axes) == {"x"}


def test_plain_columns_say_that_a_name_came_twice(tmp_path):
    path = tmp_path / "twice.csv"
    path.write_text("time,x,x\n0,0,0.5\n1,1,0.6\n2,2,0.7\n", encoding="utf-8")
    with pytest.warns(DoubtfulResult, match="is a second column called `x`"):
        hc.Joystick.from_log(path, columns={"x.2": "x"}, full_speed=0.1)


# --- units ----------------------------------------------------------------------------------------------------------

POUND = 0.45359237 * 9.80665
UNITS = {
    "in": (0.0254, "m"),
    "in/s": (0.0254, "m s^-1"),
    "in²": (0.0254**2, "m^2"),
    "ft": (0.3048, "m"),
    "lbf": (POUND, "m kg s^-2"),
    "lbs": (POUND, "m kg s^-2"),
    "lbf/in^2": (POUND / 0.0254**2, "m^-1 kg s^-2"),
    "psig": (POUND / 0.0254**2, "m^-1 kg s^-2"),
    "bar(g)": (1e5, "m^-1 kg s^-2"),
    "mA": (1e-3, "A"),
    "rpm": (2 * np.pi / 60, "s^-1 rad"),
    "L/min": (1e-3 / 60, "m^3 s^-1"),
    "gpm": (231 * 0.0254**3 / 60, "m^3 s^-1"),
    "us": (1e-6, "s"),
}


@pytest.mark.parametrize(("unit", "wanted"), UNITS.items(), ids=UNITS)
def test_units_of_loggers(unit, wanted):
    factor, dimension, zero, absolute = _core.log_unit(unit)
    assert factor == pytest.approx(wanted[0], rel=1e-12)
    assert dimension == wanted[1] and zero == 0.0 and not absolute


def test_degrees(tmp_path):
    log = log_of(tmp_path, "time [s],T [degC],U (°F)\n" + rows(lambda i: f"{i / 100},{i},{32 + 1.8 * i}"))
    np.testing.assert_allclose(log["T"], 273.15 + ROW)
    np.testing.assert_allclose(log["U"], 273.15 + ROW)
    assert log.data["T"].attrs["units"] == "K"


@pytest.mark.parametrize("unit", ["psia", "bar(a)", "bar abs"])
def test_absolute_pressure(unit, tmp_path):
    log = log_of(tmp_path, f"time [s],p1 [{unit}],gas [{unit}]\n" + rows(lambda i: f"{i / 100},{20 + i},{20 + i}"))
    one, *_ = _core.log_unit(unit)
    np.testing.assert_allclose(log["p1"], (20 + ROW) * one - ATMOSPHERE)
    np.testing.assert_allclose(log["gas"], (20 + ROW) * one)
    text = messages(log, "absolute-pressure")
    assert "`p1` is absolute; 1.01325 bar" in text and "`gas` is absolute pressure and remains so" in text


def test_pounds_and_units_in_names_are_told(tmp_path):
    log = log_of(tmp_path, "time [s],force [lbs],Length_mm\n" + rows(lambda i: f"{i / 100},{i},{i}"))
    np.testing.assert_allclose(log["force"], ROW * POUND)
    assert "pound-force" in messages(log, "assumed-unit")
    mapped = hc.read_log(tmp_path / "log.csv", {"signal": {"x": {"column": "Length_mm"}}})
    assert 'unit = "mm"' in messages(mapped, "assumed-unit")


def test_raw_output_of_a_sensor(tmp_path):
    text = "time [s];p1 [mA]\n" + rows(lambda i: f"{i / 100};{4 + i / 5}")
    with pytest.raises(hc.InputError, match=r"raw output.*25 bar"):
        log_of(tmp_path, text)
    log = log_of(tmp_path, text, {"signal": {"p1": {"unit": "25 bar", "offset": "-100 bar"}}})
    np.testing.assert_allclose(log["p1"], ROW * 5e5, atol=1e-6)


def test_columns_in_memory_that_are_left_out_or_alike():
    import pandas as pd

    frame = pd.DataFrame([[0.01 * i, i, 2 * i, "on"] for i in range(N)], columns=["time", "p", "p", "state"])
    log = Log.of(frame)
    np.testing.assert_array_equal(log["p.2"], 2.0 * ROW)
    assert "`state`" in messages(log, "left-out") and "renamed" in kinds(log)
    log = Log.of({"time": 0.01 * ROW, "x": 1.0 * ROW, "table": np.ones((N, 2))})
    assert "2 dimensions" in messages(log, "left-out")
