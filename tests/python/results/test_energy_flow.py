"""Where the energy of a run came from and went to adds up, with every term of the ledger, with and without a pump."""

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.results.energy import energy_balance, energy_flow

MACHINES = ("rottne-f9-lab", "rottne-f9-pump", "rottne-f9-mobile")


@pytest.fixture(scope="module", params=MACHINES)
def run(request):
    return hc.simulate("vertical-lift-open-loop", machine=request.param, duration=1.5, rtol=1e-6)


def test_what_was_given_is_what_was_taken(run):
    flow = energy_flow(run)
    assert flow.total > 500.0 and abs(flow.gap) < 1e-3 and flow.residual < 1e-2
    for entries in (flow.given, flow.taken):
        totals = [entry.total for entry in entries]
        assert totals == sorted(totals, reverse=True) and min(totals) > 0.0
    names = [entry.name for entry in (*flow.given, *flow.taken)]
    assert len(set(names)) == len(names)


def test_the_pump_gave_what_its_power_adds_up_to(run):
    """Once: what the mains hand on to the valves is not given a second time."""
    data = run.data
    power = data["mains.shaft_power"] if "mains.p" in data else data["supply.power"]
    work = float(np.trapezoid(power, data.time))
    flow = energy_flow(run)
    first = flow.given[0]
    assert first.name == ("shaft of the pump" if "mains.p" in data else "supply")
    assert first.total == pytest.approx(work, rel=5e-3)
    assert energy_balance(run).pump == pytest.approx(work, rel=2e-2)
    assert f"pump {energy_balance(run).pump:.0f} J" in run.summary()


def test_every_loss_of_the_ledger_is_named_and_has_its_cylinder(run):
    """Each term that ended above zero is found again, by its number, among what was taken."""
    taken = {entry.name: entry.parts for entry in energy_flow(run).taken}
    for name, text in (("edge_pa", "metering edge supply to A"), ("friction", "seal friction")):
        for cylinder in run.cylinder_names:
            lost = float(run.data[f"ledger.{cylinder}.{name}"][-1])
            assert taken[text].get(cylinder, 0.0) == pytest.approx(lost, abs=1e-12)
    shared = {"mains.relief": "relief valve", "mains.mechanical_loss": "hydromechanical loss of the pump"}
    shared["valves.compensators"] = "pressure compensators of all valves"
    for term, text in shared.items():
        if f"ledger.{term}" in run.data and float(run.data[f"ledger.{term}"][-1]) > 0.0:
            assert taken[text] == {"": pytest.approx(float(run.data[f"ledger.{term}"][-1]))}


def test_a_crane_that_sinks_gives_energy_and_one_that_rises_takes_it():
    sinking = hc.simulate("single-cylinder-step", duration=1.4)
    rising = hc.simulate("vertical-lift-open-loop", duration=1.5)
    for run, side in ((sinking, "given"), (rising, "taken")):
        kinds = [run.data[f"energy.{kind}"] for kind in ("kinetic", "potential")]
        change = sum(float(energy[-1] - energy[0]) for energy in kinds)
        assert (change < 0.0) == (side == "given")
        entries = {entry.name: entry.total for entry in getattr(energy_flow(run), side)}
        assert entries["crane lifted and moving"] == pytest.approx(abs(change))


def test_what_the_tank_line_takes_is_named_once():
    line = {"volume": "1 l", "nominal-flow": "10 l/min", "nominal-pressure-drop": "3 bar"}
    part = {"nominal-flow": "10 l/min", "nominal-pressure-drop": "2 bar", "bypass-pressure": "0.5 bar"}
    overrides = {f"tank-line.{key}": value for key, value in line.items()}
    overrides |= {f"tank-line.filter.{key}": value for key, value in part.items()}
    machine = hc.load_machine("rottne-f9-mobile", overrides)
    run = hc.simulate("vertical-lift-open-loop", machine=machine, duration=1.5, rtol=1e-6)
    flow = energy_flow(run)
    assert flow.total > 500.0 and abs(flow.gap) < 1e-3 and flow.residual < 1e-2
    taken = {entry.name: entry.total for entry in flow.taken}
    names = {
        "resistance": "resistance of the tank line", "filter": "return filter",
        "bypass": "bypass valve of the return filter",
    }  # fmt: skip
    for term, name in names.items():
        assert taken[name] == pytest.approx(float(run.data[f"ledger.tank_line.{term}"][-1])) and taken[name] > 1.0
    assert energy_balance(run).lost["return filter"] == pytest.approx(taken["return filter"] + taken[names["bypass"]])
    assert run.plot("supply").axes[1].get_title(loc="left") == "Return pressure"


def test_a_run_without_a_ledger_says_so():
    run = hc.simulate("single-cylinder-step", duration=0.1, ledger=False)
    with pytest.raises(hc.InputError, match="no energy ledger"):
        energy_flow(run)
