"""The ground from Python: a load is lowered onto it, the ledger closes, the result names what it carries."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.results.energy import energy_balance

FLOOR = -1.21
GROUND = {"ground.height": "-1.21 m", "payload.hang": "0.32 m", "payload.hang-growth": "0.044 m/kg^0.5"}


@pytest.fixture(scope="module")
def lowered():
    """300 kg are lowered by the lift cylinder until the ground carries, then the valve is closed."""
    scenario = hc.Scenario(
        machine="rottne-f9-lab",
        joints={"boom": 1.9, "jib": 1.7, "extension": 0.0},
        payload=300.0,
        commands={"lift": ([0.0, 7.0], [-0.015, 0.0])},
        duration=10.0,
    )
    return hc.simulate(scenario, overrides=GROUND)


def test_the_ground_carries_what_is_lowered_onto_it(lowered):
    data = lowered.data
    carried = float(data["tip.contact.z"][-1])
    underside = float(data["tip.z"][-1]) - 0.32 - 0.044 * np.sqrt(300)
    assert carried > 1000 and underside == pytest.approx(FLOOR - 0.001 - carried / 2e5, abs=2e-4)
    assert float(data["tip.contact.z"].min()) == 0.0 and float(data["tip.contact.z"][0]) == 0.0


def test_the_ledger_names_the_heat_of_the_contact_and_closes(lowered):
    balance = energy_balance(lowered)
    heat = float(lowered.data["ledger.ground.contact"][-1])
    assert balance.lost["contact with the ground"] == pytest.approx(heat) and heat > 10
    assert balance.residual < 1e-3 * heat
    assert not [warning for warning in lowered.warnings if warning.kind == "energy-ledger-open"]


def test_a_machine_without_ground_has_no_names_of_it():
    names = [name for name, *_ in hc.load_machine("rottne-f9-lab").core.ledger_info]
    assert not any("ground" in name for name in names)
    with_ground = [name for name, *_ in hc.load_machine("rottne-f9-lab", GROUND).core.ledger_info]
    assert [name for name in with_ground if name not in names] == ["ground.contact"]


def test_a_start_in_the_ground_is_refused_with_a_cure():
    crane = hc.load_machine("rottne-f9-lab", {**GROUND, "ground.height": "1 m"})
    with pytest.raises(hc.OutOfReachError, match="is inside the ground.*raise the tip"):
        crane.equilibrium([1.7, 1.7, 0.0])
