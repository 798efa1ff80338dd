"""The tip after a stop and at rest under tip control: it settles, is quiet and stays where it is."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.benchmark.stops import random_stop

# m/s and m
QUIET, DRIFT = 1e-3, 1e-3
LAB = "rottne-f9-lab"


def campaign(name: str, sensors: str, payload: float, seeds: int) -> np.ndarray:
    """Settling, quiet and drift (m, 3) of the stops that the machine can make."""
    machine = hc.load_machine(name)
    stops = [random_stop(machine, seed, payload=payload, sensors=sensors) for seed in range(seeds)]
    found = [(stop.settling, stop.quiet, stop.drift) for stop in stops if stop is not None]
    assert len(found) > seeds // 2
    return np.array(found)


@pytest.mark.parametrize(("payload", "sensors"), [(0.0, "ideal"), (200.0, "data-sheet")])
def test_a_few_stops_settle_and_are_quiet(payload, sensors):
    settle, quiet, drift = campaign(LAB, sensors, payload, 4).T
    assert np.median(settle) < 1.2 and quiet.max() < QUIET and drift.max() < DRIFT


@pytest.mark.evidence
@pytest.mark.parametrize("payload", [0.0, 80.0, 200.0, 300.0])
@pytest.mark.parametrize(("sensors", "median", "most"), [("ideal", 0.6, 2.0), ("data-sheet", 1.2, 2.0)])
def test_stops_settle_and_the_tip_is_quiet_at_rest(sensors, median, most, payload):
    settle, quiet, drift = campaign(LAB, sensors, payload, 24).T
    assert np.median(settle) < median and settle.max() < most
    assert quiet.max() < QUIET and drift.max() < DRIFT


@pytest.mark.evidence
def test_the_loader_crane_settles_too():
    """4 kN of friction and a lowest mode at 2 Hz; no gain is its own."""
    settle, quiet, _ = campaign("hiab-xs031", "ideal", 0.0, 24).T
    assert np.median(settle) < 1.7 and settle.max() < 3.0 and quiet.max() < QUIET
