"""Runs in phases: controller, sticks and values of the machine change on the way."""

from __future__ import annotations

import json

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.errors import InputError

START = {"boom": np.deg2rad(100), "jib": np.deg2rad(100), "extension": 0.2}
UP = hc.Joystick([0.1], {"z": [1.0]}, full_speed=0.1, ramp=0.1)
LEVERS = hc.Joystick([0.0], {"lift": [0.2]}, mode="lever")


def plan(**more):
    return hc.Scenario(joints=START, joystick=UP, duration=3.0, solver=hc.Solver("hc-rosenbrock-3", step=1e-3), **more)


@pytest.fixture(scope="module")
def switched():
    phases = [
        hc.Phase(1.0, joystick=LEVERS),
        hc.Phase(2.0, {"supply.pressure": "100 bar"}, controller="tip", joystick=UP),
    ]
    return hc.simulate(plan(phases=phases, payload_changes={1.5: 30.0}))


def test_up_to_the_first_phase_nothing_differs(switched):
    whole = hc.simulate(plan())
    early = whole.data.time.values <= 1.0
    for name in ("tip.x", "tip.z", "cylinder.lift.p1", "stick.z", "ledger.lift.supply"):
        np.testing.assert_array_equal(switched.data[name].values[early], whole.data[name].values[early])
    assert np.abs(switched.data["tip.z"] - whole.data["tip.z"]).max() > 1e-3


def test_a_phase_goes_on_from_the_state_at_hand(switched):
    data, step = switched.data, 0.01
    for name in ("joint.boom.q", "joint.boom.qd", "cylinder.lift.xs", "tip.z", "ledger.lift.supply"):
        values = data[name].values
        largest = np.abs(np.diff(values)).max()
        for begin in (1.0, 2.0):
            at = round(begin / step)
            assert abs(values[at + 1] - values[at]) <= largest, name
    # What sticks there are depends on the phase.
    time = data.time.values
    levers = (time > 1.0) & (time <= 2.0)
    assert np.isnan(data["stick.lift"].values[~levers]).all() and (data["stick.lift"].values[levers] == 0.2).all()
    assert np.isnan(data["set_point.z"].values[levers]).all() and np.isfinite(data["set_point.z"].values[~levers]).all()
    assert data["payload"].values[-1] == 30.0


def test_values_change_with_the_phase(switched):
    data, time = switched.data, switched.data.time.values
    flow, power = data["supply.flow"].values, data["supply.power"].values
    pumping = flow > 1e-6
    pressure = power[pumping] / flow[pumping]
    early = time[pumping] <= 2.0
    assert pressure[early] == pytest.approx(140e5) and pressure[~early] == pytest.approx(100e5)
    assert json.loads(data.attrs["phases"])[1][:2] == [2.0, "tip"]
    assert "from 1 s on: controller lever" in switched.summary()


def test_the_energy_account_stays_closed(switched):
    """Nothing is lost or made where phases meet; weaker supply takes no energy from what the crane holds."""
    data = switched.data
    signed = sum(data[n].values * data[n].attrs["sign"] for n in data if str(n).startswith("ledger."))
    stored = sum(data[n].values for n in data if str(n).startswith("energy."))
    drift = (signed - (stored - stored[0])) / np.abs(data["ledger.lift.supply"].values[-1])
    assert np.abs(drift).max() < 2e-3


def test_a_run_can_be_cut_where_the_same_goes_on():
    """Levers have no memory, so that a phase that changes nothing leads to the same place, also between two samples."""
    driven = hc.Scenario(joints=START, joystick=LEVERS, duration=3.0, solver=hc.Solver("hc-rosenbrock-3", step=1e-3))
    whole = hc.simulate(driven)
    cut = hc.simulate(driven.changed(phases=[hc.Phase(1.0, controller="lever"), hc.Phase(1.505, controller="lever")]))
    assert float(np.ptp(whole.data["tip.z"].values)) > 0.1
    assert float(np.abs(cut.data["tip.z"] - whole.data["tip.z"]).max()) < 1e-7


def test_phases_of_a_file_are_those_of_python(tmp_path, switched):
    path = tmp_path / "phases.toml"
    path.write_text(
        """
[scenario]
name = "phases"
machine = "rottne-f9-lab"
duration = "3 s"
[initial.joint]
boom = "100 deg"
jib = "100 deg"
extension = "0.2 m"
[payload]
time = ["1.5 s"]
mass = ["30 kg"]
[joystick]
time = ["0.1 s"]
z = [1]
full-speed = "0.1 m/s"
ramp = "0.1 s"
[phase.back]
time = "2 s"
overrides."supply.pressure" = "100 bar"
controller.name = "tip"
joystick = { time = ["0.1 s"], z = [1], full-speed = "0.1 m/s", ramp = "0.1 s" }
[phase.levers]
time = "1 s"
joystick = { mode = "lever", time = ["0 s"], lift = [0.2] }
[solver]
method = "hc-rosenbrock-3"
step = "1 ms"
""",
        encoding="utf-8",
    )
    run = hc.simulate(path)
    assert np.abs(run.data["tip.z"] - switched.data["tip.z"]).max() < 1e-9


def test_the_monitor_of_a_file_reaches_the_run(tmp_path):
    path = tmp_path / "off.toml"
    head = '[scenario]\nname = "off"\nmachine = "rottne-f9-lab"\nduration = "1 s"\n'
    path.write_text(head + '[controller]\nname = "tip"\nmonitor = "off"\n', encoding="utf-8")
    assert hc.load_scenario(path).monitored is False


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: hc.Phase(0.0), "greater than zero"),
        (lambda: hc.Phase(1.0, delay=0.01), "belongs to its controller"),
        (lambda: hc.Phase(1.0, joystick="up"), "must be a Joystick"),
        (lambda: plan(phases=[hc.Phase(1.0), hc.Phase(1.0)]), "two phases begin at 1 s"),
        (lambda: plan(phases=[1.0]), "list of Phase"),
        (lambda: hc.Scenario(joints=START, phases=[hc.Phase(1.0)]), "give a controller or a joystick"),
    ],
)
def test_wrong_phases_are_one_clear_error(make, match):
    with pytest.raises(InputError, match=match):
        make()


def test_a_phase_cannot_change_what_states_there_are():
    """LuGre friction has a state, the static map has none."""
    run = hc.simulate(plan(phases=[hc.Phase(1.0, {"friction.lift.model": "static"})]))
    assert run.outcome.kind == "bad-state" and "other states (cylinder.lift" in run.outcome.message, run.outcome
