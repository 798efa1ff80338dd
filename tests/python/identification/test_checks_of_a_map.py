"""What says whether a static map can be trusted: levels left out and predicted, residuals of neighbours, intervals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hydrocrane.identification import FrictionPoints, StaticMap, fit_static, synthetic_points
from hydrocrane.identification.static.residuals import Succession
from hydrocrane.identification.static.stage import identify_static

LAW = StaticMap.of(
    {"coulomb": (160, 280), "breakaway": (340, 400), "stribeck-velocity": 0.002, "viscous": (8000, 12000),
     "viscous-exponent": 1.0}
)  # fmt: skip
TOLD = {"viscous-exponent": 1.0}


def levels(count: int, seed: int, **how) -> FrictionPoints:
    return synthetic_points(LAW, speeds=np.geomspace(5e-4, 0.1, count), seed=seed, **how)


def wavy(points: FrictionPoints, waves: float) -> FrictionPoints:
    """Friction that no form of the map has: 10 % up and down along the logarithm of the speed."""
    return replace(points, force=points.force * (1.0 + 0.1 * np.sin(waves * np.log(points.speed))))


def in_time(points: FrictionPoints, seed: int) -> FrictionPoints:
    """The levels measured one after the other in a mixed order, 100 s each."""
    draw = np.random.default_rng(seed)
    order = draw.permutation(points.level.max() + 1)
    return replace(points, time=100.0 * order[points.level] + draw.uniform(0.0, 1.0, len(points)))


# --- levels left out --------------------------------------------------------------------------------------------------


def test_a_level_left_out_is_predicted_as_a_fit_without_it_predicts():
    """The same by hand: another call, of the points without the level, with form and floor as found."""
    points = levels(8, seed=2, windows=2)
    fit = fit_static(points, exponents=TOLD)
    found = fit.held_out
    assert found.fits == points.levels.count.size == 16 and found.known.all()
    for k in (0, 5, 11):
        out = points.level == k
        rest = fit_static(points.select(~out), exponents=TOLD, form=fit.form, floor=fit.spread.floor, loss="linear")
        here = points.select(out)
        assert found.error[k] == pytest.approx(np.mean(here.force - rest.force(here.velocity)), abs=0.05)
        assert found.within[k] == pytest.approx(np.mean(here.force - fit.force(here.velocity)), abs=0.02)
    assert found.rms > found.rms_within > 0.0
    assert found.reach == pytest.approx(np.ptp(points.levels.force))


def test_errors_of_predictions_are_as_large_as_promised():
    """Of a true form, with the errors stated and with more that each level shares."""
    for how in ({}, {"level_error": 8.0}):
        fits = [fit_static(levels(10, seed, **how), exponents=TOLD) for seed in range(6)]
        assert np.mean([fit.held_out.ratio for fit in fits]) == pytest.approx(1.0, abs=0.25)
        assert not any(fit.held_out.warnings for fit in fits)


def test_a_form_that_does_not_carry_over_is_told():
    """As many levels as the map can just follow: nothing but the prediction of what was left out shows it."""
    fit = fit_static(wavy(levels(6, seed=1, windows=2), 6.0))
    assert not fit.residual_analysis.notable and fit.held_out.notable
    (told,) = (text for text in fit.warnings if "does not predict" in text)
    assert "mm/s is off by" in told and "Hold exponents" in told
    assert fit.held_out.rms > 5.0 * fit.held_out.rms_within


def test_what_cannot_be_predicted_is_said_and_not_guessed():
    fit = fit_static(levels(5, seed=0))
    assert not fit.held_out.known.any() and not fit.held_out.warnings
    assert "as many parameters as levels" in fit.held_out.sentence
    one = FrictionPoints.of([0.01, 0.01], [200.0, 202.0], force_error=2.0)
    assert fit_static(one).held_out is None


def test_many_levels_are_left_out_in_groups():
    fit = fit_static(levels(20, seed=1, windows=1), exponents=TOLD)
    assert fit.points.levels.count.size == 40 and fit.held_out.fits == 24
    assert fit.held_out.known.all() and "in 24 groups" in fit.held_out.sentence
    assert fit.held_out.ratio == pytest.approx(1.0, abs=0.35)


# --- neighbours -------------------------------------------------------------------------------------------------------


def test_a_drift_that_no_cause_explains_is_told_with_what_readings_count():
    """20 N up and down along the log: no straight line in time, and each level stands at a place of its own."""
    points = in_time(levels(24, seed=0, windows=1), 0)
    points = replace(points, force=points.force + 20.0 * np.sin(points.time / 240.0))
    fit = fit_static(points, exponents=TOLD)
    assert not fit.residual_analysis.likely
    (found,) = (each for each in fit.successions if each.order == "time")
    assert found.shows and found.effective < 0.4 * found.count
    (told,) = (text for text in fit.warnings if text.startswith("residuals of consecutive windows"))
    assert f"count as about {found.effective:.0f}" in told and "warm up" in told


def test_another_form_shows_in_neighbours_of_velocity():
    fit = fit_static(wavy(levels(16, seed=0, windows=1), 3.0), exponents=TOLD)
    (found,) = fit.successions
    assert found.order == "velocity" and found.shows and found.warning in fit.warnings


def test_effective_number_of_readings():
    """n (1 - r)/(1 + r); correlation against each other gives no more than there are."""
    assert Succession("time", 0.5, 0.0, 90).effective == pytest.approx(30.0)
    assert Succession("time", -0.5, 1.0, 90).effective == 90.0
    assert "factor of 1.7." in Succession("time", 0.5, 0.0, 90).warning


@pytest.mark.evidence
@pytest.mark.parametrize("how", [{}, {"level_error": 8.0}, {"windows": 1}], ids=["plain", "levels", "single"])
def test_chances_of_independent_readings_are_even(how):
    """Of 40 fits 2 lie below 5 %; beyond 6 in one of a hundred cases. A level's common error is no succession."""
    chances, shown = {"time": [], "velocity": []}, 0
    for seed in range(40):
        for each in fit_static(in_time(levels(12, seed, **how), seed), exponents=TOLD).successions:
            chances[each.order].append(each.p_value)
            shown += each.shows
    for values in chances.values():
        assert len(values) == 40 and np.count_nonzero(np.array(values) < 0.05) <= 6
        assert 0.3 < np.median(values) < 0.7
    # One of 200 does by chance.
    assert shown <= 3


# --- the report -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("exponents", "said"), [(TOLD, "Student"), ("free", "profile likelihood")])
def test_the_report_says_how_intervals_were_found(exponents, said):
    found = identify_static(levels(10, seed=1), exponents=exponents)
    assert (found.fit.interval_method == "profile") == any("exponent" in label for label in found.fit.spread.labels)
    sections = dict(found.stages("test"))
    assert said in sections["Parameters"]().text
    assert found.fit.intervals() == found.fit.intervals(method=found.fit.interval_method)


def test_the_report_shows_predictions_and_neighbours():
    found = identify_static(levels(10, seed=1), exponents=TOLD)
    page = found.report("test").html()
    assert "Prediction of levels left out" in page and found.fit.held_out.sentence in page
    assert "neighbours in velocity" in page and "Not finished" not in page
