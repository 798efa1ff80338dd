"""Tip control on every bundled crane: what docs/validation/tip-machines.md says is met, on few lines."""

from __future__ import annotations

import pytest
from tip_machines import short


@pytest.mark.evidence
def test_no_demand_is_newly_missed():
    assert not short()
