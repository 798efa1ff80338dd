"""What `hydrocrane new` writes: an example of nobody's crane, and a pump to hang a machine on."""

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.app.starter import KINDS, write_starter
from hydrocrane.errors import InputError


@pytest.mark.parametrize("pump", KINDS)
@pytest.mark.parametrize("machine", ["rottne-f9-lab", "hiab-xs031", "single-cylinder"])
def test_what_is_written_fits_together_and_runs(tmp_path, machine, pump):
    machine_file, scenario_file = write_starter(tmp_path, machine, pump)
    crane = hc.load_machine(machine_file)
    assert not crane.warnings
    assert ("mains.load" in crane.state_names) == (pump == "ls")
    run = hc.simulate(scenario_file, duration=0.5)
    assert run.outcome.kind == "completed"
    assert np.isfinite(run.data["mains.p"].values).all()


def test_two_functions_at_once_do_not_exceed_it(tmp_path):
    """Without load the two largest valves take 6 l/min times the root of 70 over 75 bar each."""
    crane = hc.load_machine(write_starter(tmp_path, "rottne-f9-lab", "fixed")[0])
    flow = np.asarray(crane.value("pump.main.displacement").si).item() * 1450 / 60 * 0.94
    assert 1.0 < flow / (2 * 1e-4 * np.sqrt(70 / 75)) < 1.1


@pytest.mark.parametrize(
    ("machine", "pump", "words"),
    [("rottne-f9-lab", "load-sensing", "ls"), ("rottne-f9-pump", "ls", "has a pump already")],
)
def test_what_cannot_be_is_refused_before_anything_is_written(tmp_path, machine, pump, words):
    with pytest.raises(InputError, match=words):
        write_starter(tmp_path / "new", machine, pump)
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("pump", [None, "ls"])
def test_without_a_machine_the_start_is_nobodys_crane(tmp_path, pump):
    """No word of a bundled machine or its sources, and no value without the word that it is to be replaced."""
    machine_file, scenario_file = write_starter(tmp_path, pump=pump)
    words = (machine_file.read_text() + scenario_file.read_text()).lower()
    assert not [word for word in ("heinze", "rottne", "thesis", "hiab", "kalmar") if word in words]
    crane = hc.load_machine(machine_file)
    assert not crane.warnings
    assert {kind for _, kind, _ in crane.provenance} == {"assumed"}
    assert all("to be replaced" in source for _, _, source in crane.provenance)
    run = hc.simulate(scenario_file)
    assert run.outcome.kind == "completed" and not run.warnings
