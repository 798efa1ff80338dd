"""A stick held against the end of the ranges: the tip stands, and the joints do not go back and forth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tip_soak import random_sticks

import hydrocrane as hc

EXCAVATOR = Path(__file__).resolve().parents[2] / "data" / "small-excavator.toml"
STEP = 0.01


def smooth(values, seconds):
    """Running mean."""
    count = round(seconds / STEP)
    return np.convolve(values, np.ones(count) / count, "same")


@pytest.mark.parametrize("seed", [0, 1, 3, 4, 5, 10])
def test_a_tip_that_stands_does_not_swing(seed):
    """Between 56 and 111 mm/s, where joints crossed a singular pose and back for the last of the speed, and a joint
    that follows its measured position corrected its own swing. A start against a limit leaves a swing that dies out:
    up to 34 mm/s, by where the drive begins to a tenth of a millimetre."""
    crane = hc.load_machine(EXCAVATOR)
    plan = hc.Scenario(
        machine=crane,
        joints=dict(zip(crane.joint_names, crane.home, strict=True)),
        joystick=random_sticks(seed, 60.0),
        controller="tip",
        duration=60.0,
        record_interval=STEP,
    )
    run = hc.simulate(plan, ledger=False)
    tip, wanted = (
        np.array([np.gradient(run.data[f"{point}.{axis}"].values, STEP) for axis in "xz"])
        for point in ("tip", "set_point")
    )
    swing = tip - [smooth(axis, 0.3) for axis in tip]
    stands = smooth(np.hypot(*wanted), 2.5) < 0.01
    assert stands.sum() > 300
    assert np.sqrt(smooth((swing**2).sum(axis=0), 1.0))[stands].max() < 40e-3
    assert not any(warning.kind == "controller-oscillates" for warning in run.warnings)
