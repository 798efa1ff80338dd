"""Studies on disk: stopped, killed, resumed, changed, on a cluster, within their memory."""

from __future__ import annotations

import importlib.util
import json
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import zarr

import hydrocrane as hc
from hydrocrane.studies import StudyInterrupted, design, distribution

pytestmark = [pytest.mark.evidence, pytest.mark.filterwarnings("ignore:.*cases have no results")]

ROOT = Path(__file__).resolve().parents[3]
RIG = "single-cylinder-step"
KEYS = {"payload.mass": [50.0, 60.0, 70.0, 80.0], "supply.pressure": [100e5, 120e5, 140e5]}


def rig_study(keys=KEYS, **options):
    return hc.sweep(RIG, keys, **{"duration": 0.4, "progress": False, "signals": ["tip.z"], **options})


@pytest.fixture(scope="module")
def bench():
    """The benchmark of reliability, whose parts run here with few cases."""
    spec = importlib.util.spec_from_file_location("sweep_reliability", ROOT / "benches/sweep_reliability.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def stop_after(count):
    """A progress that is interrupted, as by Ctrl-C."""

    def progress(done, total):
        if done >= count:
            raise KeyboardInterrupt

    return progress


def test_a_store_holds_what_memory_holds(tmp_path):
    kept = rig_study(store=tmp_path / "study.zarr")
    assert kept.load().identical(rig_study())
    assert hc.open_study(tmp_path / "study.zarr").identical(kept)
    # As any other program would open it.
    plain = xr.open_zarr(tmp_path / "study.zarr", consolidated=False, chunks=None)
    assert plain["tip.z"].dims == ("payload.mass", "supply.pressure", "time")
    assert plain["tip.z"].attrs["units"] == "m" and plain.attrs["machine"] == "single-cylinder"


def test_drawn_values_are_coordinates_in_the_store(tmp_path):
    options = {"method": "latin", "n": 5, "store": tmp_path / "study.zarr"}
    rig_study({"payload.mass": (50.0, 90.0), "solver.method": {"values": ["tsit5", "rodas5p"]}}, **options)
    data = hc.open_study(tmp_path / "study.zarr")
    assert {"payload.mass", "solver.method"} <= set(data.coords) and data["payload.mass"].attrs["units"] == "kg"


def test_signals_stay_on_disk_until_they_are_used(tmp_path):
    data = rig_study(store=tmp_path / "study.zarr")
    assert not data["tip.z"].variable._in_memory
    assert np.isfinite(data["tip.z"].sel({"payload.mass": 60.0})).all()


def test_result_goes_through_netcdf(tmp_path):
    data = rig_study({"payload.mass": [50.0, -1.0], "solver.method": ["tsit5", "rodas5p"]}, store=tmp_path / "s.zarr")
    data.to_netcdf(tmp_path / "study.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "study.nc", engine="h5netcdf") as again:
        for name in data.variables:
            assert np.array_equal(again[name].values.astype(data[name].dtype), data[name].values, equal_nan=again[name].dtype.kind == "f")  # fmt: skip  # noqa: E501
        assert again["tip_way"].attrs["units"] == "m"


def test_nothing_is_computed_twice(tmp_path, computed):
    store = tmp_path / "study.zarr"
    with pytest.raises(StudyInterrupted, match=f"after 3 of 12 cases.*{store.name}"):
        rig_study(store=store, block=3, workers=1, progress=stop_after(3))
    part = hc.open_study(store)
    assert (part.outcome.values != "").sum() == 3 and np.isfinite(part["tip_way"].values).sum() == 3
    places = np.argwhere(part.outcome.values != "")
    done = {(KEYS["payload.mass"][i], KEYS["supply.pressure"][j]) for i, j in places}
    computed.clear()
    whole = rig_study(store=store, workers=2)
    assert len(computed) == 9 == len(set(computed)) and not set(computed) & done
    assert whole.load().identical(rig_study())
    computed.clear()
    rig_study(store=store)
    assert not computed


def test_interrupted_without_a_store_says_what_to_do():
    with pytest.raises(StudyInterrupted, match="give a store"):
        rig_study(block=1, progress=stop_after(2))


def test_ctrl_c_ends_long_runs_too(monkeypatch):
    """Runs of hours: the threads stop in the middle of a case, or this test would take as long."""
    with pytest.raises(StudyInterrupted):
        rig_study(signals=(), duration=36000.0, record_interval=60.0, block=1, workers=2, progress=stop_after(0))


def test_progress_counts_from_what_is_done(tmp_path):
    seen = []
    with pytest.raises(StudyInterrupted):
        rig_study(store=tmp_path / "s.zarr", block=3, workers=1, progress=stop_after(3))
    rig_study(store=tmp_path / "s.zarr", progress=lambda done, total: seen.append((done, total)))
    assert seen == [(3, 12), (6, 12), (9, 12), (12, 12)]


DIFFERENT = {
    "values of a key": ({"keys": {**KEYS, "payload.mass": [50.0, 60.0, 70.0, 81.0]}}, ["keys.payload.mass", "81"]),
    "one more key": ({"keys": {**KEYS, "seed": [1.0]}}, ["keys.seed was not there"]),
    "machine": ({"overrides": {"cylinder.test.bore": 0.07}}, ["machine.values.cylinder.test.bore", "0.07"]),
    "law": ({"overrides": {"fluid.viscosity": "0.05 Pa s"}}, ["machine.values.fluid.viscosity"]),
    "field of the scenario": ({"duration": 0.5}, ["scenario.duration was 0.4, is 0.5"]),
    "tolerance": ({"rtol": 1e-5}, ["scenario.solver.rtol was 3e-05, is 1e-05"]),
    "measures": ({"measures": ["steps"]}, ["measures.steps was not there"]),
    "signals": ({"signals": ["tip.x"]}, ["signals was ['tip.z'], is ['tip.x']"]),
    "own measure": ({"measures": {"tip_way": lambda run: 0.0}}, ["measures.tip_way was None"]),
}


@pytest.mark.parametrize(("changes", "words"), DIFFERENT.values(), ids=DIFFERENT)
def test_another_study_does_not_go_on_in_a_store(changes, words, tmp_path, computed):
    store = tmp_path / "study.zarr"
    rig_study(store=store)
    computed.clear()
    with pytest.raises(hc.ResultFileError, match="another study") as caught:
        rig_study(**{"store": store, **changes})
    for word in words:
        assert word in str(caught.value), str(caught.value)
    assert not computed and hc.open_study(store).load().identical(rig_study())
    assert rig_study(**{"store": store, "overwrite": True, **changes}).load().identical(rig_study(**changes))


def test_another_version_does_not_go_on_in_a_store(tmp_path, monkeypatch):
    rig_study(store=tmp_path / "study.zarr")
    monkeypatch.setattr(hc, "__version__", "99.0", raising=False)
    with pytest.raises(hc.ResultFileError, match=r"hydrocrane was .*, is 99\.0"):
        rig_study(store=tmp_path / "study.zarr")


def test_a_changed_function_is_another_study(tmp_path):
    rig_study(store=tmp_path / "s.zarr", measures={"one": lambda run: 1.0})
    with pytest.raises(hc.ResultFileError, match=r"measures\.one"):
        rig_study(store=tmp_path / "s.zarr", measures={"one": lambda run: 2.0})


def test_a_machine_that_changes_under_the_study_stops_it(tmp_path):
    file = tmp_path / "machine.toml"
    file.write_text('extends = "single-cylinder"\n')
    study = hc.Study(RIG, {"payload.mass": [50.0]}, machine=file)
    assert study.base_machine.name and study.job.digest
    file.write_text('extends = "single-cylinder"\n[cylinder.test]\nbore = { value = "70 mm", class = "setting" }\n')
    with pytest.raises(hc.InputError, match="has changed"):
        study.run(progress=False)


@pytest.mark.parametrize("overwrite", [False, True])
def test_what_is_no_study_is_left_alone(overwrite, tmp_path):
    (tmp_path / "thesis.txt").write_text("years of work")
    with pytest.raises(hc.ResultFileError, match="not a study"):
        rig_study(store=tmp_path, overwrite=overwrite)
    zarr.open_group(tmp_path / "other.zarr", mode="w").create_array("x", data=np.ones(3))
    with pytest.raises(hc.ResultFileError, match="not a study"):
        rig_study(store=tmp_path / "other.zarr", overwrite=overwrite)
    assert (tmp_path / "thesis.txt").read_text() == "years of work"
    with pytest.raises(hc.ResultFileError, match="no such store"):
        hc.open_study(tmp_path / "nowhere.zarr")


def test_an_empty_folder_becomes_a_store(tmp_path):
    assert rig_study({"payload.mass": [50.0]}, store=tmp_path).outcome.values.tolist() == ["completed"]


def test_an_array_that_a_killed_process_had_begun_is_made_anew(tmp_path, monkeypatch):
    """The array of a figure of one's own appears with the first block; the process ended before it was listed."""
    from hydrocrane.studies import store as store_module

    store, plain = tmp_path / "study.zarr", store_module.seal

    def ends(folder, **attributes):
        if folder.name == "own":
            raise KeyboardInterrupt
        plain(folder, **attributes)

    monkeypatch.setattr(store_module, "seal", ends)
    with pytest.raises(StudyInterrupted):
        rig_study(store=store, measures={"own": own_figure}, signals=())
    monkeypatch.undo()
    assert (store / "own").exists()
    assert (rig_study(store=store, measures={"own": own_figure}, signals=()).own == 1.0).all()


def own_figure(run):
    return 1.0


def test_half_written_blocks_are_written_again(tmp_path):
    """As after a kill between the chunks of one block: figures are there, outcomes are not."""
    store = tmp_path / "study.zarr"
    whole = rig_study(store=store, block=3).load()
    for chunk in ("outcome/c/1/0", "tip_way/c/2/0", "outcome/c/2/0"):
        (store / chunk).unlink()
    (store / "tip_way/c/1/0").with_suffix(".0badcafe.partial").write_bytes(b"half")
    assert (hc.open_study(store).outcome.values == "").sum() == 6
    assert rig_study(store=store).load().identical(whole)
    assert not list(store.rglob("*.partial"))


@pytest.mark.parametrize("way", distribution.WAYS)
def test_killed_twice_and_resumed_it_is_the_undisturbed_study(bench, tmp_path, way):
    found = bench.killed(tmp_path, 400, scheduler=way, duration=1.0)
    first, second, last = found["lives"]
    assert [life["status"] for life in (first, second, last)] == [-9, -9, 0]
    assert 0 < first["done_after"] < second["done_after"] < last["done_after"] == 396
    assert not any(life["computed_although_done"] for life in found["lives"])
    # What is lost is what was under way.
    under_way = 400 // design.BLOCKS * distribution.AHEAD * found["workers"]
    assert 396 <= sum(life["computed"] for life in found["lives"]) <= 396 + 2 * under_way
    assert found["identical"] and found["outcomes"] == {"completed": 396, "invalid-input": 4}


def test_a_cluster_that_loses_a_worker_loses_no_case(bench, tmp_path):
    pytest.importorskip("distributed")
    found = bench.lost_worker(tmp_path, 120, duration=1.0)
    assert 60 <= found["lost_after"] < 120 and found["one_worker_left"]
    assert found["missing"] == 0 and found["identical"]


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning", "ignore::ResourceWarning")
def test_a_lost_scheduler_is_one_error_after_which_the_study_goes_on(bench, tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    import dask

    from hydrocrane.studies import distribution

    # The client tries to reach the scheduler again for as long.
    with dask.config.set({"distributed.comm.timeouts.connect": "3s"}):
        monkeypatch.setattr(distribution, "CONNECT", 5)
        found = bench.lost_scheduler(tmp_path, 120, duration=1.0)
    assert "the cluster failed" in found["error"] and "\n" not in found["error"]
    assert f"{found['done']} of 120 cases; the same call resumes there (STORE)" in found["error"]
    assert 60 <= found["done"] < 120 and found["identical"]


def test_a_case_that_ends_its_process_costs_a_cluster_nothing_else(bench, tmp_path):
    pytest.importorskip("distributed")
    rows = bench.poisoned(tmp_path, 12)
    assert [row["calls"] for row in rows] == [3, 1, 1]
    assert all(row["right"] and row["killed"] == 1 and row["completed"] == 11 for row in rows)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning", "ignore::ResourceWarning")
def test_a_cluster_that_lost_all_workers_ends_the_study(bench, tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    from hydrocrane.studies import distribution
    from hydrocrane.studies.processes import NotComputed

    monkeypatch.setattr(distribution, "WORKERS_AWAITED", 1)

    with bench.cluster(tmp_path) as (address, workers):

        def watch(done, total):
            if done:
                for worker in workers:
                    worker.kill()

        with pytest.raises(NotComputed, match="no worker for 1 s; stopped after .* of 12 cases; give a store"):
            rig_study(scheduler=address, progress=watch, block=1)


def test_no_change_escapes_when_a_study_is_resumed(bench, tmp_path):
    rows = bench.changed(tmp_path)
    assert len(rows) == 12 and all(row["resumed"] and row["refused"] for row in rows), rows


def test_a_full_disk_is_one_error(bench, tmp_path):
    found = bench.full_disk(tmp_path, 60)
    assert found["statuses"] == [1, 0] and found["identical"] and "cannot write `STORE`" in found["error"]


def test_a_cluster_without_workers_is_one_clear_error(bench, tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    from hydrocrane.studies import distribution

    monkeypatch.setattr(distribution, "CONNECT", 1)
    # A scheduler under load may itself take longer than that.
    says = pytest.raises(hc.InputError, match="no workers|answers")
    with bench.cluster(tmp_path, workers=0) as (address, _), says:
        rig_study(scheduler=address)


def peak(cases, store):
    """Largest memory that a study with signals takes, bytes."""
    keys = {"payload.mass": (50.0, 90.0)}
    signals = [f"cylinder.test.{name}" for name in ("p1", "p2", "xs", "vs", "x", "v", "force", "friction")]
    tracemalloc.start()
    try:
        rig_study(
            keys, method="random", n=cases, signals=signals, resample=1e-4, record_interval=1e-4, duration=0.2,
            store=store, workers=2, block=10,
        )  # fmt: skip
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_memory_does_not_grow_with_the_number_of_cases(tmp_path):
    """A block of ten cases has 1.3 MB of signals; two per worker are under way and one is being written."""
    block = 10 * 8 * 2001 * 8
    few, many = peak(60, tmp_path / "few.zarr"), peak(240, tmp_path / "many.zarr")
    assert many < 1.2 * few
    # Besides these: a run as it is recorded, in both threads, and one signal of a block as it is compressed.
    assert many < (distribution.AHEAD * 2 + 2) * block < 24 * block


def test_identity_is_told_in_the_result():
    about = json.loads(rig_study().attrs["study"])
    assert about["keys"]["payload.mass"] == KEYS["payload.mass"] and about["hydrocrane"] == hc.__version__
