"""States at rest: forces in balance, no friction, and in steady mode pressures that stay."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

BACK_PRESSURE = {"rottne-f9-lab": 10e5, "hiab-xs031": 20e5, "single-cylinder": 10e5}


def part(crane, states, kind):
    """Columns of all states of one kind, for example ``qd`` or ``p1``."""
    return states[..., [i for i, name in enumerate(crane.state_names) if name.endswith(f".{kind}")]]


@pytest.fixture(params=[0.0, 150.0], ids=["empty", "150 kg"])
def payload(request):
    return request.param


def steady_states(crane, poses, payload):
    """Steady states of all poses but those refused, which must be ones that the supply pressure can hardly carry."""
    found = []
    for pose in poses:
        try:
            found.append(crane.equilibrium(pose, "steady", payload=payload))
        except hc.OutOfReachError:
            share = crane.static_cylinder_force(pose, payload=payload) / crane.supply_pressure
            assert (share > 0.8 * crane.piston_areas[:, 0]).any() or (share < -0.8 * crane.piston_areas[:, 1]).any()
    assert len(found) > 0.5 * len(poses)
    return np.array(found)


@pytest.mark.parametrize("mode", ["hold", "steady"])
def test_nothing_accelerates(corrected, random_poses, mode, payload):
    if mode == "hold":
        poses = random_poses(corrected, 60, seed=51)
        rest, doubts = corrected.rest(poses, payload=payload)
        doubts = [doubt for doubt in doubts if doubt.kind == "start-rests-on-stop"]
        # What the supply cannot press into an end stop rests on it, and says so.
        moved = part(corrected, rest, "q") != poses
        assert np.count_nonzero(moved) == len(doubts) and moved.any(axis=-1).mean() < 0.5
    else:
        rest = steady_states(corrected, random_poses(corrected, 60, seed=51, margin=0.2), payload)
    for kind in ("qd", "vs", "z"):
        assert (part(corrected, rest, kind) == 0.0).all()
    spools = part(corrected, rest, "xs")
    rates = corrected.state_derivative(rest, spools, payload=payload)
    assert np.abs(part(corrected, rates, "qd")).max() < 1e-9
    for kind in ("q", "xs", "vs", "z"):
        assert (part(corrected, rates, kind) == 0.0).all()
    outputs = corrected.outputs(rest, spools, payload=payload)
    for i, cylinder in enumerate(corrected.cylinder_names):
        assert (outputs[f"cylinder.{cylinder}.friction"] == 0.0).all()
        needed = corrected.static_cylinder_force(part(corrected, rest, "q"), payload=payload)[:, i]
        np.testing.assert_allclose(outputs[f"cylinder.{cylinder}.force"], needed, rtol=1e-9, atol=1e-6)


def test_the_chamber_that_carries_less_is_at_the_back_pressure(corrected, random_poses, payload):
    rest, _ = corrected.rest(random_poses(corrected, 60, seed=52), payload=payload)
    p1, p2 = part(corrected, rest, "p1"), part(corrected, rest, "p2")
    np.testing.assert_array_equal(np.minimum(p1, p2), BACK_PRESSURE[corrected.name])
    assert (part(corrected, rest, "xs") == 0.0).all()


def test_pressures_balance_the_static_force_away_from_the_stops(corrected, random_poses):
    """p1 A1 - p2 A2 = static force."""
    poses = random_poses(corrected, 60, seed=53, margin=0.2)
    rest = corrected.equilibrium(poses)
    areas = corrected.piston_areas
    carried = part(corrected, rest, "p1") * areas[:, 0] - part(corrected, rest, "p2") * areas[:, 1]
    np.testing.assert_allclose(carried, corrected.static_cylinder_force(poses), rtol=1e-9, atol=1e-6)


def test_steady_pressures_stay_or_the_pose_is_refused(corrected, random_poses):
    """The spools let in what leaks: no pressure changes by more than a millionth of its rate with the spool centred.

    A load that the supply pressure cannot carry has no steady state, which is an error and never another state.
    """
    steady = steady_states(corrected, random_poses(corrected, 100, seed=54, margin=0.2), None)
    spools = part(corrected, steady, "xs")
    rates = corrected.state_derivative(steady, spools)
    centred = steady.copy()
    centred[:, [i for i, name in enumerate(corrected.state_names) if name.endswith(".xs")]] = 0.0
    leaking = corrected.state_derivative(centred, np.zeros_like(spools))
    for kind in ("p1", "p2"):
        reference = np.abs(part(corrected, leaking, kind)).max(axis=0)
        assert (reference > 0.0).all()
        assert (np.abs(part(corrected, rates, kind)) < 1e-6 * reference).all()


def test_a_crane_at_rest_stays_at_rest():
    """Two seconds in the steady state, spools held where they are: the tip does not move."""
    crane = hc.load_machine("rottne-f9-lab")
    rest = crane.equilibrium(crane.home, "steady")
    sim = hc.Simulator(crane, sample_time=0.1, rtol=1e-8)
    start = sim.reset(state=rest)
    for _ in range(20):
        seen = sim.step(part(crane, rest, "xs"))
    np.testing.assert_allclose(seen.tip, start.tip, rtol=0, atol=1e-9)
    np.testing.assert_allclose(seen.p, start.p, rtol=1e-6)


def test_a_load_beyond_the_supply_pressure_has_no_steady_state():
    """Loader crane with 5 t at the tip: the lift cylinder would need more than its 190 bar."""
    crane = hc.load_machine("hiab-xs031")
    with pytest.raises(hc.OutOfReachError, match="cylinder `lift`"):
        crane.equilibrium(crane.home, "steady", payload=5000.0)


@pytest.mark.parametrize("payload", [0.0, 200.0])
@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("rottne-f9-ls", {}),
        ("rottne-f9-ls", {"valve.lift.compensator-time-constant": "20 ms"}),
        ("rottne-f9-mobile", {"tank-line.volume": "1 l", "tank-line.nominal-flow": "20 l/min",
                              "tank-line.nominal-pressure-drop": "20 bar"}),
    ],
)  # fmt: skip
def test_a_load_sensing_circuit_feeds_its_leakage(name, overrides, payload):
    """The section of the highest load signals it, and the pump keeps its margin above: nothing changes."""
    crane = hc.load_machine(name, overrides)
    rest = crane.equilibrium(crane.home, "steady", payload=payload)
    rates = dict(zip(crane.state_names, crane.state_derivative(rest, part(crane, rest, "xs"), payload=payload)))
    assert max(map(abs, rates.values())) < 1.0, rates
    at = dict(zip(crane.state_names, rest, strict=True))
    loads = [max(at[f"cylinder.{c}.p1"], at[f"cylinder.{c}.p2"]) for c in crane.cylinder_names]
    assert at["mains.load"] == pytest.approx(max(loads), rel=1e-3) and at["mains.p"] > at["mains.load"] + 10e5
