"""Sticks at the ends of their ranges do not take a loader crane over its dead centre."""

import pytest

import hydrocrane as hc
from hydrocrane.benchmark.soak import soak

SECONDS = 40.0
# Cylinders without a stated rating are rated for this many supply pressures.
RATED = 1.5


@pytest.mark.evidence
@pytest.mark.parametrize("seed", range(2))
def test_random_sticks_at_its_own_full_speed_keep_the_loader_crane_within_its_bounds(seed: int) -> None:
    found = soak(hc.load_machine("hiab-xs031"), seed, SECONDS)
    assert found.outcome == "completed"
    assert not found.warnings
    assert not found.alarms
    assert found.beyond_limits == 0.0
    assert found.pressure < RATED
