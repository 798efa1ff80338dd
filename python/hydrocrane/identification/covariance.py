"""Covariances of fitted values: from the derivatives of a fit, and as correlations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hydrocrane.arrays import Array

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
