"""The tip after a stop, at rest and under random sticks for long: it settles, is quiet and keeps within its bounds."""

from __future__ import annotations

import numpy as np
import pytest
from tip_soak import soak
from tip_stops import REST, random_stop

import hydrocrane as hc

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


@pytest.mark.parametrize("end", [6.0, float("nan"), float("inf")])
def test_a_stop_needs_a_rest_to_judge(end):
    with pytest.raises(hc.InputError, match="end must be more than"):
        random_stop(hc.load_machine(LAB), 0, end=end)


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
    settle, quiet, drift = campaign("hiab-xs031", "ideal", 0.0, 24).T
    assert np.median(settle) < 1.5 and settle.max() < 2.5 and quiet.max() < QUIET and drift.max() < DRIFT


@pytest.mark.parametrize(("name", "sensors", "payload"), [(LAB, "data-sheet", 300.0), ("hiab-xs031", "ideal", 0.0)])
def test_a_minute_at_rest_is_without_creep(name, sensors, payload):
    """One count of the laboratory crane's encoders is some millimetres at the tip; the seals of the other relax."""
    stop = random_stop(hc.load_machine(name), 4, payload=payload, sensors=sensors, end=REST + 60.0)
    assert stop is not None and stop.quiet < QUIET and stop.drift < DRIFT


@pytest.mark.evidence
@pytest.mark.parametrize("sensors", ["ideal", "data-sheet"])
@pytest.mark.parametrize(("payload", "seed"), [(0.0, 0), (0.0, 2), (300.0, 2), (300.0, 4)])
def test_ten_minutes_at_rest_are_quiet_and_without_creep(sensors, payload, seed):
    stop = random_stop(hc.load_machine(LAB), seed, payload=payload, sensors=sensors, end=REST + 600.0)
    assert stop is not None and stop.quiet < QUIET and stop.drift < DRIFT


@pytest.mark.evidence
@pytest.mark.parametrize(("payload", "seed"), [(0.0, 1), (80.0, 5), (300.0, 5)])
def test_ten_minutes_at_rest_of_the_loader_crane(payload, seed):
    stop = random_stop(hc.load_machine("hiab-xs031"), seed, payload=payload, end=REST + 600.0)
    assert stop is not None and stop.quiet < QUIET and stop.drift < DRIFT


@pytest.mark.evidence
@pytest.mark.parametrize(("sensors", "payload", "lag"), [("ideal", 0.0, 10e-3), ("data-sheet", 200.0, 20e-3)])
def test_random_sticks_stay_within_limits_regions_and_pressures(sensors, payload, lag):
    found = soak(hc.load_machine(LAB), 3, 180.0, payload=payload, sensors=sensors)
    assert found.outcome == "completed" and not found.alarms and all("vacuum" in text for text in found.warnings)
    assert found.beyond_limits == 0.0 and found.pressure < 1.5 and found.lag < lag
    assert found.clearance > 0.03


@pytest.mark.evidence
@pytest.mark.parametrize(("seed", "lasts"), [(0, 210.0), (1, 290.0)])
def test_random_sticks_do_not_lead_the_loader_crane_over_its_dead_centre(seed, lasts):
    found = soak(hc.load_machine("hiab-xs031"), seed, lasts, full_speed=0.3)
    assert found.outcome == "completed" and not found.alarms and all("vacuum" in text for text in found.warnings)
    assert found.beyond_limits == 0.0 and found.pressure < 1.5


@pytest.mark.evidence
def test_sticks_that_push_into_regions_stay_out():
    machine = hc.load_machine("hiab-xs031")
    found = soak(machine, 3, 120.0, full_speed=0.3, towards=(-1.0, -1.0))
    assert found.outcome == "completed"
    assert found.clearance > machine.tip_gains["keep-out-margin"] - 5e-3
