"""Points as a measurement would give them, from a map that is known: what a fit is tried on before it is trusted."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import real_array
from hydrocrane.errors import InputError
from hydrocrane.identification.points import FrictionPoints
from hydrocrane.identification.static_map import StaticMap


def synthetic_points(
    law: StaticMap,
    *,
    speeds: ArrayLike | None = None,
    windows: ArrayLike = 3,
    force_error: float = 4.0,
    velocity_error: float = 0.005,
    level_error: float = 0.0,
    offset: float = 0.0,
    seed: int = 0,
) -> FrictionPoints:
    """Steady points of both directions with normal errors.

    Parameters
    ----------
    speeds : array_like, optional
        Speed of each level, m/s; by default twelve from 0.1 mm/s to 0.1 m/s, as in the thesis's experiments.
    windows : int or array_like of int
        Windows per level; each level's true speed is met to within 1 %.
    force_error : float
        Standard error of the force of one window, N.
    velocity_error : float
        Standard error of the velocity, as a share of it.
    level_error : float
        Standard deviation, N, of an error that all windows of a level share; the points do not state it.
    offset : float
        Constant error of the force, N.
    """
    chosen = np.atleast_1d(np.geomspace(1e-4, 0.1, 12) if speeds is None else real_array(speeds, "speeds"))
    if (chosen <= 0.0).any():
        raise InputError("speeds must be positive; both directions are made from them")
    count = np.broadcast_to(np.asarray(windows, dtype=int), chosen.shape)
    if (count < 1).any():
        raise InputError("every level needs one window or more")
    rng = np.random.default_rng(seed)
    level = np.repeat(np.arange(2 * chosen.size), np.tile(count, 2))
    true = np.concatenate([chosen, -chosen])[level] * (1.0 + 0.01 * rng.uniform(-1.0, 1.0, level.size))
    shared = level_error * rng.normal(size=2 * chosen.size)[level]
    force = law.force(true) + shared + offset + force_error * rng.normal(size=level.size)
    error = velocity_error * np.abs(true)
    measured = true + error * rng.normal(size=level.size)
    return FrictionPoints.of(measured, force, velocity_error=error, force_error=force_error, source=(f"seed {seed}",))
