"""A cylinder on a pump against a model in SciPy, written from the pages of the theory."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator

import hydrocrane as hc
from hydrocrane.errors import MachineFileError

BAR, RPM = 1e5, 2 * np.pi / 60
GRAVITY, MASS = 9.81, 115.0 + 5.173
BORE, ROD, STROKE, PISTON, GLAND, GAP, PORT = 0.05, 0.03, 0.63, 0.08, 0.01, 1e-5, 0.01
AREAS = np.pi / 4 * np.array([BORE**2, BORE**2 - ROD**2])
MIDDLE = (AREAS * STROKE / 2 + np.pi / 4 * PORT**2 * 0.02).tolist()
VISCOUS, DENSITY, VISCOSITY = 3000.0, 1000.0, 0.04
DYNAMIC = (DENSITY / 2 * ((AREAS / (np.pi / 4 * PORT**2)) ** 2 - 1)).tolist()
AREAS = AREAS.tolist()
SET, EFFICIENCIES, GRADIENT, SPEED = 140 * BAR, (0.92, 0.88), 3e-3 / 60 / BAR, 1500 * RPM
COMMAND = ([0.0, 0.2, 0.3, 1.2, 1.3, 2.2, 2.3, 3.0], [0.0, 0.0, 0.03, 0.03, -0.045, -0.045, 0.0, 0.0])


class Pump(NamedTuple):
    """Displacement (m^3), volume (m^3), compliance (m^3/Pa) and relief pressure (Pa); range (Pa), time constant (s) and
    largest torque (N m) of its control; margin (Pa) and time constant (s) of its load sensing; compensator of the valve
    with its setting (Pa), and areas of the edges to the tank; droop of the engine (share per N m), pressures that the
    ports keep as they drain (Pa), points of the curve of the edge from the supply to port B, and time constant of the
    compensator (s).
    """

    displacement: float
    volume: float
    compliance: float
    relief: float
    range: float | None = None
    time_constant: float | None = None
    torque: float = np.inf
    margin: float | None = None
    line: float = 0.02
    compensator: str = "none"
    setting: float | None = None
    returns: tuple[float, float] = (1.0, 1.0)
    droop: float = 0.0
    out: tuple[float, float] | None = None
    curve: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    lag: float | None = None


# A fixed pump past its relief valve, one that swivels, one at the limit of its torque; one that senses the load, with
# the compensator before and behind the spool, that follows at once or late, and a fixed one that is unloaded.
PUMPS = {
    "fixed": Pump(2.5e-6, 0.5e-3, 0.2e-6 / BAR, SET),
    "swivelling": Pump(4e-6, 0.3e-3, 0.0, 1.15 * SET, 5 * BAR, 0.04),
    "limited": Pump(9e-6, 0.3e-3, 0.0, 1.15 * SET, 8 * BAR, 0.06, 9.0),
    "load-sensing": Pump(
        4e-6, 0.3e-3, 0.0, 1.15 * SET, 5 * BAR, 0.04, np.inf, 30 * BAR, 0.03, "before-spool", 20 * BAR, (0.5, 0.3)
    ),
    "flow-sharing": Pump(
        1.5e-6, 0.3e-3, 0.0, 1.15 * SET, 5 * BAR, 0.04, np.inf, 25 * BAR, 0.015, "behind-spool", None, (0.5, 0.3)
    ),
    "late": Pump(
        4e-6,
        0.3e-3,
        0.0,
        1.15 * SET,
        5 * BAR,
        0.04,
        np.inf,
        30 * BAR,
        0.03,
        "before-spool",
        20 * BAR,
        (0.5, 0.3),
        lag=0.03,
    ),
    "late sharing": Pump(
        1.5e-6,
        0.3e-3,
        0.0,
        1.15 * SET,
        5 * BAR,
        0.04,
        np.inf,
        25 * BAR,
        0.015,
        "behind-spool",
        None,
        (0.5, 0.3),
        lag=0.02,
    ),
    "engine": Pump(2.5e-6, 0.5e-3, 0.2e-6 / BAR, SET, droop=0.015, curve=((0, 0.2, 0.5, 1), (0, 0, 0.2, 1.2))),
    "meter-out": Pump(
        4e-6,
        0.3e-3,
        0.0,
        1.15 * SET,
        5 * BAR,
        0.04,
        np.inf,
        30 * BAR,
        0.03,
        "before-spool",
        20 * BAR,
        (0.5, 0.8),
        out=(3 * BAR, 25 * BAR),
    ),
    "unloaded": Pump(2.5e-6, 0.5e-3, 0.2e-6 / BAR, SET, margin=25 * BAR, returns=(0.5, 0.3)),
}


def machine_on(pump):
    """A mass hanging on one cylinder whose seal has viscous friction alone, on a pump."""
    of = PUMPS[pump]
    optional = {
        "control-range": of.range,
        "time-constant": of.time_constant,
        "torque-limit": of.torque if np.isfinite(of.torque) else None,
        "ls-margin": of.margin,
        "ls-time-constant": None if of.margin is None else of.line,
    }
    kind = "fixed" if of.range is None else "pressure-compensated" if of.margin is None else "load-sensing"
    stated = {
        "type": kind,
        "displacement": of.displacement,
        "speed": SPEED,
        "volumetric-efficiency": EFFICIENCIES[0],
        "hydromechanical-efficiency": EFFICIENCIES[1],
        **{key: value for key, value in optional.items() if value is not None},
    }
    mains = {
        "volume": of.volume,
        "hose-compliance": of.compliance,
        "relief-pressure": of.relief,
        "relief-gradient": GRADIENT,
    }
    valve = {"compensator": of.compensator, "return-area-ratio": list(of.returns)}
    if of.setting is not None:
        valve["compensator-setting"] = of.setting
    if of.lag is not None:
        valve["compensator-time-constant"] = of.lag
    if of.droop:
        stated |= {"droop": 10 * of.droop, "rated-torque": 10.0}
    if of.out:
        valve |= {"return-pressure": list(of.out), "return-pressure-range": 6 * BAR}
    if of.curve:
        travel, area = map(list, of.curve)
        valve |= {"metering.supply-to-b.travel": travel, "metering.supply-to-b.area": area}
    friction = {
        "model": "static",
        "coulomb": 0.0,
        "breakaway": 0.0,
        "viscous-exponent": 1,
        "viscous": f"{VISCOUS} N s/m",
    }
    tables = {"pump.main": stated, "mains": mains, "valve.test": valve, "friction.test": friction}
    return hc.load_machine(
        "single-cylinder", {f"{table}.{k}": v for table, keys in tables.items() for k, v in keys.items()}
    )


def bulk_modulus(p):
    """Without cavitation, to which this move does not come."""
    return 0.5e9 * math.log10(90 * p / (200 * BAR) + 3)


def edge(opening, drop):
    root = math.copysign(math.sqrt(abs(drop)), drop)
    if abs(drop) < 3 * BAR:
        root = drop * (3 - abs(drop) / (3 * BAR)) / (2 * math.sqrt(3 * BAR))
    return 1e-4 / (0.05 * math.sqrt(75 * BAR)) * max(opening, 0.0) * root


def rounded(x, width):
    return x if x > width else max(x + width, 0.0) ** 2 / (4 * width)


def drop(of, supply, load, port, opening=None):
    """Over the edge from the supply; with an opening that of a compensator that follows late."""
    if opening is not None:
        return opening**2 * (supply - port)
    if of.compensator == "before-spool":
        return supply - port - rounded(supply - port - of.setting, 0.2 * BAR)
    if of.compensator == "behind-spool":
        return supply - port - rounded(load - port, 0.2 * BAR)
    return supply - port


def supply_rates(of, state, drawn, signal):
    p, load, e = state[0], state[1] if of.margin is not None else 0.0, state[-1] if of.range is not None else 1.0
    full = of.displacement / (2 * np.pi) * SPEED
    slowed = max(0.0, 1 - of.droop * of.displacement / (2 * np.pi) * p * (e + 1 / EFFICIENCIES[1] - 1))

    def followed(highest):
        return highest if of.margin is None else min(highest, load + of.margin)

    opens = of.relief if of.range is not None else followed(of.relief)
    leaked, relieved = (1 - EFFICIENCIES[0]) * full * p / SET, GRADIENT * rounded(p - opens, 0.5 * BAR)
    inflow = e * full * slowed - leaked - relieved - drawn
    found = [inflow / ((of.volume + of.compliance * p) / bulk_modulus(p) + of.compliance)]
    if of.margin is not None:
        found.append((signal - load) / of.line)
    if of.range is not None:
        by_torque = of.torque / (of.displacement / (2 * np.pi) * max(p, 1e3)) - (1 / EFFICIENCIES[1] - 1)
        wanted = min(1.0, max(0.0, min((followed(SET) - p) / of.range, by_torque)))
        found.append((wanted - e) / of.time_constant)
    return found


def connection(spool):
    """Share of the fed port's pressure that the load-sensing line is given, over the first hundredth of the stroke."""
    t = min(abs(spool) / 0.5e-3, 1.0)
    return t**3 * (10 - 15 * t + 6 * t**2)


def returned(of, port, spool, p):
    """Opening of the edge from a port to the tank, m."""
    that_way = spool if port else -spool
    if of.out is None:
        return of.returns[port] * max(that_way, 0.0)
    share = (p - of.out[port]) / (6 * BAR)
    return of.returns[port] * 0.05 * connection(max(that_way, 0.0)) * (rounded(share, 0.1) - rounded(share - 1, 0.1))


def fed_to_b(of, spool):
    """Opening of the edge from the supply to port B, m."""
    return -spool if of.curve is None else 0.05 * float(CURVES[of.curve](min(max(-spool, 0.0) / 0.05, 1.0)))


CURVES = {of.curve: PchipInterpolator(*of.curve) for of in PUMPS.values() if of.curve}


def rates(t, state, pump):
    of = PUMPS[pump]
    x, v, p1, p2, spool, spool_rate = state[:6]
    opening, supply = (state[6], state[7:]) if of.lag is not None else (None, state[6:])
    p, load = supply[0], supply[1] if of.margin is not None else 0.0
    pa, pb = (pressure - dynamic * v * v for pressure, dynamic in zip((p1, p2), DYNAMIC, strict=True))
    fed = [edge(spool, drop(of, p, load, pa, opening)), edge(fed_to_b(of, spool), drop(of, p, load, pb, opening))]
    if of.compensator != "none":
        fed = [max(flow, 0.0) for flow in fed]
    q1, q2 = fed[0] - edge(returned(of, 0, spool, pa), pa), edge(returned(of, 1, spool, pb), pb) - fed[1]
    gap = np.pi * GAP**3 / (6 * VISCOSITY)
    internal, external = gap * (BORE / 2 + GAP) / PISTON * (p1 - p2), gap * (ROD / 2 + GAP) / GLAND * p2
    v1, v2 = MIDDLE[0] + AREAS[0] * x, MIDDLE[1] - AREAS[1] * x
    w = 161.2 * 2 * np.pi
    signal = max(0.0, connection(spool) * (pb if spool < 0 else pa))
    return [
        v,
        (p1 * AREAS[0] - p2 * AREAS[1] - VISCOUS * v) / MASS + GRAVITY,
        bulk_modulus(p1) / v1 * (q1 - internal - AREAS[0] * v),
        bulk_modulus(p2) / v2 * (AREAS[1] * v - q2 + internal - external),
        spool_rate,
        w**2 * (float(np.interp(t, *COMMAND)) - spool) - 2 * 0.481 * w * spool_rate,
        *opening_rate(of, p, load, signal, opening),
        *supply_rates(of, supply, fed[0] + fed[1], signal),
    ]


def opening_rate(of, supply, load, port, opening):
    """Of a compensator that follows late; the port is the one that is fed, or the tank."""
    if opening is None:
        return []
    share = drop(of, supply, load, port) / (supply - port)
    return [(math.sqrt(min(max(share, 0.0), 1.0)) - opening) / of.lag]


def column(run, name):
    return run.data[name].values


@pytest.mark.parametrize("pump", PUMPS)
def test_a_cylinder_on_a_pump_moves_as_an_independent_model_does(pump):
    scenario = hc.Scenario(
        machine=machine_on(pump),
        joints={"slide": -0.05},
        commands={"test": hc.Command(*COMMAND, "linear")},
        duration=3.0,
        record_interval=0.01,
    )
    run = hc.simulate(scenario, rtol=1e-9)
    assert run.outcome.kind == "completed"
    names = list(machine_on(pump).state_names)
    ours = np.column_stack([column(run, name) for name in names])
    theirs = solve_ivp(
        rates, (0, 3), ours[0], "LSODA", column(run, "time"), args=(pump,), rtol=1e-8, atol=1e-9, max_step=5e-3
    ).y.T
    span = np.ptp(ours, axis=0)
    for name, gap, wide in zip(names, abs(ours - theirs).max(axis=0), span, strict=True):
        assert gap < 1e-4 * wide, f"{name}: {gap} of {wide}"
    mains = ours[:, names.index("mains.p")]
    assert mains.min() < 0.9 * SET, "the pump is asked for more than it gives, or follows the load"


def test_the_pump_that_reaches_its_torque_gives_up_flow():
    """At most 9 N m reach the pump while its swivel follows: within what it lags behind."""
    run = hc.simulate(
        hc.Scenario(
            machine=machine_on("limited"),
            joints={"slide": -0.05},
            commands={"test": hc.Command([0.0, 0.1, 1.5], [0.0, 0.05, 0.05], "linear")},
            duration=1.5,
        )
    )
    late = column(run, "time") > 0.8
    torque = column(run, "mains.shaft_power")[late] / SPEED
    assert np.all(torque < 9.05)


@pytest.mark.parametrize(
    "key",
    [
        *(
            "pump.main.displacement",
            "pump.main.time-constant",
            "mains.volume",
            "mains.hose-compliance",
            "supply.pressure",
        ),
        *("pump.main.ls-margin", "pump.main.ls-time-constant", "valve.lift.compensator-setting"),
    ],
)
def test_derivatives_by_values_of_the_supply_are_those_of_differences(key):
    name = "rottne-f9-mobile" if "ls-" in key or "compensator" in key else "rottne-f9-pump"
    scenario = hc.load_scenario("vertical-lift-open-loop").changed(machine=name, duration=1.5, record_interval=0.05)
    crane = hc.load_machine(name)
    exact = hc.sensitivities(scenario, [key], rtol=1e-8)
    value = np.asarray(crane.value(key).si).item()
    share = 1e-3

    def at(factor):
        run = hc.simulate(scenario, overrides={key: value * factor}, rtol=1e-10)
        return np.column_stack([column(run, name) for name in ("tip.x", "tip.z", "mains.p")])

    difference = (at(1 + share) - at(1 - share)) / (2 * share * value)
    found = np.column_stack([np.asarray(exact.data[name]).squeeze() for name in ("tip.x", "tip.z", "mains.p")])
    assert found.shape == difference.shape
    gap = abs(found - difference).max(axis=0) / abs(difference).max(axis=0)
    assert np.all(gap < 1e-3), gap


@pytest.mark.parametrize("key", ["valve.lift.compensator-time-constant", "valve.lift.compensator-setting"])
def test_derivatives_by_values_of_a_compensator_that_follows_late_are_those_of_differences(key):
    crane = hc.load_machine("rottne-f9-mobile", {"valve.lift.compensator-time-constant": "60 ms"})
    worst = mismatch(crane, key, ("tip.z", "mains.p", "cylinder.lift.compensator"))
    assert np.all(worst < 1e-3), worst


def mismatch(crane, key, signals):
    """Largest gaps between exact derivatives of a lift and difference quotients, over the largest of these."""
    scenario = hc.load_scenario("vertical-lift-open-loop").changed(machine=crane, duration=1.0, record_interval=0.05)
    exact = hc.sensitivities(scenario, [key], rtol=1e-8)
    value = np.asarray(crane.value(key).si).item()
    share = 1e-4

    def at(factor):
        run = hc.simulate(scenario, overrides={key: value * factor}, rtol=1e-10)
        return np.column_stack([column(run, name) for name in signals])

    difference = (at(1 + share) - at(1 - share)) / (2 * share * value)
    found = np.column_stack([np.asarray(exact.data[name]).squeeze() for name in signals])
    return abs(found - difference).max(axis=0) / abs(difference).max(axis=0)


@pytest.mark.parametrize("pump", ["main", "aside"])
def test_derivatives_by_the_margin_of_each_pump_are_those_of_differences(pump):
    beside = {
        "type": "load-sensing",
        "displacement": "4 ml",
        "speed": "1450 rpm",
        "volumetric-efficiency": 0.9,
        "hydromechanical-efficiency": 0.9,
        "ls-margin": "27 bar",
    }
    crane = hc.load_machine(
        "rottne-f9-mobile",
        {"pump.main.displacement": "3 ml", **{f"pump.aside.{key}": value for key, value in beside.items()}},
    )
    signals = ("tip.z", "mains.p", "pump.main.displacement", "pump.aside.displacement")
    worst = mismatch(crane, f"pump.{pump}.ls-margin", signals)
    assert np.all(worst < 1e-3), worst


@pytest.mark.parametrize("name", ["rottne-f9-pump", "rottne-f9-mobile"])
def test_a_batch_of_cranes_with_pumps_is_the_simulator_with_a_leading_axis(name):
    crane = hc.load_machine(name)
    batch, alone = hc.BatchSimulator(crane, 3), hc.Simulator(crane, rtol=1e-8)
    pose = np.array([1.7, 1.7, 0.0])
    batch.reset(q=pose), alone.reset(q=pose)
    for _ in range(60):
        many, one = batch.step(np.full((3, 3), 0.03)), alone.step(np.full(3, 0.03))
    np.testing.assert_allclose(many.tip[1], one.tip, atol=1e-3)
    at = list(crane.state_names).index("mains.p")
    assert batch.state[1, at] == pytest.approx(alone.state[at], rel=1e-2)
    assert alone.state[at] < 0.9 * crane.supply_pressure


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"pump.main.type": "fixed"}, ("control-range", "none")),
        ({"mains.relief-pressure": "120 bar"}, ("relief-pressure", "reduces its displacement")),
        ({"pump.main.volumetric-efficiency": 1.2}, ("volumetric-efficiency", "exceeds 1")),
        ({"pump.main.displacement": "6.3 mm"}, ("displacement", "volume")),
        ({"pump.second.type": "fixed"}, ("pump", "second")),
        ({"valve.extension.load-check": "yes"}, ("load-check", "regenerative")),
        ({"pump.main.control-range": "150 bar"}, ("control-range", "below")),
        ({"pump.main.typ": "fixed"}, ("typ", "type")),
        ({"pump.main.type": "load-sensing"}, ("ls-margin", "load pressure")),
        ({"pump.main.ls-time-constant": "10 ms"}, ("ls-time-constant", "load-sensing")),
        ({"valve.lift.compensator": "before-spool"}, ("compensator-setting", "drop")),
        ({"valve.lift.compensator-setting": "8 bar"}, ("compensator-setting", "before-spool")),
        ({"valve.lift.compensator-time-constant": "20 ms"}, ("compensator-time-constant", "no compensator")),
        ({"valve.lift.compensator": "behind-spool"}, ("lift", "no pump senses the load")),
        ({"valve.extension.compensator": "behind-spool"}, ("compensator", "regenerative")),
        ({"valve.extension.return-area-ratio": [0.5, 1]}, ("return-area-ratio", "regenerative")),
        ({"valve.lift.return-area-ratio": [0.5, -1]}, ("return-area-ratio", "greater than zero")),
        ({"valve.lift.compensator": "behind"}, ("compensator", "behind-spool")),
    ],
)
def test_what_a_supply_cannot_be_is_said(changes, words):
    with pytest.raises(MachineFileError) as error:
        hc.load_machine("rottne-f9-pump", changes)
    assert all(word in str(error.value) for word in words), str(error.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            '[pump.main]\ntype = "fixed"\ndisplacement = "5 ml"\nspeed = "1500 rpm"\nvolumetric-efficiency = 0.9\n'
            "hydromechanical-efficiency = 0.9\n",
            ("mains", "volume"),
        ),
        ('[mains]\nvolume = "1 l"\n', ("mains", "pump")),
        ('[pump.main]\ntype = "constant-pressure"\ndisplacement = "5 ml"\n', ("displacement", "constant-pressure")),
    ],
)
def test_half_a_supply_is_refused_with_what_is_missing(tmp_path, text, words):
    path = tmp_path / "crane.toml"
    path.write_text(f'extends = "rottne-f9-lab"\n[machine]\nclass = "assumed"\n{text}', encoding="utf-8")
    with pytest.raises(MachineFileError) as error:
        hc.load_machine(path)
    assert all(word in str(error.value) for word in words), str(error.value)


def test_a_pump_that_one_valve_exceeds_is_told():
    small = hc.load_machine("rottne-f9-pump", {"pump.main.displacement": "3 ml"})
    (warning,) = [warning for warning in small.warnings if "displacement" in warning.text]
    # 3 ml at 1450 rpm and 94 %; 6 l/min at 75 bar per edge are 5.8 l/min where 140 bar fall over both.
    assert "4.1 l/min" in warning.text and "5.8 l/min" in warning.text
    assert not hc.load_machine("rottne-f9-pump").warnings


def test_a_constant_pressure_pump_is_no_pump(tmp_path):
    path = tmp_path / "crane.toml"
    path.write_text('extends = "rottne-f9-lab"\n[pump.main]\ntype = "constant-pressure"\n', encoding="utf-8")
    names = hc.load_machine(path).state_names
    assert names == hc.load_machine("rottne-f9-lab").state_names
