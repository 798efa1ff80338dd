"""A comparison says how much of the log it compares."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc


@pytest.fixture(scope="module")
def run() -> hc.Run:
    return hc.simulate("single-cylinder-step", duration=1.0)


def test_samples_compared_and_left_out_are_counted(run: hc.Run) -> None:
    time, z = run.columns.time, run.columns["tip.z"].values
    whole = run.compare({"time": time, "tip.z": z})
    assert (whole["tip.z"].compared, whole["tip.z"].left_out, whole.warnings) == (time.size, 0, ())
    gaps = np.where(time > 0.3, np.nan, z)
    few = run.compare({"time": time, "tip.z": gaps})
    assert few["tip.z"].left_out == np.count_nonzero(time > 0.3)
    assert [warning.kind for warning in few.warnings] == ["little-compared"]


@pytest.mark.parametrize("factor", [1e3, 1e6], ids=["ms", "us"])
def test_times_in_another_unit_are_warned_of(run: hc.Run, factor: float) -> None:
    apart = run.compare({"time": run.columns.time * factor, "tip.z": run.columns["tip.z"].values})
    assert apart["tip.z"].compared == 1 and "1 of 201 samples" in apart.summary()


def test_the_times_compared_are_told(run: hc.Run) -> None:
    """All samples of a log in minutes lie within the run, at its very beginning."""
    minutes = run.compare({"time": run.columns.time / 60.0, "tip.z": run.columns["tip.z"].values})
    assert "201 samples from 0 to 0.01667 s compared, 0 left out" in minutes.summary()


def test_two_drives_in_one_log_are_refused(run: hc.Run) -> None:
    time, z = run.columns.time, run.columns["tip.z"].values
    with pytest.raises(hc.HydrocraneError, match="goes back"):
        run.compare({"time": np.r_[time, time], "tip.z": np.r_[z, z]})
