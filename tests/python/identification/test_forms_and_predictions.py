"""Forms of a map that nobody told: intervals of what the points determine, of friction at a speed, and beyond them."""

from __future__ import annotations

import numpy as np
import pytest

from hydrocrane.identification import FrictionPoints, StaticMap, fit_static, synthetic_points
from hydrocrane.identification.static.stage import identify_static

COULOMB, RISE, FALL, VISCOUS = (160.0, 280.0), (180.0, 120.0), 3e-3, (8000.0, 12000.0)


def size(v: np.ndarray, tail: str) -> np.ndarray:
    """Friction, N, at velocities v, m/s, that falls as a Lorentzian or a Gaussian."""
    side = (v < 0.0).astype(int)
    ratio = np.abs(v) / FALL
    share = 1.0 / (1.0 + ratio**2) if tail == "lorentzian" else np.exp(-(ratio**2))
    coulomb, rise, viscous = (np.array(pair)[side] for pair in (COULOMB, RISE, VISCOUS))
    return np.sign(v) * (coulomb + rise * share + viscous * np.abs(v))


def points(tail: str, seed: int, speeds: np.ndarray) -> FrictionPoints:
    """Three windows at each speed in each direction, with 4 N and 0.5 % of the velocity."""
    rng = np.random.default_rng(seed)
    v = np.repeat(np.concatenate([speeds, -speeds]), 3) * (1.0 + 0.01 * rng.uniform(-1.0, 1.0, 6 * speeds.size))
    error = 0.005 * np.abs(v)
    measured = v + error * rng.normal(size=v.size)
    force = size(v, tail) + 4.0 * rng.normal(size=v.size)
    return FrictionPoints.of(measured, force, velocity_error=error, force_error=4.0)


def test_a_lorentzian_is_recognised_and_its_map_holds():
    v = np.concatenate([[-1.0], [1.0]])[:, None] * np.geomspace(1e-4, 0.1, 9)
    held, coulomb = [], []
    for seed in range(3):
        fit = fit_static(points("lorentzian", seed, np.geomspace(1e-4, 0.1, 12)))
        assert fit.form.lorentzian and "Lorentzian" in fit.form_text
        low, high = fit.force_interval(v.ravel()).T
        held.append((low <= size(v.ravel(), "lorentzian")) & (size(v.ravel(), "lorentzian") <= high))
        ends = [fit.intervals()[f"coulomb.{side}"] for side in ("extending", "retracting")]
        coulomb += [low <= true <= high for true, (low, high) in zip(COULOMB, ends, strict=True)]
    assert np.mean(held) > 0.9 and all(coulomb)
    block = fit.toml("test")
    assert "none of machine files" in block and "stribeck-exponent" in block
    assert not fit.for_machines.form.lorentzian


def test_derivatives_of_the_lorentzian_are_its_own():
    law = StaticMap(StaticMap.of({"coulomb": 160, "breakaway": 340, "stribeck-velocity": FALL, "viscous": 8e3}).values)
    law = StaticMap(law.values, lorentzian=True)
    v = np.array([1e-4, 2e-3, 0.05, -1e-3, -0.02])
    _, over_v, over = law.evaluate(v)
    step = 1e-6 * np.abs(v)
    assert over_v == pytest.approx((law.force(v + step) - law.force(v - step)) / (2.0 * step), rel=1e-3, abs=10.0)
    for i in range(12):
        ends = []
        for sign in (1.0, -1.0):
            moved = law.values.copy()
            moved[i] *= 1.0 + sign * 1e-6
            ends.append(StaticMap(moved, lorentzian=True).evaluate(v)[0])
        expected = (ends[0] - ends[1]) / (2e-6 * law.values[i])
        assert over[:, i] == pytest.approx(expected, rel=1e-5, abs=1e-6 * np.abs(expected).max() + 1e-12), i


def test_speeds_that_do_not_tell_an_exponent_take_one_and_say_so_beyond():
    """Slow levels only: any viscous exponent fits. Without a preference 1.5 was taken, and no word of the rest."""
    fit = fit_static(points("gaussian", 0, np.geomspace(2e-4, 0.008, 6)))
    assert fit.params["viscous-exponent"] == (1.0, 1.0)
    fast = np.array([0.3])
    (low, high), force = fit.force_interval(fast)[0], float(size(fast, "gaussian")[0])
    near = fit.force_interval(np.array([0.006]))[0]
    assert low <= force <= high and high - low > 5.0 * (near[1] - near[0])
    assert any("the map is an extrapolation" in text for text in fit.warnings), fit.warnings
    table = identify_static(fit.points).report("test").html()
    assert "Friction of the map" in table and "beyond the levels" in table


@pytest.mark.parametrize("seed", [17, 27])
def test_a_viscous_coefficient_allows_for_the_choice_of_a_free_exponent(seed):
    """The exponent is 1; of the first 35 seeds these two free it. That form alone holds 2 of their 4 coefficients."""
    viscous = (2000.0, 3000.0)
    law = StaticMap.of(
        {"coulomb": COULOMB, "breakaway": (340, 400), "stribeck-velocity": 2e-3, "viscous": viscous}
        | {"viscous-exponent": 1.0}
    )
    errors = {"windows": 2, "force_error": 2.0, "velocity_error": 0.002}
    fit = fit_static(synthetic_points(law, seed=seed, speeds=np.geomspace(3e-4, 0.15, 10), **errors))
    assert "viscous exponent free" in fit.form_text
    for side, true in zip(("extending", "retracting"), viscous, strict=True):
        low, high = fit.intervals()[f"viscous.{side}"]
        alone = fit._alone(f"viscous.{side}", 0.95, fit.interval_method)
        assert low <= true <= high and high - low < 1.4 * (alone[1] - alone[0])


@pytest.mark.parametrize("seed", range(4))
def test_what_the_points_do_not_determine_has_an_upper_bound_only(seed):
    """Fast levels on a long fall: Coulomb and viscous friction may be anything from zero up to all friction."""
    rng = np.random.default_rng(seed)
    v = np.concatenate([np.linspace(0.07, 0.25, 6), -np.linspace(0.07, 0.25, 6)])
    force = np.sign(v) * (50.0 + 15.0 * np.exp(-((v / 0.15) ** 2)) + 60.0 * np.abs(v)) + rng.normal(0, 0.7, v.size)
    levels = FrictionPoints.of(v, force, velocity_error=0.002 * np.abs(v), force_error=0.7)
    fit = fit_static(levels, exponents={"viscous-exponent": 1.0})
    table = identify_static(levels, exponents={"viscous-exponent": 1.0}).report("test").html()
    determined = True
    for each in (fit, *fit.rivals):
        for label, (low, high) in each.intervals().items():
            assert low >= 0.0 or np.isinf(low), (label, low, high)
            if label.startswith("coulomb") and np.isfinite(high):
                assert high < 3.0 * np.abs(force).max(), (label, low, high)
    for label, (low, high) in fit.intervals().items():
        if low == 0.0 and np.isfinite(high):
            determined = False
            assert f"{label} is not determined, at most {high:.4g} (95 %)" in fit.warnings
            assert f"not determined, at most {high:.4g}" in fit.toml("test")
            assert f"<td>not determined</td><td>0</td><td>{high:.4g}</td>" in table
    assert not determined


def test_a_form_that_leaves_a_parameter_open_says_nothing_on_it():
    """Levels from the fall on: no form that is nearly flat there may open the interval of Coulomb friction."""
    for seed in range(3):
        fit = fit_static(points("gaussian", seed, np.geomspace(4e-4, 0.06, 8)))
        for side, true in zip(("extending", "retracting"), COULOMB, strict=True):
            low, high = fit.intervals()[f"coulomb.{side}"]
            alone = fit._alone(f"coulomb.{side}", 0.95, "t")
            assert low <= true <= high
            assert high - low < max(3.0 * (alone[1] - alone[0]), 2.0 * true)
        for label, (low, high) in fit.intervals().items():
            assert not np.isfinite(high) or low >= 0.0 or "Stribeck" not in label
            said = [text for text in fit.warnings if text.startswith(f"{label} is poorly known")]
            assert not said or f"{low:.4g} to {high:.4g}" in said[0]
