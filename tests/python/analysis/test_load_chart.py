"""Load charts: what can be held at a reach, whatever the grid of poses."""

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane import plots
from hydrocrane.analysis.capacity import Places, capacity
from hydrocrane.plots.maps import load_chart as draw

pytestmark = pytest.mark.evidence

LAB, HIAB, SLIDER = "rottne-f9-lab", "hiab-xs031", "single-cylinder"


@pytest.fixture(scope="module", params=[LAB, HIAB])
def chart(request):
    return hc.load_chart(request.param, samples=12)


@pytest.fixture(scope="module")
def drawn(chart):
    """Random poses, their tips where they are permitted, and what they hold."""
    crane = chart.machine
    low, high = crane.joint_limits.T
    q = low + (high - low) * np.random.default_rng(1).random((300_000, 3))
    tip, load = crane.tip(q), np.nan_to_num(capacity(crane, q, 1e5)[0], nan=0.0)
    permitted = ~crane.forbidden(tip, load)
    return tip[permitted], load[permitted]


def near(where, value, width):
    return np.abs(where - value) < width


@pytest.mark.parametrize("height", ["best", "worst", 0.5])
def test_the_curve_does_not_depend_on_the_grid(chart, height):
    """It did: with 12 values per joint 40 kg stood beside 1000."""
    finer = hc.load_chart(chart.machine, samples=50)
    (reach, coarse), (same, fine) = chart.against_reach(height), finer.against_reach(height)
    np.testing.assert_allclose(reach, same, rtol=1e-12)
    np.testing.assert_allclose(coarse, fine, rtol=0.05, atol=1.0)


def test_neighbours_are_alike(chart):
    reach, best = chart.against_reach("best")
    inside = (reach > 1.5) & (reach < 0.95 * reach.max())
    assert (np.abs(np.diff(best[inside])) < 0.15 * best[inside][:-1]).all()


def test_best_is_what_no_drawn_pose_exceeds(chart, drawn):
    tip, load = drawn
    for reach, best in list(zip(*chart.against_reach("best"), strict=True))[5:-5:4]:
        found = load[near(tip[:, 0], reach, 0.005)]
        if found.size > 200 and np.isfinite(best):
            # Places beside this reach, half a centimetre off, may hold a little more.
            assert found.max() <= 1.04 * best + 1.0
            assert found.max() >= 0.9 * best - 1.0


def test_worst_is_what_every_height_within_reach_holds(chart):
    crane = chart.machine
    reach, worst = chart.against_reach("worst")
    places = Places(crane, 1e5, 192, 24)
    heights = np.linspace(-3.0, 5.5, 90)
    points = np.stack(np.meshgrid(reach, heights, indexing="ij"), axis=-1)
    at = places.payload(points)
    at = np.where(np.isfinite(at) & ~crane.forbidden(points, np.nan_to_num(at)), at, np.inf)
    told = np.isfinite(worst)
    assert (at.min(axis=1)[told] >= 0.9 * worst[told] - 5.0).all()
    assert (worst <= chart.against_reach("best")[1] + 1e-9)[told].all()


def test_a_chosen_height_is_held_in_the_best_pose_there(chart, drawn):
    tip, load = drawn
    reach, at = chart.against_reach(0.5)
    for place, payload in list(zip(reach, at, strict=True))[::5]:
        found = load[near(tip[:, 0], place, 0.03) & near(tip[:, 1], 0.5, 0.03)]
        if np.isfinite(payload) and found.size > 20:
            assert 0.85 * payload - 5.0 <= found.max() <= 1.15 * payload + 5.0
        elif found.size > 20:
            raise AssertionError(f"{place} m is within reach at 0.5 m")


def test_places_hold_what_their_poses_hold(chart):
    """Places of known poses: at least what that pose holds."""
    crane = chart.machine
    low, high = crane.joint_limits.T
    q = low + (high - low) * np.random.default_rng(2).uniform(0.05, 0.95, (200, 3))
    found, held = Places(crane, 1e5, 192, 24).payload(crane.tip(q)), np.nan_to_num(capacity(crane, q, 1e5)[0], nan=0.0)
    permitted = ~crane.forbidden(crane.tip(q), held)
    assert permitted.any() and np.isfinite(found[permitted]).all()
    assert (found >= 0.9 * held - 1.0)[permitted].all()


def test_one_joint_has_one_reach():
    chart = hc.load_chart(SLIDER, samples=12)
    best, worst = chart.against_reach("best"), chart.against_reach("worst")
    assert best[0].size == 1 and 0 < worst[1][0] <= best[1][0] * (1 + 1e-9)
    crane = hc.load_machine(SLIDER)
    height = float(crane.tip(crane.home)[1])
    assert chart.against_reach(height)[1][0] == pytest.approx(best[1][0], rel=1e-6)


@pytest.mark.parametrize("height", ["highest", True, np.nan, np.inf])
def test_a_wrong_height_is_refused(height):
    with pytest.raises(hc.InputError, match="best.*worst"):
        hc.load_chart(SLIDER, samples=3).against_reach(height)


def test_the_picture_says_which_height_and_cuts_nothing(chart):
    for height, labels in (
        (None, ["at the best height", "at the worst permitted height"]),
        (0.5, ["at z = 0.5 m"]),
        ("worst", ["at the worst permitted height"]),
    ):
        axes = draw(chart.machine, chart, height=height).axes[1]
        assert [line.get_label() for line in axes.lines] == labels
        assert [text.get_text() for text in axes.get_legend().get_texts()] == labels
        assert axes.get_ylim()[1] >= max(np.nanmax(line.get_ydata()) for line in axes.lines)
    assert draw is plots.load_chart
