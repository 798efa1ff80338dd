"""Grids of poses that a caller sizes: their number and their memory are bounded."""

import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.analysis import capacity, poses


@pytest.mark.parametrize("samples", [3000, 10**5, 10**9])
@pytest.mark.parametrize("draw", [hc.load_chart, hc.mode_map])
def test_a_map_beyond_its_memory_is_refused_with_a_size(draw, samples):
    with pytest.raises(hc.InputError, match=rf"samples={samples} would take .* GB .* more than 1 GB; give \d+ samples"):
        draw("rottne-f9-lab", samples=samples)


@pytest.mark.parametrize(
    ("units", "shape"),
    [
        (["rad", "rad", "m"], (60, 60, 8)),
        (["rad", "rad", "rad"], (60, 60, 8)),
        (["rad"] * 4, (60, 60, 8, 8)),
        (["rad"] * 6, (60, 60, 3, 3, 3, 3)),
        (["m", "rad", "m", "rad"], (8, 60, 8, 60)),
        (["m", "m"], (8, 8)),
        (["m"], (60,)),
        (["rad"], (60,)),
    ],
)
def test_the_number_of_poses_grows_with_the_square_of_the_samples_at_most(units, shape):
    limits = np.tile([0.0, 1.0], (len(units), 1))
    home = limits.mean(axis=1)
    machine = SimpleNamespace(joint_names=units, joint_units=units, joint_limits=limits, home=home, first_in_plane=0)
    assert poses.pose_grid(machine, 60).shape == (*shape, len(units))


@pytest.mark.parametrize("samples", [1, 2.5, "9", True])
def test_samples_that_are_no_number_of_poses_are_refused(samples):
    with pytest.raises(hc.InputError, match="a whole number, at least 2"):
        hc.load_chart("single-cylinder", samples=samples)


def test_a_chart_takes_the_memory_that_is_reckoned():
    tracemalloc.start()
    try:
        chart = hc.load_chart("rottne-f9-lab", samples=200)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    # A block on its way takes some 100 bytes for each pose.
    assert peak < 8 * chart.payload.size * (3 + poses._NUMBERS) + 150 * capacity._BLOCK
