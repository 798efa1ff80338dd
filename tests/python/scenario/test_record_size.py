"""The memory of a record: what a machine's own columns take, against a limit that the caller sets."""

from __future__ import annotations

import pytest

import hydrocrane as hc
from hydrocrane.scenario.record_size import bytes_of, check_record, row_count, row_numbers

RIG = "single-cylinder-step"


def plan(**fields):
    start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
    return hc.Scenario(**{"machine": "rottne-f9-lab", "joints": start, "duration": 0.2, **fields})


@pytest.mark.parametrize("scenario", ["vertical-lift-open-loop", "tip-vertical-line", RIG, "flow-valve-lift"])
@pytest.mark.parametrize("ledger", [True, False])
def test_a_row_has_the_columns_of_its_machine(scenario, ledger):
    run = hc.simulate(scenario, duration=0.05, ledger=ledger)
    controlled = "tip.deviation" in run.columns
    counted = row_numbers(run.machine, ledger=ledger, controlled=controlled)
    assert len(run.columns) <= counted <= len(run.columns) + controlled


def test_an_hour_of_one_cylinder_is_within_the_limit_and_two_are_not():
    hour = hc.load_scenario(RIG).changed(duration=3600.0, record_interval=1e-3)
    machine = hour.load_machine()
    check_record(machine, hour, row_count(3600.0, 1e-3), ledger=True)
    with pytest.raises(hc.InputError, match=r"would take 2.3 GB \(7.2e\+06 times 40 numbers\), more than 2 GB"):
        hc.simulate(hour, duration=7200.0)


def test_samples_of_a_controller_count_also_between_the_recorded_times():
    fast = plan(controller="tip", period=1e-4, duration=20000.0, record_interval=10.0)
    with pytest.raises(hc.InputError, match="of its samples"):
        hc.simulate(fast)


@pytest.mark.parametrize(
    ("given", "size"),
    [(None, 2e9), ("8 GB", 8e9), ("1.5GB", 1.5e9), ("512 MiB", 2**29), ("3e9 B", None), (4e9, 4e9), (8, None),
     ("8", None), ("8 GH", None), ("1.2.3 GB", None), (True, None), ([1e9], None)],
)  # fmt: skip
def test_a_limit_is_a_size_of_memory_with_its_unit(given, size):
    if size is not None:
        assert bytes_of(given) == size and plan(record_limit=given).record_limit == given
        return
    with pytest.raises(hc.InputError, match="record_limit"):
        plan(record_limit=given)


def test_every_door_has_the_callers_limit(tmp_path):
    doors = {
        "simulate": lambda **limit: hc.simulate(plan(record_interval=1e-5), **limit),
        "sweep": lambda **limit: hc.sweep(
            plan(record_interval=1e-5), {"payload": [0.0]}, signals=["tip.z"], progress=False, **limit
        ),
        "sensitivities": lambda **limit: hc.sensitivities(plan(record_interval=1e-5), "supply.pressure", **limit),
    }
    for name, door in doors.items():
        with pytest.raises(hc.InputError, match=r"more than 0.00[35] GB; give a longer"):
            door(record_limit="3 MB" if name == "sweep" else "5 MB")
        door(record_limit="60 MB")


def test_the_limit_is_a_matter_of_the_computer_not_of_the_scenario(tmp_path):
    large = plan(record_limit="8 GB")
    assert large == plan() and "limit" not in large.to_toml()
    store = tmp_path / "study.zarr"
    hc.sweep(plan(), {"payload": [0.0]}, store=store, progress=False)
    hc.sweep(large, {"payload": [0.0]}, store=store, progress=False)


@pytest.mark.parametrize("interval", [1e-7, 4e-7])
def test_a_record_larger_than_memory_is_refused_with_its_size(interval):
    with pytest.raises(hc.InputError, match=r"(GB|bytes).*more than 2 GB; give a longer record_interval"):
        hc.simulate(plan(), record_interval=interval, duration=5.0)
    with pytest.raises(hc.InputError, match="shorter duration"):
        hc.simulate(plan(), duration=1e7)


def test_batches_and_kept_signals_have_the_same_bound():
    with pytest.raises(hc.InputError, match=r"this batch would take .* fewer cranes"):
        hc.BatchSimulator(hc.load_machine("single-cylinder"), 10**12)
    with pytest.raises(hc.InputError, match=r"the record of this run would take .* resample"):
        hc.sweep(plan(), {"payload": [0.0, 1.0]}, signals=["tip.z"], resample=1e-12)
