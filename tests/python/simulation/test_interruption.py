"""What was stopped by hand says so, wherever it was stopped; loops of runs end."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager, nullcontext

import pytest

import hydrocrane as hc
from hydrocrane.analysis.sensitivity import Experiment, solve
from hydrocrane.benchmark.tuning import tune
from hydrocrane.simulation import running

# A run of minutes.
LONG = {"duration": 20000.0, "record_interval": 1.0, "commands": {}}
SCENARIO = "vertical-lift-open-loop"


@contextmanager
def ctrl_c(after: float):
    timer = threading.Timer(after, signal.raise_signal, [signal.SIGINT])
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def kinds(run):
    return [warning.kind for warning in run.warnings]


def test_the_part_of_a_run_until_ctrl_c_warns_also_from_its_file(tmp_path):
    with ctrl_c(0.3), pytest.raises(KeyboardInterrupt) as stopped:
        hc.simulate(SCENARIO, **LONG)
    part = stopped.value.run
    assert part.outcome.kind == "interrupted" and kinds(part)[-1] == "interrupted"
    doubt = part.warnings[-1]
    assert "of 2e+04 s" in doubt.text and doubt.cure and doubt.time == part.outcome.time
    again = hc.load_run(part.save(tmp_path / "part.nc"))
    assert again.warnings == part.warnings and doubt.text in again.summary()


def giving_up(obs, command):
    if obs.t > 0.1:
        raise KeyboardInterrupt
    return [0.0, 0.0, 0.0]


@pytest.mark.parametrize("on_error", ["raise", "stop", "neutral"])
def test_a_controller_may_be_what_is_stopped(on_error):
    with pytest.raises(KeyboardInterrupt) as stopped:
        hc.simulate(
            hc.Scenario(joints={"boom": 1.7, "jib": 1.7, "extension": 0.0}, controller=giving_up, duration=0.5),
            on_error=on_error,
        )
    assert stopped.value.run.outcome.kind == "interrupted" and "interrupted" in kinds(stopped.value.run)
    assert not any("on_error" in note for note in stopped.value.__notes__)


def test_a_study_whose_controller_is_stopped_ends():
    plan = hc.Scenario(joints={"boom": 1.7, "jib": 1.7, "extension": 0.0}, controller=giving_up, duration=0.5)
    with pytest.raises(KeyboardInterrupt):
        hc.sweep(plan, {"payload.mass": [0.0, 10.0]}, progress=False, workers=1)


def test_a_repeat_that_is_stopped_is_no_doubt_of_the_run(monkeypatch):
    begun, tightened = [], hc.Solver.tightened
    monkeypatch.setattr(hc.Solver, "tightened", lambda solver: begun.append(solver) or tightened(solver))
    monkeypatch.setattr(running, "interruptible", lambda: nullcontext(lambda: bool(begun)))
    with pytest.raises(KeyboardInterrupt, match="repeat") as stopped:
        hc.simulate(SCENARIO, verify=True, step=1e-3, duration=0.5)
    run = stopped.value.run
    assert run.outcome.completed and run.verification is None and "not-converged" not in kinds(run)


def test_sensitivities_and_what_loops_over_them_end():
    with ctrl_c(0.3), pytest.raises(KeyboardInterrupt) as stopped:
        hc.sensitivities(SCENARIO, "supply.pressure", **LONG)
    part = stopped.value.sensitivities
    assert part.outcome.kind == "interrupted" and kinds(part.run)[-1] == "interrupted"
    made = Experiment(SCENARIO, ["supply.pressure"], **LONG)
    with ctrl_c(0.3), pytest.raises(KeyboardInterrupt):
        solve(made)


def test_what_the_progress_of_sensitivities_raises_is_raised():
    def progress(reached, duration):
        raise ZeroDivisionError("no bar")

    with pytest.raises(ZeroDivisionError, match="no bar"):
        hc.sensitivities(SCENARIO, "supply.pressure", progress=progress)


def test_ctrl_c_shortly_before_the_end_of_a_run_counts():
    """The core asks every 256 steps: a run that ends before it asks again was stopped all the same."""

    def late(obs, command):
        if 0.045 < obs.t < 0.055:
            signal.raise_signal(signal.SIGINT)
        return [0.0, 0.0, 0.0]

    start = {"boom": 1.7, "jib": 1.7, "extension": 0.0}
    with pytest.raises(KeyboardInterrupt) as stopped:
        hc.simulate(hc.Scenario(joints=start, controller=late, duration=0.1))
    assert stopped.value.run.outcome.completed


def test_a_fit_ends_although_its_runs_are_short(monkeypatch):
    solved = Experiment.run

    def late(self, *given):
        made = self._core
        monkeypatch.setattr(self, "_core", Ending(made))
        return solved(self, *given)

    class Ending:
        def __init__(self, core):
            self.core = core

        def run(self, *given):
            raw = self.core.run(*given)
            signal.raise_signal(signal.SIGINT)
            return raw

    log = hc.simulate("single-cylinder-step", duration=0.5).data
    monkeypatch.setattr(Experiment, "run", late)
    with pytest.raises(KeyboardInterrupt):
        hc.fit("single-cylinder-step", log, ["supply.pressure"], duration=0.5)


def test_a_tuning_ends():
    with ctrl_c(0.5), pytest.raises(KeyboardInterrupt):
        tune("rottne-f9-lab")
