"""The measures by which the reproduction judges, on cases whose answer is known, and on faults that they notice."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "reproductions" / "heinze-2007"))
common, cells, spool, steps, valves = (
    importlib.import_module(name)
    for name in ("common", "fig91_92_load_cells", "fig44_spool", "table6_control_algorithm", "table2_valve_signs")
)


def test_a_run_that_ends_early_is_no_run():
    outcome = SimpleNamespace(kind="solver-failed", time=0.04, message="a law jumps here")
    with pytest.raises(RuntimeError, match="heinze-2007 ended at 0.04 s"):
        common.completed(SimpleNamespace(outcome=outcome, data=SimpleNamespace(attrs={"machine": "heinze-2007"})))


def test_a_straight_load_cell_has_no_linearity_error_and_a_bent_one_has_its_own():
    assert cells.linearity(np.array([0.5, 1.0])) == pytest.approx(0.0, abs=1e-12)
    # 0.5 + d and 1 - d are best met by a line of slope 1 through zero.
    assert cells.linearity(np.array([0.501, 0.999])) == pytest.approx(100 * 0.001 / 0.999)
    assert cells.hysteresis(0.5, 0.501) == pytest.approx(0.2)


def test_frequency_and_damping_are_read_from_a_step_whose_own_are_known(monkeypatch):
    natural, ratio = 2 * np.pi * 120.0, 0.3
    damped, time = natural * np.sqrt(1 - ratio**2), np.arange(0, 0.03, 1e-5)
    swing = np.cos(damped * time) + ratio / np.sqrt(1 - ratio**2) * np.sin(damped * time)
    answer = spool.STEP * (1 - np.exp(-ratio * natural * time) * swing)
    monkeypatch.setattr(spool, "response", lambda: (time, answer))
    found = spool.compute()
    assert found["frequency_hz"] == pytest.approx(120.0, rel=1e-5)
    assert found["damping_ratio"] == pytest.approx(0.3, rel=1e-5)
    assert found["largest_share_of_the_rounding"] > 1


@pytest.mark.parametrize("left_out", range(12, 18))
def test_a_step_of_table_6_that_is_left_out_is_noticed(left_out):
    q = np.zeros((40, 3))
    targets = np.cumsum(np.full((40, 3), 0.004), axis=0)
    whole = steps.commands(q, targets)
    assert not steps.close(whole, steps.commands(q, targets, left_out))
    assert np.abs(whole).max() == steps.printed_program.SPOOL_STROKE


def test_a_creep_of_more_than_a_hundredth_counts_as_a_closed_valve_that_does_not_hold():
    motion = np.array([[1.0, -1.0, 0.02], [-1.0, 1.0, 0.005], [-1.0, -1.0, 0.0]])
    assert valves.missed(motion).tolist() == [[False, False, True], [False] * 3, [True, False, False]]
