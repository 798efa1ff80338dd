"""The set-point moves no faster than the cylinders can brake: shorter stops, gentler full sticks of a loader crane."""

import numpy as np
import pytest
from tip_soak import soak
from tip_stops import random_stop

import hydrocrane as hc

LOADER = "hiab-xs031"
SECONDS = 120.0
# Without braking these drives reach 1.88, 2.06 and 1.92 supply pressures.
MOST_PRESSURE = 1.6


@pytest.mark.parametrize(("seed", "payload", "most"), [(280, 0.0, 4.5), (201, 200.0, 5.0)])
def test_stops_that_took_eight_seconds_are_shorter(seed: int, payload: float, most: float) -> None:
    """8.8 and 8.4 s without braking and with a damping ratio of 0.25; 7.1 and 8.4 s without braking alone."""
    stop = random_stop(hc.load_machine(LOADER), seed, payload=payload)
    assert stop is not None and stop.settling < most


def test_a_set_point_that_a_limit_has_held_starts_behind_its_lags() -> None:
    """Held at its reach, then the stick turns: with lags that stay wound up it jumped by 330 mm/s within a sample,
    and the tip fell back by 336 mm."""
    pose = {"lift": np.deg2rad(68.6), "tilt": np.deg2rad(-10.0), "extension": 1.08}
    stick = hc.Joystick([0.0, 3.0], {"x": [-1.0, -1.0], "z": [1.0, -1.0]}, full_speed=0.3)
    run = hc.simulate(hc.Scenario(machine=LOADER, joints=pose, joystick=stick, duration=4.9), ledger=False)
    set_point, tip = (np.column_stack([run.data[f"{of}.{axis}"] for axis in "xz"]) for of in ("set_point", "tip"))
    speed = np.hypot(*np.gradient(set_point, run.data["time"].values, axis=0).T)
    assert speed.max() > 0.25 and np.diff(speed).max() < 0.05
    assert np.hypot(*(tip - set_point).T).max() < 0.05


@pytest.mark.evidence
@pytest.mark.parametrize("seed", [3, 4, 5, 19])
def test_random_sticks_at_low_speed_do_not_swing_the_tip_away_from_its_set_point(seed: int) -> None:
    """Seeds 3 and 19: 586 and 1903 mm where the oil stayed compressed for the force of a set-point that had stopped
    at once near the dead centre of the lift."""
    found = soak(hc.load_machine(LOADER), seed, 360.0, full_speed=0.3)
    assert found.outcome == "completed" and found.lag < 0.2 and found.beyond_limits == 0.0


@pytest.mark.evidence
@pytest.mark.parametrize(("speed", "seed"), [(0.3, 21), (None, 16), (None, 17)])
def test_random_sticks_take_no_joint_over_its_dead_centre(speed: float | None, seed: int) -> None:
    """11.9 % and 44.5 % of its range beyond its limits where only a load that pushes on counted, and 49.6 % where the
    set-point lost its speed no faster before a dead centre than elsewhere."""
    found = soak(hc.load_machine(LOADER), seed, 360.0, full_speed=speed)
    assert found.outcome == "completed" and found.beyond_limits == 0.0


@pytest.mark.evidence
@pytest.mark.parametrize(("speed", "seed"), [(0.3, 4), (0.3, 6), (None, 0)])
def test_random_sticks_keep_the_tip_out_of_the_margin_of_regions(speed: float | None, seed: int) -> None:
    """19.3, 16.4 and 17.7 mm into it without the rules for slow cranes."""
    crane = hc.load_machine(LOADER)
    found = soak(crane, seed, 360.0, full_speed=speed)
    assert crane.tip_gains["keep-out-margin"] - found.clearance < 0.005


@pytest.mark.evidence
@pytest.mark.parametrize("seed", [50, 53, 54])
def test_random_sticks_at_its_own_full_speed_do_not_burst_the_loader_crane(seed: int) -> None:
    found = soak(hc.load_machine(LOADER), seed, SECONDS)
    assert found.outcome == "completed" and found.beyond_limits == 0.0
    assert found.pressure < MOST_PRESSURE
