"""Output-error fitting: a simulated experiment is fitted to its log.      theory: docs/theory/identification/dynamic.md

The unknowns are of three kinds: *keys* of the machine, which the simulation depends on; *nuisances*, which only change
the readings (a sensor's bias, the direction-dependent part of a potentiometer); and priors hold either where the data
sheet or an earlier fit knows something. With residuals r, each divided by its standard deviation, the fit minimises

    sum r^2 + sum ((theta - prior) / sigma_prior)^2

and its covariance is the inverse of the information matrix J^T J, J being exact: the slopes of the simulated signals
come from :func:`hydrocrane.sensitivity`, those of the nuisances are written down. The same matrix at assumed values is
the Fisher information of an experiment that nobody has run yet.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import optimize

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError


Misfit = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True)
class Unknown:
    """One quantity to be fitted.

    Parameters
    ----------
    name : str
        Key of the machine file, or of a nuisance.
    start : float
        SI.
    scale : float
        A change that matters, SI; the search works in its multiples.
    prior : (float, float) or None
        Mean and standard deviation known beforehand, SI.
    bounds : (float, float)
        SI.
    """

    name: str
    start: float
    scale: float
    prior: tuple[float, float] | None = None
    bounds: tuple[float, float] = (-np.inf, np.inf)

    def __post_init__(self) -> None:
        if not (np.isfinite(self.start) and np.isfinite(self.scale) and self.scale > 0):
            raise InputError(f"`{self.name}` needs a finite start and a scale above zero; got {self.start}, {self.scale}")
        if self.prior is not None and not self.prior[1] > 0:
            raise InputError(f"the prior of `{self.name}` needs a deviation above zero; got {self.prior[1]}")


@dataclass(frozen=True)
class Estimate:
    """What a fit found.

    Attributes
    ----------
    names : tuple of str
    values : (k,) array
        SI.
    covariance : (k, k) array
        Inverse information at `values`, scaled by `variance` where that exceeds one.
    variance : float
        Weighted sum of squares per degree of freedom: near one if the stated noise is the true one.
    converged : bool
    message : str
    evaluations : int
    at_bound : tuple of str
        Unknowns that ended on a bound: their intervals mean nothing.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array
    variance: float
    converged: bool
    message: str
    evaluations: int
    at_bound: tuple[str, ...]

    def __getitem__(self, name: str) -> float:
        return float(self.values[self.names.index(name)])

    def deviation(self, name: str) -> float:
        """Standard deviation of one unknown, SI."""
        i = self.names.index(name)
        return float(np.sqrt(self.covariance[i, i]))

    @property
    def correlation(self) -> Array:
        """(k, k) correlation matrix."""
        deviation = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(deviation, deviation), dtype=np.float64)


class Evaluator:
    """Residuals and slopes of all logs and priors at one point, kept because the search asks for both in turn."""

    def __init__(self, unknowns: Sequence[Unknown], misfit: Callable[[Array], tuple[Array, Array]]) -> None:
        self.unknowns = tuple(unknowns)
        self.misfit = misfit
        self.scale = np.array([u.scale for u in unknowns])
        self.known = [(i, *u.prior) for i, u in enumerate(unknowns) if u.prior is not None]
        self.evaluations = 0
        self._at: Array | None = None
        self._residuals = np.empty(0)
        self._slopes = np.empty((0, 0))

    def residuals(self, scaled: Array) -> Array:
        self._evaluate(scaled)
        return self._residuals

    def slopes(self, scaled: Array) -> Array:
        """Slopes per scaled unknown."""
        self._evaluate(scaled)
        return self._slopes

    def _evaluate(self, scaled: Array) -> None:
        if self._at is not None and np.array_equal(self._at, scaled):
            return
        values = scaled * self.scale
        residuals, slopes = self.misfit(values)
        prior = np.array([(values[i] - mean) / deviation for i, mean, deviation in self.known])
        rows = np.zeros((len(self.known), len(values)))
        for row, (i, _, deviation) in enumerate(self.known):
            rows[row, i] = 1.0 / deviation
        self._residuals = np.concatenate([residuals, prior])
        self._slopes = np.vstack([slopes, rows]) * self.scale
        self._at = scaled.copy()
        self.evaluations += 1


def fit(
    unknowns: Sequence[Unknown],
    misfit: Callable[[Array], tuple[Array, Array]],
    *,
    loss: str = "linear",
    most_evaluations: int = 60,
) -> Estimate:
    """Fit the unknowns.

    Parameters
    ----------
    unknowns : sequence of Unknown
    misfit : callable
        From the values (k,), SI, to weighted residuals (m,) and their slopes (m, k) per SI unit.
    loss : str
        As of :func:`scipy.optimize.least_squares`; ``soft_l1`` forgives outliers.
    most_evaluations : int
    """
    evaluator = Evaluator(unknowns, misfit)
    low = np.array([u.bounds[0] for u in unknowns]) / evaluator.scale
    high = np.array([u.bounds[1] for u in unknowns]) / evaluator.scale
    start = np.clip(np.array([u.start for u in unknowns]) / evaluator.scale, low, high)
    found = optimize.least_squares(
        evaluator.residuals,
        start,
        jac=evaluator.slopes,
        bounds=(low, high),
        loss=loss,
        x_scale=1.0,
        xtol=1e-10,
        ftol=1e-10,
        gtol=1e-10,
        max_nfev=most_evaluations,
    )
    slopes = evaluator.slopes(found.x)
    residuals = evaluator.residuals(found.x)
    data = len(residuals) - len(evaluator.known)
    freedom = max(data + len(evaluator.known) - len(unknowns), 1)
    variance = float(np.sum(residuals**2) / freedom)
    covariance = _inverse(slopes) * np.outer(evaluator.scale, evaluator.scale) * max(variance, 1.0)
    at_bound = tuple(u.name for u, active in zip(unknowns, found.active_mask) if active)
    return Estimate(
        names=tuple(u.name for u in unknowns),
        values=np.asarray(found.x * evaluator.scale),
        covariance=covariance,
        variance=variance,
        converged=bool(found.success),
        message=str(found.message),
        evaluations=evaluator.evaluations,
        at_bound=at_bound,
    )


def bound(unknowns: Sequence[Unknown], misfit: Callable[[Array], tuple[Array, Array]]) -> Mapping[str, float]:
    """Smallest standard deviation that an unbiased fit can reach (Cramer-Rao), by name, SI; priors count as data."""
    evaluator = Evaluator(unknowns, misfit)
    slopes = evaluator.slopes(np.array([u.start for u in unknowns]) / evaluator.scale)
    deviation = np.sqrt(np.diag(_inverse(slopes))) * evaluator.scale
    return {u.name: float(d) for u, d in zip(unknowns, deviation)}


def _inverse(slopes: Array) -> Array:
    """(J^T J)^-1; a direction that the data say nothing of gets a variance of 1e24 in place of infinity."""
    _, s, vt = np.linalg.svd(slopes, full_matrices=False)
    weight = 1.0 / np.maximum(s, 1e-12) ** 2
    return np.asarray((vt.T * weight) @ vt, dtype=np.float64)
