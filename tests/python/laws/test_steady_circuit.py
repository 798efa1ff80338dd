"""The circuit in steady motion and at rest, against figures by hand and against runs."""

import re
from pathlib import Path

import numpy as np
import pytest

import hydrocrane as hc

TWO = Path(__file__).parents[2] / "data" / "two-slides.toml"
LPM = 1e-3 / 60
AREAS = np.pi / 4 * np.array([0.040**2, 0.040**2 - 0.025**2])
NOMINAL = 20 * LPM / np.sqrt(8e5)
COUNTERBALANCE = {
    "counterbalance.c.cylinder": "first",
    "counterbalance.c.side": "piston-side",
    "counterbalance.c.setting": "130 bar",
    "counterbalance.c.pilot-ratio": 3,
    "counterbalance.c.opening-pressure": "40 bar",
    "counterbalance.c.nominal-flow": "4 l/min",
    "counterbalance.c.nominal-pressure-drop": "10 bar",
}

TANK_LINE = {
    "tank-line.volume": "1 l",
    "tank-line.nominal-flow": "20 l/min",
    "tank-line.nominal-pressure-drop": "20 bar",
}


def two(**overrides):
    """The two slides; `_` in a key stands for its dots."""
    return hc.load_machine(TWO, {key.replace("__", "-").replace("_", "."): value for key, value in overrides.items()})


def driven(machine, *shares, joints=(-0.28, 0.0), duration=1.6, payload=None):
    """A run with spools at shares of their stroke."""
    commands = {
        name: hc.Command([0.0, 0.1, 0.3, duration], [0.0, 0.0, 0.01 * share, 0.01 * share], "linear")
        for name, share in zip(machine.cylinder_names, shares, strict=True)
    }
    start = dict(zip(machine.joint_names, joints, strict=True))
    more = {} if payload is None else {"payload": payload}
    return hc.simulate(hc.Scenario(machine=machine, joints=start, commands=commands, duration=duration, **more))


def warned(run, kind):
    return [warning for warning in run.warnings if warning.kind == kind]


def test_by_hand_a_small_pump_sets_the_speed():
    """A pump of 8 ml at full displacement, less its leakage, at the pressure of load, friction and both edges."""
    idle, load = 8e-6 * 1500 / 60, 1000 * 9.81
    v = idle / AREAS[0]
    for _ in range(50):
        back = (AREAS[1] * v / NOMINAL) ** 2
        piston_side = (load + 20_000 * v + back * AREAS[1]) / AREAS[0]
        mains = piston_side + (AREAS[0] * v / NOMINAL) ** 2
        v = idle * (1 - 0.05 * mains / 250e5) / AREAS[0]
    found = two(pump_main_displacement="8 ml").piston_speeds([0.0, 0.0])[0, 1]
    assert found == pytest.approx(v, rel=2e-3)
    assert found == pytest.approx(0.156, abs=1e-3)


@pytest.mark.parametrize(
    ("overrides", "sense"),
    [
        ({}, 1),
        ({"pump.main.displacement": "8 ml"}, 1),
        ({"pump.main.torque-limit": "10 N m"}, 1),
        ({"pump.main.displacement": "10 ml", "pump.main.droop": 0.2, "pump.main.rated-torque": "15 N m"}, 1),
        ({"pump.main.control-range": "25 bar", "pump.main.displacement": "8 ml"}, 1),
        (TANK_LINE, 1),
        (COUNTERBALANCE, -1),
        ({}, -1),
    ],
)  # fmt: skip
def test_speeds_are_those_of_a_run_at_full_spool(overrides, sense):
    machine = hc.load_machine(TWO, overrides)
    run = driven(machine, sense, 0.0, joints=(-0.28 * sense, 0.0))
    reached = run.data["cylinder.first.v"].values[-20]
    assert machine.piston_speeds([0.0, 0.0])[0, (sense + 1) // 2] == pytest.approx(reached, rel=0.02)


def test_a_load_that_the_supply_cannot_move_stands():
    speeds = two(supply_pressure="70 bar").piston_speeds([0.0, 0.0])
    assert speeds[0, 1] == 0.0 and speeds[0, 0] < 0.0 and (speeds[1] != 0.0).all()


@pytest.mark.parametrize(
    ("overrides", "shares", "words"),
    [
        ({"pump.main.torque-limit": "15 N m"}, (0.9, 0.9), "torque limit"),
        ({"pump.main.control-range": "25 bar", "pump.main.displacement": "8 ml"}, (0.9, 0.4), "before the pump"),
        ({"pump.main.displacement": "15 ml"}, (0.9, 0.9), "full displacement"),
        ({"pump.main.displacement": "27 ml", "pump.main.droop": 0.3, "pump.main.rated-torque": "20 N m"}, (0.9, 0.9),
         "engine"),
        ({"pump.main.displacement": "15 ml", "priority.cylinder": "first", "priority.margin": "8 bar",
          "priority.range": "3 bar"}, (0.9, 0.9), "priority"),
    ],
)  # fmt: skip
def test_a_section_that_gets_less_than_its_spool_asks_for_says_so(overrides, shares, words):
    machine = hc.load_machine(TWO, overrides)
    run = driven(machine, *shares, joints=(-0.25, -0.25), duration=1.2)
    last = run.data.isel(time=-1)
    short = {c: float(last[f"cylinder.{c}.q1"]) / LPM for c in machine.cylinder_names}
    asked = dict(zip(machine.cylinder_names, 20 * np.array(shares), strict=True))
    starved = [c for c in short if short[c] < 0.9 * asked[c]]
    texts = [warning.text for warning in warned(run, "pump-saturated")]
    assert starved and len(texts) >= len(starved)
    for cylinder in starved:
        (text,) = [text for text in texts if f"`{cylinder}`" in text]
        assert f"of the {asked[cylinder]:.2f} l/min" in text or f"of the {asked[cylinder]:.1f}" in text, text
    assert any(words in text for text in texts), texts


def test_a_fixed_pump_whose_oil_leaves_over_the_relief_valve_says_so(tmp_path):
    """The load takes all but 10 of 95 bar, so half a bar below the setting of the valve is a twentieth of the flow."""
    text = TWO.read_text().replace('type = "load-sensing"', 'type = "fixed"')
    for key in ("control-range", "time-constant", "ls-time-constant"):
        text = re.sub(f'(?m)^{key} = ".*"\n', "", text)
    (tmp_path / "fixed.toml").write_text(text)
    steep = {"mains.relief-gradient": "100 l/(min bar)", "pump.main.displacement": "9 ml"}
    pressures = dict.fromkeys(("supply.pressure", "mains.relief-pressure"), "95 bar")
    run = driven(hc.load_machine(tmp_path / "fixed.toml", steep | pressures), 0.9, 0.0, joints=(-0.25, -0.25))
    (warning,) = warned(run, "pump-saturated")
    assert "`first`" in warning.text and "relief valve of the mains" in warning.text
    assert warning.cure.startswith("raise `mains.relief-pressure`")
    assert run.data["mains.relief_flow"].values[-1] > 0.0


@pytest.mark.parametrize("payload", [2000.0, 2180.0])
def test_a_load_that_takes_the_supply_pressure_says_so(payload):
    """18 l/min of oil need 272 bar under 2 t: 234 for the load, 38 for friction."""
    run = driven(two(), 0.9, 0.0, joints=(-0.25, -0.25), payload=payload)
    (warning,) = warned(run, "pump-saturated")
    assert "of the 18.00 l/min" in warning.text and "supply pressure" in warning.text
    assert warning.cure.startswith("carry less, or raise `supply.pressure`")
    higher = two(supply_pressure="320 bar", mains_relief__pressure="350 bar")
    assert not warned(driven(higher, 0.9, 0.0, joints=(-0.25, -0.25), payload=payload), "pump-saturated")


def test_a_piston_on_its_end_stop_asks_for_nothing(tmp_path):
    """Its pressure rises to that of the supply; a section that shares the flow with it gets none."""
    for machine, starved in ((two(), []), (sharing(tmp_path), ["second"])):
        run = driven(machine, 0.4, 0.5, joints=(0.27, -0.25), duration=1.2)
        assert run.data["mains.load"].values[-1] > 245e5
        texts = [warning.text for warning in warned(run, "pump-saturated")]
        assert [c for c in machine.cylinder_names if any(f"`{c}`" in text for text in texts)] == starved, texts
        assert all("supply pressure" in text for text in texts)


def sharing(folder, **overrides):
    """The two slides with compensators behind their spools."""
    text = TWO.read_text().replace(
        'compensator = "before-spool"\ncompensator-setting = "8 bar"', 'compensator = "behind-spool"'
    )
    (folder / "sharing.toml").write_text(text)
    return hc.load_machine(folder / "sharing.toml", overrides)


def test_a_pump_that_suffices_does_not_warn(tmp_path):
    for machine in (two(), sharing(tmp_path)):
        run = driven(machine, 0.5, 0.4, joints=(-0.25, -0.25), duration=1.2)
        assert not warned(run, "pump-saturated"), run.warnings


def test_shared_flow_deep_in_saturation_states_its_error_and_its_speed(tmp_path):
    machine = sharing(tmp_path, **{"pump.main.displacement": "4 ml"})
    run = driven(machine, 0.9, 0.4)
    texts = [warning.text for warning in warned(run, "pump-saturated")]
    assert any("off by up to" in text for text in texts), texts
    run = driven(machine, 1.0, 0.0)
    assert machine.piston_speeds([0.0, 0.0])[0, 1] == pytest.approx(run.data["cylinder.first.v"].values[-20], rel=0.02)


@pytest.mark.parametrize("stated", [{}, {"pump_main_rated__speed": "1500 rpm"}])
def test_the_leakage_stays_when_the_speed_changes(stated, tmp_path):
    """It belongs to the rated speed, or to that of the file; also after the machine was written to a file."""

    def leaked(machine):
        state = machine.equilibrium([0.0, 0.0])
        state[machine.state_names.index("pump.main.displacement")] = 0.0
        state[machine.state_names.index("mains.p")] = 200e5
        return float(machine.outputs(state, [0.0, 0.0])["mains.pump_flow"])

    slow = two(**stated, pump_main_speed="700 rpm")
    (tmp_path / "slow.toml").write_text(slow.to_toml())
    assert leaked(two()) < 0.0
    for machine in (slow, hc.load_machine(tmp_path / "slow.toml")):
        assert leaked(machine) == pytest.approx(leaked(two()), rel=1e-12)


def test_a_small_pump_is_reported_with_its_least_and_its_most():
    machine = two(pump_main_displacement="10 ml", pump_main_droop=0.3, **{"pump_main_rated__torque": "20 N m"})
    (text,) = [warning.text for warning in machine.warnings if "displacement" in warning.text]
    assert "15.0 l/min without a load" in text and "at 250 bar" in text and "-" not in text.split("gives")[1]


# --- at rest ----------------------------------------------------------------------------------------------------------

RELIEF = {
    "port-relief.l.cylinder": "lift",
    "port-relief.l.side": "piston-side",
    "port-relief.l.setting": "60 bar",
    "port-relief.l.nominal-flow": "20 l/min",
}


def sunk(machine, q, payload):
    start = dict(zip(machine.joint_names, q, strict=True))
    run = hc.simulate(hc.Scenario(machine=machine, joints=start, payload=payload, duration=2.0))
    return float(run.data["tip.z"].values[0] - run.data["tip.z"].values[-1]), run


def clear(chart):
    """Poses of a chart clear of the zones of the end stops."""
    low, high = chart.machine.joint_limits.T
    return ((chart.q > low + 0.1 * (high - low)) & (chart.q < high - 0.1 * (high - low))).all(axis=-1)


def test_a_load_chart_holds_when_it_is_loaded():
    machine = hc.load_machine("rottne-f9-mobile", RELIEF)
    chart, free = hc.load_chart(machine, samples=6), hc.load_chart("rottne-f9-mobile", samples=6)
    both = np.isfinite(chart.payload) & np.isfinite(free.payload)
    assert (chart.payload[both] <= free.payload[both]).all() and (chart.payload[both] < 0.9 * free.payload[both]).any()
    limited = np.argwhere((chart.payload > 100.0) & (chart.payload < 900.0) & (chart.limiting == 0) & clear(chart))
    for place in limited[:: max(len(limited) // 3, 1)]:
        q, payload = chart.q[tuple(place)], float(chart.payload[tuple(place)])
        sinks, run = sunk(machine, q, payload)
        assert not warned(run, "start-not-held")
        sinks_more, overloaded = sunk(machine, q, 1.3 * payload)
        assert warned(overloaded, "start-not-held")
        assert abs(sinks) < 0.02 and sinks_more > abs(sinks), (q, payload, sinks, sinks_more)


def test_a_start_that_is_not_held_says_what_it_needs_and_what_there_is():
    run = hc.simulate("vertical-lift-open-loop", payload=900.0, duration=0.2)
    (text,) = [warning.text for warning in warned(run, "start-not-held")]
    needed = run.data["cylinder.lift.p1"].values[0] / 1e5
    assert f"{needed:.0f} bar in the piston side of cylinder `lift`" in text and "140 bar" in text
    machine = hc.load_machine("rottne-f9-mobile", RELIEF)
    run = sunk(machine, machine.home, 400.0)[1]
    (text,) = [warning.text for warning in warned(run, "start-not-held")]
    assert "relief valve" in text and "lift" in text
    with pytest.warns(hc.result_warning.DoubtfulResult, match="relief valve"):
        machine.equilibrium(machine.home, payload=400.0)


@pytest.mark.parametrize("over", [{}, RELIEF])
def test_a_lower_back_pressure_keeps_a_relief_valve_closed(over):
    """The stated one is 10 bar, and stays where no valve would open."""
    machine = hc.load_machine("rottne-f9-mobile", over)
    chart = hc.load_chart(machine, samples=6)
    i = np.unravel_index(np.argmax((chart.limiting == 0) & (chart.payload > 50.0) & clear(chart)), chart.payload.shape)
    state, doubts = machine.rest(chart.q[i], payload=float(chart.payload[i]))
    p1, p2 = state[[machine.state_names.index(f"cylinder.lift.p{side}") for side in (1, 2)]]
    assert not doubts and p2 == pytest.approx(0.0 if over else 10e5, abs=1e3)
    assert p1 == pytest.approx(59.5e5, rel=1e-6) if over else p1 > machine.holdable_pressures[0, 0]


def test_a_chamber_at_vacuum_says_so():
    """The load lowers its piston through 20 l/min at 8 bar faster than the compensated edge fills the rod side."""
    run = driven(two(), 0.0, -1.0, joints=(0.0, 0.28), payload=600.0)
    (warning,) = [warning for warning in warned(run, "cavitation") if "`second`" in warning.text]
    assert "rod side of cylinder `second`" in warning.text and "anti-cavitation" in warning.cure
    valve = {"cylinder": "second", "side": "rod-side", "nominal-flow": "40 l/min", "nominal-pressure-drop": "0.5 bar"}
    fed = hc.load_machine(TWO, {f"anti-cavitation.a.{key}": value for key, value in valve.items()})
    run = driven(fed, 0.0, -1.0, joints=(0.0, 0.28), payload=600.0)
    assert not [warning for warning in warned(run, "cavitation") if "`second`" in warning.text]
