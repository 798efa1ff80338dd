"""What the linear model says of the period of tip control, and whether oscillations agree."""

from __future__ import annotations

import numpy as np

import hydrocrane as hc
from hydrocrane.benchmark.fitted_tasks import INNER
from hydrocrane.linear import period_advice

LAB = "rottne-f9-lab"


def put_down(machine: hc.Machine, seed: int) -> float:
    """Time until the tip stays below 5 mm/s after 20 kg are put down in a random pose, s."""
    low, high = machine.joint_limits.T
    start = low + (high - low) * np.random.default_rng(seed).uniform(*INNER, low.size)
    plan = hc.Scenario(
        machine=machine,
        joints=dict(zip(machine.joint_names, start.tolist(), strict=True)),
        payload=20.0,
        payload_changes={1.0: 0.0},
        duration=4.0,
        record_interval=2e-3,
        joystick=hc.Joystick([0.0], {"x": [0.0], "z": [0.0]}),
    )
    data = hc.simulate(plan, ledger=False).data
    time = data["time"].values
    speed = np.hypot(*(np.gradient(data[f"tip.{axis}"].values, time) for axis in "xz"))
    return float(time[np.flatnonzero(speed > 5e-3)[-1]] - 1.0)


def test_the_laboratory_crane_needs_half_of_the_default_and_rings_at_it() -> None:
    """Medians of 16 poses: 0.45 s at 10 ms, 0.16 s at 5 ms."""
    advice = period_advice(LAB)
    assert advice.too_long and 'control.period = "5 ms"' in str(advice)
    shorter = hc.load_machine(LAB, {"control.period": "5 ms"})
    assert not period_advice(shorter).too_long
    slow, fast = (np.median([put_down(m, seed) for seed in range(16)]) for m in (hc.load_machine(LAB), shorter))
    assert slow > 0.35 and fast < 0.2, (slow, fast)


def test_rigs_whose_modes_no_stop_excites_need_no_other_period() -> None:
    advice = period_advice("rig-rottne")
    assert not advice.too_long and "damps all oil modes" in str(advice)


def test_drift_by_leakage_hides_no_mode() -> None:
    """The slowest mode of a loader crane is some 1 Hz; one of 19 Hz in a single pose sets the period."""
    advice = period_advice("hiab-xs031")
    assert advice.too_long and 15.0 < advice.frequency < 21.0
