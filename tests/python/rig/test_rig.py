"""The virtual friction rig: it moves as commanded, LuGre shows what the thesis saw, and two solvers agree on it."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
from oracles.rig import STATES, Rig

import hydrocrane as hc
from hydrocrane import rig

ROOT = Path(__file__).resolve().parents[3]
RIGS = ("rig-rottne", "rig-kalmar")
LOADS = (0.0, 20.0, 115.0)


def settled(log, segment, share=0.7):
    """The truth of the last part of a segment, without its edge."""
    samples = log.part(segment, truth=True)
    count = samples.sizes["time"]
    return samples.isel(time=slice(int(share * count), count - 2))


# --- what the rig can do --------------------------------------------------------------------------------------------


SUPPLIES = [("rig-rottne", "140 bar"), ("rig-rottne", "100 bar"), ("rig-rottne", "40 bar"), ("rig-kalmar", "40 bar")]


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize(("name", "supply"), SUPPLIES)
def test_a_tenth_of_a_metre_per_second_both_ways_at_every_load_and_supply(name, supply, load):
    log = rig.run("constant-velocity", name, payload=load, supply=supply, levels=[0.1], sensors="ideal")
    assert log.run.outcome.completed
    assert [segment.velocity for segment in log.segments] == [0.1, -0.1]
    for segment in log.segments:
        assert settled(log, segment).v.values == pytest.approx(segment.velocity, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "load"), [("rig-rottne", m) for m in LOADS] + [("rig-kalmar", 0.0), ("rig-kalmar", 20.0)]
)
def test_every_level_is_reached_and_the_bristles_settle_on_it(name, load):
    """Ten levels in each direction, from 0.1 mm/s: velocity as aimed at, friction that of the static map."""
    log = rig.run("constant-velocity", name, payload=load, sensors="ideal")
    crane, levels = log.run.machine, log.segments
    assert len(levels) == 20 and min(abs(s.velocity) for s in levels) == pytest.approx(1e-4)
    for segment in levels:
        end = settled(log, segment)
        v = end.v.values
        assert v.mean() == pytest.approx(segment.velocity, rel=5e-3), segment.name
        assert v.std() < 1e-3 * abs(v.mean()), segment.name
        assert end.friction.values == pytest.approx(crane.friction_map(v), abs=3.0), segment.name


def test_the_kalmar_cylinder_chatters_under_115_kg_where_its_file_says_so():
    log = rig.run(
        "constant-velocity", "rig-kalmar", payload=115.0, sensors="ideal", levels=[0.005, 0.0135, 0.05], seconds=4
    )
    wobble = {s.velocity: settled(log, s).v.values.std() / abs(s.velocity) for s in log.segments if s.velocity > 0}
    assert wobble[0.0135] > 0.1 and wobble[0.005] < 1e-3 and wobble[0.05] < 1e-3


def test_slow_motion_is_found_where_leakage_takes_most_of_the_flow():
    base = hc.load_machine("rig-kalmar")
    gap = 1.2 * float(base.value("cylinder.test.leakage-gap").si)
    crane = hc.load_machine("rig-kalmar", {"cylinder.test.leakage-gap": gap, "friction.test.breakaway": [450.0, 450.0]})
    spools = [rig.steady_motion(crane, v, payload=0.0).spool for v in (-4e-5, -5e-5, -6e-5, -7e-5)]
    # Slower needs less opening, and what is found lies on one smooth curve.
    assert np.all(np.diff(spools) < 0) and np.all(np.array(spools) < 0)
    assert np.abs(np.diff(spools, 2)).max() < 0.05 * abs(spools[1])


def test_steady_motion_balances_forces_and_flows():
    crane = hc.load_machine("rig-rottne")
    a1, a2 = crane.piston_areas[0]
    for velocity in (-0.1, -1e-4, 2e-4, 0.03):
        steady = rig.steady_motion(crane, velocity, payload=20.0)
        weight = 9.81 * (5.173 + 20.0)
        assert steady.p1 * a1 - steady.p2 * a2 + weight == pytest.approx(steady.friction, abs=1e-3)
        state = crane.pack_state([0.0], [velocity], [[steady.p1, steady.p2]])
        state[crane.state_names.index("cylinder.test.xs")] = steady.spool
        rates = crane.state_derivative(state, [steady.spool], payload=20.0)
        assert np.abs(rates[2:4]).max() < 1.0


# --- what LuGre shows -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", RIGS)
def test_break_away_force_falls_with_the_rate_of_the_force(name):
    """Figure 54, in both directions: every faster ramp breaks away at less."""
    log = rig.run("break-away", name, sensors="ideal")
    for direction in (1, -1):
        found = []
        for segment in log.segments:
            if np.sign(segment.velocity) == direction:
                piece = log.part(segment, truth=True)
                force, time = direction * piece.friction.values, piece.time.values
                peak = force.argmax()
                low, high = (np.flatnonzero(force[: peak + 1] < share * force[peak])[-1] for share in (0.5, 0.8))
                found.append(((force[high] - force[low]) / (time[high] - time[low]), force[peak]))
        rates, peaks = np.array(found).T
        assert (np.diff(rates) > 0).all() and rates[-1] > 10 * rates[0]
        assert (np.diff(peaks) < -5.0).all(), peaks
        most = abs(log.run.machine.friction_map(direction * 1e-9))
        assert 0.95 * most < peaks[0] < most


@pytest.mark.parametrize("name", RIGS)
def test_the_loop_of_frictional_lag_widens_with_frequency(name):
    """Figure 55: more friction while the velocity grows, and the more so the faster it swings."""
    log = rig.run("frictional-lag", name, sensors="ideal")
    areas = []
    for segment in log.segments:
        second = slice(0.5 * (segment.start + segment.end), segment.end)
        piece = log.truth.sel(time=second)
        v, force = piece.v.values, piece.friction.values
        assert v.min() > 0
        # Going round as velocity grows above and falls below: the enclosed area is positive.
        areas.append(-0.5 * np.sum(v * np.roll(force, -1) - np.roll(v, -1) * force))
    assert areas[0] > 0 and (np.diff(areas) > 0.1 * areas[0]).all(), areas


def test_a_slow_ramp_shows_sticking_shearing_and_slipping():
    """Figures 57, 58: friction rises with the way, about as the bristles' stiffness, and falls once they slip."""
    log = rig.run("ramp", sensors="ideal")
    piece = log.part(log.segments[0], truth=True)
    x, force = piece.x.values - piece.x.values[0], piece.friction.values
    early = (force > 5) & (force < 100) & (x < 2e-3)
    slope = np.polyfit(x[early], force[early], 1)[0]
    assert slope == pytest.approx(1.1e5, rel=0.2)
    peak = force.argmax()
    assert 300 < force[peak] < 340 and force[-10] < force[peak] - 70
    assert piece.z.values[-10] < piece.z.values[peak]


def test_load_and_pressure_do_not_change_friction():
    """Figures 74, 75: what the thesis found of its cylinders is what the model assumes."""
    for name in ("load-variation", "pressure-variation"):
        logs = rig.series(name, sensors="ideal")
        assert len(logs) == {"load-variation": 3, "pressure-variation": 2}[name]
        assert len({(log.data.attrs["payload"], log.data.attrs["supply"]) for log in logs}) == len(logs)
        for pieces in zip(*(log.segments for log in logs), strict=True):
            forces = [settled(log, s).friction.values.mean() for log, s in zip(logs, pieces, strict=True)]
            assert np.ptp(forces) < 3.0


def test_friction_follows_from_pressures_and_load_as_in_equation_118():
    log = rig.run("small-sine", payload=20.0, sensors="ideal")
    a1, a2 = log.run.machine.piston_areas[0]
    data = log.data
    mass = 5.173 + 20.0
    friction = data.p1 * a1 - data.p2 * a2 + mass * 9.81 - mass * data.x.differentiate("time").differentiate("time")
    inside = slice(5, -5)
    error = (friction - log.truth.friction).values[inside]
    # Kinks of the command swing the spool faster than differences over the log's interval can follow.
    assert np.sqrt((error**2).mean()) < 1.0
    cell = (data.p1 * a1 - data.p2 * a2 - data.force - log.truth.friction).values
    assert np.abs(cell).max() < 1e-6


# --- against another solver -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("experiment", "options", "load"),
    [("ramp", {"speed": 1.0, "last": 2.0}, 0.0), ("small-sine", {"cycles": 2}, 115.0)],
)
def test_an_independent_model_and_solver_agree(experiment, options, load):
    """SciPy's LSODA at 1e-10 on equations written out anew.

    Within 0.5 Pa and a nanometre at rtol 1e-9, and within 100 Pa and 0.1 um with the rig's own tolerance.
    """
    plan = rig.scenario("rig-rottne", experiment, payload=load, interval=0.01, **options)
    command, crane = plan.commands["test"], plan.load_machine()
    assert crane.state_names == STATES
    grid = plan.record_times()
    expected = Rig(load).integrate(plan.initial_state(crane), command.time, command.spool, grid)
    for rtol, pressure, length in ((1e-9, 0.5, 1e-9), (plan.solver.rtol, 100.0, 1e-7)):
        data = hc.simulate(plan, rtol=rtol, ledger=False).data
        for i, name in enumerate(STATES):
            bound = {"p1": pressure, "p2": pressure, "qd": 100 * length, "vs": 100 * length}.get(name[-2:], length)
            assert np.abs(data[name].values - expected[:, i]).max() < bound, name


def test_bundled_scenarios_are_the_experiments():
    written = runpy.run_path(str(ROOT / "docs/reference/rig_scenarios.py"))
    assert {name.removeprefix("rig-") for name in written["SCENARIOS"]} > set(rig.experiments())
    for name in written["SCENARIOS"]:
        assert (ROOT / f"scenarios/{name}.toml").read_text(encoding="utf-8") == written["text"](name), name
        assert name in hc.bundled_scenarios()
    run, log = hc.simulate("rig-ramp", ledger=False), rig.run("ramp")
    assert np.abs(run.data["cylinder.test.friction"].values - log.truth.friction.values).max() < 0.1


# --- bristle damping and the tables ---------------------------------------------------------------------------------

RULE = {"rig-rottne": (1.1e5, 5.173, 160.0, 0.5), "rig-kalmar": (1.1e6, 1.776, 80.0, 0.1)}


def bristle(damping, velocity=1e6):
    """Overrides of a bristle damping; a velocity of 1000 km/s leaves it constant."""
    return {"friction.test.bristle-damping": damping, "friction.test.bristle-damping-velocity": velocity}


@pytest.mark.parametrize("name", RIGS)
def test_the_files_hold_what_the_rule_of_bristle_damping_gives(name):
    stiffness, mass, coulomb, ratio = RULE[name]
    found = rig.bristle_damping(stiffness, mass, coulomb, damping_ratio=ratio)
    crane, ruled = hc.load_machine(name), hc.load_machine(name, bristle(found.damping, found.velocity))
    at = crane.equilibrium([0.0])
    at[crane.state_names.index("joint.slide.qd")] = 0.03
    forces = [float(c.outputs(at, [0.0])["cylinder.test.friction"]) for c in (crane, ruled)]
    assert forces[0] == pytest.approx(forces[1], rel=1e-3)
    assert all(entry["holds"] for entry in crane.passivity())


def test_the_rule_bounds_what_friction_may_give_back():
    for fading in (True, False):
        for stiffness, mass, coulomb in ((1.1e5, 5.173, 160.0), (1.1e6, 60.0, 80.0)):
            found = rig.bristle_damping(stiffness, mass, coulomb, margin=2.0, fading=fading)
            v = np.linspace(0, 1.0 if fading else 0.1, 5000)
            sigma = found.damping * np.exp(-((v / found.velocity) ** 2)) if fading else found.damping
            assert (sigma * v).max() <= 2.0 * coulomb * (1 + 1e-9)


@pytest.mark.parametrize(("name", "printed"), [("rig-rottne", 1.54e4), ("rig-kalmar", 1.74e5)])
def test_table_5_cannot_be_used_with_either_sign(name, printed):
    """As printed the bristles drive the piston, and no file takes it; turned, they give energy back at speed."""
    with pytest.raises(hc.MachineFileError, match="bristle-damping"):
        hc.load_machine(name, bristle(-printed))
    entry = hc.load_machine(name, bristle(printed)).passivity()[0]
    assert not entry["holds"] and entry["velocity_limit"] < 0.1
    row = rig.TABLE_3[name, 0]
    # The condition on sigma_1 at a small velocity, where g is the break-away force: negative damping fails at once.
    v, g = 1e-4, row.alpha_0[0] + row.alpha_1[0]
    viscous = row.alpha_2[0] * (v**0.5 if name == "rig-rottne" else 1.0)
    assert 4 * g * (-printed + viscous) < 0 < 4 * g * (printed + viscous) - printed**2 * v


def test_constant_damping_is_passive_as_far_as_it_was_bounded():
    found = rig.bristle_damping(1.1e6, 60.0, 80.0, margin=1.0, fading=False)
    entry = hc.load_machine("rig-kalmar", bristle(found.damping)).passivity()[0]
    assert found.velocity is None and (entry["holds"] or entry["velocity_limit"] > 0.1)
    more = hc.load_machine("rig-kalmar", bristle(4 * found.damping)).passivity()[0]
    assert not more["holds"]


@pytest.mark.parametrize("name", RIGS)
def test_rows_of_table_3_are_in_the_files_and_can_be_put_in(name):
    v = np.array([1e-9, 3e-3, 0.1])
    for load in (0, 115):
        row = rig.TABLE_3[name, load]
        crane = hc.load_machine(name, rig.loaded_friction(name, load) if load else {})
        exponent = 1.5 if name == "rig-rottne" else 1.0
        for side, sign in enumerate((1, -1)):
            stribeck = row.alpha_1[side] * np.exp(-((v / row.v_sigma[side]) ** 2))
            expected = row.alpha_0[side] + stribeck + row.alpha_2[side] * v**exponent
            assert crane.friction_map(sign * v) * sign == pytest.approx(expected, rel=1e-6)
