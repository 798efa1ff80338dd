"""Runs in the formats of loggers, viewers and offices, read back by the libraries of those formats."""

from __future__ import annotations

import json
import sys

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.files import excel

FORMATS = {".mcap": ("mcap", "mcap"), ".mf4": ("asammdf", "mdf"), ".xlsx": ("openpyxl", "excel")}


@pytest.fixture(scope="module")
def run():
    return hc.simulate("tip-vertical-line", duration=0.1)


def names_of(run):
    return [name for name in run.columns if name != "time"]


def test_mcap(run, tmp_path):
    reader = pytest.importorskip("mcap.reader")
    with run.save(tmp_path / "run.mcap").open("rb") as stream:
        found, units = {}, {}
        opened = reader.make_reader(stream)
        for schema, channel, message in opened.iter_messages():
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            fields = json.loads(schema.data)["properties"]
            for field, value in json.loads(message.data).items():
                name = f"{channel.topic}/{field}"
                found.setdefault(name, []).append((message.log_time, value))
                units[name] = fields[field]["description"]
        about = {record.name: record.metadata for record in opened.iter_metadata()}["hydrocrane"]
    assert about["machine"] == run.columns.attrs["machine"]
    assert {"/cylinder/lift/p1", "/tip/z", "/run/payload", "/measured/joint/boom/q"} <= set(found)
    assert units["/tip/z"] == "crane tip, up [m]"
    for name in names_of(run):
        rows = found[f"/{name.replace('.', '/')}" if "." in name else f"/run/{name}"]
        values, there = run.columns[name].values, np.isfinite(run.columns[name].values)
        np.testing.assert_array_equal([value for _, value in rows], values[there])
        np.testing.assert_allclose([1e-9 * time for time, _ in rows], run.columns.time[there], atol=1e-9)


def test_excel(run, tmp_path, monkeypatch):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.load_workbook(run.save(tmp_path / "run.xlsx"), read_only=True)
    head, *rows = book["data"].iter_rows(values_only=True)
    assert head[0] == "time [s]" and "cylinder.lift.p1 [Pa]" in head and "stick.x" in head
    assert len(rows) == run.columns.rows
    for i, title in enumerate(head):
        column = np.array([np.nan if row[i] is None else row[i] for row in rows], dtype=float)
        # The library writes 16 digits.
        np.testing.assert_allclose(column, run.columns[title.split(" [")[0]].values, rtol=1e-15)
    about = {row[0]: row[1:] for row in book["about"].iter_rows(values_only=True) if row and row[0]}
    assert about["tip.z"][:2] == ("m", "crane tip, up") and about["machine"][0] == run.columns.attrs["machine"]
    monkeypatch.setattr(excel, "MOST_ROWS", 5)
    with pytest.raises(hc.ResultFileError, match="record less often"):
        run.save(tmp_path / "long.xlsx")
    assert not (tmp_path / "long.xlsx").exists()


@pytest.mark.evidence
def test_mdf(run, tmp_path):
    asammdf = pytest.importorskip("asammdf")
    path = run.save(tmp_path / "run.mf4")
    with asammdf.MDF(path) as stored:
        assert json.loads(stored.header.description)["machine"] == run.columns.attrs["machine"]
        for name in names_of(run):
            signal = stored.get(name)
            np.testing.assert_array_equal(signal.samples, run.columns[name].values)
            np.testing.assert_array_equal(signal.timestamps, run.columns.time)
        assert stored.get("tip.z").unit == "m" and stored.get("tip.z").comment == "crane tip, up"
    comparison = run.compare(path)
    assert comparison.rms["tip.z"] == 0.0


def test_a_csv_with_units_compares_with_its_run(run, tmp_path):
    comparison = run.compare(run.save(tmp_path / "run.csv"))
    assert comparison.rms["tip.z"] == 0.0 and comparison.rms["cylinder.lift.p1"] == 0.0


@pytest.mark.parametrize("suffix", FORMATS)
def test_without_its_package_the_extra_is_named(run, tmp_path, monkeypatch, suffix):
    package, extra = FORMATS[suffix]
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(hc.ResultFileError, match=rf"need the package {package}; install hydrocrane\[{extra}\]"):
        run.save(tmp_path / f"run{suffix}")
    assert not list(tmp_path.iterdir())
