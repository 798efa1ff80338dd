"""Logs of every format read back as written; every defect is flagged or explained, never passed over."""

from __future__ import annotations

import re
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.io import savemat

import hydrocrane as hc
from hydrocrane.logs import Log

N = 400
FORMATS = ("csv", "mat", "nc", "h5", "mf4")


def readings(seed=1):
    """A healthy log: the piston goes out and back, pressures follow, everything is noisy."""
    rng = np.random.default_rng(seed)
    time = np.arange(N) * 0.01
    x = 0.1 * np.sin(2 * np.pi * time / 4)
    return {
        "time": time,
        "x": x + rng.normal(0, 5e-5, N),
        "p1": 40e5 + 20e5 * np.sin(2 * np.pi * time / 3) + rng.normal(0, 1e4, N),
        "p2": 60e5 + 20e5 * np.cos(2 * np.pi * time / 3) + rng.normal(0, 1e4, N),
        "command": np.sign(x) * 0.01,
    }


def kinds(log):
    return {flag.kind for flag in log.flags}


def with_extra(suffix):
    if suffix == "mf4":
        pytest.importorskip("asammdf")
    return suffix


# --- what is written reads back -------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_log_reads_back_equal(tmp_path, suffix):
    log = Log.of(readings(), source="rig")
    assert not log.flags
    back = hc.read_log(log.save(tmp_path / f"deep/log.{with_extra(suffix)}"))
    assert list(back.data.data_vars) == list(log.data.data_vars)
    for name in ("time", "x", "p1", "p2", "command"):
        np.testing.assert_array_equal(back[name], log[name])
        assert back.data[name].attrs["units"] == log.data[name].attrs["units"]
    assert not back.flags


@pytest.mark.parametrize("suffix", FORMATS)
def test_what_a_log_says_about_itself_reads_back(tmp_path, suffix):
    about = {"experiment": "ramp", "payload": 20.5, "seed": 3, "note": 'ö "quoted" # [x]', "empty": ""}
    data = Log.of(readings()).data.assign_attrs(about)
    path = Log(data).save(tmp_path / f"log.{with_extra(suffix)}")
    assert hc.read_log(path).data.attrs == {**about, "source": str(path)}


def test_comments_of_a_text_that_are_no_facts_are_passed_over(tmp_path):
    path = tmp_path / "a.csv"
    lines = ["# Measured on Monday = windy", "% payload = 20", "# [rig]", "// speeds = [1, 2]", "time,x"]
    path.write_text("\n".join(lines + [f"{i},{i * i}" for i in range(12)]))
    assert hc.read_log(path).data.attrs == {"payload": 20, "source": str(path)}


@settings(max_examples=25, deadline=None)
@given(
    values=arrays(np.float64, 20, elements=st.floats(-1e12, 1e12, allow_subnormal=False)),
    suffix=st.sampled_from(["csv", "mat", "nc", "h5"]),
)
def test_any_numbers_survive_any_format(tmp_path_factory, values, suffix):
    path = tmp_path_factory.mktemp("round") / f"log.{suffix}"
    log = Log.of({"time": np.arange(20) * 0.1, "x": values})
    np.testing.assert_array_equal(hc.read_log(log.save(path))["x"], values)


@pytest.mark.evidence
@settings(max_examples=40, deadline=None)
@given(
    delimiter=st.sampled_from([",", ";", "\t"]),
    comma=st.booleans(),
    unit_row=st.booleans(),
    comment=st.booleans(),
    header=st.booleans(),
    values=st.lists(st.floats(-1e6, 1e6), min_size=12, max_size=30),
)
def test_csv_dialects_are_told_apart(tmp_path_factory, delimiter, comma, unit_row, comment, header, values):
    """Decimal commas need another delimiter; a row of units needs a header."""
    comma, unit_row = comma and delimiter != ",", unit_row and header
    rows = ["# logger 7"] if comment else []
    rows += [delimiter.join(["time", "way"])] if header else []
    rows += [delimiter.join(["ms", "[mm]"])] if unit_row else []
    text = [delimiter.join([repr(10.0 * i), repr(v)]) for i, v in enumerate(values)]
    rows += [row.replace(".", ",") for row in text] if comma else text
    path = tmp_path_factory.mktemp("dialect") / "log.csv"
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    mapping = {"time": {"column": 1, "unit": "ms"}, "signal": {"x": {"column": 2, "unit": "mm"}}}
    log = hc.read_log(path, mapping)
    np.testing.assert_allclose(log.time, np.arange(len(values)) * 0.01, rtol=1e-15)
    np.testing.assert_allclose(log["x"], np.array(values) / 1000, rtol=1e-15)
    if unit_row:
        np.testing.assert_array_equal(hc.read_log(path)["way"], log["x"])


def test_units_come_from_a_row_or_from_the_names(tmp_path):
    (tmp_path / "a.csv").write_text("Time [ms];x [mm];p1 (bar)\n" + "".join(f"{i};{i},5;{i}\n" for i in range(12)))
    log = hc.read_log(tmp_path / "a.csv")
    np.testing.assert_allclose(log["x"], (np.arange(12) + 0.5) * 1e-3)
    np.testing.assert_allclose(log["p1"], np.arange(12) * 1e5)
    np.testing.assert_allclose(log.time, np.arange(12) * 1e-3)
    assert log.data["p1"].attrs["units"] == "Pa"


# --- MATLAB and HDF5 in their habits --------------------------------------------------------------------------------


def test_a_capture_of_dspace(tmp_path):
    """`X.Data` is the time, `Y` a list of structures with `Name` and `Data`."""
    t = np.arange(30) * 0.01
    y = np.array([("Length", t * 2), ("Pressure", t * 3)], dtype=[("Name", object), ("Data", object)])
    savemat(tmp_path / "c.mat", {"capture": {"X": {"Data": t}, "Y": y, "Description": "rig"}})
    log = hc.read_log(tmp_path / "c.mat", {"signal": {"x": {"column": "Length", "unit": "mm"}}})
    np.testing.assert_allclose(log["x"], t * 2e-3)
    np.testing.assert_allclose(log.time, t)


def test_nested_structures_and_matrices(tmp_path):
    t = np.arange(30) * 0.01
    savemat(tmp_path / "n.mat", {"rig": {"t": t, "sensor": {"p": np.stack([t, 2 * t])}}, "note": "text"})
    log = hc.read_log(
        tmp_path / "n.mat", {"time": {"column": "rig.t"}, "signal": {"p2": {"column": "rig.sensor.p[2]"}}}
    )
    np.testing.assert_allclose(log["p2"], 2 * t)


def test_matlab_7_3(tmp_path):
    """Its HDF5: column-major, characters as numbers, structures as groups, arrays of structures as references."""
    t = np.arange(30) * 0.01
    with h5py.File(tmp_path / "v.mat", "w", userblock_size=512) as f:

        def put(where, name, value, kind):
            where.create_dataset(name, data=value).attrs["MATLAB_class"] = np.bytes_(kind)
            return where[name]

        rig = f.create_group("rig")
        rig.attrs["MATLAB_class"] = np.bytes_("struct")
        put(rig, "time", t[np.newaxis], "double")
        put(rig, "note", np.array([[ord(c)] for c in "hello"], dtype=np.uint16), "char")
        refs = f.create_group("#refs#")
        names = [put(refs, n, np.array([[ord(c)] for c in n], dtype=np.uint16), "char").ref for n in ("Way", "Press")]
        data = [put(refs, n, v[np.newaxis], "double").ref for n, v in (("a", 2 * t), ("b", 3 * t))]
        y = rig.create_group("Y")
        y.create_dataset("Name", data=np.array(names, dtype=h5py.ref_dtype))
        y.create_dataset("Data", data=np.array(data, dtype=h5py.ref_dtype))
    log = hc.read_log(
        tmp_path / "v.mat",
        {"time": {"column": "rig.time"}, "signal": {"x": {"column": "Way"}, "p1": {"column": "Press"}}},
    )
    np.testing.assert_allclose(log["x"], 2 * t)
    np.testing.assert_allclose(log["p1"], 3 * t)


def test_plain_hdf5_and_classic_netcdf(tmp_path):
    t = np.arange(30) * 0.01
    with h5py.File(tmp_path / "p.h5", "w") as f:
        f["group/time"], f["group/way"] = t, 5 * t
        f["group/way"].attrs["units"] = "mm"
    log = hc.read_log(tmp_path / "p.h5", {"time": {"column": "group.time"}, "signal": {"x": {"column": "group.way"}}})
    np.testing.assert_allclose(log["x"], 5e-3 * t)
    way = xr.DataArray(5 * t, dims="time", attrs={"units": "mm"})
    xr.Dataset({"x": way}, coords={"time": t}).to_netcdf(tmp_path / "c.nc", engine="scipy")
    np.testing.assert_allclose(hc.read_log(tmp_path / "c.nc")["x"], 5e-3 * t)


def test_mdf_without_its_package_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "asammdf", None)
    (tmp_path / "a.mf4").write_bytes(b"MDF     4.10")
    with pytest.raises(hc.ResultFileError, match=r"hydrocrane\[mdf\]"):
        hc.read_log(tmp_path / "a.mf4")
    with pytest.raises(hc.ResultFileError, match=r"hydrocrane\[mdf\]"):
        Log.of(readings()).save(tmp_path / "b.mf4")


def test_mdf_channels_of_two_rates(tmp_path):
    asammdf = pytest.importorskip("asammdf")
    fast, slow = np.arange(100) * 0.01, np.arange(10) * 0.1
    with asammdf.MDF(version="4.10") as f:
        f.append([asammdf.Signal(2 * fast, fast, unit="mm", name="way")])
        f.append([asammdf.Signal(3 * slow, slow, unit="bar", name="press")])
        f.save(tmp_path / "two.mf4")
    log = hc.read_log(tmp_path / "two.mf4", {"signal": {"x": {"column": "way"}, "p1": {"column": "press"}}})
    inside = log.time <= 0.9
    np.testing.assert_allclose(log["x"], 2e-3 * fast)
    np.testing.assert_allclose(log["p1"][inside], 3e5 * fast[inside], atol=1e-6)
    assert "resampled" in kinds(log)


# --- the mapping ----------------------------------------------------------------------------------------------------

TABLE = {"t": np.arange(20.0), "Length_3": np.arange(20.0), "U": np.arange(20.0)}


def test_a_mapping_file(tmp_path):
    (tmp_path / "rig.toml").write_text(
        '[time]\nsample-rate = "1 kHz"\n[signal.x]\ncolumn = "Length_3"\nunit = "mm"\nsign = -1\noffset = "0.5 m"\n'
        '[signal.p1]\ncolumn = "U"\nunit = "40 bar"\n',
        encoding="utf-8",
    )
    Log.of({"time": TABLE["t"], **TABLE}).save(tmp_path / "a.csv")
    log = hc.read_log(tmp_path / "a.csv", tmp_path / "rig.toml")
    np.testing.assert_allclose(log.time, np.arange(20) * 1e-3)
    np.testing.assert_allclose(log["x"], 0.5 - np.arange(20) * 1e-3)
    np.testing.assert_allclose(log["p1"], np.arange(20) * 40e5)


@pytest.mark.parametrize(
    ("mapping", "words"),
    [
        ({"signal": {"x": {"column": "Lenght_3"}}}, ["Lenght_3", "did you mean `Length_3`"]),
        ({"signal": {"x": {"column": 9}}}, ["count from 1 to 3"]),
        ({"signal": {"x": {"column": "U", "unit": "barr"}}}, ["[signal.x] unit", "did you mean `bar`"]),
        ({"signal": {"x": {"column": "U", "unit": "bar"}}}, ["`bar` is not a unit of `x`", "m"]),
        ({"signal": {"x": {"column": "U", "offset": "3 bar"}}}, ["[signal.x] offset", "not a unit of `x`"]),
        ({"signal": {"x": {"column": "U", "sign": 2}}}, ["sign must be 1 or -1"]),
        ({"signal": {"x": {"colum": "U"}}}, ["unknown key `colum`", "did you mean `column`"]),
        ({"signals": {}}, ["unknown key `signals`", "did you mean `signal`"]),
        ({"signal": {"x": "U"}}, ["must be a table"]),
        ({"time": {"column": "t", "sample-rate": "1 kHz"}}, ["keep one"]),
        ({"time": {"sample-rate": "1 s"}}, ["positive frequency"]),
        ({"time": {"sample-rate": 1000}}, ["text with a unit"]),
        ({"time": {"column": "tt"}}, ["no column `tt`"]),
        ("none.toml", ["no such mapping file: none.toml"]),
        (3, ["a mapping is"]),
    ],
)
def test_wrong_mappings_are_explained(mapping, words):
    with pytest.raises(hc.InputError) as caught:
        Log.of(TABLE, mapping)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_a_mapping_that_is_no_toml(tmp_path):
    (tmp_path / "m.toml").write_text("signal x", encoding="utf-8")
    with pytest.raises(hc.InputError, match="not valid TOML"):
        Log.of(TABLE, tmp_path / "m.toml")


# --- files that are no logs -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", FORMATS)
def test_foreign_and_empty_files(tmp_path, suffix):
    path = tmp_path / f"a.{with_extra(suffix)}"
    with pytest.raises(hc.ResultFileError, match="no such file"):
        hc.read_log(path)
    path.write_bytes(b"")
    with pytest.raises(hc.ResultFileError, match="empty"):
        hc.read_log(path)
    path.write_bytes(b"\x00\x01foreign" * 300)
    with pytest.raises(hc.ResultFileError, match=r"not|binary"):
        hc.read_log(path)


@pytest.mark.parametrize("suffix", ["mat", "nc", "h5"])
def test_truncated_binary_files(tmp_path, suffix):
    path = Log.of(readings()).save(tmp_path / f"a.{suffix}")
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(hc.ResultFileError, match=r"not a|damaged|cut off"):
        hc.read_log(path)


def test_a_truncated_csv_keeps_what_is_whole(tmp_path):
    path = Log.of(readings()).save(tmp_path / "a.csv")
    path.write_text(path.read_text()[:-60])
    log = hc.read_log(path)
    assert "truncated" in kinds(log) and N - 3 <= log.time.size < N


@pytest.mark.parametrize("text", ["hello\nworld\n", "# only\n# comments\n", "a,b\n", "time,x\n0,oops\n1,oops\n"])
def test_texts_without_numbers(tmp_path, text):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(hc.HydrocraneError):
        hc.read_log(tmp_path / "a.csv", {"signal": {"x": {}}})


def test_unknown_suffixes_and_missing_time(tmp_path):
    (tmp_path / "a.docx").write_text("x")
    with pytest.raises(hc.ResultFileError, match="unknown suffix"):
        hc.read_log(tmp_path / "a.docx")
    with pytest.raises(hc.ResultFileError, match="unknown suffix"):
        Log.of(readings()).save(tmp_path / "a.docx")
    with pytest.raises(hc.InputError, match="no time column.*clock, x"):
        Log.of({"clock": [0.0, 1.0], "x": [0.0, 1.0]})


# --- defects --------------------------------------------------------------------------------------------------------


def spoilt(name, change):
    table = readings()
    table[name] = change(table[name].copy())
    return Log.of(table)


def put(values, where, value):
    values[where] = value
    return values


DEFECTS = {
    "missing values": ("x", lambda v: put(v, slice(50, 60), np.nan), "not-finite", False),
    "infinite and absurd": ("p2", lambda v: put(put(v, 7, np.inf), 9, -1e300), "not-finite", False),
    "nothing but missing": ("p1", lambda v: v * np.nan, "not-finite", True),
    "missing time": ("time", lambda v: put(v, 5, np.nan), "not-finite", True),
    "gap": ("time", lambda v: v + (np.arange(N) > 200) * 1.0, "gap", False),
    "clock goes back": ("time", lambda v: v - (np.arange(N) > 200) * 1.0, "time-not-increasing", True),
    "clock stands": ("time", lambda v: put(v, 11, v[10]), "time-not-increasing", True),
    "irregular": ("time", lambda v: v + 0.004 * np.sin(np.arange(N) * 2.1), "irregular-time", False),
    "saturated": ("p1", lambda v: np.minimum(v, 50e5), "saturated", False),
    "frozen": ("p2", lambda v: put(v, slice(100, 180), v[100]), "frozen", False),
    "frozen position": ("x", lambda v: put(v, slice(150, 250), v[150]), "frozen", False),
    "unmoving": ("x", lambda v: np.random.default_rng(2).normal(0, 5e-5, N), "unmoving", False),
    "time in ms": ("time", lambda v: v * 1e3, "wrong-unit", False),
    "position in mm": ("x", lambda v: v * 1e3, "wrong-unit", True),
    "pressure a thousandfold": ("p2", lambda v: v * 1e3, "wrong-unit", True),
}


@pytest.mark.parametrize(("name", "change", "kind", "fatal"), DEFECTS.values(), ids=DEFECTS)
def test_every_defect_is_flagged(name, change, kind, fatal):
    log = spoilt(name, change)
    found = [flag for flag in log.flags if flag.kind == kind]
    assert found, log.flags
    assert found[0].fatal is fatal and str(found[0]) in log.summary()
    assert {f.kind for f in log.flags} == {kind}, log.flags
    if fatal:
        with pytest.raises(hc.InputError, match="cannot be used"):
            log.usable("x")


def test_flags_say_where():
    flag = spoilt("p2", DEFECTS["frozen"][1]).flags[0]
    assert flag.signal == "p2" and flag.start == pytest.approx(1.0) and flag.end == pytest.approx(1.79)
    bad = spoilt("p2", DEFECTS["frozen"][1]).spoilt("p2")
    assert bad.sum() == 80 and not spoilt("p2", DEFECTS["frozen"][1]).spoilt("x").any()


def test_pressures_in_bar_are_suspected():
    table = readings()
    log = Log.of(table | {"p1": table["p1"] / 1e5, "p2": table["p2"] / 1e5})
    assert kinds(log) == {"wrong-unit"} and "in bar" in log.flags[0].message and log.fatal
    one = Log.of(table | {"p1": table["p1"] / 1e5})
    assert kinds(one) == {"wrong-unit"} and not one.fatal


def test_a_coarse_sensor_at_rest_is_not_frozen():
    """Twelve bits over 1250 mm repeat themselves whenever the piston rests."""
    table = readings()
    table["x"] = np.concatenate([np.zeros(200), np.linspace(0, 0.05, N - 200)])
    table["x"] = np.round(table["x"] / 3.05e-4) * 3.05e-4
    assert not Log.of(table).flags


def test_too_short_and_unstated_units(tmp_path):
    assert kinds(Log.of({"time": [0.0, 0.1], "x": [0.0, 1.0]})) == {"too-short"}
    (tmp_path / "a.csv").write_text("time,x\n" + "".join(f"{0.1 * i},{0.01 * i}\n" for i in range(20)))
    assert kinds(hc.read_log(tmp_path / "a.csv")) == {"assumed-unit"}
    (tmp_path / "b.csv").write_text("time,x\ns,furlong\n" + "".join(f"{0.1 * i},{0.01 * i}\n" for i in range(20)))
    log = hc.read_log(tmp_path / "b.csv")
    assert "unknown-unit" in kinds(log) and log.fatal


def test_cells_that_are_no_numbers(tmp_path):
    rows = [f"{0.1 * i},{0.01 * i if i != 7 else 'ERR'}" for i in range(20)]
    (tmp_path / "a.csv").write_text("time,x\ns,m\n" + "\n".join(rows))
    log = hc.read_log(tmp_path / "a.csv")
    assert kinds(log) == {"unreadable-cells", "not-finite"} and np.isnan(log["x"][7])


def test_missing_signals_and_empty_parts():
    log = Log.of(readings())
    with pytest.raises(hc.InputError, match=r"no signal `force`.*\[signal.force\]"):
        log.usable("x", "force")
    with pytest.raises(hc.InputError, match="no sample between"):
        log.between(90, 91)
    part = log.between(1.0, 2.0)
    assert part.time[0] == 1.0 and part.time[-1] == 2.0


def test_a_run_is_a_log_through_a_mapping():
    run = hc.simulate("single-cylinder-step")
    log = Log.of(run, {"signal": {"x": {"column": "cylinder.test.x"}, "p1": {"column": "cylinder.test.p1"}}})
    np.testing.assert_array_equal(log["x"], run.data["cylinder.test.x"].values)
    assert log.data["p1"].attrs["units"] == "Pa" and not log.flags


def test_the_reference_names_every_flag():
    """Kinds that the sources raise, either way round."""
    root = Path(__file__).resolve().parents[3]
    sources = [*root.glob("python/hydrocrane/logs/*.py"), root / "python/hydrocrane/signals/window_checks.py"]
    sources.append(root / "crates/logs/src/table.rs")
    text = "".join(path.read_text(encoding="utf-8") for path in sources)
    raised = set(re.findall(r'(?:Flag|append|push|return \[|_flag|_whole)\(\s*\(?"([a-z]+(?:-[a-z]+)+|[a-z]+)",', text))
    page = (root / "docs/reference/log-files.md").read_text(encoding="utf-8").split("## Flags")[1]
    rows = "".join(line.split("|")[1] for line in page.splitlines() if line.startswith("| `"))
    assert raised == set(re.findall(r"`([a-z-]+)`", rows))


# --- dates and times of day -----------------------------------------------------------------------------------------

ISO = {
    "zone": ("Timestamp", "2024-05-01T23:59:59.{0:03d}Z", ","),
    "space": ("timestamp", "2024-05-01 12:00:00.{0:03d}", ","),
    "offset, semicolon": ("DateTime", "2024-05-01T12:00:00.{0:03d}+02:00", ";"),
    "quoted, foreign name": ("Zeit", '"2024-05-01 12:00:00.{0:03d}000"', ";"),
    "time of day": ("time", "12:00:00.{0:03d}", ","),
    "time of day, decimal comma": ("Time", "12:00:00,{0:03d}", ";"),
}


@pytest.mark.parametrize(("name", "stamp", "delimiter"), ISO.values(), ids=ISO)
def test_dates_are_seconds_from_the_first(name, stamp, delimiter, tmp_path):
    rows = [delimiter.join([stamp.format(10 * i), f"{i}.5", "ok"]) for i in range(20)]
    file = tmp_path / "log.csv"
    file.write_text("\n".join([delimiter.join([name, "x [mm]", "state"]), *rows]) + "\n", encoding="utf-8")
    for mapping in (None, {"time": {"column": name}, "signal": {"x": {"column": "x"}}}):
        log = hc.read_log(file, mapping)
        np.testing.assert_allclose(log.time, 0.01 * np.arange(20), atol=1e-9)
        np.testing.assert_allclose(log["x"], 1e-3 * (np.arange(20) + 0.5), rtol=1e-12)
        assert not log.fatal


def test_times_of_day_pass_midnight(tmp_path):
    file = tmp_path / "log.csv"
    stamps = [f"23:59:{59 - 5 + i:02d}" for i in range(6)] + [f"00:00:{i:02d}" for i in range(6)]
    file.write_text("time,x\n" + "\n".join(f"{stamp},{i}" for i, stamp in enumerate(stamps)), encoding="utf-8")
    np.testing.assert_allclose(hc.read_log(file).time, np.arange(12.0))


def test_dates_of_pandas_and_xarray():
    import pandas as pd

    stamps = pd.date_range("2024-05-01 12:00", periods=20, freq="10ms")
    x = np.arange(20.0)
    wanted = 0.01 * np.arange(20)
    for log in (
        pd.DataFrame({"Timestamp": stamps, "x": x}),
        pd.DataFrame({"x": x}, index=stamps),
        xr.Dataset({"x": ("time", x)}, coords={"time": stamps}),
    ):
        np.testing.assert_allclose(hc.Log.of(log).time, wanted, atol=1e-9)


def test_dates_of_netcdf(tmp_path):
    import pandas as pd

    stamps = pd.date_range("2024-05-01 12:00", periods=20, freq="10ms")
    data = xr.Dataset({"x": ("time", np.arange(20.0))}, coords={"time": stamps})
    data.to_netcdf(tmp_path / "log.nc", encoding={"time": {"units": "milliseconds since 2024-05-01 12:00:00"}})
    np.testing.assert_allclose(hc.read_log(tmp_path / "log.nc").time, 0.01 * np.arange(20), atol=1e-9)


def test_what_is_no_time_is_told(tmp_path):
    file = tmp_path / "log.csv"
    file.write_text("when,x,state\n" + "\n".join(f"Monday,{i},on" for i in range(12)), encoding="utf-8")
    with pytest.raises(hc.InputError, match=r"`when`, which begins with `Monday`; times are written .* ISO 8601"):
        hc.read_log(file, {"time": {"column": "when"}})
    with pytest.raises(hc.InputError, match=r"no time column.*when"):
        hc.read_log(file)
    file.write_text("timestamp,x\n" + "\n".join(f"{1714564800000 + 10 * i},{i}" for i in range(12)), encoding="utf-8")
    with pytest.raises(hc.InputError, match=r'it seems to count ms; say \[time\] unit = "ms"'):
        hc.read_log(file)
    log = hc.read_log(file, {"time": {"column": "timestamp", "unit": "ms"}})
    np.testing.assert_allclose(np.diff(log.time), 0.01, rtol=1e-4)
