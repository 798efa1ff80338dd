"""A study is resumed if it is the same, down to the code that it calls; what crashed is computed again."""

from __future__ import annotations

import functools
import pickle
import sys
import threading
import types

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.result_warning import DoubtfulResult
from hydrocrane.studies import case
from hydrocrane.studies.identity import UNKNOWN, fingerprint

PLAN = "single-cylinder-step"
LOADS = {"payload.mass": [50.0, 100.0, 150.0]}


def run(store, **given):
    return hc.sweep(PLAN, LOADS, store=store, **{"duration": 0.05, "measures": ["tip_way"], **given})


class Proportional:
    def __init__(self, gain):
        self.gain = gain

    def reset(self, machine, obs):
        self.start = obs.q[0]

    def step(self, obs, command):
        return [self.gain * (self.start + 0.1 - obs.q[0])]


OFFSET = 1.0


def helper(run):
    return OFFSET * run.outcome.time


def measured(run, factor=1.0):
    return factor * helper(run)


def of(offset):
    return lambda run: offset


def changed_default():
    made = types.FunctionType(measured.__code__, globals(), "measured", (2.0,))
    made.__module__, made.__qualname__ = measured.__module__, measured.__qualname__
    return made


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (Proportional(1.0), Proportional(5.0)),
        (functools.partial(measured, factor=1.0), functools.partial(measured, factor=2.0)),
        (of(1.0), of(2.0)),
        (measured, changed_default()),
        (Proportional(np.zeros(3)).step, Proportional(np.ones(3)).step),
        (np.random.default_rng(1), np.random.default_rng(2)),
    ],
    ids=["state", "argument", "closure", "default", "method", "generator"],
)
def test_what_is_changed_has_another_digest(before, after):
    assert fingerprint(before) != fingerprint(after)
    assert fingerprint(before) == fingerprint(before)
    assert UNKNOWN not in fingerprint(before)


def test_globals_helpers_and_files_count(monkeypatch, tmp_path):
    before = fingerprint(measured)
    monkeypatch.setattr(sys.modules[__name__], "OFFSET", 2.0)
    assert fingerprint(measured) != before
    monkeypatch.undo()
    assert fingerprint(measured) == before
    monkeypatch.setattr(sys.modules[__name__], "helper", lambda run: run.outcome.time)
    assert fingerprint(measured) != before
    file = tmp_path / "table.csv"
    file.write_text("1\n")
    held = fingerprint(of(str(file)))
    file.write_text("2\n")
    assert fingerprint(of(str(file))) != held
    assert UNKNOWN not in fingerprint(of("a" * 500))


def test_another_gain_is_another_study(tmp_path):
    def swept(gain):
        plan = hc.Scenario(
            machine="single-cylinder", joints={"slide": 0.0}, controller=Proportional(gain), duration=0.05
        )
        return hc.sweep(plan, LOADS, store=tmp_path / "s", measures=["tip_way"])

    swept(0.01)
    assert (swept(0.01)["outcome"] == "completed").all()
    with pytest.raises(hc.ResultFileError, match="controller was"):
        swept(0.05)


def test_what_cannot_be_told_is_refused_or_taken_on_trust(tmp_path):
    guard = threading.Lock()

    def slow(run):
        with guard:
            return run.outcome.time

    run(tmp_path / "s", measures=[slow])
    with pytest.raises(hc.ResultFileError, match="lock does not tell its state.*resume"):
        run(tmp_path / "s", measures=[slow])
    found = run(tmp_path / "s", measures=[slow], resume="trust")
    assert "lock" in found.attrs["resumed_on_trust"]
    with pytest.raises(hc.InputError, match="trust"):
        run(tmp_path / "s", measures=[slow], resume="blindly")


def test_the_content_of_a_log_counts(tmp_path):
    log = tmp_path / "commands.csv"
    text = "time,test\n0,0\n0.01,{}\n1,{}\n"
    log.write_text(text.format(0.002, 0.002))
    keys = {"command.log": [str(log)]}
    first = hc.sweep(PLAN, keys, store=tmp_path / "s", duration=0.1, measures=["tip_way"])
    log.write_text(text.format(0.009, 0.009))
    with pytest.raises(hc.ResultFileError, match="logs"):
        hc.sweep(PLAN, keys, store=tmp_path / "s", duration=0.1, measures=["tip_way"])
    assert (first["outcome"] == "completed").all()


def test_what_crashed_is_told_and_computed_again(tmp_path, monkeypatch):
    simulated, heavy = case._simulated, {150.0}

    def crashing(job, values, should_stop):
        if values[0] in heavy:
            raise TypeError("a mistake of the program")
        return simulated(job, values, should_stop)

    monkeypatch.setattr(case, "_simulated", crashing)
    with pytest.warns(DoubtfulResult, match=r"1 of 3 cases have no results \(crashed\).*a mistake of the program"):
        found = run(tmp_path / "s", block=1)
    assert list(found["outcome"].values) == ["completed", "completed", "crashed"]
    heavy.clear()
    assert list(run(tmp_path / "s", block=1)["outcome"].values) == ["completed"] * 3


@pytest.mark.parametrize("offset", range(1, 8))
def test_arrays_may_lie_at_any_byte(offset):
    """As buffers of pickle lie that another process sends."""

    def sent(array):
        kept = []
        data = pickle.dumps(np.asarray(array, dtype=float), protocol=5, buffer_callback=kept.append)
        buffers = []
        for buffer in kept:
            room = bytearray(len(buffer.raw()) + 8)
            room[offset : offset + len(buffer.raw())] = buffer.raw()
            buffers.append(memoryview(room)[offset : offset + len(buffer.raw())])
        return pickle.loads(data, buffers=buffers)

    times, spools = [0.0, 0.02, 0.05], [0.0, 2e-3, 1e-3]
    assert not sent(times).flags.aligned
    plain = hc.simulate(PLAN, commands={"test": hc.Command(times, spools)}, duration=0.1)
    command = hc.Command(times, spools)
    for name in ("time", "spool"):
        object.__setattr__(command, name, sent(getattr(command, name)))
    odd = hc.simulate(PLAN, commands={"test": command}, duration=0.1)
    assert odd.columns["tip.x"].values.tobytes() == plain.columns["tip.x"].values.tobytes()
    one, two = hc.BatchSimulator("single-cylinder", 3), hc.BatchSimulator("single-cylinder", 3)
    places, spools = np.array([[0.0], [0.01], [0.02]]), np.array([[1e-3], [2e-3], [0.0]])
    one.reset(q=places)
    two.reset(q=sent(places))
    assert one.step(spools).q.tobytes() == two.step(sent(spools)).q.tobytes()
