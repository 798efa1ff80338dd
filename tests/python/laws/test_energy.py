"""Where the pump's work goes: the ledger of a run against the energies computed from its states.

stored(t) - stored(0) = sum of sign x ledger, with stored = kinetic + potential + oil + end stops + bristles. The left
side comes from the states alone, the right one is integrated by the method along with them.
"""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

METHODS = ("rodas5p", "hc-exponential-4", "tsit5")
DISSIPATED = (
    "edge_pa",
    "edge_at",
    "edge_pb",
    "edge_bt",
    "internal_leakage",
    "external_leakage",
    "friction",
    "end_stop",
)


def with_static_friction(machine):
    return {f"friction.{c}.model": "static" for c in hc.load_machine(machine).cylinder_names}


def hanging_mass(start, spool, **changes):
    """The single cylinder from piston position `start` with one spool command."""
    setting = {"joints": {"slide": start}, "commands": {"test": spool}, "duration": 1.5}
    return hc.Scenario(machine="single-cylinder", **(setting | changes))


def into_every_stop():
    """Laboratory crane: all three pistons run outwards into their end stops at full spool."""
    crane = hc.load_machine("rottne-f9-lab")
    joints = dict(zip(crane.joint_names, crane.joints_from_strokes([0.13, 0.14, 0.25]), strict=True))
    return hc.Scenario(joints=joints, commands=dict.fromkeys(crane.cylinder_names, 0.05), duration=3.0)


def bundled_with_static_friction(name, machine):
    return hc.load_scenario(name).changed(overrides=with_static_friction(machine))


RUNS = {
    "laboratory crane": lambda: hc.load_scenario("vertical-lift-open-loop"),
    "laboratory crane, static friction": lambda: bundled_with_static_friction(
        "vertical-lift-open-loop", "rottne-f9-lab"
    ),
    "laboratory crane, payload": lambda: hc.load_scenario("vertical-lift-open-loop").changed(payload=200.0),
    "laboratory crane, loads that come and go": lambda: hc.load_scenario("vertical-lift-open-loop").changed(
        payload=20.0, payload_changes={0.5: 220.0, 1.7: 60.0, 2.6: 150.0, 3.5: 0.0}
    ),
    "single cylinder, loads that come and go": lambda: hc.load_scenario("single-cylinder-step").changed(
        payload_changes={0.3: 200.0, 0.6: 0.0}
    ),
    "laboratory crane, into the stops": into_every_stop,
    "loader crane": lambda: hc.load_scenario("hiab-lift"),
    "single cylinder": lambda: hc.load_scenario("single-cylinder-step"),
    "single cylinder, static friction": lambda: bundled_with_static_friction("single-cylinder-step", "single-cylinder"),
    "single cylinder, into the stop": lambda: hanging_mass(0.1, 0.05),
    "single cylinder, into the inner stop": lambda: hanging_mass(-0.1, -0.05, duration=3.0),
    "single cylinder, cavitating": lambda: hanging_mass(-0.2, 0.0, pressures={"test": (0.0, 0.0)}, duration=0.5),
}


@pytest.fixture(scope="module", params=[(run, method) for run in RUNS for method in METHODS], ids=" - ".join)
def run(request):
    name, method = request.param
    result = hc.simulate(RUNS[name](), method=method, rtol=1e-10)
    assert result.outcome.kind == "completed", result.outcome
    return result


def stored(data):
    return sum(data[name].values for name in data if name.startswith("energy."))


def throughput(data):
    """Work of the pump and of the cylinders, J, each counted positive."""
    moved = [n for n in data if n.startswith("ledger.") and n.rsplit(".", 1)[1] in ("supply", "work")]
    steps = [np.abs(np.diff(data[name].values)).sum() for name in moved]
    return sum(steps)


@pytest.mark.evidence
def test_stored_energy_is_what_the_ledger_brought(run):
    data = run.data
    brought = sum(data[n].attrs["sign"] * data[n].values for n in data if n.startswith("ledger."))
    energy = stored(data)
    assert throughput(data) > 1.0
    assert np.abs(energy - energy[0] - brought).max() < 1e-9 * throughput(data)


def test_work_of_the_cylinders_moves_the_links(run):
    """Kinetic plus potential energy change by the work of the net cylinder forces and by loads alone."""
    data = run.data
    mechanical = data["energy.kinetic"].values + data["energy.potential"].values
    work = sum(data[n].values for n in data if n.startswith("ledger.") and n.endswith(".work"))
    loads = data["ledger.payload.load"].values - data["ledger.payload.impact"].values
    assert np.abs(mechanical - mechanical[0] - work - loads).max() < 1e-9 * throughput(data)


def test_every_loss_only_grows(run):
    """Metering edges, leakage, friction (while passive) and the damping of end stops never give anything back."""
    data, crane = run.data, run.machine
    limits = {entry["cylinder"]: entry["velocity_limit"] or np.inf for entry in crane.passivity()}
    rounding = 1e-10 * throughput(data)
    for cylinder in crane.cylinder_names:
        assert np.abs(data[f"cylinder.{cylinder}.v"]).max() < limits.get(cylinder, np.inf)
        for loss in DISSIPATED:
            assert np.diff(data[f"ledger.{cylinder}.{loss}"]).min() >= -rounding, f"{cylinder}: {loss}"


def test_supply_power_integrates_to_the_work_of_the_pump():
    """The recorded power, summed by the trapezoidal rule, against the quadrature of the method."""
    run = hc.simulate("single-cylinder-step", rtol=1e-9, record_interval=1e-4)
    power = run.data["supply.power"].values
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(run.data.time))])
    total = sum(run.data[n].values for n in run.data if n.startswith("ledger.") and n.endswith(".supply"))
    np.testing.assert_allclose(work, total, rtol=0, atol=1e-4 * total[-1])


def test_the_runs_meet_what_they_are_named_for():
    stops = hc.simulate(into_every_stop()).data
    for cylinder in ("lift", "jib", "extension"):
        assert stops[f"ledger.{cylinder}.end_stop"].values[-1] > 0.01
        assert np.abs(stops[f"cylinder.{cylinder}.v"].values[-1]) < 1e-3
    torn = hc.simulate(RUNS["single cylinder, cavitating"]()).data
    assert min(torn["cylinder.test.p1"].min(), torn["cylinder.test.p2"].min()) < -0.5e5
    static = hc.simulate(RUNS["laboratory crane, static friction"]())
    assert len(static.machine.state_names) == 18
    assert "energy.bristles" in static.data and np.abs(static.data["energy.bristles"]).max() == 0.0
