"""Tip control on every bundled crane: what docs/validation/tip-machines.md says is met, on few lines."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).resolve().parents[3] / "docs" / "validation"))

from tip_machines import short  # noqa: E402


@pytest.mark.evidence
def test_no_demand_is_newly_missed():
    assert not short()
