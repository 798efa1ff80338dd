"""Speed of the tip at full stick where no file states one (docs/theory/control/reference.md)."""

from __future__ import annotations

import math

import numpy as np

import hydrocrane as hc


def fastest_set_point(machine: hc.Machine, stick: dict[str, list[float]], start: np.ndarray) -> float:
    """Speed that the set-point reaches within 3 s of full stick, m/s."""
    plan = hc.Scenario(
        machine=machine,
        joints=dict(zip(machine.joint_names, start.tolist(), strict=True)),
        duration=3.0,
        joystick=hc.Joystick([0.0], stick),
    )
    data = hc.simulate(plan, ledger=False).data
    x, z = (np.gradient(data[f"set_point.{axis}"].values, data["time"].values) for axis in "xz")
    return float(np.hypot(x, z).max())


def test_a_crane_that_is_slow_on_its_oil_has_the_speed_that_it_can_follow() -> None:
    lag_limit = 0.03
    machine = hc.load_machine("hiab-xs031", {"control.tip.lag-limit": lag_limit})
    middle = machine.joint_limits.mean(axis=1)
    # By eigenvalues of the linearised plant, not by the modes of the controller.
    slowest = float(np.min(hc.modes(machine, middle, friction="released").frequency)) * 2.0 * math.pi
    expected = math.e * lag_limit * slowest
    assert slowest < machine.tip_gains["stick-bandwidth"]
    found = fastest_set_point(machine, {"x": [-1.0], "z": [0.0]}, middle + [0.1, -0.3, -0.2])
    assert math.isclose(found, expected, rel_tol=0.02), (found, expected)


def test_a_stiff_crane_has_the_speed_of_its_fastest_joint() -> None:
    machine = hc.load_machine("rottne-f9-lab")
    middle = machine.joint_limits.mean(axis=1)
    posture = np.hypot(*machine.tip_jacobian(middle[np.newaxis])[0])
    # Telescope: the joint is the piston, so nothing stands between its speed and the tip's.
    assert math.isclose(posture[2], 1.0, rel_tol=1e-12)
    found = fastest_set_point(machine, {"x": [-1.0], "z": [0.0]}, middle)
    assert 0.24 < found < 0.27, found
