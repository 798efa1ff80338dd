"""The stick runs against the limits of joints and pistons: felt as slowing, not as a blow."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

START = {"boom": np.deg2rad(100), "jib": np.deg2rad(100), "extension": 0.0}
# Rate of the slow-down before limits, 1/s, and the bandwidth of the stick's lags, rad/s: the defaults of `tip`.
RATE, STICK = 2.0, 15.0
SPEED, PERIOD = 0.2, 0.01


@pytest.mark.parametrize("axes", [{"x": [1.0]}, {"x": [-1.0]}, {"z": [1.0]}, {"x": [0.7], "z": [0.7]}], ids=str)
def test_a_limit_is_approached_exponentially_without_a_blow(axes) -> None:
    stick = hc.Joystick([0.2], axes, full_speed=SPEED)
    run = hc.simulate(hc.Scenario(joints=START, joystick=stick, duration=14.0))
    told = [event for event in run.events if "out of the range of the joints" in event.text]
    assert len(told) == 1
    place = np.column_stack([run.data["set_point.x"], run.data["set_point.z"]])
    pace = np.hypot(*np.diff(place, axis=0).T) / PERIOD
    fastest = int(pace.argmax())
    slowing = np.diff(pace[fastest:]) / PERIOD
    # The measure is a stick that is released: behind two lags speed falls by up to bandwidth / e of itself per second.
    assert slowing[:-1].min() > -SPEED * STICK / np.e
    assert pace[-2] < 0.1 * SPEED
    crane = run.machine
    for joint, (low, high) in zip(crane.joint_names, crane.joint_limits, strict=True):
        q, rate = (run.data[f"joint.{joint}.{what}"].values for what in ("q", "qd"))
        assert low - 2e-3 < q.min() and q.max() < high + 2e-3, joint
        # The true joint differs a little from its reference, which keeps the law exactly.
        assert (rate < RATE * (high - q) + 0.02).all() and (rate > -RATE * (q - low) - 0.02).all(), joint
