"""A controller model that differs from the crane."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import hydrocrane as hc

POSE = {"boom": np.deg2rad(100), "jib": np.deg2rad(100), "extension": 0.0}
CRANE = hc.load_machine("rottne-f9-lab")
UP = hc.Joystick([0.1], {"z": [1.0]}, full_speed=0.1)


def plan(**fields):
    return hc.Scenario(**{"joints": POSE, "joystick": UP, "duration": 1.5, **fields})


def spools(run):
    return np.column_stack([run.data[f"controller.{c}"].values for c in run.cylinder_names])


def test_the_controller_model_changes_the_commands_and_not_the_crane():
    truth, wrong = hc.simulate(plan()), hc.simulate(plan(controller_model={"payload.mass": 1000.0}))
    # The measured load corrects most of what a wrong payload makes.
    assert np.abs(spools(truth) - spools(wrong)).max() > 1e-5
    assert wrong.machine.overrides == truth.machine.overrides
    assert (wrong.data["payload"].values == 0.0).all()
    assert json.loads(wrong.data.attrs["controller_model_overrides"])["payload.mass"] == 1000.0
    assert "controller_model_overrides" not in truth.data.attrs


def test_a_model_equal_to_the_crane_changes_nothing():
    weak = {"supply.pressure": 1.2e7}
    known = hc.simulate(plan(overrides=weak))
    for model in ({}, weak, hc.load_machine("rottne-f9-lab", weak)):
        np.testing.assert_array_equal(spools(hc.simulate(plan(overrides=weak, controller_model=model))), spools(known))
    unknown = hc.simulate(plan(overrides=weak, controller_model=CRANE))
    assert np.abs(spools(unknown) - spools(known)).max() > 1e-4


def test_a_period_holds_whatever_the_controller_model():
    for model in ({"payload.mass": 10.0}, CRANE):
        run = hc.simulate(plan(period=0.02, controller_model=model, duration=0.2))
        changes = np.flatnonzero(np.diff(spools(run)[:, 0]))
        assert changes.size and (np.diff(changes) % 2 == 0).all(), "commands change every second row of 10 ms"


def test_ones_own_controller_is_given_the_controller_model():
    class Curious:
        def reset(self, crane, obs):
            self.crane = crane

        def step(self, obs, command):
            return np.zeros(3)

    law = Curious()
    hc.simulate(plan(controller=law, controller_model={"payload.mass": 55.0}, duration=0.05))
    assert law.crane.payload_mass == 55.0


def test_a_scenario_file_states_the_controller_model(tmp_path):
    text = (
        '[scenario]\nname = "b"\nmachine = "rottne-f9-lab"\nduration = "0.3 s"\n[initial.joint]\nboom = "100 deg"\n'
        'jib = "100 deg"\nextension = "0 mm"\n[controller]\nname = "tip"\n'
        '[controller.model]\n"payload.mass" = "80 kg"\n'
    )
    path = Path(tmp_path / "b.toml")
    path.write_text(text, encoding="utf-8")
    loaded = hc.load_scenario(path)
    assert loaded.controller_model == {"payload.mass": "80 kg"}
    assert json.loads(hc.simulate(loaded).data.attrs["controller_model_overrides"])["payload.mass"] == "80 kg"
    path.write_text(text.replace("payload.mass", "payload.mas"), encoding="utf-8")
    with pytest.raises(hc.MachineFileError, match=r"b\.toml:12:17: \[unknown-key\].*did you mean `mass`"):
        hc.load_scenario(path)


def test_a_machine_that_cannot_be_meant_is_one_error():
    with pytest.raises(hc.InputError, match=r"boom \(rad\), jib \(rad\), extension \(m\); .* has slide \(m\)"):
        hc.simulate(plan(controller_model=hc.load_machine("single-cylinder")))
    with pytest.raises(hc.InputError, match="no controller"):
        hc.Scenario(joints=POSE, controller_model={"payload.mass": 1.0})
    with pytest.raises(hc.InputError, match="mapping"):
        plan(controller_model="rottne-f9-lab")
    with pytest.raises(hc.MachineFileError, match="payload.mas"):
        hc.simulate(plan(controller_model={"payload.mas": 1.0}))


@pytest.mark.parametrize("seed", [-1, 1.5, 2**64, True, "one"])
def test_a_seed_is_a_whole_number(seed):
    for call in (lambda: plan(seed=seed), lambda: hc.Simulator(CRANE, seed=seed)):
        with pytest.raises(hc.InputError, match="seed must be a whole number"):
            call()


def test_values_are_found_by_their_key():
    force = CRANE.value("friction.lift.coulomb")
    np.testing.assert_array_equal(force.si, [280.0, 490.0])
    assert (force.unit, force.provenance) == ("N", "assumed") and "Heinze" in force.source
    assert CRANE.value("supply.pressure").si == CRANE.supply_pressure
    changed = hc.load_machine("rottne-f9-lab", {"supply.pressure": "100 bar"}).value("supply.pressure")
    assert (changed.si, changed.unit, changed.provenance, changed.source) == (1e7, "Pa", "setting", "override")
    np.testing.assert_array_equal(CRANE.value("link.jib.centre-of-gravity").si.shape, (2,))
    assert set(CRANE.keys) == {key for key, _, _ in CRANE.provenance}
    assert all(np.isfinite(CRANE.value(key).si).all() for key in CRANE.keys)
    with pytest.raises(hc.InputError, match="did you mean `friction.lift.coulomb`"):
        CRANE.value("friction.lift.coulom")
