"""Hysteresis of the pilot stage: the loop by hand, the same by every way that commands take, wrong values."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.errors import MachineFileError

STROKE, SHARE = 0.05, 0.08
PLAY = 0.5 * SHARE * STROKE
POSE = np.radians([100.0, 100.0, 0.0])
TIMES, VALUES = [0.0, 0.2, 0.4, 0.5, 0.6], [0.0, 0.02, -0.01, -0.008, -0.009]


def crane(share=SHARE):
    return hc.load_machine("rottne-f9-lab", {"valve.lift.command.hysteresis": share})


def test_a_run_records_what_the_spool_follows():
    scenario = hc.Scenario(
        machine=crane(),
        joints=dict(zip(("boom", "jib", "extension"), POSE, strict=True)),
        commands={"lift": hc.Command(TIMES, VALUES, "linear")},
        duration=0.7,
        record_interval=0.01,
    )
    run = hc.simulate(scenario, rtol=1e-8)
    time, followed = run.data["time"].values, run.data["cylinder.lift.command"].values
    given = np.interp(time, TIMES, VALUES)
    # Up by 20 mm, down to -10 mm, and then cycles of 2 mm within a loop of 4 mm, which do not move the spool.
    up, down = np.maximum(given - PLAY, 0.0), np.maximum(given + PLAY, -0.01 + PLAY)
    by_hand = np.where(time <= 0.2, up, np.minimum(0.02 - PLAY, down))
    by_hand[time > 0.4] = -0.01 + PLAY
    np.testing.assert_allclose(followed, by_hand, atol=1e-12)
    spool = run.data["cylinder.lift.xs"].values
    assert abs(spool[-1] - (-0.01 + PLAY)) < 1e-6


def test_program_batch_and_schedule_move_the_spool_alike():
    held = hc.Command(np.arange(60) * 0.01, np.interp(np.arange(60) * 0.01, TIMES, VALUES), "hold")
    scenario = hc.Scenario(
        machine=crane(),
        joints=dict(zip(("boom", "jib", "extension"), POSE, strict=True)),
        commands={"lift": held},
        duration=0.6,
        record_interval=0.01,
    )
    run = hc.simulate(scenario, rtol=1e-8)
    alone = hc.Simulator(crane(), rtol=1e-8, sample_time=0.01)
    batch = hc.BatchSimulator(crane(), 2, sample_time=0.01, tolerance=1e-4)
    alone.reset(q=POSE)
    batch.reset(q=POSE)
    names = list(crane().state_names)
    xs, q = names.index("cylinder.lift.xs"), names.index("joint.boom.q")
    for i in range(60):
        u = np.array([np.interp(i * 0.01, TIMES, VALUES), 0.0, 0.0])
        alone.step(u)
        batch.step(np.stack([u, -u]))
        assert abs(alone.state[xs] - run.data["cylinder.lift.xs"].values[i + 1]) < 1e-7
        assert abs(batch.state[0, xs] - alone.state[xs]) < 5e-5
        assert abs(batch.state[1, xs] + alone.state[xs]) < 5e-5
    assert abs(alone.state[q] - run.data["joint.boom.q"].values[-1]) < 1e-6


def test_a_batch_forgets_the_loop_when_it_is_reset():
    batch = hc.BatchSimulator(crane(), 1, sample_time=0.01)
    batch.reset(q=POSE)
    for _ in range(5):
        batch.step(np.array([[0.02, 0.0, 0.0]]))
    batch.reset(q=POSE)
    for _ in range(5):
        batch.step(np.array([[0.5 * PLAY, 0.0, 0.0]]))
    assert batch.state[0, list(crane().state_names).index("cylinder.lift.xs")] == 0.0


def test_without_hysteresis_nothing_changes():
    bits = [
        hc.simulate("vertical-lift-open-loop", overrides=more).data["tip.z"].values
        for more in ({}, {"valve.lift.command.hysteresis": 0.0})
    ]
    np.testing.assert_array_equal(*bits)


@pytest.mark.parametrize(("share", "words"), [(1.0, "as wide as the stroke"), (-0.01, "must"), ("3 mm", "number")])
def test_a_loop_that_cannot_be_is_refused(share, words):
    with pytest.raises(MachineFileError) as error:
        crane(share)
    assert "hysteresis" in str(error.value) and words in str(error.value), str(error.value)
