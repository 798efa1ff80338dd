"""Oil is neither made nor lost: density times volume of each chamber, against what flows through its boundary."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

TIGHT = "1e-12 m"  # leakage gap through which nothing passes: conductance goes with its cube


def annulus(bore, rod, length, dead):
    """Volumes at mid-stroke: half a stroke of piston and of ring area, plus the dead volume at both ends, m^3."""
    areas = np.pi / 4 * np.array([bore**2, bore**2 - rod**2])
    return areas, areas * length / 2 + np.asarray(dead)


PORT = np.pi / 4 * 0.01**2 * 0.02  # dead volume of the laboratory crane: port of 10 mm, 20 mm long
CHAMBERS = {
    "rottne-f9-lab": {
        "lift": annulus(0.1, 0.04, 0.33, PORT),
        "jib": annulus(0.09, 0.045, 0.345, PORT),
        "extension": annulus(0.05, 0.03, 0.63, PORT),
    },
    "hiab-xs031": {
        "lift": annulus(0.08, 0.045, 0.59, 3e-3),
        "tilt": annulus(0.08, 0.045, 0.59, 4e-3),
        "extension": annulus(0.05, 0.03, 1.1, 5e-3),
    },
    "single-cylinder": {"test": annulus(0.05, 0.03, 0.63, PORT)},
}
# Start rates of the joints that throw the crane about on its closed cylinders, down to cavitation.
KICK = {"rottne-f9-lab": [0.4, -0.5, 0.6], "hiab-xs031": [0.2, -0.2, 0.5], "single-cylinder": [0.6]}


def volumes(name, cylinder, stroke):
    """Volumes (..., 2) of both chambers at piston position `stroke`."""
    areas, middle = CHAMBERS[name][cylinder]
    return middle + areas * np.stack([stroke, -np.asarray(stroke)], axis=-1)


def pressures(crane, states, cylinder):
    columns = [crane.state_names.index(f"cylinder.{cylinder}.p{side}") for side in (1, 2)]
    return states[..., columns]


def sealed(name):
    tight = {f"cylinder.{c}.leakage-gap": TIGHT for c in CHAMBERS[name]}
    none = {f"cylinder.{c}.internal-leakage": 0.0 for c in CHAMBERS[name]}
    return hc.load_machine(name, none if name == "hiab-xs031" else tight)


@pytest.mark.parametrize("method", ["rodas5p", "tsit5"])
@pytest.mark.parametrize("name", CHAMBERS)
def test_closed_chambers_keep_their_oil(name, method):
    """Spools centred, no leakage, and the crane thrown: pressures swing, density times volume does not."""
    crane = sealed(name)
    state = crane.equilibrium(crane.home)
    state[[crane.state_names.index(f"joint.{j}.qd") for j in crane.joint_names]] = KICK[name]
    sim = hc.Simulator(crane, sample_time=0.01, method=method, rtol=1e-11)
    sim.reset(state=state)
    states = np.array([state] + [sim.step(np.zeros(len(crane.cylinder_names))) and sim.state for _ in range(60)])
    stroke = crane.strokes(states[:, [crane.state_names.index(f"joint.{j}.q") for j in crane.joint_names]])
    for i, cylinder in enumerate(crane.cylinder_names):
        p = pressures(crane, states, cylinder)
        assert np.ptp(p, axis=0).min() > 0.3e5
        mass = crane.density(p) * volumes(name, cylinder, stroke[:, i])
        np.testing.assert_allclose(mass, np.broadcast_to(mass[0], mass.shape), rtol=1e-9)


@pytest.mark.parametrize("name", CHAMBERS)
def test_pressure_rates_account_for_every_flow(name, random_states):
    """V p'/E is inflow less swept volume, at any state; leakage by the annular gap (97)-(99)."""
    crane = hc.load_machine(name)
    states, commands = random_states(crane, 400, seed=31)
    rates, outputs = crane.state_derivative(states, commands), crane.outputs(states, commands)
    for cylinder in crane.cylinder_names:
        p, p_rate = pressures(crane, states, cylinder), pressures(crane, rates, cylinder)
        areas, _ = CHAMBERS[name][cylinder]
        internal, external = leakage(name, cylinder)
        past_piston = internal * (p[:, 0] - p[:, 1])
        outside = external * p[:, 1]
        flow = {k: outputs[f"cylinder.{cylinder}.{k}"] for k in ("x", "v", "q1", "q2")}
        stored = volumes(name, cylinder, flow["x"]) * p_rate / crane.bulk_modulus(p)
        terms = [
            (stored[:, 0], flow["q1"], -past_piston, -areas[0] * flow["v"]),
            (stored[:, 1], -flow["q2"], past_piston - outside, areas[1] * flow["v"]),
        ]
        for gained, *parts in terms:
            size = np.abs(parts).sum(axis=0)
            assert (np.abs(gained - np.sum(parts, axis=0)) <= 1e-12 * size).all()


def test_oil_of_a_driven_cylinder_is_what_flowed_in():
    """Along a run with leakage the oil of each chamber changes by the integral of density times inflow."""
    run = hc.simulate("single-cylinder-step", rtol=1e-10, record_interval=1e-4, duration=1.4)
    data, crane = run.data, run.machine
    internal, external = leakage("single-cylinder", "test")
    p = np.stack([data["cylinder.test.p1"], data["cylinder.test.p2"]], axis=-1)
    past_piston = internal * (p[:, 0] - p[:, 1])
    inflow = [data["cylinder.test.q1"] - past_piston, past_piston - external * p[:, 1] - data["cylinder.test.q2"]]
    gain = crane.density(p) * np.stack(inflow, axis=-1)
    brought = np.cumsum(0.5 * (gain[1:] + gain[:-1]) * np.diff(data.time)[:, None], axis=0)
    mass = crane.density(p) * volumes("single-cylinder", "test", data["cylinder.test.x"].values)
    moved = np.abs(mass - mass[0]).max(axis=0)
    assert moved.min() > 0.01
    assert (np.abs(mass[1:] - mass[0] - brought) < 1e-5 * moved).all()


def leakage(name, cylinder):
    """(internal, external) conductance, m^3/(s Pa): the annular gap (99) of 10 um, oil of 0.04 Pa s."""
    if name == "hiab-xs031":
        return 1e-16, 0.0
    bore, rod, piston = {"lift": (0.1, 0.04, 0.1), "jib": (0.09, 0.045, 0.1)}.get(cylinder, (0.05, 0.03, 0.08))
    gap, viscosity, gland = 10e-6, 0.04, 0.01
    return tuple(
        np.pi * (d / 2 + gap) * gap**3 / (6 * viscosity * length) for d, length in ((bore, piston), (rod, gland))
    )
