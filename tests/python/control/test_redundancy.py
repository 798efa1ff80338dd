"""The resolution of the redundancy is the optimum that it claims to be, by solvers that know nothing of it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog, lsq_linear

from hydrocrane import _core

REST = (0.0, 0.0)


def problem(seed: int, joints: int = 3, fast: float = 0.5):
    """A random chain away from singular postures, request and limits.

    Jacobian, velocity, weights, preferred rates, bounds; a thousandth of a singular posture is where the damping shows.
    """
    rng = np.random.default_rng(seed)
    jacobian = rng.normal(size=(2, joints))
    while np.linalg.cond(jacobian) > 5.0 or np.abs(jacobian).min() < 0.1:
        jacobian = rng.normal(size=(2, joints))
    bounds = np.column_stack([-rng.uniform(0.05, 1.0, joints), rng.uniform(0.05, 1.0, joints)])
    weights = rng.uniform(0.2, 5.0, joints)
    return jacobian, fast * rng.normal(size=2), weights, 0.1 * rng.normal(size=joints), bounds


def largest_share(jacobian, velocity, bounds) -> float:
    """The largest s in 0 to 1 with J q' = s v inside the bounds, by a linear programme."""
    joints = jacobian.shape[1]
    found = linprog(
        np.append(np.zeros(joints), -1.0),
        A_eq=np.column_stack([jacobian, -velocity]),
        b_eq=np.zeros(2),
        bounds=[*bounds, (0.0, 1.0)],
    )
    assert found.success
    return found.x[-1]


@pytest.mark.parametrize("joints", [2, 3, 4, 6])
@pytest.mark.parametrize("fast", [0.2, 1.0, 5.0])
def test_no_faster_motion_keeps_the_direction(fast, joints):
    for seed in range(60):
        jacobian, velocity, weights, preferred, bounds = problem(seed, joints, fast)
        rates, share = _core.resolve_rates(jacobian, tuple(velocity), REST, weights, preferred, bounds)
        assert share == pytest.approx(largest_share(jacobian, velocity, bounds), abs=1e-6), seed
        np.testing.assert_allclose(jacobian @ rates, share * velocity, atol=1e-6)
        assert (rates > bounds[:, 0] - 1e-9).all() and (rates < bounds[:, 1] + 1e-9).all()


@pytest.mark.parametrize("joints", [3, 6])
def test_of_all_motions_as_fast_it_takes_the_one_of_least_effort(joints):
    """Against bounded least squares with the tip's velocity as a stiff condition."""
    for seed in range(150):
        jacobian, velocity, weights, preferred, bounds = problem(seed, joints)
        rates, share = _core.resolve_rates(jacobian, tuple(velocity), REST, weights, preferred, bounds)
        stiff = 1e6
        matrix = np.vstack([np.diag(np.sqrt(weights)), stiff * jacobian])
        request = np.concatenate([np.sqrt(weights) * preferred, stiff * share * velocity])
        best = lsq_linear(matrix, request, bounds=tuple(bounds.T), method="bvls", tol=1e-14).x

        def effort(q, weights=weights, preferred=preferred):
            return float((weights * (q - preferred) ** 2).sum())

        assert effort(rates) < effort(best) + 1e-6, seed


def test_arrays_that_do_not_fit_are_told():
    one = np.ones(3)
    with pytest.raises(ValueError, match="bounds"):
        _core.resolve_rates(np.ones((2, 3)), REST, REST, one, one, np.zeros((2, 2)))
    with pytest.raises(ValueError, match="1 to 6 joints"):
        _core.resolve_rates(np.ones((2, 7)), REST, REST, np.ones(7), np.ones(7), np.zeros((7, 2)))
