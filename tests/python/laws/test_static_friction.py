"""Static friction from steady points: known maps come back, intervals hold, what cannot be told is said."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, replace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.optimize import curve_fit

import hydrocrane as hc
from hydrocrane.identification import (
    FrictionPoints,
    OffsetPrior,
    StaticMap,
    fit_static,
    graphical,
    identify_static,
    synthetic_points,
)
from hydrocrane.identification.static.intervals import reach
from hydrocrane.identification.static.maps import LABELS

# Thesis Table 3, 0 kg; the viscous exponent is that of (108).
ROTTNE = StaticMap.of(
    {"coulomb": (160, 280), "breakaway": (340, 400), "stribeck-velocity": 0.002, "viscous": (8000, 12000)}
)
KALMAR = StaticMap.of(
    {"coulomb": (105, 80), "breakaway": (455, 380), "stribeck-velocity": (0.01, 0.015), "viscous": (1250, 1800)}
)
MAPS = pytest.mark.parametrize("law", [ROTTNE, KALMAR], ids=["rottne", "kalmar"])
SEEDS = range(10)


def oracle(v, coulomb, rise, v_s, viscous):
    """(119) of one direction with exponents 2 and 1.5, written again."""
    return coulomb + rise * np.exp(-((v / v_s) ** 2)) + viscous * v**1.5


def truth(law: StaticMap, label: str) -> float:
    return float(law.values[LABELS.index(label)])


def test_the_map_is_the_law_of_the_thesis():
    v = np.geomspace(1e-4, 0.1, 30)
    assert ROTTNE.force(v) == pytest.approx(oracle(v, 160, 180, 0.002, 8000), rel=1e-12)
    assert ROTTNE.force(-v) == pytest.approx(-oracle(v, 280, 120, 0.002, 12000), rel=1e-12)


def test_the_map_is_that_of_the_machine_which_simulates():
    crane = hc.load_machine("single-cylinder")
    v = np.array([-0.05, -1e-3, 1e-3, 0.05])
    given = {"coulomb": (170, 350), "breakaway": (620, 800), "stribeck-velocity": (0.004, 0.002)}
    law = StaticMap.of({**given, "viscous": (10500, 12000)})
    assert law.force(v) == pytest.approx(crane.friction_map(v, "test"), rel=1e-9)


# --- points -----------------------------------------------------------------------------------------------------------


@dataclass
class Window:
    velocity: float
    velocity_error: float
    force: float
    force_error: float


def test_windows_become_points_and_levels():
    windows = [Window(v, 1e-6, 100.0 + k, 2.0) for k, v in enumerate((0.01, 0.0101, 0.02, -0.01))]
    points = FrictionPoints.from_windows(windows, source=["a.csv"])
    assert points.level.tolist() == [0, 0, 1, 2]
    assert points.levels.count.tolist() == [2, 1, 1]
    assert points.levels.force[0] == 100.5 and points.levels.scatter[0] == pytest.approx(np.sqrt(0.5))
    assert np.isnan(points.levels.scatter[1]) and points.direction.tolist() == [0, 0, 0, 1]


def test_a_level_is_not_split_by_the_error_of_its_velocities():
    """At 0.1 mm/s a window may know its velocity to a tenth only."""
    v = np.array([0.8e-4, 1.0e-4, 1.3e-4, 1e-3])
    assert FrictionPoints.of(v, np.ones(4), velocity_error=0.1 * v).level.tolist() == [0, 0, 0, 1]
    assert FrictionPoints.of(v, np.ones(4)).level.tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"velocity": [], "force": []}, "no friction points"),
        ({"velocity": [1e-3, np.nan], "force": [1, 1]}, "velocity must be finite"),
        ({"velocity": [1e-3], "force": [1, 1]}, "equal length"),
        ({"velocity": [0.0], "force": [1]}, "direction"),
        ({"velocity": [0.1], "force": [1], "direction": [-1]}, "contradicts"),
        ({"velocity": [0.1], "force": [1], "direction": [2]}, "direction must be"),
        ({"velocity": [0.1], "force": [1], "force_error": -1.0}, "force_error must not be negative"),
        ({"velocity": [0.1], "force": [1], "velocity_error": [1, 2]}, "one per point"),
    ],
)
def test_bad_points_are_named(arguments, said):
    with pytest.raises(hc.InputError, match=said):
        FrictionPoints.of(arguments.pop("velocity"), arguments.pop("force"), **arguments)


# --- recovery and intervals -------------------------------------------------------------------------------------------


@MAPS
def test_exact_points_give_the_map_back(law):
    fit = fit_static(synthetic_points(law, force_error=0.0, velocity_error=0.0))
    assert fit.law.values == pytest.approx(law.values, rel=1e-6)


@MAPS
def test_exact_points_give_the_exponents_back(law):
    other = StaticMap.of({**law.pairs, "stribeck-exponent": (1.2, 1.6), "viscous-exponent": (1.0, 1.3)})
    fit = fit_static(synthetic_points(other, force_error=0.0, velocity_error=0.0), exponents="free")
    assert fit.law.values == pytest.approx(other.values, rel=1e-4)


@MAPS
def test_medians_over_seeds_and_the_share_of_intervals_that_hold(law):
    """Within 5 % (Stribeck velocity 15 %). Of 80 intervals at 95 % fewer than 68 hold in one of 10^4 studies."""
    fits = [fit_static(synthetic_points(law, seed=seed), exponents="fixed") for seed in SEEDS]
    held = 0
    for label in fits[0].intervals():
        median = np.median([fit.value(label) for fit in fits])
        assert median == pytest.approx(truth(law, label), rel=0.15 if "stribeck" in label else 0.05), label
        held += sum(low <= truth(law, label) <= high for low, high in (fit.intervals()[label] for fit in fits))
    assert held >= 68


def test_intervals_by_profile_agree_where_the_map_is_nearly_straight():
    """Levels dense and errors small: both constructions say the same, to a tenth of the width."""
    fit = fit_static(synthetic_points(ROTTNE, force_error=1.0, seed=3))
    by_t, by_profile = fit.intervals(method="t"), fit.intervals(method="profile")
    for label, ends in by_t.items():
        assert by_profile[label] == pytest.approx(ends, abs=0.1 * (ends[1] - ends[0])), label


@pytest.mark.evidence
def test_the_profile_holds_where_the_linear_interval_does_not():
    """Kalmar's viscous force is 40 N at most: with free exponents its coefficient is all but unknown."""
    points = synthetic_points(KALMAR, force_error=8.0, windows=5, seed=1)
    fit = fit_static(points, exponents="free")
    intervals = fit.intervals()
    for side in ("extending", "retracting"):
        low, high = intervals[f"viscous.{side}"]
        assert low <= truth(KALMAR, f"viscous.{side}") <= high and high / max(low, 1.0) > 5
    assert any(w.startswith("viscous.extending is poorly known") for w in fit.warnings)


def test_it_is_plain_least_squares_where_nothing_asks_for_more():
    """No floor, no robust loss, equal errors: scipy's curve_fit on each direction gives the same numbers."""
    points = synthetic_points(ROTTNE, velocity_error=0.0, seed=5)
    fit = fit_static(points, floor=0.0, loss="linear")
    for side, sign in ((0, 1.0), (1, -1.0)):
        here = points.direction == side
        start = (200, 150, 0.003, 9000)
        found, covariance = curve_fit(oracle, points.speed[here], sign * points.force[here], p0=start)
        ours = fit.law.values.reshape(6, 2)[[0, 1, 2, 4], side] - [0, fit.law.values[side], 0, 0]
        assert ours == pytest.approx(found, rel=1e-5)
        label = f"coulomb.{('extending', 'retracting')[side]}"
        ours_error = float(np.sqrt(fit.covariance.sel(parameter=label, **{"with": label})))
        # The scatter is that of the levels here, that of the points there.
        assert ours_error == pytest.approx(np.sqrt(covariance[0, 0]), rel=0.5)


@pytest.mark.study
@pytest.mark.evidence
def test_the_trap_of_figure_68():
    """Most points slow, and an error that the points of a level share: every level must weigh the same.

    Plain least squares over the points bends the fast end of the map to the errors of the slow levels.
    """
    speeds = np.geomspace(1e-4, 0.1, 10)
    windows = np.where(speeds < 3e-3, 60, 1)
    off: dict[str, list[float]] = {"levels": [], "points": []}
    for seed in range(20):
        points = synthetic_points(
            ROTTNE, speeds=speeds, windows=windows, force_error=3.0, level_error=8.0, velocity_error=0.0, seed=seed
        )
        for name, floor in (("levels", 10.0), ("points", 0.0)):
            fit = fit_static(points, floor=floor, loss="linear")
            off[name].append(float(np.mean((fit.force(speeds) - ROTTNE.force(speeds)) ** 2)))
    factor = np.sqrt(np.mean(off["points"]) / np.mean(off["levels"]))
    assert factor > 1.1


@pytest.mark.parametrize("seed", range(3))
def test_stray_points_are_left_out_and_named(seed):
    points = synthetic_points(ROTTNE, seed=seed)
    stray = [4, 20, 50]
    force = points.force.copy()
    force[stray] += [120.0, -90.0, 150.0]
    fit = fit_static(replace(points, force=force))
    assert [r.index for r in fit.rejected] == stray
    assert fit.law.values == pytest.approx(fit_static(points).law.values, rel=0.05)
    assert not fit.accepted[stray].any() and fit.accepted.sum() == len(points) - 3
    assert abs(fit.residuals[4] - 120.0) < 20.0


# --- what cannot be told ----------------------------------------------------------------------------------------------


def test_each_log_may_have_a_constant_error_of_its_own():
    """Two logs that were calibrated each by itself, off by +5 and -5 N: the fit tells them apart, and joins the map."""
    one, other = (synthetic_points(ROTTNE, offset=off, force_error=0.5, seed=k) for k, off in enumerate((5.0, -5.0)))
    both = FrictionPoints.joined([one, other])
    assert both.logs == 2 and len(both) == len(one) + len(other)
    assert both.select(both.log == 1).force == pytest.approx(other.force)
    fit = fit_static(both, bias=[5.0, 5.0])
    assert fit.offsets[0] - fit.offsets[1] == pytest.approx(10.0, abs=1.0)
    assert fit.value("offset.2") == fit.offsets[1] and fit.unit("offset.1") == "N"
    assert 3.0 * fit.residuals.std() < fit_static(both, bias=5.0).residuals.std()
    with pytest.raises(hc.InputError, match="3 entries for points of 2 logs"):
        fit_static(both, bias=[5.0, 5.0, 5.0])


def test_a_bowed_potentiometer_is_carried_along():
    """The slope of the position sensor is off by 2 % per metre from its middle: levels elsewhere read another speed."""
    bent, position = 0.02, np.linspace(-0.3, 0.3, len(synthetic_points(ROTTNE)))
    true = synthetic_points(ROTTNE, force_error=0.1, velocity_error=1e-4, seed=6)
    seen = replace(true, velocity=true.velocity * (1.0 + bent * position), position=position)
    fit = fit_static(seen, linearity_error=0.02)
    low, high = fit.intervals()["linearity"]
    assert low < bent < high and high - low < 0.04 and fit.unit("linearity") == "1/m"
    for label, (low, high) in fit.intervals().items():
        if label != "linearity":
            assert low < ROTTNE.values[LABELS.index(label)] < high, label
    for bad, message in ((-1.0, "1/m"), (0.1, "needs the position")):
        with pytest.raises(hc.InputError, match=message):
            fit_static(true, linearity_error=bad)
    with pytest.raises(hc.InputError, match="shape"):
        FrictionPoints.of([0.1, 0.2], [1.0, 2.0], position=[0.0])


@pytest.mark.evidence
def test_points_known_less_well_are_not_stray():
    """Levels on a steep flank are as far off as their velocities explain, and far from a bulk that is known better."""
    for seed in range(5):
        points = synthetic_points(ROTTNE, force_error=0.1, velocity_error=0.05, seed=seed)
        assert not fit_static(points).rejected


def test_reaches_of_scatter_and_bounds():
    assert reach(0.95, 1.0, np.inf, np.zeros(0)) == pytest.approx(1.95996, abs=1e-4)
    assert reach(0.95, 2.0, 5.0, np.zeros(1)) == pytest.approx(2.5706, abs=1e-3)
    # One bound alone: 95 % of it. Two equal ones: a triangle, 1 - sqrt(0.05) of the sum.
    assert reach(0.95, 0.0, np.inf, np.array([3.0])) == pytest.approx(0.95 * 3**0.5, rel=2e-3)
    triangle = (1 - 0.05**0.5) * 2 / (2 / 3) ** 0.5
    assert reach(0.95, 0.0, np.inf, np.array([1.0, 1.0])) == pytest.approx(triangle, rel=2e-3)
    draw = np.random.default_rng(1)
    mixed = draw.normal(size=400_000) + draw.uniform(-2.0, 2.0, 400_000)
    assert reach(0.9, 1.0, np.inf, np.array([2.0])) == pytest.approx(np.quantile(mixed, 0.95) / mixed.std(), rel=0.01)


def test_an_offset_only_shifts_what_its_prior_allows():
    """Coulomb friction of the directions moves against each other; their sum, slopes and widths do not."""
    shifted = synthetic_points(ROTTNE, offset=40.0, seed=2)
    blind, aware = (fit_static(shifted, exponents="fixed", bias=bias) for bias in (None, 40.0))
    low, high = blind.intervals()["coulomb.extending"]
    assert not low <= 160.0 <= high
    for label, (low, high) in aware.intervals().items():
        if label != "offset":
            assert low <= truth(ROTTNE, label) <= high, label
    assert aware.intervals()["offset"] == pytest.approx((-78.4, 78.4), abs=0.1)
    assert sum(aware.params["coulomb"]) == pytest.approx(440.0, abs=10.0)
    assert float(aware.correlation.sel(parameter="coulomb.extending", **{"with": "coulomb.retracting"})) < -0.9
    assert any("zero calibration" in w for w in aware.warnings)


def test_a_symmetric_cylinder_tells_the_offset():
    law = StaticMap.of({"coulomb": 200, "breakaway": 350, "stribeck-velocity": 0.003, "viscous": (8000, 12000)})
    fit = fit_static(synthetic_points(law, offset=40.0, seed=2), bias=OffsetPrior(200.0), symmetric=True)
    low, high = fit.intervals()["offset"]
    assert low < 40.0 < high and high - low < 10.0
    assert fit.params["coulomb"][0] == fit.params["coulomb"][1] == pytest.approx(200.0, abs=5.0)


def test_the_offset_prior_of_two_transmitters():
    prior = OffsetPrior.of_pressures((2e-3, 1e-3), (1e5, 2e5))
    assert prior.deviation == pytest.approx(np.hypot(200.0, 200.0))


def test_one_level_only_is_said():
    fit = fit_static(synthetic_points(ROTTNE, speeds=[0.01], windows=4))
    assert any("one velocity level only" in w for w in fit.warnings)
    for name in ("coulomb", "stribeck-velocity", "breakaway", "viscous"):
        assert fit.intervals()[f"{name}.retracting"] == (-np.inf, np.inf)
    assert "coulomb = " in fit.toml("test") and "not identifiable" in fit.toml("test")
    assert fit.params["coulomb"] == pytest.approx(np.abs(ROTTNE.force([0.01, -0.01])), rel=0.03)


def test_one_level_in_one_direction_leaves_the_other_as_it_is():
    both = synthetic_points(ROTTNE, seed=3)
    kept = (both.velocity > 0.0) | (np.abs(both.velocity + 0.1) < 0.01)
    fit = fit_static(both.select(kept))
    assert fit.intervals()["coulomb.retracting"] == (-np.inf, np.inf)
    assert np.isinf(fit.force_error(np.array([-0.1])))
    low, high = fit.intervals()["coulomb.extending"]
    assert low < 160.0 < high < 200.0


def test_a_name_that_no_table_can_have_is_refused():
    fit = fit_static(synthetic_points(ROTTNE))
    for wrong in ("big cylinder", "a]b", ""):
        with pytest.raises(hc.InputError, match="the name of a friction table"):
            fit.toml("test", name=wrong) if wrong else fit.toml("")
    with pytest.raises(hc.InputError, match="for example `big-cylinder`"):
        fit.toml("big cylinder")
    assert tomllib.loads(fit.toml("big cylinder", name="big_1"))["friction"]["big_1"]["cylinder"] == "big cylinder"


def test_no_slow_levels_leave_stribeck_friction_out():
    """Otherwise the Stribeck terms imitate the bend of the viscous ones, and Coulomb friction goes to zero."""
    fit = fit_static(synthetic_points(ROTTNE, speeds=np.geomspace(0.02, 0.1, 8), seed=1))
    assert fit.params["coulomb"] == fit.params["breakaway"] == pytest.approx((160.0, 280.0), rel=0.05)
    assert sum("is not seen in these levels" in w for w in fit.warnings) == 2
    assert fit.intervals()["breakaway.extending"] == (-np.inf, np.inf)
    assert "not identifiable" in fit.toml("test")


def test_no_fast_levels_are_said():
    fit = fit_static(synthetic_points(ROTTNE, speeds=np.geomspace(1e-4, 3e-3, 8)))
    assert any("add faster levels" in w for w in fit.warnings)
    low, high = fit.intervals()["viscous.extending"]
    assert high - low > fit.value("viscous.extending")


def test_a_map_that_does_not_fit_is_said():
    """Friction that swings with the logarithm of speed is no Stribeck curve."""
    points = synthetic_points(ROTTNE, force_error=1.0)
    bent = replace(points, force=points.sign * (400.0 + 60.0 * np.sin(2.0 * np.log(points.speed))))
    assert any("does not describe" in w or "levels lie" in w for w in fit_static(bent, loss="linear").warnings)


def test_one_direction_alone():
    points = synthetic_points(ROTTNE)
    fit = fit_static(points.select(points.direction == 0))
    assert fit.params["coulomb"][0] == pytest.approx(160.0, rel=0.05) and np.isnan(fit.params["coulomb"][1])
    assert any("no points retracting" in w for w in fit.warnings)
    with pytest.raises(hc.InputError, match="no friction retracting was measured"):
        fit.toml("test")
    assert np.isnan(graphical(points.select(points.direction == 0)).params["coulomb"][1])


def test_breakaway_readings_count_as_the_limit_of_rest():
    points = synthetic_points(ROTTNE, speeds=np.geomspace(3e-3, 0.1, 8))
    both = FrictionPoints.of(
        np.append(points.velocity, [0, 0, 0, 0]),
        np.append(points.force, [338.0, 342.0, -399.0, -401.0]),
        velocity_error=np.append(points.velocity_error, np.zeros(4)),
        force_error=4.0,
        direction=np.append(points.sign, [1, 1, -1, -1]),
    )
    fit = fit_static(both)
    assert fit.params["breakaway"] == pytest.approx((340.0, 400.0), rel=0.03)


def test_points_that_may_stand_still_are_left_out():
    points = synthetic_points(ROTTNE)
    coarse = replace(points, velocity_error=np.where(points.speed < 1.5e-4, 1e-4, points.velocity_error))
    fit = fit_static(coarse)
    assert len(fit.rejected) == 6 and "direction unknown" in fit.rejected[0].reason


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"exponents": "fre"}, "did you mean `free`"),
        ({"exponents": None}, "or a dict such as"),
        ({"exponents": {"viscous-exponent": [1, 2, 3]}}, "one per direction"),
        ({"held": {"viscous": 1.0}}, "viscous-exponent"),
        ({"exponents": {"stribeck": 2}}, "stribeck-exponent"),
        ({"exponents": {"stribeck-exponent": "loose"}}, "loose"),
        ({"exponents": {"viscous-exponent": -1.0}}, "between 0 and 10"),
        ({"loss": "soft"}, "soft_l1"),
        ({"bias": -3.0}, "standard deviation above zero"),
        ({"floor": -1.0}, "floor must be"),
    ],
)
def test_wrong_arguments_are_named(arguments, said):
    with pytest.raises(hc.InputError, match=said):
        fit_static(synthetic_points(ROTTNE), **arguments)


def test_all_at_rest_is_an_error():
    with pytest.raises(hc.InputError, match="break-away readings"):
        fit_static(FrictionPoints.of([0.0, 0.0], [300.0, -300.0], direction=[1, -1]))
    with pytest.raises(hc.InputError, match="larger than its error"):
        fit_static(FrictionPoints.of([1e-4, -1e-4], [300.0, -300.0], velocity_error=1e-4))


# --- reading by ruler, block, report ----------------------------------------------------------------------------------


@MAPS
def test_the_reading_by_ruler(law):
    """What Figure 67 gives from clean levels: forces to a few per cent, Stribeck velocity to the spacing of levels."""
    reading = graphical(synthetic_points(law, speeds=np.geomspace(1e-4, 0.1, 25), force_error=0.5))
    for name, close in (("coulomb", 0.1), ("breakaway", 0.02), ("stribeck-velocity", 0.15), ("viscous", 0.3)):
        assert reading.params[name] == pytest.approx(law.pairs[name], rel=close), name
    assert any("between levels" in w for w in reading.warnings)
    with pytest.raises(hc.InputError, match="fit_static"):
        reading.intervals()


@pytest.mark.parametrize("exponents", ["fixed", "free"])
def test_the_block_loads_and_gives_the_same_map(tmp_path, exponents):
    fit = fit_static(synthetic_points(ROTTNE, seed=4), exponents=exponents)
    block = fit.toml("test", source=["a.csv", 'odd "name".mat'], date="2024-05-01")
    table = tomllib.loads(block)["friction"]["test"]
    assert table["class"] == "fitted" and 'odd "name".mat' in table["source"] and "2024-05-01" in table["source"]
    assert ("held in the fit" in block) == (exponents == "fixed")
    path = tmp_path / "rig.toml"
    head = 'extends = "single-cylinder"\n[machine]\nname = "rig"\nclass = "setting"\nsource = "test"\n'
    path.write_text(head + block, encoding="utf-8")
    v = np.array([-0.08, -0.02, 0.02, 0.08])
    assert hc.load_machine(path).friction_map(v, "test") == pytest.approx(fit.force(v), rel=1e-3)


def test_the_report_holds_all_stages_and_survives_a_failed_one(tmp_path):
    points = synthetic_points(ROTTNE, seed=1)
    force = points.force.copy()
    force[7] += 200.0
    windows = [Window(*row) for row in zip(points.velocity, points.velocity_error, force, points.force_error)]
    found = identify_static(windows, source=["<a>.csv"], bias=10.0)
    report = found.report("test")
    assert not report.failures
    assert not report.stage("Dynamic friction", lambda: fit_static(FrictionPoints.of([], [])))
    path = report.write(tmp_path / "sub" / "report.html")
    plt.close("all")
    page = path.read_text(encoding="utf-8")
    for piece in ("&lt;a&gt;.csv", "Windows left out", "[friction.test]", "by ruler", "data:image/svg+xml;base64"):
        assert piece in page, piece
    assert "standard deviations off the map" in page and "Not finished: no friction points" in page
    assert "http" not in page.replace("http-equiv", "") and report.failures == ["Dynamic friction"]
    with pytest.raises(hc.ResultFileError, match=r"\.html"):
        report.write(tmp_path / "report.pdf")


@pytest.mark.evidence
@pytest.mark.parametrize("seed", range(25))
def test_nonsense_ends_in_a_result_or_in_one_clear_error(seed):
    """Few, wild or contradictory points: finite parameters with warnings, or an error that is ours."""
    rng = np.random.default_rng(seed)
    n = int(rng.choice([1, 2, 3, 5, 8, 20]))
    direction = rng.choice([-1.0, 1.0], n)
    velocity = np.where(rng.random(n) < 0.1, 0.0, direction * 10.0 ** rng.uniform(-5, 0, n))
    force = direction * float(rng.choice([0.0, 1.0, 1e5])) * rng.uniform(-0.5, 1.5, n)
    try:
        points = FrictionPoints.of(velocity, force, force_error=float(rng.choice([0.0, 3.0])), direction=direction)
        fit = fit_static(points, exponents=str(rng.choice(["fixed", "free"])), bias=rng.choice([None, 20.0]))
    except hc.HydrocraneError as error:
        assert str(error)
        return
    used = np.unique(points.direction)
    assert np.isfinite(fit.law.values.reshape(6, 2)[:, used]).all()
    assert not np.isnan(list(fit.intervals(method="t").values())).any()
