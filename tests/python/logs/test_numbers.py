"""Texts that Python takes for numbers and people do not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.units import plain_number


def test_a_cell_with_an_underscore_is_no_number(tmp_path: Path) -> None:
    rows = "".join(f"{i / 10};{i}_10\n" for i in range(20))
    (tmp_path / "log.csv").write_text("time [s];x [mm];y [mm]\n" + rows.replace("\n", ";1\n"))
    log = hc.read_log(tmp_path / "log.csv")
    assert "x" not in log or not np.isfinite(log["x"]).any()


def test_a_number_has_no_underscores() -> None:
    assert plain_number("1e1") == 10.0
    with pytest.raises(ValueError, match="1_10"):
        plain_number("1_10")
