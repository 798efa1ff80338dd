"""A model is fitted to its logs: least squares with priors, and the covariance of what it finds.
                                                              theory: docs/theory/identification/dynamic.md

The unknowns are *keys* of the machine, on which the simulation depends, and *nuisances*, which only change the readings
(a sensor's zero, its span). Each may have a prior from a data sheet or an earlier fit. With residuals r in standard
deviations the fit minimises

    sum r^2 + sum ((theta - prior) / sigma_prior)^2 + (theta_j - mean_j)^T Cov_j^-1 (theta_j - mean_j)

with the last term for unknowns theta_j with a joint prior from an earlier fit. Its covariance is the inverse of the
information matrix J^T J, with J the derivatives of all terms. At assumed values this matrix is the Fisher information
of an experiment that has not been run.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from hydrocrane.arrays import Array
from hydrocrane.errors import HydrocraneError, InputError

if TYPE_CHECKING:
    import xarray as xr


# Singular values below this share of the largest belong to combinations of unknowns that the data do not identify.
BLIND = 1e-9


def inverse(slopes: Array) -> Array:
    """(J^T J)^-1; a combination of unknowns without information gets a huge variance in place of infinity."""
    _, s, vt = np.linalg.svd(slopes, full_matrices=False)
    weight = 1.0 / np.maximum(s, BLIND * s[0]) ** 2
    return np.asarray((vt.T * weight) @ vt, dtype=np.float64)


@dataclass(frozen=True)
class Inverse:
    """Inverse of the information of a fit.

    Attributes
    ----------
    from_data : ndarray, shape (n, n)
        Covariance of the unknowns from the scatter of the points; zero where `undetermined`.
    over_prior : ndarray, shape (n, k)
        Change of the unknowns per standard deviation of each sensor error.
    undetermined : ndarray of bool, shape (n,)
        Unknowns in a combination that does not affect any point.
    condition : float
    """

    from_data: Array
    over_prior: Array
    undetermined: NDArray[np.bool_]
    condition: float

    @property
    def from_prior(self) -> Array:
        """Covariance of the unknowns from the priors, (n, n)."""
        return self.over_prior @ self.over_prior.T

    @property
    def whole(self) -> Array:
        """Covariance of the unknowns, (n, n)."""
        return self.from_data + self.from_prior


def invert(jacobian: Array, deviations: Array) -> Inverse:
    """Covariance of the unknowns from the weighted derivatives of the points (n_points, n).

    `deviations` (k,) are those of the priors of the last k unknowns.
    """
    of_sensors = np.arange(jacobian.shape[1])[jacobian.shape[1] - deviations.size :]
    information = np.vstack([jacobian, np.eye(jacobian.shape[1])[of_sensors] / deviations[:, None]])
    size = np.linalg.norm(information, axis=0)
    size[size == 0.0] = 1.0
    _, s, vt = np.linalg.svd(information / size, full_matrices=False)
    kept = s > BLIND * s[0]
    undetermined = (np.abs(vt[~kept]) > 1e-3).any(axis=0)
    root = vt[kept].T / s[kept]
    inverse = (root @ root.T) / np.outer(size, size)
    weighted = inverse[:, of_sensors] / deviations
    condition = float(s[0] / s[-1]) if s[-1] > 0.0 else np.inf
    return Inverse(inverse - weighted @ weighted.T, weighted, undetermined, condition)


def correlation_of(covariance: Array) -> Array:
    """Correlations (k, k); NaN for unknowns without a finite deviation above zero."""
    sigma = np.sqrt(np.diag(covariance))
    known = np.isfinite(sigma) & (sigma > 0.0)
    out = np.full(covariance.shape, np.nan)
    out[np.ix_(known, known)] = covariance[np.ix_(known, known)] / np.outer(sigma[known], sigma[known])
    return out


def labelled(labels: Sequence[str], table: Array) -> xr.DataArray:
    """A square table (m, m) with its rows and columns by name."""
    import xarray as xr

    return xr.DataArray(table, dims=("parameter", "with"), coords={"parameter": list(labels), "with": list(labels)})


# From the values (k,), SI, to residuals in standard deviations (m,) and their derivatives (m, k) per SI unit.
ResidualFunction = Callable[[Array], tuple[Array, Array]]
# Relative change of cost or unknowns at which the search stops, far below that of one standard deviation.
TOLERANCE = 1e-5
MOST_EVALUATIONS = 40
# Lower limit of the prior variance of a combination of unknowns, as a share of the largest variance.
SINGULAR = 1e-10


@dataclass(frozen=True)
class Unknown:
    """One quantity to be fitted.

    Parameters
    ----------
    name : str
        Key of the machine file, or name of a nuisance.
    start : float
        SI.
    scale : float
        Typical change, SI; the search uses its multiples.
    prior : (float, float) or None
        Mean and standard deviation of the prior, SI.
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
            raise InputError(
                f"`{self.name}` needs a finite start and a scale above zero; got {self.start}, {self.scale}"
            )
        if self.prior is not None and not self.prior[1] > 0:
            raise InputError(f"the prior of `{self.name}` needs a deviation above zero; got {self.prior[1]}")

    def started(self, value: float) -> Unknown:
        """The same unknown with another start."""
        return replace(self, start=float(value))


@dataclass(frozen=True)
class JointPrior:
    """Joint prior of several unknowns from an earlier fit; they have no other prior.

    Parameters
    ----------
    names : tuple of str
        Of the unknowns.
    mean : (m,) array
        SI.
    covariance : (m, m) array
        In products of SI units. A combination with zero variance, such as the difference of two parameters that the
        earlier fit held equal, is held almost exactly.
    """

    names: tuple[str, ...]
    mean: Array
    covariance: Array

    def __post_init__(self) -> None:
        m = len(self.names)
        deviation = np.sqrt(np.diag(self.covariance)) if self.covariance.shape == (m, m) else np.zeros(m)
        if self.mean.shape != (m,) or not (np.isfinite(self.covariance).all() and (deviation > 0.0).all()):
            raise InputError(
                f"a joint prior of {m} unknowns needs ({m},) means and a finite ({m}, {m}) covariance with a diagonal "
                f"above zero; got shapes {self.mean.shape} and {self.covariance.shape}"
            )

    @property
    def deviations(self) -> Array:
        """(m,) standard deviations, SI."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def root(self) -> Array:
        """(m, m) W with W^T W the inverse of the covariance: W (theta - mean) are numbers of variance one."""
        deviation = self.deviations
        variance, vectors = np.linalg.eigh(self.covariance / np.outer(deviation, deviation))
        variance = np.maximum(variance, SINGULAR * variance[-1])
        return np.asarray(vectors.T / np.sqrt(variance)[:, np.newaxis] / deviation)


@dataclass(frozen=True)
class Estimate:
    """Result of a fit.

    Attributes
    ----------
    names : tuple of str
    values : (k,) array
        SI.
    bound : (k, k) array
        Inverse information at `values`: the smallest covariance that these data allow (Cramer-Rao).
    variance : float
        Weighted sum of squares per degree of freedom: near one if the stated noise is the true one.
    converged : bool
    message : str
    evaluations : int
    at_bound : tuple of str
        Unknowns that ended on a bound; their intervals are meaningless.
    """

    names: tuple[str, ...]
    values: Array
    bound: Array
    variance: float
    converged: bool
    message: str
    evaluations: int
    at_bound: tuple[str, ...]

    def __getitem__(self, name: str) -> float:
        return float(self.values[self.names.index(name)])

    @property
    def covariance(self) -> Array:
        """(k, k), SI: the bound, widened if the residuals exceed the stated noise."""
        return self.bound * max(self.variance, 1.0)

    def deviation(self, name: str) -> float:
        """Standard deviation of one unknown, SI."""
        i = self.names.index(name)
        return float(np.sqrt(self.covariance[i, i]))

    @property
    def correlation(self) -> Array:
        """(k, k) correlation matrix."""
        return correlation_of(self.bound)


def minimise(
    function: ResidualFunction, begin: Array, bounds: tuple[Array, Array], **options: object
) -> optimize.OptimizeResult:
    """Least squares from `begin` (k,) within bounds. The search asks for residuals and derivatives in turn, so the last
    point is kept."""
    last: tuple[Array, tuple[Array, Array]] | None = None

    def at(u: Array) -> tuple[Array, Array]:
        nonlocal last
        if last is None or not np.array_equal(last[0], u):
            last = u.copy(), function(u)
        return last[1]

    # A robust loss scales in place what it gets.
    return optimize.least_squares(
        lambda u: at(u)[0].copy(), begin, jac=lambda u: at(u)[1].copy(), bounds=bounds, **options
    )


def fit(
    unknowns: Sequence[Unknown],
    function: ResidualFunction,
    *,
    joint: JointPrior | None = None,
    tolerance: float = TOLERANCE,
    softened: float = 1.0,
) -> Estimate:
    """Fit the unknowns. The search steps back from values that `function` cannot evaluate.

    Parameters
    ----------
    joint : JointPrior, optional
        Joint prior of some of the unknowns.
    tolerance : float
        The search stops where cost or unknowns change by less, relative.
    softened : float
        Factor on all standard deviations of the data. Far from the solution the linearisation misjudges the nuisances;
        with a small weight of the data their priors hold them.
    """
    evaluator = _Evaluator(unknowns, function, joint, softened)
    low, high = (np.array([u.bounds[side] for u in unknowns]) / evaluator.scale for side in (0, 1))
    begin = np.clip(evaluator.start, low, high)
    # A trial far from the data may have a cost beyond all numbers; the search then goes back.
    with np.errstate(over="ignore"):
        found = minimise(
            evaluator, begin, (low, high), xtol=tolerance, ftol=tolerance, gtol=None, max_nfev=MOST_EVALUATIONS
        )
    freedom = max(evaluator.count - len(unknowns), 1)
    return Estimate(
        names=tuple(u.name for u in unknowns),
        values=np.asarray(found.x * evaluator.scale),
        bound=inverse(found.jac) * np.outer(evaluator.scale, evaluator.scale),
        variance=float(2.0 * found.cost * softened**2 / freedom),
        converged=bool(found.success),
        message=str(found.message),
        evaluations=evaluator.evaluations,
        at_bound=tuple(u.name for u, active in zip(unknowns, found.active_mask, strict=True) if active),
    )


def bound(
    unknowns: Sequence[Unknown], function: ResidualFunction, *, joint: JointPrior | None = None
) -> dict[str, float]:
    """Smallest standard deviations that an unbiased fit can reach at the unknowns' starts (Cramer-Rao), by name, SI.

    Priors count as data.
    """
    evaluator = _Evaluator(unknowns, function, joint)
    deviation = np.sqrt(np.diag(inverse(evaluator(evaluator.start)[1]))) * evaluator.scale
    return {u.name: float(d) for u, d in zip(unknowns, deviation, strict=True)}


class _Evaluator:
    """Residuals and derivatives of all logs and priors in scaled unknowns, reduced by an orthogonal transformation to
    one row more than there are unknowns. Sums of squares are unchanged, and the search does not decompose thousands of
    rows in each step.

    Attributes
    ----------
    count, evaluations : int
        Number of residuals, priors included, and of calls.
    """

    def __init__(
        self,
        unknowns: Sequence[Unknown],
        function: ResidualFunction,
        joint: JointPrior | None = None,
        softened: float = 1.0,
    ) -> None:
        self.function, self.softened, self.count, self.evaluations = function, softened, 0, 0
        self.scale = np.array([u.scale for u in unknowns])
        self.start = np.array([u.start for u in unknowns]) / self.scale
        self.known, self.mean = _priors(unknowns, joint)
        self._last: tuple[Array, Array] | None = None

    def __call__(self, scaled: Array) -> tuple[Array, Array]:
        """Residuals and their derivatives by the scaled unknowns."""
        self.evaluations += 1
        values = scaled * self.scale
        try:
            residuals, slopes = self.function(values)
        except HydrocraneError:
            if self._last is None:
                raise
            # The search steps back from what is not finite.
            return np.full_like(self._last[0], np.inf), self._last[1]
        rows = np.column_stack([self.known, self.known @ (values - self.mean)])
        both = np.vstack([np.column_stack([slopes, residuals]) / self.softened, rows])
        self.count = len(both)
        turned = np.asarray(np.linalg.qr(both, mode="r"))
        self._last = turned[:, -1], turned[:, :-1] * self.scale
        return self._last


def _priors(unknowns: Sequence[Unknown], joint: JointPrior | None) -> tuple[Array, Array]:
    """Rows (m, k) and means (k,) of all priors: rows (theta - means) are numbers of variance one."""
    single = [i for i, u in enumerate(unknowns) if u.prior is not None]
    mean = np.array([0.0 if u.prior is None else u.prior[0] for u in unknowns])
    rows = np.zeros((len(single), len(unknowns)))
    rows[np.arange(len(single)), single] = [1.0 / u.prior[1] for u in unknowns if u.prior is not None]
    if joint is None:
        return rows, mean
    names = [u.name for u in unknowns]
    at = [names.index(name) for name in joint.names]
    together = np.zeros((len(at), len(unknowns)))
    mean[at], together[:, at] = joint.mean, joint.root
    return np.vstack([rows, together]), mean
