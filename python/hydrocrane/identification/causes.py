"""Tests of further dependences of friction, beside the velocity in the map; each cause is tested by itself.

Source: the F-test of one more term in a regression, Draper and Smith, Applied Regression Analysis, 1998, section 6.1.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.stats import chi2
from scipy.stats import f as fisher

from hydrocrane.arrays import Array, rms
from hydrocrane.identification.least_squares import Problem, floor_is_found, level_means
from hydrocrane.identification.points import FrictionPoints
from hydrocrane.identification.residual_analysis import SIGNIFICANT, Cause, ResidualAnalysis

# Least number of distinct values of a cause, and of points beyond the number of parameters.
PLACES, SPARE = 4, 3
# Cosines over the logarithm of the speed, in each direction, that stand for another form of the map.
WAVES = (1, 2, 3)
# Where a valve sets the pressures, the chamber that resists the motion follows the friction, by less than friction
# changes. What the map does not explain of its force must exceed the residuals by this factor.
APART = 3.0
# A cause of which the map leaves less than this share changes together with the speed.
MOSTLY = 0.5
# The straight line of a cause ends at no friction if the change over its range is this share of the friction.
VANISHES = 2.0


def residual_analysis(problem: Problem, x: Array) -> ResidualAnalysis:
    """Residuals of a fit, with their possible causes tested one by one.

    Each cause adds a term to the fitted map, with all parameters of the map free. An F-test decides whether the points
    are described better than by chance.
    """
    points = problem.points
    residuals, slopes = problem.residuals(x)
    theta = problem.theta(x)
    sigma = problem.standard_deviation(theta)
    size = np.abs(residuals + points.force)
    size = np.maximum(size, 1e-9 * float(np.abs(points.force).max()))
    own = replace(problem, floor=0.0).standard_deviation(theta)
    # The floor is that of a level: a point has its own errors and the level's.
    counts = points.levels.count[points.level]
    sigma = np.sqrt(own**2 + (sigma**2 - own**2) / counts)
    sigma = np.maximum(sigma, 1e-9 * float(np.abs(points.force).max()))
    # Errors with a prior keep their fitted values: if left free, they would absorb the causes.
    free = slopes[:, : problem.unknowns + len(problem.sensors.offsets)]
    left = -residuals
    causes = [
        _cause(name, values, left, free, sigma, points, size)
        for name, values in _candidates(points, slopes[:, : problem.unknowns], left)
    ]
    # A floor that was given is one of the stated errors.
    stated = np.maximum(own if problem.free_floor else problem.standard_deviation(theta), 1e-9 * size)
    weight, means, _ = level_means(points, residuals, stated)
    spare = means.size - problem.unknowns
    # Bounds may keep a map away from its levels even if it has as many parameters as levels.
    freedom = max(spare, 1)
    return ResidualAnalysis(
        p_value=float(chi2.sf(np.sum(weight * means**2), freedom)),
        spare=spare,
        floor=problem.floor if floor_is_found(problem) else float(np.sqrt(np.sum(means**2) / freedom)),
        point_error=float(np.median(own)),
        force=float(np.median(np.abs(points.force))),
        shares=left * points.sign / size,
        direction=points.direction,
        causes=tuple(sorted((c for c in causes if np.isfinite(c.p_value)), key=lambda cause: cause.p_value)),
        confounded=tuple(c for c in causes if c.hides),
    )


def _candidates(points: FrictionPoints, of_map: Array, left: Array) -> Iterator[tuple[str, Array]]:
    """Names and values (n,) of the possible causes that the points have."""
    yield "velocity", points.speed
    if points.position is not None:
        yield "position", points.position
    if points.time is not None:
        yield "time", points.time
    if points.chambers is not None:
        # The force of the chamber that resists the motion: the other one carries the friction.
        resists = 0.5 * (points.chambers.sum(axis=1) - points.sign * points.force)
        apart = resists - of_map @ np.linalg.lstsq(of_map, resists, rcond=None)[0]
        if np.std(apart) > APART * np.std(left):
            yield "pressure", resists
    if points.load is not None:
        yield "load", points.load


def _cause(
    name: str, values: Array, left: Array, free: Array, sigma: Array, points: FrictionPoints, size: Array
) -> Cause:
    """The F-test of one dependence."""
    shares = _waves(points) if name == "velocity" else _straight(values)[:, np.newaxis]
    unknown = Cause(name, values, np.nan, 0.0, np.zeros(values.size))
    if not shares.size or np.unique(values).size < (2 if name == "load" else PLACES):
        return unknown
    # A share of the friction, against the motion.
    added = shares * (points.sign * size)[:, np.newaxis] / sigma[:, np.newaxis]
    base = _basis(free / sigma[:, np.newaxis])
    rest, new = left / sigma, added - base @ (base.T @ added)
    rest = rest - base @ (base.T @ rest)
    # A dependence that the map's own parameters can represent is not identifiable.
    extra = _basis(new, np.linalg.norm(added, axis=0).max())
    spare = values.size - base.shape[1] - extra.shape[1]
    if spare < SPARE:
        return unknown
    if extra.shape[1] == 0:
        return replace(unknown, hidden=np.inf)
    gained = float(np.sum((extra.T @ rest) ** 2))
    remaining = max(float(rest @ rest) - gained, 1e-12)
    p_value = float(fisher.sf(gained / extra.shape[1] / (remaining / spare), extra.shape[1], spare))
    if name == "velocity":
        # The coefficients of cosines that the map can nearly represent mean nothing; their joint contribution does.
        fitted = extra @ (extra.T @ rest) * sigma * points.sign / size
        return Cause(name, values, p_value, rms(fitted), fitted)
    power = float(new[:, 0] @ new[:, 0])
    change = float(new[:, 0] @ rest) / power
    alike = power < MOSTLY**2 * float(added[:, 0] @ added[:, 0])
    hidden = float(np.sqrt(fisher.isf(SIGNIFICANT, 1, spare) * remaining / spare / power)) if alike else 0.0
    if abs(change) > VANISHES:
        return replace(unknown, hidden=hidden)
    return Cause(name, values, p_value, change, change * shares[:, 0], hidden)


def _straight(values: Array) -> Array:
    """Values from -1/2 to 1/2 over their range."""
    wide = float(np.ptp(values))
    return np.asarray((values - values.min()) / wide - 0.5 if wide > 0.0 else np.zeros_like(values))


def _waves(points: FrictionPoints) -> Array:
    """Cosines (n, k) over the logarithm of the speed in each direction that has enough levels."""
    columns = []
    for side in (0, 1):
        here = (points.direction == side) & (points.speed > 0.0)
        if np.unique(points.level[here]).size < PLACES:
            continue
        place = _straight(np.log(points.speed[here])) + 0.5
        for wave in WAVES:
            column = np.zeros(len(points))
            column[here] = np.cos(np.pi * wave * place)
            columns.append(column)
    return np.stack(columns, axis=-1) if columns else np.zeros((len(points), 0))


def _basis(columns: Array, against: float = 0.0) -> Array:
    """Orthonormal basis (n, r) of the space of the columns."""
    size = np.linalg.norm(columns, axis=0)
    scaled = columns / (np.maximum(size, 1e-300) if against == 0.0 else against)
    u, s, _ = np.linalg.svd(scaled, full_matrices=False)
    return np.asarray(u[:, s > (1e-9 if against == 0.0 else 1e-2)])
