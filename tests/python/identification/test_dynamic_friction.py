"""Bristle stiffness and damping from logs: readings, exact slopes, the fit on a virtual rig, and what must not pass."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.signal import lfilter

import hydrocrane as hc
from hydrocrane import rig
from hydrocrane.errors import InputError
from hydrocrane.identification import Report, expected, first_readings, fit_dynamic, solve
from hydrocrane.identification.bristles import readings as bristle
from hydrocrane.identification.bristles.model import Blocks, RigLogModel, RigResiduals, corners, lagged
from hydrocrane.identification.bristles.readings import (
    BEST_FITTED,
    DYNAMIC,
    PistonMotion,
    map_prior,
    most_damping,
    rig_map,
    unknowns_of,
)
from hydrocrane.identification.sensors import RigSensors
from hydrocrane.identification.solve import JointPrior, Unknown
from hydrocrane.identification.static.result import Spread, StaticFit
from hydrocrane.logs import Log
from hydrocrane.signals import zero_calibrated

pytestmark = pytest.mark.evidence

# A ramp that takes seconds in place of minutes.
RAMP = {"speed": 1.0, "interval": 1e-3}
CRANE = hc.load_machine("rig-rottne")
TRUE = {name: CRANE.value(f"friction.test.{name}").si for name in DYNAMIC}
LAW = rig_map(CRANE)


def log_of(data: xr.Dataset, lead: float = 0.0) -> Log:
    """A rig's readings after `lead` seconds of calibration, whose mean is the zero of the pressures."""
    log = Log.of(data, source=data.attrs["experiment"])
    return zero_calibrated(log, lead, signals=("p1", "p2")).log if lead else log


@pytest.fixture(scope="module")
def logs() -> tuple[Log, Log]:
    """A ramp and a step of one seed."""
    how = {"seed": 4, "calibration": 1.0}
    step = rig.run("step", CRANE, **how)
    return log_of(rig.run("ramp", CRANE, **how, **RAMP).data, 1.0), log_of(step.data, 1.0)


@pytest.fixture(scope="module")
def fit(logs):
    return fit_dynamic([logs[0]], [logs[1]], CRANE, calibrated=True)


def motion(law, stiffness, damping, velocity, duration, samples=8000) -> PistonMotion:
    """A motion of bristles computed here, by small steps of (116), (119)."""
    time = np.linspace(0.0, duration, samples)
    v = velocity(time)
    seal, h = np.abs(bristle.dry(law).force(np.where(v == 0, 1e-12, v))), time[1]
    z = np.zeros(samples)
    for k in range(samples - 1):
        # Midpoint rule.
        half = z[k] + 0.5 * h * (v[k] - stiffness * abs(v[k]) / seal[k] * z[k])
        vm, gm = 0.5 * (v[k] + v[k + 1]), 0.5 * (seal[k] + seal[k + 1])
        z[k + 1] = z[k] + h * (vm - stiffness * abs(vm) / gm * half)
    rate = v - stiffness * np.abs(v) / seal * z
    x = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * h)])
    return PistonMotion("made", time, x, v, stiffness * z + damping * rate + bristle.viscous(law, v))


# --- readings -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_readings_of_exact_motions_are_exact(way):
    """Ramp (123)-(126) without damping, as the thesis supposes; step (127) with it."""
    slow = motion(LAW, 1.1e5, 0.0, lambda t: way * 2e-6 * t, 60.0)
    assert bristle.stiffness(slow, LAW).value == pytest.approx(1.1e5, rel=5e-3)
    fast = motion(LAW, 1.1e5, 754.0, lambda t: way * 0.01 * np.minimum(t / 0.005, 1.0), 0.1)
    assert bristle.damping(fast, LAW, 1.1e5).value == pytest.approx(754.0, rel=0.02)


def test_deflection_of_a_ramp_of_force_is_equation_125_with_erratum_e18():
    """F = c t with g = alpha_0 + alpha_1: x - c/(alpha_0 + alpha_1) (x t - int x dt); the printed form is not."""
    law = type(LAW).of({"coulomb": 400.0, "breakaway": 400.0, "stribeck-velocity": 2e-3, "viscous": 0.0})
    time = np.linspace(0.0, 10.0, 2001)
    x, c = 1e-5 * time**3, 20.0
    found = bristle.without_slip(law, PistonMotion("made", time, x, 3e-5 * time**2, c * time))
    area = np.concatenate([[0.0], np.cumsum(0.5 * (x[1:] + x[:-1]) * time[1])])
    assert found == pytest.approx(x - c / 400.0 * (x * time - area), abs=1e-7)
    printed = x - c / 800.0 * (x * time + area)
    assert np.abs(found - printed).max() > 1e-4


def test_readings_of_a_log_cover_both_directions(logs):
    readings, warnings = first_readings([logs[0]], [logs[1]], CRANE)
    assert [len(found) for found in readings.values()] == [2, 8] and not warnings
    for reading in readings["bristle-stiffness"].values():
        assert reading.value == pytest.approx(TRUE["bristle-stiffness"], rel=0.3)


# --- the model of a log ---------------------------------------------------------------------------------------------


def test_a_block_of_a_parabola_has_its_mean():
    time = np.arange(0.0, 4.0, 1e-3)
    blocks = Blocks.of(time, np.array([0.0, 1.2345]))

    def parabola(t):
        return 3.0 - 2.0 * t + 0.7 * t**2

    assert blocks.count.sum() == time.size and len(blocks.nodes) < time.size / 3
    assert blocks.mean_of_nodes(parabola(blocks.nodes)) == pytest.approx(blocks.mean(parabola(time)), rel=1e-12)
    assert 1235 in blocks.first and 1 in blocks.count


def test_corners_between_samples_are_found_again():
    t, u = np.array([0.0, 0.5003, 0.5053, 1.2, 1.2049, 2.0]), np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0])
    time = np.arange(0.0, 2.0005, 1e-3)
    found = corners(time, np.interp(time, t, u), 1e-5)
    assert found[0] == pytest.approx(t, abs=1e-9) and found[1] == pytest.approx(u, abs=1e-9)


def test_the_lag_of_a_ramp_is_exact_on_uneven_times():
    time = np.sort(np.random.default_rng(1).uniform(0.0, 0.1, 300))
    time -= time[0]
    assert lagged(time, 5.0 * time, 0.01) == pytest.approx(
        5.0 * (time - 0.01 * (1.0 - np.exp(-time / 0.01))), abs=1e-12
    )


def test_slopes_of_the_residuals_are_those_of_differences(logs):
    """Of every unknown, nuisances too, at a point away from the file."""
    sensors = RigSensors.of(CRANE, calibrated=True)
    keys, nuisances = unknowns_of(CRANE, logs[1:], sensors, dict.fromkeys(DYNAMIC, ()), None)
    unknowns = [*keys, *nuisances]
    model = RigLogModel(logs[1].between(1.0, 2.6), CRANE, sensors, payload=None, keys=[u.name for u in keys])
    residuals = RigResiduals([model])
    theta = np.array([u.start + 0.1 * u.scale for u in unknowns])
    _, slopes = residuals(theta)
    for i, unknown in enumerate(unknowns):
        step = np.zeros(theta.size)
        step[i] = 0.02 * unknown.scale
        difference = (residuals(theta + step)[0] - residuals(theta - step)[0]) / 0.04
        expected_slope = slopes[:, i] * unknown.scale
        size = np.sqrt(np.mean(expected_slope**2))
        # The solver's own tolerance limits differences of small effects.
        assert np.sqrt(np.mean((difference - expected_slope) ** 2)) < 0.02 * size + 0.05, unknown.name


# --- the fit --------------------------------------------------------------------------------------------------------


def test_a_straight_line_is_fitted_with_the_textbook_covariance():
    x = np.linspace(0.0, 1.0, 50)
    y = 2.0 + 3.0 * x + 0.1 * np.random.default_rng(0).normal(size=50)
    jacobian = np.stack([np.ones(50), x], axis=-1) / 0.1
    unknowns = [Unknown("a", 0.0, 1.0), Unknown("b", 0.0, 10.0, prior=(2.0, 0.5))]
    found = solve.fit(unknowns, lambda t: (jacobian @ t - y / 0.1, jacobian))
    information = jacobian.T @ jacobian + np.diag([0.0, 4.0])
    mean = np.linalg.solve(information, jacobian.T @ y / 0.1 + [0.0, 8.0])
    assert found.values == pytest.approx(mean, rel=1e-6)
    assert found.bound == pytest.approx(np.linalg.inv(information), rel=1e-6)
    assert found.variance == pytest.approx(1.0, abs=0.5)
    low = [unknowns[0], Unknown("b", 0.5, 1.0, bounds=(0.0, 1.0))]
    bounded = solve.fit(low, lambda t: (jacobian @ t - y / 0.1, jacobian))
    assert bounded.at_bound == ("b",)


def test_a_joint_prior_counts_as_the_data_that_it_came_from():
    """A line fitted to both halves of its points is that of one half with the other as a prior."""
    x = np.linspace(0.0, 1.0, 40)
    y = 2.0 + 3.0 * x + 0.1 * np.random.default_rng(1).normal(size=40)
    jacobian, target = np.stack([np.ones(40), x], axis=-1) / 0.1, y / 0.1
    first, second = slice(0, 20), slice(20, 40)
    covariance = np.linalg.inv(jacobian[first].T @ jacobian[first])
    joint = JointPrior(("a", "b"), covariance @ jacobian[first].T @ target[first], covariance)
    unknowns = [Unknown("b", 0.0, 10.0), Unknown("a", 0.0, 1.0)]

    def later(theta):
        return jacobian[second] @ theta[::-1] - target[second], jacobian[second][:, ::-1]

    found = solve.fit(unknowns, later, joint=joint)
    whole = np.linalg.lstsq(jacobian, target)[0]
    assert found.values[::-1] == pytest.approx(whole, rel=1e-6)
    assert found.bound[::-1, ::-1] == pytest.approx(np.linalg.inv(jacobian.T @ jacobian), rel=1e-6)
    deviation = solve.bound(unknowns, later, joint=joint)
    assert deviation["a"] == pytest.approx(np.sqrt(found.bound[1, 1]), rel=1e-6)


def test_what_a_joint_prior_holds_equal_stays_equal():
    """A covariance without inverse says that a difference is known, not that nothing is."""
    joint = JointPrior(("a", "b"), np.array([1.0, 1.0]), np.full((2, 2), 4.0))
    found = solve.fit(
        [Unknown("a", 1.0, 1.0), Unknown("b", 1.0, 1.0)],
        lambda t: (np.array([(t[0] - 3.0) / 0.1]), np.array([[10.0, 0.0]])),
        joint=joint,
    )
    assert found["a"] == pytest.approx(3.0, abs=0.01) and found["b"] == pytest.approx(found["a"], abs=1e-3)
    for mean, covariance in ((np.ones(1), np.eye(2)), (np.ones(2), np.diag([1.0, np.inf]))):
        with pytest.raises(InputError, match="joint prior of 2 unknowns"):
            JointPrior(("a", "b"), mean, covariance)


def static_fit(labels, covariance) -> StaticFit:
    """The file's own map with a covariance."""
    spread = Spread(
        labels, covariance, np.zeros_like(covariance), covariance, np.zeros((len(labels), 0)), 20.0, 1.0, 1.0
    )
    return StaticFit(None, LAW, spread=spread)  # type: ignore[arg-type]


def test_the_map_goes_along_with_all_of_its_covariance(logs):
    """Correlations too, free exponents too; what it could not identify is known as without a fit."""
    labels = ("coulomb.extending", "breakaway.extending", "viscous-exponent.extending", "viscous.extending", "offset")
    deviation, correlation = np.array([20.0, 20.0, 0.2, 1.0, 5.0]), np.eye(5)
    correlation[0, 1] = correlation[1, 0] = -0.9
    covariance = correlation * np.outer(deviation, deviation)
    covariance[3, 3] = np.inf
    prior = map_prior(CRANE, logs, static_fit(labels, covariance))
    assert prior is not None
    assert prior.names == tuple(f"friction.test.{n}[0]" for n in ("coulomb", "breakaway", "viscous-exponent"))
    assert prior.mean == pytest.approx([160.0, 340.0, 1.5])
    assert prior.covariance[0, 1] == pytest.approx(-360.0)
    assert prior.deviations == pytest.approx(np.hypot([20.0, 20.0, 0.2], BEST_FITTED * prior.mean))
    sensors = RigSensors.of(CRANE, calibrated=True)
    keys, _ = unknowns_of(CRANE, logs, sensors, dict.fromkeys(DYNAMIC, ()), prior)
    own = {u.name: u.prior for u in keys}
    assert all(own[name] is None for name in prior.names)
    assert own["friction.test.viscous[0]"] == (8000.0, 800.0) and "friction.test.viscous-exponent[1]" not in own


def test_one_rig_with_its_sensors_comes_back(fit):
    """Within 10 % and 25 %, inside the intervals; the full study is docs/validation/dynamic_friction.py."""
    for name, bound in (("bristle-stiffness", 0.10), ("bristle-damping", 0.25)):
        low, high = fit.intervals(0.999)[name]
        assert fit.params[name] == pytest.approx(TRUE[name], rel=bound)
        assert low < TRUE[name] < high
        assert fit.bound[name] <= fit.fitted().deviation(f"friction.test.{name}") < bound * TRUE[name]
    assert 0.6 < fit.fitted().variance < 1.3 and fit.passive_up_to == np.inf
    assert [text[:30] for text in fit.warnings] == ["the static map was not fitted "]
    assert fit.correlation.shape == fit.covariance.shape and fit.correlation.values.diagonal() == pytest.approx(1.0)


def test_without_a_calibration_the_fit_is_repeated_until_its_starts_stay():
    # Of this seed the first answer leaves the place by more than a millimetre, over which its effects are no lines.
    runs = rig.run("ramp", CRANE, seed=6, **RAMP), rig.run("step", CRANE, seed=6)
    ramp, step = (log_of(run.data) for run in runs)
    found = fit_dynamic([ramp], [step], CRANE).estimate
    assert found is not None
    assert all(abs(found[f"x.start {log}"]) < 1e-4 and abs(found[f"p1.start {log}"]) < 1e3 for log in (0, 1))


def test_what_was_found_was_to_be_expected(fit, logs):
    """The Fisher information beforehand is that of the fit."""
    before = expected(logs, CRANE, calibrated=True)
    for name in DYNAMIC:
        assert before[name] == pytest.approx(fit.bound[name], rel=0.25)


def test_the_block_loads_and_the_report_is_whole(fit, tmp_path):
    block = fit.toml(source=["ramp.csv"], date="2024-05-01")
    machine = tmp_path / "fitted.toml"
    machine.write_text(f'extends = "rig-rottne"\n\n[machine]\nname = "fitted"\n\n{block}', encoding="utf-8")
    loaded = hc.load_machine(machine)
    for name in DYNAMIC:
        value = loaded.value(f"friction.test.{name}")
        assert value.si == pytest.approx(fit.params[name], rel=1e-4) and value.provenance == "fitted"
    report = Report("Bristles")
    assert all(report.stage(*stage) for stage in fit.stages())
    assert "bristle-damping" in report.html() and "95 %" in fit.summary()


def test_a_delay_is_found_and_does_not_count_as_friction(fit, logs):
    """All readings later than the command, by more than one straight line of their effect reaches."""
    by = 3e-3
    late = [changed(log, command=np.interp(log.time + by, log.time, log["command"])) for log in logs]
    found = fit_dynamic(late[:1], late[1:], CRANE, calibrated=True)
    assert found.delay - fit.delay == pytest.approx(by, abs=5e-5)
    for name in DYNAMIC:
        fifth = 0.2 * fit.fitted().deviation(f"friction.test.{name}")
        assert found.params[name] == pytest.approx(fit.params[name], abs=fifth)
    table = next(make() for title, make in found.stages() if title == "Correlations and nuisance parameters").table
    shown = {row[0]: row[1] for row in table.rows}
    assert float(shown["delay"]) == pytest.approx(found.delay, rel=1e-3)


def fast_ramp() -> Log:
    """Up to six Stribeck velocities, both ways."""
    run = rig.run("ramp", CRANE, seed=4, calibration=1.0, speed=1.0, last=6.0, interval=2e-3)
    return log_of(run.data, 1.0)


def test_a_ramp_beyond_break_away_tells_the_exponents_too(logs):
    """It is fitted whole, with a file whose viscous exponent is wrong; that of a slow ramp stays as it is."""
    assert not bristle.goes_beyond(logs[0], CRANE, LAW, None)
    ramp, step = fast_ramp(), logs[1].between(1.0, 3.0)
    assert bristle.goes_beyond(ramp, CRANE, LAW, None)
    # Equal at 10 mm/s.
    viscous = [8000.0 * 0.01**0.25, 12000.0 * 0.01**0.25]
    wrong = CRANE.changed({"friction.test.viscous-exponent": 1.25, "friction.test.viscous": viscous})
    found = fit_dynamic([ramp], [step], wrong, calibrated=True)
    for name in DYNAMIC:
        low, high = found.intervals(0.999)[name]
        assert low < TRUE[name] < high
    estimate = found.fitted()
    assert not found.warnings
    for side in (0, 1):
        key = f"friction.test.viscous-exponent[{side}]"
        assert abs(estimate[key] - 1.5) < 3.3 * estimate.deviation(key) < 0.5


def test_a_rig_with_oil_of_constant_bulk_modulus_is_fitted(logs, tmp_path):
    lines = Path("machines/rig-rottne.toml").read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if not line.startswith("bulk-")]
    kept.insert(kept.index("[fluid]") + 1, 'bulk-modulus = "0.9 GPa"')
    machine = tmp_path / "constant.toml"
    machine.write_text("\n".join(kept), encoding="utf-8")
    crane = hc.load_machine(machine)
    found = fit_dynamic([], [logs[1].between(1.0, 4.0)], crane, calibrated=True)
    assert found.estimate is not None and "fluid.bulk-modulus" in found.estimate.names
    assert found.estimate["fluid.bulk-modulus"] > 0.0 and found.bound["bristle-damping"] > 0.0


# --- what must not pass ---------------------------------------------------------------------------------------------


def test_damping_is_bounded_by_passivity():
    """Just below the bound friction dissipates at every speed, just above it does not."""
    most = most_damping(CRANE)
    for factor, holds in ((0.99, True), (1.3, False)):
        crane = hc.load_machine("rig-rottne", {"friction.test.bristle-damping": factor * most})
        assert all(entry["holds"] for entry in crane.passivity()) == holds


def test_a_wrong_load_is_said_and_not_explained_away(logs):
    found = fit_dynamic([], [logs[1].between(1.0, 4.0)], CRANE, payload=10.0, calibrated=True)
    assert any("check load" in warning for warning in found.warnings)


def test_readings_that_err_together_are_said(logs):
    """More noise of the same size in one pressure, which lasts for ten samples."""
    step, noise = logs[1], RigSensors.of(CRANE, calibrated=True).pressure_noise
    fresh = np.random.default_rng(0).normal(size=step.time.size)
    slow = noise * lfilter([np.sqrt(1.0 - 0.9**2)], [1.0, -0.9], fresh)
    found = fit_dynamic([], [changed(step, p2=step["p2"] + slow)], CRANE, calibrated=True)
    (told,) = (text for text in found.warnings if "residuals of consecutive samples" in text)
    assert told.startswith("bad.csv, p2:") and "count as about" in told


def test_what_fails_later_keeps_the_readings(logs):
    uneven = logs[1].data.isel(time=np.r_[0:100, 101:2000, 2003 : logs[1].time.size])
    found = fit_dynamic([logs[0]], [Log.of(uneven, source="uneven")], CRANE, calibrated=True)
    assert found.estimate is None and found.params["bristle-stiffness"] > 0
    assert any("evenly spaced" in warning for warning in found.warnings)
    for use in (found.intervals, found.plot, found.toml):
        with pytest.raises(InputError, match="evenly spaced"):
            use()
    report = Report("Bristles")
    assert [report.stage(*stage) for stage in found.stages()] == [True, False, False, False]


def changed(log: Log, **signals) -> Log:
    data = log.data.copy()
    for name, values in signals.items():
        data[name] = ("time", values)
    return Log.of(data, source="bad.csv")


def test_bad_logs_are_one_clear_error(logs):
    step = logs[1]
    gap = step["p1"].copy()
    gap[100:] = np.nan
    holes = step["command"].copy()
    holes[5000:5010] = np.nan
    bad = {
        "never opened": changed(step, command=np.zeros(step.time.size)),
        "no finite number": changed(step, p1=gap * np.nan),
        "has gaps": changed(step, command=holes),
        "begin with the piston at rest": changed(step.between(1.98, 6.0)),
        "no signal `command`": Log.of(step.data.drop_vars("command"), source="bad.csv"),
    }
    for message, log in bad.items():
        try:
            found = fit_dynamic([], [log], CRANE, calibrated=True)
        except InputError as error:
            said = str(error)
        else:
            # Some motions could be read; the fit says why there is no more.
            assert found.estimate is None
            said = found.summary()
        assert message in said and "bad.csv" in said
    with pytest.raises(InputError, match="a ramp or a step"):
        fit_dynamic([], [], CRANE)
    static = hc.load_machine("rig-rottne", {"friction.test.model": "static"})
    with pytest.raises(InputError, match="bristle"):
        fit_dynamic([], [step], static)


def test_spoilt_samples_are_left_out(logs, fit):
    """A second without p2 costs information, not the fit."""
    hole = logs[1]["p2"].copy()
    hole[(logs[1].time > 2.5) & (logs[1].time < 3.0)] = np.nan
    found = fit_dynamic([], [changed(logs[1], p2=hole).between(1.0, 6.5)], CRANE, calibrated=True)
    assert found.estimate is not None and np.isfinite(found.params["bristle-damping"])
    assert found.bound["bristle-damping"] > 0.9 * fit.bound["bristle-damping"]
