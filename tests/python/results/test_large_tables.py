"""Tables as text: exact, block by block, and refused early where no sheet holds them."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import hydrocrane as hc
from hydrocrane import _core
from hydrocrane.app.cli import app
from hydrocrane.files import text_rows
from hydrocrane.files.columns import Column, Columns
from hydrocrane.files.datasets import frame, save

# A sheet takes a hundred times as long as a text.
ROWS = {".csv": 300_000, ".xlsx": 60_000}


def columns(rows, **more):
    made = {"time": np.arange(rows) * 1e-3, "a.b": np.sin(np.arange(rows))}
    return Columns({name: Column(values, {"units": "m"}) for name, values in (made | more).items()}, {"title": "wide"})


def test_texts_of_numbers_read_back_bit_by_bit_and_are_the_shortest():
    drawn = np.random.default_rng(1).integers(0, 2**64, 100_000, dtype=np.uint64).view(np.float64)
    special = [0.0, -0.0, 5e-324, 1e-4, 9.999e-5, 9999999999999998.0, 1e16, np.inf, -np.inf]
    values = np.concatenate([drawn[np.isfinite(drawn)], 10.0 ** np.arange(-320, 309), special])
    texts = _core.csv_rows([values]).decode().split("\n")[:-1]
    assert np.array_equal(np.array(texts, dtype=np.float64).view(np.int64), values.view(np.int64))
    wanted = [repr(value) for value in values.tolist()]
    assert [len(text) for text in texts] == [len(text) for text in wanted]
    # Of two shortest texts as near as each other Python takes the even one.
    assert sum(text != other for text, other in zip(texts, wanted, strict=True)) < 50


def test_csv_is_what_pandas_writes_of_the_same_data(tmp_path, monkeypatch):
    monkeypatch.setattr(text_rows, "_BLOCK", 64)
    run = hc.simulate("single-cylinder-step", duration=0.2)
    data = run.data.assign(
        flag=("time", run.columns.time > 0.1),
        count=("time", np.arange(run.columns.rows)),
        words=("time", np.array(['a,b "c"'] * run.columns.rows)),
        gaps=("time", np.where(run.columns.time > 0.1, np.nan, 1.0)),
        constant=2.5,
    )
    written = save(data, tmp_path / "run.csv").read_text(encoding="utf-8").split("\n", 1)
    assert written[0].startswith("time [s],joint.slide.q [m]")
    assert written[1] == frame(data).to_csv(index=False, header=False, lineterminator="\n")


def test_what_is_over_more_than_time_is_no_table(tmp_path):
    run = hc.simulate("single-cylinder-step", duration=0.1)
    data = run.data.assign(wide=(("time", "k"), np.zeros((run.columns.rows, 2))))
    for name in ("run.csv", "run.xlsx"):
        with pytest.raises(hc.ResultFileError, match="`wide` is over time, k"):
            save(data, tmp_path / name)


@pytest.mark.parametrize("suffix", [".csv", ".xlsx"])
def test_a_large_table_is_not_held_a_second_time(suffix, tmp_path, monkeypatch):
    pytest.importorskip("openpyxl")
    rows = ROWS[suffix]
    monkeypatch.setattr(text_rows, "_BLOCK", rows // 20)
    table = columns(rows, c=np.full(rows, np.nan))
    tracemalloc.start()
    try:
        path = save(table, tmp_path / f"large{suffix}")
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert path.stat().st_size > 10 * rows
    assert peak < 8 * rows


def test_a_sheet_has_the_same_numbers_and_no_cell_for_what_is_missing(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    gaps = np.array([np.nan, 1 / 3, np.inf, -0.0, 5e-324])
    path = save(columns(5, gaps=gaps, flag=np.arange(5) > 2), tmp_path / "run.xlsx")
    head, *rows = openpyxl.load_workbook(path)["data"].iter_rows(values_only=True)
    assert head == ("time [m]", "a.b [m]", "gaps [m]", "flag [m]")
    assert [row[2] for row in rows] == [None, 1 / 3, None, 0.0, 5e-324] and [row[3] for row in rows] == [0, 0, 0, 1, 1]
    pd.testing.assert_index_equal(pd.read_excel(path).columns, pd.Index(head))
    with pytest.raises(hc.ResultFileError, match="`words` has no numbers"):
        save(columns(2, words=np.array(["a", "b"])), tmp_path / "words.xlsx")


def test_more_rows_than_a_sheet_has_are_refused_before_the_run(tmp_path):
    arguments = ["simulate", "single-cylinder-step", "--duration", "20000", "-o", str(tmp_path), "--also", "xlsx"]
    result = CliRunner().invoke(app, arguments)
    assert isinstance(result.exception, hc.ResultFileError) and "record less often" in str(result.exception)
    assert not list(tmp_path.iterdir())
