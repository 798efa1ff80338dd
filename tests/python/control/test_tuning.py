"""The search for gains: it never makes them worse, and what it writes is a machine file's block."""

from __future__ import annotations

import tomllib

import pytest

import hydrocrane as hc
from hydrocrane.benchmark import fitted_tasks, tuning
from hydrocrane.benchmark.cases import quick_cases

pytestmark = pytest.mark.evidence


def test_bad_gains_become_better_and_the_block_loads(tmp_path):
    """From a tenth of the position gain the search finds its way; the block gives the same gains in a file."""
    crane = hc.load_machine("rottne-f9-lab", {"control.tip.position-gain": 0.2, "control.tip.damping-ratio": 0.05})
    found = tuning.tune(crane, gains=["position-gain", "damping-ratio"], cases=quick_cases()[:1], trials=8)
    assert found.cost_after < found.cost_before
    assert found.before == {"position-gain": 0.2, "damping-ratio": 0.05}
    assert found.trials <= 8 and found.rest_after < 1e-3
    path = tmp_path / "tuned.toml"
    head = 'extends = "rottne-f9-lab"\n[machine]\nname = "tuned"\nclass = "setting"\nsource = "test"\n'
    path.write_text(head + found.toml(), encoding="utf-8")
    tomllib.loads(path.read_text(encoding="utf-8"))
    gains = hc.load_machine(path).tip_gains
    for key, value in found.after.items():
        assert gains[key] == pytest.approx(value, rel=1e-3)


def test_good_gains_are_kept_where_nothing_better_is_found():
    crane = hc.load_machine("rottne-f9-lab")
    found = tuning.tune(crane, cases=quick_cases()[:1], trials=1)
    assert found.after == found.before and found.cost_after == found.cost_before


def test_the_price_is_that_of_the_worst_case_and_counts_rest():
    """The mean deviation alone chose gains that left a crane with slow valves shaking."""
    crane = hc.load_machine("rottne-f9-lab")
    cases = fitted_tasks.tuning_cases(crane)
    assert str(cases[-1].condition) == "valves 20 ms later"
    found = tuning.tune(crane, cases=cases, trials=1)
    singly = [tuning.tune(crane, cases=[case], trials=1) for case in cases]
    assert found.cost_after == max(one.cost_after for one in singly)
    assert found.rest_after == max(one.rest_after for one in singly)
    assert all(one.cost_after > one.rest_after for one in singly)


def test_wrong_wishes_are_named():
    crane = hc.load_machine("rottne-f9-lab")
    with pytest.raises(hc.HydrocraneError, match="damping-ratio"):
        tuning.tune(crane, gains=["dampin"])
    with pytest.raises(hc.HydrocraneError, match="trials"):
        tuning.tune(crane, trials=0)
    with pytest.raises(hc.InputError, match="up, down, out and in"):
        tuning.tune(hc.load_machine("rig-rottne"), trials=2)
    with pytest.raises(hc.InputError, match="nothing to improve: refused"):
        tuning.tune(hc.load_machine("rig-rottne"), trials=2, cases=quick_cases())
