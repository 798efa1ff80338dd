"""Threads and processes of a study: the same to the bit, also where a case ends its process or never ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.errors import InputError
from hydrocrane.studies import board, distribution, processes

pytestmark = pytest.mark.filterwarnings("ignore:.*cases have no results")

RIG = "single-cylinder-step"
MASSES = {"payload.mass": [50.0, 60.0, 70.0, 80.0]}


def rig_study(keys=MASSES, **options):
    return hc.sweep(RIG, keys, **{"duration": 0.1, "progress": False, "workers": 2, **options})


def deadly(run):
    """Ends the process of one case, as a lack of memory or a crash of a library does."""
    if run.data.attrs["payload"] == 60.0:
        os.kill(os.getpid(), signal.SIGKILL)
    return 1.0


def test_processes_compute_what_threads_compute():
    keys = {"payload.mass": {"low": 50.0, "high": 150.0, "count": 5}, "supply.pressure": [80e5, 120e5, 140e5]}
    options = {"signals": ["tip.z"], "block": 4}
    assert rig_study(keys, **options, scheduler="processes").identical(rig_study(keys, **options))


@pytest.mark.evidence
@pytest.mark.parametrize("slowed", ["threads", "processes"])
def test_long_studies_go_on_in_what_is_faster(slowed, monkeypatch):
    """Chosen by the time that is left and by a stretch of both, unless something of the user's own takes part."""
    seen, apart, threads = [], processes.Apart.run, distribution.run_block

    def in_process(self, task):
        seen.extend(task.numbers)
        time.sleep(0.3 * (slowed == "processes"))
        return apart(self, task)

    def in_thread(*given):
        time.sleep(0.3 if slowed == "threads" else 0.03)
        return threads(*given)

    monkeypatch.setattr(processes.Apart, "run", in_process)
    keys = {"payload.mass": {"low": 50.0, "high": 150.0, "count": 40}}
    few = rig_study(keys, block=1)
    assert not seen
    monkeypatch.setattr(distribution, "run_block", in_thread)
    monkeypatch.setattr(distribution, "START", 0.05)
    monkeypatch.setattr(distribution, "WORTH", 0.0)
    assert rig_study(keys, block=1).identical(few)
    assert (20 < len(seen) < 40) if slowed == "threads" else 0 < len(seen) < 20, seen
    seen.clear()
    rig_study(keys, block=1, measures=[lambda run: 1.0])
    assert not seen


def test_your_own_functions_are_sent_to_processes(capfd):
    gain = 3.0

    def own(run):
        print("this goes to the error output")
        return gain * run.data.attrs["payload"]

    data = rig_study(measures={"own": own}, scheduler="processes")
    assert data["own"].values.tolist() == [150.0, 180.0, 210.0, 240.0]
    assert "this goes to the error output" in capfd.readouterr().err
    lock = threading.Lock()
    with pytest.raises(InputError, match='cannot be sent.*scheduler="threads"'):
        rig_study(measures={"own": lambda run: float(lock.locked())}, scheduler="processes")


def stops_the_study(obs, command):
    raise KeyboardInterrupt


@pytest.mark.evidence
@pytest.mark.parametrize("scheduler", distribution.WAYS)
def test_a_controller_that_interrupts_ends_the_study(scheduler):
    plan = hc.Scenario(machine="single-cylinder", joints={"slide": 0.0}, controller=stops_the_study, duration=0.1)
    with pytest.raises(hc.studies.StudyInterrupted, match="0 of 4"):
        hc.sweep(plan, MASSES, scheduler=scheduler, progress=False)


@pytest.mark.evidence
def test_an_error_of_the_whole_study_comes_back_from_a_process():
    with pytest.raises(InputError, match="outcome"):
        rig_study(measures=[lambda run: {"outcome": 1.0}], scheduler="processes")


def test_a_case_that_ends_its_process_is_left_out(tmp_path):
    data = rig_study(measures=[deadly], scheduler="processes", store=tmp_path / "s.zarr", block=4)
    assert data.outcome.values.tolist() == ["completed", "killed", "completed", "completed"]
    assert "ended 2 times" in data.message.values[1] and "-9" in data.message.values[1]
    assert data["deadly"].values[[0, 2, 3]].tolist() == [1.0, 1.0, 1.0]
    assert [file.name for file in tmp_path.iterdir()] == ["s.zarr"]


SCRIPT = """
    import hydrocrane as hc
    from test_study_workers import MASSES, deadly, rig_study
    data = rig_study(measures=[deadly], scheduler="threads", store="s.zarr", block=1)
    print(*data.outcome.values)
"""


@pytest.mark.evidence
def test_in_threads_it_is_left_out_when_the_study_is_resumed(tmp_path):
    """The case is found although another one runs beside it, and is computed alone at the second time."""
    command = [sys.executable, "-W", "ignore", "-c", textwrap.dedent(SCRIPT)]
    environment = {**os.environ, "PYTHONPATH": os.path.dirname(__file__)}
    lives = [
        subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=60)
        for _ in range(3)
    ]
    assert [life.returncode for life in lives] == [-9, -9, 0], [life.stderr for life in lives]
    assert lives[2].stdout.split() == ["completed", "killed", "completed", "completed"]


@pytest.mark.parametrize("scheduler", ["threads", "processes"])
def test_a_case_may_take_a_limited_time(tmp_path, scheduler):
    options = {"duration": 36000.0, "record_interval": 600.0, "store": tmp_path / "s.zarr", "scheduler": scheduler}
    keys = {"payload.mass": [50.0, 60.0], "duration": [0.1, 36000.0]}
    data = rig_study(keys, **options, time_limit="1 s")
    assert data.outcome.values.tolist() == [["completed", "time-limit"]] * 2
    assert "limit of 1 s; it had reached" in data.message.values[0, 1]
    again = rig_study(keys, **options, time_limit=0.9)
    assert "limit of 0.9 s" in again.message.values[0, 1]


@pytest.mark.evidence
def test_a_function_that_hangs_is_ended(monkeypatch):
    monkeypatch.setattr(processes, "GRACE", 0.2)

    def hangs(run):
        time.sleep(1000.0 if run.data.attrs["payload"] == 60.0 else 0.0)
        return 1.0

    data = rig_study(measures=[hangs], scheduler="processes", time_limit=3.0)
    assert data.outcome.values.tolist() == ["completed", "time-limit", "completed", "completed"]
    assert "was ended" in data.message.values[1]


@pytest.mark.parametrize("scheduler", ["threads", "processes"])
def test_measures_count_for_the_limit(scheduler):
    def slow(run):
        time.sleep(1.5 if run.data.attrs["payload"] == 60.0 else 0.0)
        return 1.0

    data = rig_study(measures=[slow], scheduler=scheduler, time_limit=1.0)
    assert data.outcome.values.tolist() == ["completed", "time-limit", "completed", "completed"]
    assert "its measures were not" in data.message.values[1] and np.isnan(data["slow"].values[1])


@pytest.mark.parametrize("limit", [0.0, -1, True, "3 kg", float("nan"), float("inf")])
def test_limits_are_times(limit):
    with pytest.raises(InputError, match="time_limit"):
        rig_study(time_limit=limit)


def test_a_scheduler_that_there_is_not():
    with pytest.raises(InputError, match="`process`.*`processes`"):
        rig_study(scheduler="process")


@pytest.mark.evidence
def test_where_no_process_can_be_started(monkeypatch, tmp_path):
    """A program that Python is a part of, and a Python that ends at once."""
    broken = tmp_path / "python"
    broken.write_text("#!/bin/sh\nexit 3\n")
    broken.chmod(0o755)
    monkeypatch.setattr(distribution, "START", 0.0)
    monkeypatch.setattr(distribution, "WORTH", 0.0)
    keys = {"payload.mass": {"low": 50.0, "high": 150.0, "count": 12}}
    for executable, told in (("/usr/bin/matlab", "matlab"), (str(broken), "status 3")):
        monkeypatch.setattr(sys, "executable", executable)
        with pytest.raises(processes.NoProcesses, match=f"{told}.*0 of 12 cases"):
            rig_study(keys, scheduler="processes")
        assert (rig_study(keys, block=1).outcome == "completed").all()


def test_the_bar_names_what_takes_long(monkeypatch):
    monkeypatch.setattr(distribution, "LOOK", 0.05)
    monkeypatch.setattr("hydrocrane.studies.study.LONG", 0.1)
    told = []

    class Bar:
        def __enter__(self):
            return lambda done, total, running: told.append(running)

        def __exit__(self, *error):
            pass

    monkeypatch.setattr("hydrocrane.studies.board._bar", lambda title: Bar())
    rig_study(measures=[lambda run: time.sleep(0.4) or 1.0], progress=True)
    assert any("case 0 for 0 s: payload.mass = 50.0" in text for text in told)


def test_a_board_counts_the_ends_of_processes(tmp_path):
    place = tmp_path / ".s.zarr.running"
    for ends in range(3):
        with board.board_of(tmp_path / "s.zarr", 2) as own:
            assert own.deaths == ({5: ends} if ends else {})
            own.begin(1, 5)
            assert own.longest()[0] == 5
            left = place.read_bytes()
        assert not place.exists()
        place.write_bytes(left)
    place.write_bytes(b"damaged" * 9)
    with board.board_of(tmp_path / "s.zarr", 1) as own:
        assert own.at(0) is None


def test_a_case_that_may_have_ended_a_process_is_tried_apart(tmp_path, monkeypatch):
    seen, plain, store = [], processes.Apart.run, tmp_path / "s.zarr"
    monkeypatch.setattr(processes.Apart, "run", lambda self, task: (seen.extend(task.numbers), plain(self, task))[1])
    with board.board_of(store, 2) as own:
        own.begin(0, 2)
        left = own.path.read_bytes()
    (tmp_path / ".s.zarr.running").write_bytes(left)
    data = rig_study(store=store, block=1)
    assert seen == [2] and (data.outcome == "completed").all()


def test_numbers_of_cases_count_through_the_study():
    study = hc.Study(RIG, {"payload.mass": [50.0, 60.0, 70.0], "supply.pressure": [80e5, 120e5]})
    place = (slice(1, 3), slice(1, 2))
    numbers = study.cases.numbers(place)
    assert numbers == [3, 5] == np.arange(6).reshape(3, 2)[place].ravel().tolist()
    assert [study.cases.values_of(number) for number in numbers] == study.cases.values(place)
