"""Start values for the fit of a static map: the best point of a grid over the nonlinear parameters."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import numpy as np
from scipy.optimize import nnls

from hydrocrane.arrays import Array
from hydrocrane.identification.form import EACH, HELD, LINEAR, LORENTZIAN, Form
from hydrocrane.identification.points import FrictionPoints
from hydrocrane.identification.static_map import stribeck_share

# Stribeck velocities tried, from below the slowest to above the fastest level by this factor; exponents tried.
VELOCITIES, OUTSIDE = 16, 2.0
TRIED = {"stribeck-exponent": (0.7, 1.0, 2.0, 4.0), "viscous-exponent": (0.5, 0.75, 1.0, 1.25, 1.5, 2.0)}
# Least error of a level, as a share of the median force.
SHARE = 0.01


def start(points: FrictionPoints, form: Form, held: Mapping[str, Array], reference: float) -> Array:
    """Start values of the coordinates (12,); a direction without points has those of the other.

    Friction is linear in Coulomb force, Stribeck rise and viscous force. Non-negative least squares over the levels
    finds them for each Stribeck velocity and exponent of the grid.
    """
    tried = {name: _tried(form, name, held[name]) for name in TRIED}
    measured = [side for side in (0, 1) if (points.direction == side).any()]
    grid = list(product(*(range(len(values)) for values in tried.values())))
    found = [[_side(points, side, form, tried, at, reference) for at in grid] for side in measured]
    costs = np.array([[cost for cost, _ in row] for row in found])
    shared = EACH not in (form.stribeck_exponent, form.viscous_exponent)
    best = np.full(len(measured), costs.sum(axis=0).argmin()) if shared else costs.argmin(axis=1)
    theta = np.zeros((6, 2))
    for row, side, k in zip(found, measured, best, strict=True):
        theta[:, side] = row[int(k)][1]
    if len(measured) == 1:
        theta[:, 1 - measured[0]] = theta[:, measured[0]]
    return theta.ravel()


def _tried(form: Form, name: str, held: Array) -> list[Array]:
    """Values of an exponent to try, as pairs."""
    alone = {HELD: held, LORENTZIAN: held, LINEAR: np.ones(2)}.get(form.freedom(name))
    return [np.full(2, value) for value in TRIED[name]] if alone is None else [alone]


def _side(
    points: FrictionPoints,
    side: int,
    form: Form,
    tried: Mapping[str, list[Array]],
    at: tuple[int, ...],
    reference: float,
) -> tuple[float, Array]:
    """Least sum of squares of one direction at given exponents, and its coordinates (6,)."""
    levels = points.levels
    here = levels.direction == side
    speed, force = np.abs(levels.velocity[here]), np.abs(levels.force[here])
    floor = SHARE * float(np.median(np.abs(points.force)))
    weight = 1.0 / np.hypot(levels.error[here] / np.sqrt(levels.count[here]), max(floor, 1e-12))
    fall, power = (float(values[k][side]) for values, k in zip(tried.values(), at, strict=True))
    moving = speed[speed > 0.0]
    slowest, fastest = (float(moving.min()), float(moving.max())) if moving.size else (1e-4, 1e-2)
    velocities = np.geomspace(slowest / OUTSIDE, fastest * OUTSIDE, VELOCITIES if form.stribeck[side] else 1)
    viscous = (speed / reference) ** power
    best, theta = np.inf, np.zeros(6)
    for velocity in velocities:
        rise = stribeck_share(speed / velocity, None if form.lorentzian else fall) * form.stribeck[side]
        columns = np.stack([np.ones_like(speed), rise, viscous], axis=-1)
        sizes, distance = nnls(columns * weight[:, None], force * weight)
        if distance < best:
            best = distance
            theta = np.array([sizes[0], sizes[1], np.log(velocity), np.log(fall), sizes[2], power])
    return best**2, theta
