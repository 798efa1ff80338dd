"""The distance of the tip from its commanded path: the pieces that are left out change nothing."""

from __future__ import annotations

import numpy as np
import pytest

from hydrocrane.results.samples import distance_to_path


def by_all_pieces(points: np.ndarray, path: np.ndarray) -> np.ndarray:
    """The same distance, with every piece of the path for every point."""
    begin, way = path[:-1], np.diff(path, axis=0)
    to = points[:, None] - begin
    share = np.clip((to * way).sum(axis=2) / np.maximum((way**2).sum(axis=1), 1e-300), 0.0, 1.0)
    return np.linalg.norm(to - share[..., None] * way, axis=2).min(axis=1)


@pytest.mark.parametrize("step", [1e-3, 0.05, 3.0])
@pytest.mark.parametrize("seed", range(4))
def test_pieces_far_away_are_left_out_without_an_effect(seed, step):
    rng = np.random.default_rng(seed)
    path = np.cumsum(step * rng.standard_normal((400, 2)), axis=0)
    points = path[rng.integers(0, 400, 150)] + rng.choice([1e-3, 0.1, 5.0]) * rng.standard_normal((150, 2))
    np.testing.assert_allclose(distance_to_path(points, path), by_all_pieces(points, path), rtol=1e-12, atol=1e-12)


def test_a_path_of_one_point_and_points_that_are_no_numbers():
    point = np.array([[3.0, 4.0]])
    assert distance_to_path(point, np.zeros((1, 2))) == [5.0]
    assert np.isnan(distance_to_path(np.full((2, 2), np.nan), np.array([[0.0, 0.0], [1.0, 1.0]]))).all()
    assert distance_to_path(np.empty((0, 2)), point).shape == (0,)
