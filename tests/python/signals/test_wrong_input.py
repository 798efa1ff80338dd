"""What people get wrong about a log is told with its likeliest cause; logs of ``oracles/held_velocities.py``."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from oracles.held_velocities import RIG, made

from hydrocrane.logs import Log
from hydrocrane.signals import steady_windows


def kinds(flags):
    return {flag.kind for flag in flags}


def messages(flags, kind):
    found = [flag.message for flag in flags if flag.kind == kind]
    assert found, flags
    return "; ".join(found)


def test_exchanged_pressures():
    table = made()
    table["p1"], table["p2"] = table["p2"], table["p1"]
    text = messages(steady_windows(Log.of(table), RIG).flags, "friction-drives")
    assert "p1 and p2 exchanged" in text and "the sign of x" not in text


def test_a_wrong_sign():
    table = made()
    text = messages(steady_windows(Log.of(table | {"x": -table["x"]}), RIG).flags, "friction-drives")
    assert "the sign of x" in text and "exchanged;" not in text


def test_a_wrong_mass():
    heavy = dataclasses.replace(RIG, mass=300.0)
    text = messages(steady_windows(Log.of(made()), heavy).flags, "friction-drives")
    assert "the mass: 200" in text and "300 kg" in text


def test_a_wrong_machine():
    """Half the rod's area; and a stroke that the piston leaves."""
    other = dataclasses.replace(RIG, rod_area=0.5 * RIG.rod_area)
    flags = steady_windows(Log.of(made()), other).flags
    assert kinds(flags) & {"friction-drives", "lopsided-friction"}
    small = dataclasses.replace(RIG, stroke=(-0.05, 0.05))
    assert "its stroke is 0.1 m" in messages(steady_windows(Log.of(made()), small).flags, "wrong-unit")


def test_friction_that_is_lopsided():
    light = dataclasses.replace(RIG, mass=RIG.mass + 25.0)
    text = messages(steady_windows(Log.of(made()), light).flags, "lopsided-friction")
    assert "check mass and weight" in text
    assert "lopsided-friction" not in kinds(steady_windows(Log.of(made()), RIG).flags)


def test_exchanged_columns_of_position_and_pressure():
    table = made()
    log = Log.of(table | {"x": table["p1"], "p1": table["x"], "p2": table["x"]})
    assert log.fatal and "are the columns of `p1` and x exchanged?" in messages(log.flags, "wrong-unit")


def test_a_range_that_is_too_narrow():
    """Short clips, each of a few samples, that no single stretch would tell."""
    table = made()
    wave = 1e5 * np.sin(2 * np.pi * 3.0 * table["time"])
    table["p1"] = np.minimum(table["p1"] + wave, np.quantile(table["p1"] + wave, 0.97))
    log = Log.of(table)
    assert "widen it" in messages(log.flags, "clipped")
    top = table["p1"].max()
    np.testing.assert_array_equal(log.stuck("p1"), table["p1"] == top)
    assert not log.stuck("p2").any()


def test_a_position_sensor_that_ends_before_the_stroke_costs_only_that_end():
    """It stands exactly still there for most of the log, which must not pass for its noise."""
    table = made(speeds=(0.02, -0.02))
    wait = np.full(20000, table["x"].max())
    half = table["time"].size // 2 - 250
    rng = np.random.default_rng(5)
    longer = {name: np.insert(v, half, v[half] + rng.normal(0, 3e3, wait.size)) for name, v in table.items()}
    noisy = np.insert(table["x"], half, 0.06 + rng.normal(0, 2e-5, wait.size))
    longer |= {"time": np.arange(noisy.size) * 1e-3, "x": np.minimum(noisy, 0.06)}
    log = Log.of(longer)
    assert kinds(log.flags) == {"clipped"}
    assert [round(w.velocity, 3) for w in steady_windows(log, RIG)] == [0.02, -0.02]


def test_healthy_logs_are_not_called_clipped():
    for seed in range(20):
        table = made(seed, 1.0)
        assert "clipped" not in kinds(Log.of(table).flags)
        table["p1"] = np.round(table["p1"] / 1e4) * 1e4
        assert "clipped" not in kinds(Log.of(table).flags)


def test_a_clock_that_was_set_forward_and_samples_that_were_lost():
    table = made(speeds=(0.02, -0.02))
    jump = table | {"time": table["time"] + 2.0 * (table["time"] > 2.0)}
    assert "the clock was set" in messages(Log.of(jump).flags, "gap")
    keep = np.abs(table["time"] - 2.0) > 0.5
    lost = Log.of({name: values[keep] for name, values in table.items()})
    assert "the clock was set" not in messages(lost.flags, "gap")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t: t - 3.0 * (t > 5.0), "it goes back by up to 2.999 s: the clock was set, or several recordings"),
        (lambda t: np.round(t, 2), "times have too few digits"),
    ],
)
def test_a_clock_that_does_not_increase(change, words):
    table = made()
    log = Log.of(table | {"time": change(table["time"])})
    assert log.fatal and words in messages(log.flags, "time-not-increasing")


def test_none_of_this_is_said_of_a_healthy_log():
    assert not steady_windows(Log.of(made(seed=3)), RIG).flags
