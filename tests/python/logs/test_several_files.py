"""One log of several files: each signal from the file that the mapping names, on one clock; no clock is guessed."""

from __future__ import annotations

import numpy as np
import pytest
from typer.testing import CliRunner

import hydrocrane as hc

T, SLOW = np.arange(0, 2, 0.01), np.arange(0, 2, 0.05)


def write(folder, name, times, values, head="time [s];value [bar]"):
    folder.mkdir(exist_ok=True)
    rows = [f"{time};{value:.9g}" for time, value in zip(times, values)]
    (folder / name).write_text("\n".join([head, *rows]) + "\n")
    return folder


def mapping(time=None, **signals):
    return {"time": time or {}, "signal": {name: {"column": "value", **entry} for name, entry in signals.items()}}


@pytest.fixture
def folder(tmp_path):
    write(tmp_path / "drive", "x.csv", T, 100 * T, "time [s];value [mm]")
    return write(tmp_path / "drive", "2024-05-01_p1.csv", SLOW, 50 + SLOW)


def said(log, kind):
    return "; ".join(flag.message for flag in log.flags if flag.kind == kind)


def test_signals_of_two_files(folder):
    log = hc.read_log(folder, mapping(x={"file": "x.csv"}, p1={"file": "*p1.csv"}))
    np.testing.assert_allclose(log.time, T)
    np.testing.assert_allclose(log["x"], 0.1 * T)
    inside = SLOW[-1] >= T
    np.testing.assert_allclose(log["p1"][inside], 1e5 * (50 + T[inside]))
    assert "`2024-05-01_p1.csv`, 40 from 0 to 1.95 s, and is interpolated" in said(log, "resampled")
    # Beside a file, which is that of the signals without one.
    beside = hc.read_log(folder / "x.csv", mapping(x={}, p1={"file": "2024-05-01_p1.csv"}))
    np.testing.assert_array_equal(beside["p1"], log["p1"])


def test_the_mapping_chooses_the_clock(folder):
    signals = {"x": {"file": "x.csv"}, "p1": {"file": "*p1.csv"}}
    log = hc.read_log(folder, mapping({"file": "*p1.csv"}, **signals))
    np.testing.assert_allclose(log.time, SLOW)
    assert '[time] file = "x.csv" reads the log at these' in said(log, "resampled")
    with pytest.raises(hc.InputError, match="no signal is in x.csv"):
        hc.read_log(folder, mapping({"file": "x.csv"}, p1=signals["p1"]))
    with pytest.raises(hc.InputError, match="sample-rate"):
        hc.read_log(folder, mapping({"sample-rate": "1 kHz"}, **signals))


def test_units_of_the_clocks(tmp_path):
    folder = write(tmp_path / "drive", "x.csv", 1000 * T, 100 * T, "t;value [mm]")
    write(folder, "p1.csv", 1000 * T, 50 + T, "t;value [bar]")
    log = hc.read_log(folder, mapping({"column": "t", "unit": "ms"}, x={"file": "x.csv"}, p1={"file": "p1.csv"}))
    np.testing.assert_allclose(log.time, T)
    assert not log.flags


def stamps(times, start="2024-05-01T12:00:"):
    return [f"{start}{time:06.3f}" for time in times]


def test_dates_are_on_one_clock(tmp_path):
    folder = write(tmp_path / "drive", "x.csv", stamps(T), 100 * T, "stamp;value [mm]")
    write(folder, "p1.csv", stamps(T + 0.5), 50 + T, "stamp;value [bar]")
    signals = {"x": {"file": "x.csv"}, "p1": {"file": "p1.csv"}}
    log = hc.read_log(folder, mapping(**signals))
    np.testing.assert_allclose(log.time, T, atol=1e-6)
    late = T >= 0.5
    np.testing.assert_allclose(log["p1"][late], 1e5 * (49.5 + T[late]), rtol=1e-6)
    assert np.isnan(log["p1"][~late]).all()
    write(folder, "p1.csv", stamps(T, "2024-05-01T14:00:"), 50 + T, "stamp;value [bar]")
    with pytest.raises(hc.InputError, match="none in common with the log.* are all clocks set alike"):
        hc.read_log(folder, mapping(**signals))
    write(folder, "p1.csv", T, 50 + T)
    with pytest.raises(hc.InputError, match="x.csv has dates, and p1.csv only seconds"):
        hc.read_log(folder, mapping(**signals))


WRONG = {
    "no such file": ({"file": "p2.csv"}, r"\[signal.p1\] file: `p2.csv` is no file in .*drive"),
    "several files": ({"file": "*.csv"}, r"`\*.csv` fits 2024-05-01_p1.csv, x.csv; name one"),
    "no file": ({}, r"\[signal.p1\] needs a `file`, because .*drive is a folder"),
    "no such column": (
        {"file": "*p1.csv", "column": "valeu"},
        r"\[signal.p1\]: 2024.*p1.csv has no column `valeu`",
    ),
    "no such clock": ({"file": "*p1.csv", "time": "tim"}, r"\[signal.p1\]: 2024-05-01_p1.csv has no column `tim`"),
    "no text": ({"file": 3}, r"\[signal.p1\] file must be a name; got 3"),
    "elsewhere": ({"file": "/none/x.csv"}, r"`/none/x.csv` is no file in"),
    "empty": ({"file": " "}, r"` ` is no file in"),
}


@pytest.mark.parametrize(("entry", "message"), WRONG.values(), ids=WRONG)
def test_wrong_files(entry, message, folder):
    with pytest.raises(hc.InputError, match=message):
        hc.read_log(folder, mapping(x={"file": "x.csv"}, p1=entry))


def test_files_are_looked_for_beside_a_log(folder):
    with pytest.raises(hc.InputError, match="the mapping names files, which are looked for beside a log"):
        hc.Log.of({"time": T, "value": T}, mapping(x={"file": "x.csv"}))
    with pytest.raises(hc.ResultFileError, match="is a folder"):
        hc.read_log(folder)


def test_the_command_line_takes_the_folder(folder, tmp_path):
    from hydrocrane.app.cli import app

    text = '[signal.x]\nfile = "x.csv"\ncolumn = "valu"\n[signal.p1]\nfile = "*p1.csv"\ncolumn = "value"\n'
    (tmp_path / "map.toml").write_text(text)
    done = CliRunner().invoke(app, ["identify", "friction", str(folder), "--mapping", str(tmp_path / "map.toml")])
    assert done.exit_code == 1 and "x.csv has no column `valu`" in str(done.exception)


def test_a_unit_of_times_alone_counts(tmp_path):
    folder = write(tmp_path / "drive", "x.csv", 1000 * T, T, "t;x [m]")
    np.testing.assert_allclose(hc.read_log(folder / "x.csv", {"time": {"unit": "ms"}}).time, T)
