"""Filters, derivatives, friction force and windows of steady motion against what is known to be true."""

from __future__ import annotations

import dataclasses
import runpy
from functools import cache
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hydrocrane as hc
from hydrocrane import rig
from hydrocrane.identification import identify_static
from hydrocrane.logs import Log, Noise, noise_of
from hydrocrane.logs.noise import noise_before_rounding, rounding_bias
from hydrocrane.signals import (
    RigParameters,
    derivative,
    friction_force,
    friction_over_velocity,
    low_pass,
    resample,
    steady_windows,
)
from hydrocrane.signals.statistics import correlation_samples, fitted_line
from hydrocrane.signals.steadiness import mean_force, motion_of

ROOT = Path(__file__).resolve().parents[3]
RIG = hc.load_machine("single-cylinder")
# Position noise, its converter's step, pressure noise, its step.
SENSORS = {
    "fine": (5e-5, 0.0, 1e4, 0.0),
    "16 bits": (5e-5, 1.25 / 65535, 1e4, 400e5 / 65535),
    "12 bits": (5e-5, 1.25 / 4095, 5e3, 400e5 / 4095),
}


@cache
def rig_run(commands, interval=0.005, start=-0.1):
    """The rig under held spool commands ((spool, duration), ...) with half a second of rest between them."""
    times, spools, now = [0.0], [0.0], 0.5
    for spool, duration in commands:
        times += [now, now + duration]
        spools += [spool, 0.0]
        now += duration + 0.5
    plan = hc.Scenario(
        machine="single-cylinder", joints={"slide": start}, commands={"test": (times, spools)}, duration=now,
        record_interval=interval,
    )  # fmt: skip
    run = hc.simulate(plan)
    assert run.outcome.kind == "completed"
    return run.data


def truth(data, name):
    return data[f"cylinder.test.{name}"].values


def measured(data, sensors="fine", seed=0, **more):
    """A run as a data logger would have it."""
    rng = np.random.default_rng(seed)
    x_noise, x_step, p_noise, p_step = SENSORS[sensors]

    def read(values, noise, step):
        values = values + rng.normal(0.0, noise, values.size)
        return np.round(values / step) * step if step else values

    table = {"time": data.time.values, "x": read(truth(data, "x"), x_noise, x_step)}
    for name in ("p1", "p2"):
        table[name] = read(truth(data, name), p_noise, p_step)
    return Log.of(table | more)


# --- noise and statistics -------------------------------------------------------------------------------------------


@settings(max_examples=40, deadline=None)
@given(sigma=st.floats(1e-6, 1e-3), ratio=st.floats(0.0, 0.5), slope=st.floats(-0.1, 0.1), seed=st.integers(0, 99))
def test_noise_is_found_under_motion(sigma, ratio, slope, seed):
    """Up to a converter's step of half the noise, the noise is known within a tenth, and so is the step."""
    step = ratio * sigma
    values = slope * np.arange(2000) * 0.005 + np.random.default_rng(seed).normal(0, sigma, 2000)
    values = np.round(values / step) * step if step > 0.05 * sigma else values
    assert noise_of(values).sigma == pytest.approx(sigma, rel=0.1)


def test_a_converter_shows_its_step():
    x = np.round(np.linspace(0, 0.05, 3000) / 3.05e-4) * 3.05e-4
    assert noise_of(x).step == pytest.approx(3.05e-4, rel=1e-6)
    assert noise_of(np.random.default_rng(0).normal(size=3000)).step == 0.0
    assert noise_of(np.zeros(3)) == Noise(0.0, 0.0)


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
def test_errors_of_means_allow_for_correlation(memory):
    """Standardised errors of the mean and the slope of correlated noise have a spread of one."""
    rng = np.random.default_rng(3)
    time, scores = np.arange(600) * 0.01, []
    for _ in range(200):
        noise = np.zeros(600)
        shocks = rng.normal(size=600)
        for k in range(1, 600):
            noise[k] = memory * noise[k - 1] + shocks[k]
        line = fitted_line(time, 5.0 + 2.0 * (time - time.mean()) + noise)
        scores.append([(line.mean - 5.0) / line.mean_error, (line.slope - 2.0) / line.slope_error])
    spread = np.std(scores, axis=0)
    assert np.all((spread > 0.8) & (spread < 1.3)), spread


def test_correlation_and_rounding():
    assert correlation_samples(np.ones(50)) == 1.0
    assert correlation_samples(np.random.default_rng(0).normal(size=5000)) < 1.3
    assert (
        rounding_bias(0.0, 0.1) == pytest.approx(0.1 / np.sqrt(12.0), rel=0.02)
        and rounding_bias(0.1, 0.1) < 1e-9
        and rounding_bias(1.0, 0.0) == 0
    )
    # The mean of a rounded reading, over all places of the true value within a step.
    rng = np.random.default_rng(1)
    places = np.linspace(0, 1, 21)[:-1]
    errors = [np.mean(np.round(p + rng.normal(0, 0.25, 20000))) - p for p in places]
    assert np.std(errors) == pytest.approx(rounding_bias(0.25, 1.0), rel=0.2)
    # And of one that changes steadily meanwhile.
    errors = [np.mean(np.round(p + np.linspace(0, 3.5, 20000))) - p - 1.75 for p in places]
    assert 0.5 * rounding_bias(0.0, 1.0, 3.5) < np.std(errors) < 1.1 * rounding_bias(0.0, 1.0, 3.5)


def rounded(places, noise, rng, samples=1500):
    """Readings of a signal that stands at some places within steps of one, (places * samples,)."""
    return np.round(np.repeat(places, samples) + rng.normal(0, noise, len(places) * samples))


def test_noise_before_a_converter_wherever_the_signal_stands():
    """Neither a long stay in the middle of a code, where no reading differs, nor one at its edge misleads."""
    rng = np.random.default_rng(4)
    for stay in (0.0, 0.5):
        places = np.concatenate([np.full(20, stay), np.arange(12) + rng.uniform(0, 1, 12)])
        found = noise_before_rounding(rounded(places, 0.35, rng))
        assert found.step == 1.0 and found.sigma == pytest.approx(0.35, rel=0.15)
    assert noise_before_rounding(rounded(np.arange(12) + 0.2, 0.02, rng)) == Noise(0.0, 1.0)
    plain = rng.normal(size=3000)
    assert noise_before_rounding(plain) == noise_of(plain) and noise_before_rounding(plain[:20]).sigma > 0.3


@pytest.mark.parametrize("noise", [0.05, 0.25, 0.33])
def test_means_of_rounded_readings_are_as_far_off_as_stated(noise):
    """Over all places within a step: no error is stated that is not there, and none is missing."""
    rng, off, stated = np.random.default_rng(5), [], []
    time = np.arange(1500) * 0.02
    for _ in range(25):
        places = np.arange(16) + rng.uniform(0, 1, 16)
        readings = rounded(places, noise, rng)
        known = noise_before_rounding(readings)
        for place, values in zip(places, readings.reshape(16, -1)):
            mean, error, _ = mean_force(time, values, [(values, known, 1.0)])
            off.append(mean - place)
            stated.append(error)
    assert np.std(off) == pytest.approx(np.sqrt(np.mean(np.square(stated))), rel=0.25)


@pytest.mark.parametrize(("noise", "least"), [(0.0, 0.5), (0.16, 0.83)])
def test_velocities_of_rounded_positions_are_as_far_off_as_stated(noise, least):
    """A slow piston crosses the steps of a converter whose noise neighbouring samples do not show.

    The last, broken crossing is taken at its worst; without noise nothing makes the staircase random.
    """
    rng, scores = np.random.default_rng(6), []
    time = np.arange(3000) * 0.02
    for _ in range(200):
        speed = rng.uniform(0.2, 0.6)
        x = np.round(rng.uniform(0, 1) + speed * time + rng.normal(0, noise, time.size))
        found = motion_of(time, x, Noise(0.0, 1.0))
        scores.append((found.velocity - speed) / found.error)
    assert least < np.std(scores) < 1.1


# --- filters --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("zero_phase", [True, False])
@pytest.mark.parametrize("order", [1, 2, 4, 8])
def test_the_filter_loses_three_decibels_at_its_cutoff(zero_phase, order):
    rate, cutoff = 1000.0, 10.0
    t = np.arange(8000) / rate
    wave = np.sin(2 * np.pi * cutoff * t)
    out = low_pass(wave, rate, cutoff, order=order, zero_phase=zero_phase)
    middle = slice(2000, 6000)
    assert np.sqrt(2) * np.std(out[middle]) == pytest.approx(np.sqrt(0.5), rel=0.01)
    delayed = np.corrcoef(out[middle], wave[middle])[0, 1]
    assert delayed > 0.9999 if zero_phase else delayed < 0.95


def test_the_phase_norm_has_half_of_its_final_phase_at_the_cutoff():
    """Order 4: 180 degrees of 360, so that the wave comes out upside down."""
    t = np.arange(8000) / 1000.0
    wave = np.sin(2 * np.pi * 10.0 * t)
    out = low_pass(wave, 1000.0, 10.0, order=4, zero_phase=False, norm="phase")
    assert np.corrcoef(out[4000:], wave[4000:])[0, 1] < -0.99


def test_a_bessel_filter_does_not_overshoot():
    step = np.repeat([0.0, 1.0], 500)
    assert low_pass(step, 1000.0, 10.0, zero_phase=False).max() < 1.01


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"cutoff": 500.0}, "0.4 of the rate"),
        ({"cutoff": 0.0}, "cutoff must be"),
        ({"order": 11}, "1 to 10"),
        ({"norm": "phase"}, "no meaning without phase"),
        ({"norm": "fase"}, "did you mean `phase`"),
    ],
)
def test_wrong_filters(arguments, words):
    with pytest.raises(hc.InputError, match=words):
        low_pass(np.zeros(100), 1000.0, **({"cutoff": 10.0} | arguments))


# --- derivatives ----------------------------------------------------------------------------------------------------


@settings(max_examples=30, deadline=None)
@given(a=st.floats(-1, 1), b=st.floats(-1, 1), c=st.floats(-1, 1))
def test_a_parabola_is_differentiated_exactly(a, b, c):
    t = np.arange(200) * 0.01
    x = a + b * t + c * t * t
    noise = Noise(1e-9, 0.0)
    np.testing.assert_allclose(derivative(x, 100.0, noise=noise).value, b + 2 * c * t, atol=1e-7)
    np.testing.assert_allclose(derivative(x, 100.0, 2, noise=noise).value, 2 * c, atol=1e-5)


@pytest.mark.evidence
def test_the_derivative_in_use_is_never_far_from_the_best(monkeypatch):
    """Each fixed filter fails some motion by a factor that the grown window does not know; and it is honest."""
    monkeypatch.syspath_prepend(ROOT / "docs/validation")
    bench = runpy.run_path(str(ROOT / "docs/validation/derivative.py"))
    for sensor in bench["SENSORS"]:
        table = bench["compared"](sensor, seeds=1)
        best = {m: min(row[m] for row in table.values()) for m in bench["motions"]()}
        worst = {name: max(row[m] / best[m] for m in best) for name, row in table.items()}
        assert worst.pop("grown window (used)") < 5.0 and min(worst.values()) > 8.0, worst
        assert min(bench["honesty"](sensor, seeds=1).values()) > 0.8


@pytest.mark.parametrize(
    ("values", "rate", "order", "words"),
    [
        ([0.0, 1.0], 1.0, 1, "at least 7"),
        (np.zeros(50), 0.0, 1, "positive"),
        (np.zeros(50), 1.0, 3, "order"),
        ([np.nan] * 9, 1.0, 1, "finite"),
    ],
)
def test_wrong_derivatives(values, rate, order, words):
    with pytest.raises(hc.InputError, match=words):
        derivative(values, rate, order)


# --- resampling -----------------------------------------------------------------------------------------------------


def test_resampling_keeps_gaps_empty():
    time = np.delete(np.arange(400) * 0.01, slice(100, 150))
    log = resample(Log.of({"time": time, "x": 3.0 * time}), 200.0)
    np.testing.assert_allclose(np.diff(log.time), 0.005)
    gap = (log.time > 0.99 + 1e-9) & (log.time < 1.5 - 1e-9)
    assert np.isnan(log["x"][gap]).all()
    np.testing.assert_allclose(log["x"][~gap], 3.0 * log.time[~gap], atol=1e-12)
    assert "not-finite" in {flag.kind for flag in log.flags}
    full = resample(Log.of({"time": time, "x": 3.0 * time}), 200.0, longest_gap=1.0)
    np.testing.assert_allclose(full["x"], 3.0 * full.time, atol=1e-12)


def test_a_lower_rate_does_not_fold():
    time = np.arange(4000) * 0.001
    hum = Log.of({"time": time, "x": 0.1 * time + 0.01 * np.sin(2 * np.pi * 95 * time)})
    slow = resample(hum, 100.0)
    assert np.abs(slow["x"] - 0.1 * slow.time)[20:-20].max() < 1e-4
    with pytest.raises(hc.InputError, match="rate must be"):
        resample(hum, -1.0)


# --- friction force -------------------------------------------------------------------------------------------------


def test_parameters_of_the_rig():
    rig = RigParameters.of(RIG)
    assert rig.mass == pytest.approx(115 + 5.173) and rig.gravity == pytest.approx(9.81)
    assert rig.piston_area == pytest.approx(np.pi / 4 * 0.05**2)
    assert RigParameters.of(RIG, payload=100.0).mass == pytest.approx(rig.mass + 100.0)
    with pytest.raises(hc.InputError, match="one cylinder"):
        RigParameters.of(hc.load_machine("rottne-f9-lab"))
    with pytest.raises(hc.InputError, match="piston_area"):
        RigParameters(-1.0, 1.0, 1.0)


def test_friction_force_of_a_clean_log_is_that_of_the_model():
    """(118) with - m x'': acceleration at the starts, where the printed sign would be off by thousands of newtons."""
    data = rig_run(((0.02, 0.5), (-0.02, 0.5)), 0.0005, 0.0)
    log = Log.of({"time": data.time.values} | {name: truth(data, name) for name in ("x", "p1", "p2")})
    found = friction_force(log, RIG)
    error = found["friction"].values - truth(data, "friction")
    wrong = error + 2 * RigParameters.of(RIG).mass * found["acceleration"].values
    assert np.sqrt(np.mean(error**2)) < 10.0 < 0.2 * np.sqrt(np.mean(wrong**2))


def test_friction_force_knows_its_uncertainty():
    """Away from the jumps of the valve, whose ringing of some micrometres no potentiometer sees."""
    data = rig_run(((0.01, 2.0), (-0.02, 2.0)))
    found = friction_force(measured(data), RIG)
    time = data.time.values
    calm = ((time > 1.3) & (time < 2.4)) | ((time > 3.4) & (time < 4.9))
    for name, true in (("velocity", truth(data, "v")), ("friction", truth(data, "friction"))):
        within = np.abs(found[name] - true) <= 2 * found[f"{name}_error"]
        assert float(within[calm].mean()) > 0.9, name
    gapped = measured(data)
    gapped.data["p1"][300:320] = np.nan
    assert np.isnan(friction_force(Log.of(gapped.data), RIG)["friction"][300:320]).all()


def test_a_load_cell_makes_mass_and_acceleration_needless():
    data = rig_run(((0.02, 0.5), (-0.02, 0.5)), 0.0005, 0.0)
    signals = {"time": data.time.values} | {name: truth(data, name) for name in ("x", "p1", "p2", "force")}
    found = friction_force(Log.of(signals), RIG, load_cell=True)
    np.testing.assert_allclose(found["friction"], truth(data, "friction"), atol=1e-6)
    with pytest.raises(hc.InputError, match="no signal `force`"):
        friction_force(Log.of({k: v for k, v in signals.items() if k != "force"}), RIG, load_cell=True)


# --- windows --------------------------------------------------------------------------------------------------------

STAIRS = ((0.0015, 14.0), (0.01, 3.0), (0.03, 2.0), (-0.003, 12.0), (-0.01, 3.0), (-0.04, 2.0))


def scores(found, data):
    """(velocity, friction) of each window against the run's means over it, in standard errors."""
    rows = []
    for w in found:
        inside = (data.time.values >= w.start) & (data.time.values <= w.end)
        v, f = truth(data, "v")[inside].mean(), truth(data, "friction")[inside].mean()
        rows.append([(w.velocity - v) / w.velocity_error, (w.force - f) / w.force_error])
    return np.array(rows)


@pytest.mark.parametrize("sensors", SENSORS)
@pytest.mark.parametrize("with_command", [True, False])
def test_windows_of_a_staircase(sensors, with_command):
    """One window per command, its velocity and friction within their errors, and its friction on the true map."""
    data = rig_run(STAIRS)
    more = {"command": truth(data, "command")} if with_command else {}
    found = steady_windows(measured(data, sensors, **more), RIG)
    assert [w.direction for w in found] == [1, 1, 1, -1, -1, -1]
    assert np.abs(scores(found, data)).max() < 4.0
    for w in found:
        assert w.samples >= w.effective_samples > 1 and w.end - w.start >= 0.2
        assert w.force == pytest.approx(float(RIG.friction_map(w.velocity)), rel=0.02, abs=4 * w.force_error)
    v, force, error = friction_over_velocity(found)
    assert (np.diff(v) > 0).all() and (force * v > 0).all() and (error > 0).all()
    assert found[0] in found and len(found[1:3]) == 2


@pytest.mark.parametrize("sensors", SENSORS)
def test_errors_of_windows_are_honest(sensors):
    data = rig_run(STAIRS)
    all_scores = np.concatenate([scores(steady_windows(measured(data, sensors, seed), RIG), data) for seed in range(5)])
    spread = np.sqrt(np.mean(all_scores**2, axis=0))
    assert (spread < 1.7).all() and (spread > 0.2).all(), spread


@pytest.mark.parametrize("sensors", SENSORS)
def test_a_tenth_of_a_millimetre_per_second(sensors):
    data = rig_run(((7.5e-5, 600.0),), 0.02)
    (window,) = steady_windows(measured(data, sensors), RIG)
    assert window.velocity == pytest.approx(1e-4, rel=0.05)
    assert np.abs(scores([window], data)).max() < 4.0
    assert window.force == pytest.approx(float(RIG.friction_map(window.velocity)), rel=0.01)


def test_a_tenth_of_a_metre_per_second():
    data = rig_run(((0.05, 1.5),), 0.002, -0.15)
    (window,) = steady_windows(measured(data), RIG)
    assert window.velocity > 0.06 and abs(scores([window], data)[0, 1]) < 4.0


def test_what_has_not_settled_is_left_out():
    """Three seconds at 2.4 mm/s are 7 mm, during which friction still climbs."""
    found = steady_windows(measured(rig_run(((0.002, 3.0),), start=0.0)), RIG)
    assert not len(found)
    assert any("settles" in r.reason for r in found.rejected)
    assert "no-window" in {flag.kind for flag in found.flags}


def test_hunting_is_left_out():
    """On the falling branch of the map the rig swings between 3 and 7 mm/s; its mean friction is not on the map."""
    data = rig_run(((0.0015, 14.0), (0.004, 8.0)))
    v = truth(data, "v")[3400:4400]
    assert np.ptp(v) > 0.5 * np.mean(v)
    found = steady_windows(measured(data), RIG)
    assert (
        len(found) == 1
        and found[0].end < 15.0
        and any("swings" in r.reason and "Hz" in r.reason for r in found.rejected)
    )


def test_a_frozen_pressure_spoils_its_windows_only():
    data = rig_run(STAIRS)
    log = measured(data)
    frozen = log.data.copy(deep=True)
    inside = slice(int(16.0 / 0.005), int(17.5 / 0.005))
    frozen["p1"][inside] = float(frozen["p1"][inside.start])
    whole, rest = steady_windows(log, RIG), steady_windows(Log.of(frozen), RIG)
    assert any("frozen" in r.reason for r in rest.rejected)
    assert not any(w.start < 17.49 and w.end > 16.0 for w in rest)
    assert [w.velocity for w in rest][-4:] == pytest.approx([w.velocity for w in whole][-4:], rel=1e-2)


def flags_of(found):
    return {flag.kind: flag.message for flag in found.flags}


def test_what_a_set_of_windows_lacks_is_said():
    slow = flags_of(steady_windows(measured(rig_run(((0.01, 3.0),))), RIG))
    assert "one velocity level extending" in slow["few-levels"] and "retracting" in slow["one-direction"]
    assert set(flags_of(steady_windows(measured(rig_run(STAIRS)), RIG))) <= {"unsettled"}


def test_windows_before_the_bristles_have_settled_are_flagged():
    """A level of two slips and one of twelve; without bristles in the rig's file nothing is known of slips."""
    slip = RigParameters.of("rig-rottne").slip
    assert slip == pytest.approx(400.0 / 1.1e5)
    for slips, flagged in ((2.5, True), (12.0, False)):
        log = rig.run("constant-velocity", levels=[0.002, 0.005], slips=slips, least=1e-3, sensors="ideal").data
        found = steady_windows(log, "rig-rottne")
        assert len(found) > 2 and ("unsettled" in flags_of(found)) is flagged
        assert all(w.before >= min(0.5 * slips, 5.0) * slip for w in found)
    bare = dataclasses.replace(RigParameters.of("rig-rottne"), slip=0.0)
    assert "unsettled" not in flags_of(steady_windows(log, bare, settle_travel=0.5 * slip))


def test_exchanged_pressures_and_wrong_scales_are_suspected():
    log = measured(rig_run(STAIRS))
    swapped = Log.of({"time": log.time, "x": log["x"], "p1": log["p2"], "p2": log["p1"]})
    assert "exchanged" in flags_of(steady_windows(swapped, RIG)).get("friction-drives", "")
    longer = Log.of({"time": log.time, "x": log["x"] * 10.0, "p1": log["p1"], "p2": log["p2"]})
    assert "stroke" in flags_of(steady_windows(longer, RIG))["wrong-unit"]


def test_an_unmoving_piston_has_no_windows():
    data = rig_run(((0.01, 3.0),))
    log = measured(data)
    x = np.random.default_rng(0).normal(0, 5e-5, log.time.size)
    still = Log.of({"time": log.time, "x": x, "p1": log["p1"], "p2": log["p2"]})
    found = steady_windows(still, RIG)
    assert not len(found) and {"unmoving", "no-window"} <= set(flags_of(found))


def test_windows_refuse_what_is_fatal_or_senseless():
    log = measured(rig_run(((0.01, 3.0),)))
    with pytest.raises(hc.InputError, match="in bar"):
        steady_windows(Log.of({"time": log.time, "x": log["x"], "p1": log["p1"] / 1e5, "p2": log["p2"] / 1e5}), RIG)
    with pytest.raises(hc.InputError, match="no signal `p1`"):
        steady_windows(Log.of({"time": log.time, "x": log["x"]}), RIG)
    with pytest.raises(hc.InputError, match="least_duration"):
        steady_windows(log, RIG, least_duration=0.0)
    with pytest.raises(hc.InputError, match="settle_travel"):
        steady_windows(log, RIG, settle_travel=-1.0)


def test_settle_travel_is_left_out_where_it_is_known():
    log = measured(rig_run(((0.01, 3.0),)))
    (usual,) = steady_windows(log, RIG, settle_travel=0.0)
    (later,) = steady_windows(log, RIG, settle_travel=0.02)
    assert later.start - 0.5 > 0.02 / later.velocity * 0.95 and later.start > usual.start


def test_windows_show_themselves():
    found = steady_windows(measured(rig_run(STAIRS)), RIG)
    text = found.summary()
    assert text.count("+-") == 2 * len(found) and "left out" in text
    fig = found.plot()
    assert len(fig.axes) == 4
    plt.close(fig)
    plt.close(steady_windows(measured(rig_run(((0.002, 3.0),), start=0.0)), RIG).plot())


def test_windows_take_what_is_at_hand():
    """A log of the virtual rig and the name of its machine will do, and only stretches with a length are left out."""
    log = rig.run("constant-velocity", levels=[0.02, 0.05], calibration=0.5, sensors="ideal")
    found = steady_windows(log, "rig-rottne")
    built = steady_windows(Log.of(log.data), RigParameters.of(hc.load_machine("rig-rottne")))
    assert len(found) == 4 and found.windows == built.windows
    assert all(rejected.end > rejected.start for rejected in found.rejected)
    stage = identify_static(found)
    assert stage.rejected_windows == found.rejected


def test_a_zero_error_that_makes_friction_drive_is_named():
    """0.9 bar are 177 N: more than the 163 N at 5 mm/s, less than friction at the other velocities."""
    log = rig.run("constant-velocity", levels=[0.002, 0.005, 0.02, 0.1], slips=12.0, sensors="ideal")
    readings = log.data.copy()
    assert not steady_windows(readings, "rig-rottne").flags
    readings["p1"] -= 0.9e5
    (flag,) = steady_windows(readings, "rig-rottne").flags
    assert flag.kind == "friction-drives"
    assert "1 of 4 windows extending" in flag.message and "zeros of the pressure sensors" in flag.message
