"""Logs with missing values, signals of different rates and mains hum: what is good in them is used, and the rest told.

The logs are those of ``oracles/held_velocities.py``, whose friction is known.
"""

from __future__ import annotations

import re

import numpy as np
import pytest
from oracles.held_velocities import RIG, SPEEDS, friction, made

import hydrocrane as hc
from hydrocrane import rig
from hydrocrane.logs import Log
from hydrocrane.logs.hum import hum_of
from hydrocrane.logs.rates import own_samples
from hydrocrane.signals import friction_force, steady_windows, zero_calibrated


def kinds(flags):
    return {flag.kind for flag in flags}


def assert_friction(windows, speeds=SPEEDS, share=0.02):
    """A window at every speed with the friction that was put in."""
    for speed in speeds:
        near = [w for w in windows if abs(w.velocity - speed) < 0.1 * abs(speed)]
        assert near, f"no window at {speed}: {[r.reason for r in windows.rejected]}"
        for window in near:
            assert window.force == pytest.approx(friction(speed), rel=share, abs=5 * window.force_error)


def test_the_made_log_is_healthy():
    windows = steady_windows(Log.of(made()), RIG)
    assert_friction(windows)
    assert len(windows) == len(SPEEDS) and not windows.flags


# --- missing values -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["x", "p1", "p2"])
def test_single_missing_values_cost_no_window(name):
    """One missing value per quarter of a second: more than twenty, so that they are told in one flag."""
    table = made()
    table[name][::250] = np.nan
    log = Log.of(table)
    assert kinds(log.flags) == {"not-finite"} and len(log.flags) == 1
    assert f"misses {table[name][::250].size} values in" in log.flags[0].message
    windows = steady_windows(log, RIG)
    assert_friction(windows)
    assert len(windows) == len(SPEEDS) and not any("frozen" in r.reason for r in windows.rejected)


def test_a_long_gap_ends_its_window_and_no_other():
    table = made()
    table["p1"][8200:9200] = np.nan  # Within the third speed.
    windows = steady_windows(Log.of(table), RIG)
    assert_friction(windows)
    assert not any(w.start < 8.7 < w.end for w in windows)


def test_many_gaps_in_time_leave_the_rest():
    table = made()
    keep = np.ones(table["time"].size, dtype=bool)
    for first in range(200, keep.size, 1000):
        keep[first : first + 20] = False
    log = Log.of({name: values[keep] for name, values in table.items()})
    assert kinds(log.flags) == {"gap"}
    windows = steady_windows(log, RIG)
    assert_friction(windows, [v for v in SPEEDS if abs(v) > 1e-3], share=0.03)


def test_a_zero_is_read_across_missing_values():
    table = made(speeds=(0.02,))
    table["p1"][:500] -= table["p1"][:500].mean()
    table["p1"][100:400:50] = np.nan
    zero = zero_calibrated(Log.of(table), 0.45, signals=["p1"])
    assert abs(zero.zeros["p1"]) < 5 * zero.errors["p1"] + 500.0 and zero.errors["p1"] < 1e3


# --- rates ----------------------------------------------------------------------------------------------------------


def slowed(values, how, every=10):
    rows = np.arange(0, values.size, every)
    if how == "blank":
        out = np.full(values.size, np.nan)
        out[rows] = values[rows]
        return out
    if how == "held":
        return values[rows[np.arange(values.size) // every]]
    return np.interp(np.arange(values.size), rows, values[rows])


@pytest.mark.parametrize("how", ["blank", "held", "interpolated"])
@pytest.mark.parametrize("name", ["x", "p1"])
def test_a_slow_signal_is_told_and_used_at_its_rate(name, how):
    table = made()
    table[name] = slowed(table[name], how)
    log = Log.of(table)
    (flag,) = log.flags
    assert flag.kind == "slow-signal" and flag.signal == name
    assert "100 Hz beside 1000 Hz" in flag.message and how in flag.message
    windows = steady_windows(log, RIG)
    assert_friction(windows)
    assert len(windows) == len(SPEEDS)


@pytest.mark.parametrize("how", ["blank", "held"])
def test_errors_of_a_slow_position_are_honest(how):
    """Velocities of 20 logs scatter as their errors say: a held sample counts once."""
    off = []
    for seed in range(20):
        table = made(seed, 1.5, (0.02, -0.02))
        table["x"] = slowed(table["x"], how)
        off += [
            (w.velocity - np.sign(w.velocity) * 0.02) / w.velocity_error for w in steady_windows(Log.of(table), RIG)
        ]
    assert len(off) >= 36 and 0.5 < np.sqrt(np.mean(np.square(off))) < 1.5


def test_friction_over_time_with_a_slow_position():
    table = made(speeds=(0.02, -0.02))
    table["x"] = slowed(table["x"], "blank")
    found = friction_force(Log.of(table), RIG)
    middle = found.sel(time=2.0, method="nearest")
    assert float(middle.velocity) == pytest.approx(0.02, rel=0.02)
    assert float(middle.friction) == pytest.approx(friction(0.02), abs=5 * float(middle.friction_error))


def test_what_is_no_slow_signal():
    rng = np.random.default_rng(1)
    noise = rng.normal(size=2000)
    staircase = np.floor(np.arange(2000) / 20.0)
    assert own_samples(noise) is None
    assert own_samples(staircase) is None, "a converter in slow motion"
    assert own_samples(np.repeat(rng.normal(size=40), [100, 1000] * 20)) is None, "a pressure without noise"
    assert own_samples(np.round(noise)) is None, "a coarse converter"
    assert own_samples(np.where(rng.random(2000) < 0.5, noise, np.nan)) is None, "a loose contact"


# --- hum ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mains", [49.9, 60.1])
def test_mains_hum_is_told_and_costs_no_window(mains):
    """0.04 bar would be a velocity of 0.2 mm/s of the mass, beside 0.5 mm/s of the slowest windows."""
    table = made()
    table["p1"] = table["p1"] + 4e3 * np.sin(2 * np.pi * mains * table["time"] + 1.0)
    log = Log.of(table)
    (flag,) = log.flags
    assert flag.kind == "hum" and flag.signal == "p1"
    assert re.search(rf"carries 0\.0(39|4)\d* bar .* hum of {round(mains):g} Hz", flag.message)
    windows = steady_windows(log, RIG)
    assert_friction(windows)
    assert len(windows) == len(SPEEDS)


def test_the_least_hum_that_matters_is_seen():
    """0.02 bar, below the noise of one reading."""
    table = made()
    table["p2"] = table["p2"] + 2e3 * np.sin(2 * np.pi * 50.0 * table["time"])
    (hum,) = hum_of(table["time"], table["p2"], table["x"])
    assert hum.amplitude == pytest.approx(2e3, rel=0.1) and hum.frequency == pytest.approx(50.0, abs=0.1)
    (flag,) = Log.of(table).flags
    assert flag.kind == "hum" and flag.signal == "p2"


def test_a_vibration_at_the_frequency_of_the_mains_is_motion():
    """It comes with one velocity and is gone at the others."""
    table = made()
    shaking = (table["time"] > 0.5) & (table["time"] < 3.5)
    table["p1"] = table["p1"] + np.where(shaking, 2e4 * np.sin(2 * np.pi * 50.0 * table["time"]), 0.0)
    log = Log.of(table)
    assert not log.flags
    windows = steady_windows(log, RIG)
    assert_friction(windows, SPEEDS[1:])
    reasons = [r.reason for r in windows.rejected if r.start < 3.0 and "swings" in r.reason]
    assert reasons and "if it is mains hum" in reasons[0]


def test_a_stronger_vibration_is_not_taken_for_hum():
    table = made()
    shaking = (table["time"] > 0.5) & (table["time"] < 3.5)
    amplitude = np.where(shaking, 3e4, 2e3)
    table["p1"] = table["p1"] + amplitude * np.sin(2 * np.pi * 50.0 * table["time"])
    windows = steady_windows(Log.of(table), RIG)
    assert "hum" in kinds(windows.flags)
    assert any("swings" in r.reason for r in windows.rejected if r.start < 3.0)


def test_hum_needs_other_motion_to_be_known():
    table = made(seconds=20.0, speeds=(0.02,))
    inside = slice(1000, 20000)
    signal = table["p1"] + 4e3 * np.sin(2 * np.pi * 50.0 * table["time"])
    assert hum_of(table["time"][inside], signal[inside], table["x"][inside]) == []


# --- identification -------------------------------------------------------------------------------------------------


def test_friction_is_identified_from_uneven_logs():
    """Missing values and a held position leave every window and move Coulomb friction by less than 2 %."""
    log = rig.run("constant-velocity", levels=[0.005, 0.02, 0.05, 0.1], slips=12.0)
    missing, held = log.data.copy(deep=True), log.data.copy(deep=True)
    missing["x"][::100] = np.nan
    held["x"][:] = slowed(held["x"].values, "held", every=5)
    found = [hc.identify_friction([data], "rig-rottne") for data in (log.data, missing, held)]
    assert [len(each.windows[0]) for each in found] == [8, 8, 8]
    for each, words in zip(found[1:], ("`x` misses", "`x` was sampled at 100 Hz")):
        assert sum(words in warning for warning in each.warnings) == 1
        for name in ("coulomb.extending", "coulomb.retracting"):
            assert each.static.fit.value(name) == pytest.approx(found[0].static.fit.value(name), rel=0.02)
