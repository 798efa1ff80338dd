"""The set-point moves no faster than the cylinders can brake: shorter stops, gentler full sticks of a loader crane."""

import pytest

import hydrocrane as hc
from hydrocrane.benchmark.soak import soak
from hydrocrane.benchmark.stops import random_stop

LOADER = "hiab-xs031"
SECONDS = 120.0
# Without braking these drives reach 1.88, 2.06 and 1.92 supply pressures.
MOST_PRESSURE = 1.6


@pytest.mark.parametrize(("seed", "payload", "most"), [(280, 0.0, 4.5), (201, 200.0, 5.0)])
def test_stops_that_took_eight_seconds_are_shorter(seed: int, payload: float, most: float) -> None:
    """8.8 and 8.4 s without braking and with a damping ratio of 0.25; 7.1 and 8.4 s without braking alone."""
    stop = random_stop(hc.load_machine(LOADER), seed, payload=payload)
    assert stop is not None and stop.settling < most


@pytest.mark.evidence
@pytest.mark.parametrize("seed", [50, 53, 54])
def test_random_sticks_at_its_own_full_speed_do_not_burst_the_loader_crane(seed: int) -> None:
    found = soak(hc.load_machine(LOADER), seed, SECONDS)
    assert found.outcome == "completed" and found.beyond_limits == 0.0
    assert found.pressure < MOST_PRESSURE
