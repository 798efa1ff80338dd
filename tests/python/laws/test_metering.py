"""Curves of metering edges: against SciPy, through tip control, and their derivatives by values of the file."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import hydrocrane as hc
from hydrocrane.errors import InputError

TRAVEL, AREA = [0.0, 0.1, 0.5, 0.8, 1.0], [0.0, 0.0, 0.2, 0.9, 0.9]
CURVED = """extends = "{base}"
[machine]
class = "assumed"
source = "a test"
"""
FEED = "\n[valve.{valve}.metering.{edge}]\ntravel = [0, 0.1, 0.5, 0.8, 1]\narea = [0, 0, 0.2, 0.9, 0.9]\n"


def machine(tmp_path, base, valves=("lift", "jib"), edges=("supply-to-a", "supply-to-b")):
    path = tmp_path / "curved.toml"
    curves = [FEED.format(valve=valve, edge=edge) for valve in valves for edge in edges]
    path.write_text(CURVED.format(base=base) + "".join(curves), encoding="utf-8")
    return path


def test_an_edge_opens_along_the_curve_of_scipy(tmp_path):
    crane = hc.load_machine(machine(tmp_path, "rottne-f9-lab"))
    spool = np.linspace(-0.05, 0.05, 401)
    areas = crane.edge_areas(spool, "jib")
    assert areas.shape == (401, 4)
    curve = PchipInterpolator(TRAVEL, AREA)
    np.testing.assert_allclose(areas[:, 0], curve(np.maximum(spool, 0.0) / 0.05), atol=1e-14)
    np.testing.assert_allclose(areas[:, 2], curve(np.maximum(-spool, 0.0) / 0.05), atol=1e-14)
    # Edges without a curve, and a regenerative valve, which has no edge from B to the tank.
    np.testing.assert_allclose(areas[:, 1], np.maximum(-spool, 0.0) / 0.05, atol=1e-15)
    regenerative = crane.edge_areas(spool, "extension")
    np.testing.assert_allclose(regenerative[:, 2], abs(spool) / 0.05, atol=1e-15)
    assert not regenerative[:, 3].any()


@pytest.mark.parametrize("base", ["rottne-f9-lab", "rottne-f9-mobile"])
def test_a_share_of_the_speed_is_what_its_spool_position_gives(tmp_path, base):
    crane = hc.load_machine(machine(tmp_path, base))
    pose, shares = [1.745, 1.745, 0.0], np.array([0.3, -0.5, 0.0])
    spools = crane.spool_positions(shares)
    assert spools[0] > 0.005 and spools[1] < -0.005 and spools[2] == 0.0
    run = hc.simulate(
        hc.Scenario(
            machine=crane,
            joints=dict(zip(crane.joint_names, pose, strict=True)),
            commands={name: hc.Command([0.0], [spool]) for name, spool in zip(("lift", "jib"), spools, strict=False)},
            duration=1.5,
        )
    )
    speeds = crane.piston_speeds(np.array([run.data[f"joint.{j}.q"].values[-1] for j in crane.joint_names]))
    for i, name in enumerate(("lift", "jib")):
        wanted = abs(shares[i]) * speeds[i, int(shares[i] > 0)]
        assert run.data[f"cylinder.{name}.v"].values[-1] == pytest.approx(wanted, rel=0.1), name


def test_tip_control_knows_the_curve(tmp_path):
    """On the same path, the deviation with curves is that with straight edges, within half a millimetre."""
    path = machine(tmp_path, "rottne-f9-lab")
    off = [
        float(np.nanmax(abs(hc.simulate("tip-vertical-line", machine=m, duration=4.0).data["tip.deviation"].values)))
        for m in ("rottne-f9-lab", path)
    ]
    assert off[1] < off[0] + 1e-3, off


@pytest.mark.parametrize("key", ["valve.lift.stroke", "valve.lift.nominal-flow"])
def test_derivatives_by_the_values_around_a_curve_are_those_of_differences(tmp_path, key):
    path = machine(tmp_path, "rottne-f9-mobile")
    lift = hc.load_scenario("vertical-lift-open-loop")
    scenario = lift.changed(machine=str(path), duration=1.0, record_interval=0.05)
    exact = hc.sensitivities(scenario, [key], rtol=1e-8)
    value = np.asarray(hc.load_machine(path).value(key).si).item()

    def at(factor):
        run = hc.simulate(scenario, overrides={key: value * factor}, rtol=1e-10)
        return np.column_stack([run.data[name].values for name in ("tip.x", "tip.z")])

    difference = (at(1.001) - at(0.999)) / (0.002 * value)
    found = np.column_stack([np.asarray(exact.data[name]).squeeze() for name in ("tip.x", "tip.z")])
    gap = abs(found - difference).max(axis=0) / abs(difference).max(axis=0)
    assert np.all(gap < 2e-3), gap


def test_shares_of_the_wrong_number_are_refused():
    crane = hc.load_machine("rottne-f9-lab")
    with pytest.raises(InputError, match="shares"):
        crane.spool_positions([0.5, 0.5])
    assert crane.spool_positions(np.zeros((4, 3))).shape == (4, 3)


def test_the_speed_of_the_pump_changes_with_the_phases():
    """At idle speed the pump gives no more than its displacement times that speed."""
    phases = [hc.Phase(1.0, {"pump.main.speed": "700 rpm"}), hc.Phase(2.0, {"pump.main.speed": "1450 rpm"})]
    plan = hc.load_scenario("tip-vertical-line").changed(machine="rottne-f9-pump", duration=3.0, phases=phases)
    data = hc.simulate(plan).data
    rpm = data["mains.shaft_speed"].values * 60 / (2 * np.pi)
    slow = (data.time.values > 1.01) & (data.time.values < 1.99)
    assert rpm[slow] == pytest.approx(700.0)
    assert rpm[data.time.values > 2.01] == pytest.approx(1450.0)
    assert data["mains.pump_flow"].values[slow].max() < 6.3e-6 * 700 / 60


def test_flow_valves_keep_their_speed_when_a_load_is_taken_up():
    """The thesis's own block keeps 8 bar over the edge, so that 150 kg change nothing; its model slows down."""
    speeds = {}
    for name in ("rottne-f9-ls", "rottne-f9-lab"):
        data = hc.simulate("flow-valve-lift", machine=name).data
        q, time = data["cylinder.lift.q1"].values, data.time.values
        speeds[name] = [q[(time > a) & (time < a + 0.5)].mean() for a in (1.9, 3.7)]
        if name == "rottne-f9-ls":
            # 1e-4 m^3/s at full opening, 21 of 46 mm of it.
            assert speeds[name][0] == pytest.approx(1e-4 * 21 / 46, rel=2e-3)
    before, after = np.array(list(speeds.values())).T
    assert after[0] == pytest.approx(before[0], rel=2e-3)
    assert after[1] < 0.95 * before[1]
