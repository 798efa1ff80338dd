"""The tip after a stop and at rest under tip control: it settles, is quiet and stays where it is."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

# m/s and m; a stop takes 0.4 s from 0.3 m/s by the lags of the stick alone.
SETTLED, QUIET, DRIFT = 5e-3, 1e-3, 1e-3
STOP, END, REST = 1.0, 16.0, 6.0


def stopped(sensors: str, payload: float, seed: int) -> tuple[float, float, float] | None:
    """Time to settle, RMS speed at rest and drift of the laboratory crane after a random move from a random pose.

    None where it cannot hold or lift the load there.
    """
    rng = np.random.default_rng(seed)
    crane = hc.load_machine("rottne-f9-lab")
    low, high = np.asarray(crane.joint_limits).T
    q = low + (high - low) * rng.uniform(0.15, 0.85, len(low))
    angle = rng.uniform(0.0, 2.0 * np.pi)
    stick = hc.Joystick([0.0, STOP], {"x": [np.cos(angle), 0.0], "z": [np.sin(angle), 0.0]}, full_speed=0.3)
    plan = hc.Scenario(
        joints=dict(zip(crane.joint_names, q.tolist(), strict=True)),
        payload=payload,
        duration=END,
        record_interval=5e-3,
        joystick=stick,
        sensors=sensors,
        seed=seed,
    )
    try:
        run = hc.simulate(plan, ledger=False)
    except hc.HydrocraneError:
        return None
    if run.events or run.warnings:
        return None
    time = run.data["time"].values
    tip = np.stack([run.data["tip.x"].values, run.data["tip.z"].values], axis=1)
    speed = np.hypot(*np.gradient(tip, time, axis=0).T)
    fast = time[(time > STOP) & (speed > SETTLED)]
    settled = float(fast.max() - STOP) if fast.size else 0.0
    rest = time > REST
    drift = np.linalg.norm(tip[rest] - tip[rest][0], axis=1).max()
    return settled, float(np.sqrt((speed[rest] ** 2).mean())), float(drift)


def campaign(sensors: str, payload: float, seeds: int) -> np.ndarray:
    found = [each for each in (stopped(sensors, payload, seed) for seed in range(seeds)) if each is not None]
    assert len(found) > seeds // 2
    return np.array(found)


@pytest.mark.parametrize(("payload", "sensors"), [(0.0, "ideal"), (200.0, "data-sheet")])
def test_a_few_stops_settle_and_are_quiet(payload, sensors):
    settle, quiet, drift = campaign(sensors, payload, 4).T
    assert np.median(settle) < 1.5 and quiet.max() < QUIET and drift.max() < DRIFT


@pytest.mark.evidence
@pytest.mark.parametrize("payload", [0.0, 80.0, 200.0, 300.0])
@pytest.mark.parametrize(("sensors", "median", "most"), [("ideal", 0.8, 3.0), ("data-sheet", 1.5, 3.0)])
def test_stops_settle_and_the_tip_is_quiet_at_rest(sensors, median, most, payload):
    settle, quiet, drift = campaign(sensors, payload, 24).T
    print(f"{payload:3g} kg, {sensors}: settled {np.median(settle):.2f} s, at most {settle.max():.2f} s;", end=" ")
    print(f"{1e3 * quiet.max():.2f} mm/s, drift {1e3 * drift.max():.2f} mm at most, {len(settle)} stops")
    assert np.median(settle) < median and settle.max() < most
    assert quiet.max() < QUIET and drift.max() < DRIFT
