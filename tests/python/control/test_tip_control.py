"""The controller `tip` keeps its line: the limits that were set before it was written.

Straight lines at 80 % of the feasible speed of each direction (the largest constant speed whose steady spool demand
stays within the stroke along the line, `crates/sim/tests/suite/tip_control.rs`), from rest, on the corrected machine.
"""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.benchmark.cases import Case, run_case
from hydrocrane.benchmark.conditions import Condition
from hydrocrane.benchmark.tasks import straight

CRANE = hc.load_machine("rottne-f9-lab")
# Direction and 80 % of its feasible speed, m/s; 0.4 m each way.
LINES = {
    "up": ((0.0, 0.4), 0.138),
    "down": ((0.0, -0.4), 0.134),
    "out": ((0.4, 0.0), 0.094),
    "in": ((-0.4, 0.0), 0.156),
}


def deviation(direction: str, sensors: str, seed: int = 0, factor: float = 1.0) -> tuple[float, float]:
    """Largest and root-mean-square distance of the true tip from the line, m."""
    leg, speed = LINES[direction]
    task = straight(direction, [np.array(leg)], speed * factor)
    result = run_case(CRANE, "tip", Case(task, Condition(sensors=sensors)), seed=seed)
    assert result.outcome.kind == "completed" and result.metrics is not None
    return result.metrics.path_max, result.metrics.path_rms


@pytest.mark.parametrize("direction", LINES)
def test_ideal_sensors_keep_the_tip_within_5_mm(direction: str) -> None:
    largest, rms = deviation(direction, "ideal")
    assert largest < 5e-3 and rms < 2e-3


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("direction", LINES)
def test_data_sheet_sensors_keep_it_within_20_mm(direction: str, seed: int) -> None:
    largest, rms = deviation(direction, "data-sheet", seed)
    assert largest < 20e-3 and rms < 8e-3


@pytest.mark.parametrize("direction", LINES)
def test_asked_for_twice_the_feasible_speed_it_still_keeps_its_way(direction: str) -> None:
    """2 / 0.8 of the speeds above: the speed gives way, not the direction."""
    largest, _ = deviation(direction, "ideal", factor=2.5)
    assert largest < 10e-3


@pytest.mark.parametrize(
    ("stick", "changes", "why"),
    [
        ({"x": [1.0]}, {}, "out of the range of the joints"),
        ({"z": [-1.0]}, {}, "a keep-out region"),
        ({"z": [1.0]}, {"payload": 400.0, "overrides": {"supply.pressure": "40 bar"}}, "too heavy"),
        ({"z": [0.3]}, {"duration": 3.0}, None),
    ],
)
def test_who_holds_the_stick_is_told_once_why_the_tip_stands(stick, changes, why) -> None:
    start = {"boom": np.deg2rad(60 if "payload" in changes else 100), "jib": np.deg2rad(100), "extension": 0.0}
    stick = hc.Joystick([0.2], stick, full_speed=0.2)
    run = hc.simulate(hc.Scenario(**{"joints": start, "joystick": stick, "duration": 14.0, **changes}))
    events = [event for event in run.events if not event.warning]
    assert len(events) == (why is not None)
    assert all(why in event.text and event.time > 1.0 for event in events)
