"""Forbidden positions of the tip: left out of load charts and mode maps, and hatched."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.collections import PolyCollection

import hydrocrane as hc
from hydrocrane import plots
from hydrocrane.analysis.capacity import Places

GROUND = {"ground.height": "0.5 m", "ground.stiffness": "1e6 N/m", "payload.hang": "0.5 m"}


@pytest.fixture(scope="module")
def chart():
    return hc.load_chart("rottne-f9-lab", samples=8)


def test_the_chart_leaves_out_what_is_under_the_floor(chart):
    assert chart.forbidden.any() and np.isnan(chart.payload[chart.forbidden]).all()
    inside = chart.machine.clearance(chart.tip) < 0.0
    np.testing.assert_array_equal(inside, chart.forbidden)
    places = Places(chart.machine, 1e5, 48, 6)
    under, above = np.array([[2.5, -1.5], [2.5, -2.0]]), np.array([[2.5, -1.0], [2.5, 1.0]])
    assert np.isnan(places.payload(under)).all() and np.isfinite(places.payload(above)).all()


def test_best_and_worst_count_permitted_heights_only(chart):
    reach, best = chart.against_reach("best")
    near = int(np.argmin(np.abs(reach - 0.47)))
    assert best[near] == pytest.approx(539.0, rel=0.15), "1106 kg was held under the floor"
    worst = chart.against_reach("worst")[1]
    both = np.isfinite(best) & np.isfinite(worst)
    assert both.any() and (worst[both] <= best[both] + 1e-9).all()


def test_the_ground_forbids_as_far_down_as_the_load_hangs():
    machine = hc.load_machine("rottne-f9-lab", GROUND)
    tips = np.array([[2.5, 0.4], [2.5, 0.8], [2.5, 1.1]])
    assert machine.forbidden(tips, 0.0).tolist() == [True, False, False]
    assert machine.forbidden(tips, 100.0).tolist() == [True, True, False]


def test_maps_hatch_forbidden_positions_and_charts_have_lines_of_equal_load(chart):
    modes = hc.mode_map("rottne-f9-lab", samples=3)
    assert modes.forbidden.any() and np.isnan(modes.frequency[modes.forbidden]).all()
    for figure in (plots.load_chart(chart.machine, chart), plots.mode_map(chart.machine, modes)):
        hatched = [c for c in figure.axes[0].collections if isinstance(c, PolyCollection) and c.get_hatch()]
        assert hatched
        plt.close(figure)
    axes = plots.load_chart(chart.machine, chart).axes[0]
    assert any("kg" in text.get_text() for text in axes.texts)
