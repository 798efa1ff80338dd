"""Answers of one's own measures: a figure, or an error of the whole study before anything is kept."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

import hydrocrane as hc
from hydrocrane.studies.measures import Measure

CASES = {"payload.mass": [50.0, 60.0]}


def answered(answer, **options):
    return hc.sweep(
        "single-cylinder-step", CASES, measures={"own": lambda run: answer}, duration=0.05, progress=False, **options
    )


@pytest.mark.parametrize(
    "answer",
    [1, True, np.float32(1), np.array(1.0), xr.DataArray(1.0), Decimal(1), Fraction(1, 1), np.ma.array(1.0)],
    ids=lambda answer: type(answer).__name__,
)
def test_numbers_of_all_kinds_are_figures(answer):
    assert answered(answer)["own"].values.tolist() == [1.0, 1.0]


def test_mappings_name_figures():
    found = answered({"low": np.float64(1.0), "high": xr.DataArray(2.0)})
    assert found["low"].values.tolist() == [1.0, 1.0] and found["high"].values.tolist() == [2.0, 2.0]
    assert answered(xr.Dataset({"far": 3.0}))["far"].values.tolist() == [3.0, 3.0]


@pytest.mark.parametrize(
    "answer",
    [
        None, "12", b"1", 1j, (1.0, 2.0), [1.0], [1, [2, 3]], {1.0}, np.ones(1), np.ones((2, 2)), xr.DataArray([1.0]),
        np.ma.masked, np.ma.array(1.0, mask=True), np.datetime64("2020-01-01"), np.timedelta64(1, "s"),
        {"a": {"b": 1.0}}, {"a": None}, {"a": [1.0]}, {"a": np.ma.masked}, {1: 2.0}, {"": 1.0}, {"a/b": 1.0},
        {"..": 1.0}, {"zarr.json": 1.0}, {"a\0b": 1.0}, {"a\nb": 1.0},
    ],
    ids=repr,
)  # fmt: skip
def test_what_is_no_figure_ends_the_study(answer):
    measure = Measure("own", own=lambda run: answer)
    with pytest.raises(hc.InputError, match="`own` returned .*one real number, or a mapping of names to such numbers"):
        measure.of(SimpleNamespace(run=None))


def test_nothing_is_kept_of_a_study_whose_measure_gives_no_figure(tmp_path):
    store = tmp_path / "study.zarr"
    with pytest.raises(hc.InputError, match="`own` returned ndarray of shape"):
        answered(np.ones(3), store=store, block=1, workers=2)
    assert (hc.open_study(store).outcome == "").all()


@pytest.mark.parametrize("name", ["", "..", "a/b", "zarr.json", "a\0b"])
def test_names_that_no_store_takes_are_refused_at_once(name):
    with pytest.raises(hc.InputError, match="empty, or that no folder"):
        hc.sweep("single-cylinder-step", CASES, measures={name: lambda run: 1.0}, progress=False)


@pytest.mark.parametrize("measures", [5, None, 1.5, {"tip_way"}])
def test_measures_are_names_or_functions(measures):
    with pytest.raises(hc.InputError, match="names or functions of a run"):
        hc.sweep("single-cylinder-step", CASES, measures=measures, progress=False)
