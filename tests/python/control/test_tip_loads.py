"""The controller `tip` under loads near and beyond what the supply pressure can lift, and near dead centres.

The bound of 5 mm is what a sample of the stick may cost before the chambers are filled: the oil gives way by some
tenths of a millimetre at the piston, which the boom makes some millimetres at the tip.
"""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

BACKWARDS = 5e-3
# The printed machine is left out: with closed valves alone its tip sinks by decimetres.
POSES = {"hiab-xs031": 24, "rottne-f9-lab": 18, "single-cylinder": 6, "rig-kalmar": 6, "rig-rottne": 6}


def way(run):
    """Displacement (m, 2) of the tip since the start, m."""
    tip = np.column_stack([run.data["tip.x"], run.data["tip.z"]])
    return tip - tip[0]


def driven(crane, q, payload, direction, speed=0.1, duration=1.5):
    """A second of stick, and the tip's way less that with closed valves."""
    common = {"machine": crane.name, "joints": dict(zip(crane.joint_names, q, strict=True))}
    common |= {"payload": payload, "duration": duration}
    stick = hc.Joystick([0.0, 1.0], {"x": [direction[0], 0.0], "z": [direction[1], 0.0]}, full_speed=speed)
    run = hc.simulate(hc.Scenario(**common, controller="tip", joystick=stick), ledger=False)
    closed = hc.simulate(hc.Scenario(**common, commands={crane.cylinder_names[0]: 0.0}), ledger=False)
    assert run.outcome.completed and closed.outcome.completed
    return run, way(run) - way(closed)


@pytest.mark.parametrize(
    ("machine", "q", "payload", "direction"),
    [
        ("hiab-xs031", (1.667, -1.515, 0.468), 52.0, (-1.0, 0.0)),
        ("hiab-xs031", (0.3, -0.3, 1.0), 0.0, (0.0, 1.0)),
        ("rottne-f9-lab", (1.745, 1.745, 0.0), 800.0, (0.0, 1.0)),
    ],
)
def test_a_load_beyond_the_supply_pressure_does_not_fall(machine, q, payload, direction) -> None:
    """With the valve opened these fell by 740, 155 and 79 mm; the other cylinders can do what is asked."""
    _, moved = driven(hc.load_machine(machine), q, payload, direction)
    assert (moved @ direction).min() > -BACKWARDS
    assert moved[-1] @ direction > 0.03


@pytest.mark.parametrize("machine", POSES)
def test_the_tip_never_moves_against_the_stick(machine, random_poses) -> None:
    """Or it says why it stands: with the cylinder that cannot lift, or what else is in the way."""
    crane, rng = hc.load_machine(machine), np.random.default_rng(3)
    for q in random_poses(crane, POSES[machine], seed=5, margin=0.08):
        payload, angle = float(rng.uniform(0.0, 300.0)) * rng.integers(2), rng.uniform(0.0, 2.0 * np.pi)
        direction = np.array([np.cos(angle), np.sin(angle)])
        if len(q) == 1:
            tangent = crane.tip_jacobian(q)[:, 0]
            direction = tangent / np.linalg.norm(tangent) * rng.choice([-1.0, 1.0])
        run, moved = driven(crane, q, payload, direction)
        assert (moved @ direction).min() > -BACKWARDS, (q, payload, direction)
        stands = float(moved[-1] @ direction) < 0.005
        assert not stands or run.events, (q, payload, direction)


def test_a_load_that_cannot_be_lifted_names_its_cylinder_and_other_ways_stay_open() -> None:
    crane = hc.load_machine("single-cylinder")
    stick = hc.Joystick([0.0, 2.0, 2.5], {"z": [1.0, 0.0, -1.0]}, full_speed=0.1)
    plan = hc.Scenario(
        machine=crane.name,
        joints=dict.fromkeys(crane.joint_names, 0.0),
        overrides={"supply.pressure": "20 bar"},
        payload=300.0,
        joystick=stick,
        duration=5.0,
    )
    run = hc.simulate(plan, ledger=False)
    moved = way(run)[:, 1]
    events = [event for event in run.events if event.time < 2.0 and not event.warning]
    assert len(events) == 1 and f"cylinder `{crane.cylinder_names[0]}` cannot lift this here" in events[0].text
    half = int(np.searchsorted(run.data.time, 2.4))
    assert abs(moved[:half]).max() < BACKWARDS
    assert moved[-1] < -0.02, "it can still be lowered"


@pytest.mark.parametrize(("payload", "told"), [(300.0, 1), (10.0, 0)])
def test_a_load_that_sinks_at_rest_is_told_once_with_its_cylinder(payload, told) -> None:
    """Leakage lets it sink where the supply pressure cannot lift it; what can be lifted is held against it."""
    crane = hc.load_machine("single-cylinder")
    (cylinder,) = crane.cylinder_names
    plan = hc.Scenario(
        machine=crane.name,
        joints=dict.fromkeys(crane.joint_names, 0.0),
        overrides={"supply.pressure": "20 bar", f"cylinder.{cylinder}.leakage-gap": "20 um"},
        payload=payload,
        joystick=hc.Joystick([0.0], {"z": [0.0]}, full_speed=0.1),
        duration=30.0,
    )
    run = hc.simulate(plan, ledger=False)
    events = [event.text for event in run.events if not event.warning]
    assert len(events) == told and all(
        f"sinks slowly: cylinder `{cylinder}` cannot hold it here" in text for text in events
    )
    assert (abs(way(run)[-1, 1]) > 5e-3) == bool(told)


@pytest.mark.parametrize("direction", [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
def test_the_tip_stops_before_a_dead_centre(direction) -> None:
    """The lift's lies at 2.073 rad, its limit at 2.039; closed valves hold up to some 1.87 here."""
    start = {"lift": 1.7, "tilt": -0.417, "extension": 0.938}
    axes = {"x": [direction[0], 0.0], "z": [direction[1], 0.0]}
    stick = hc.Joystick([0.0, 8.0], axes, full_speed=0.1)
    plan = hc.Scenario(machine="hiab-xs031", joints=start, joystick=stick, duration=16.0)
    run = hc.simulate(plan, ledger=False)
    assert run.outcome.completed and float(run.data["joint.lift.q"].max()) < 1.9
    # The boom swings on its oil at a third of a hertz with hardly any damping.
    assert float(np.ptp(way(run)[-400:], axis=0).max()) < 0.03, "it swings out where it was left"
    assert not [event for event in run.events if "sensor" in event.text or "cannot hold" in event.text]


def test_a_start_that_closed_valves_cannot_hold_is_told_with_the_joint() -> None:
    start = {"lift": 1.888, "tilt": -0.417, "extension": 0.938}
    stick = hc.Joystick([0.0, 2.0, 4.0], {"x": [1.0, -1.0, 0.0]}, full_speed=0.1)
    run = hc.simulate(hc.Scenario(machine="hiab-xs031", joints=start, joystick=stick, duration=1.0), ledger=False)
    first = run.events[0]
    assert first.time == 0.0 and "joint `lift`" in first.text and "dead centre" in first.text
