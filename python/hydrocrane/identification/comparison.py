"""Does friction change with load or supply pressure?   Thesis 5.2.4, Figures 74 and 75, as a statistical test."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares
from scipy.stats import f as fisher
from scipy.stats import t as student

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.identification.form import Exponents
from hydrocrane.identification.least_squares import Loss, level_means
from hydrocrane.identification.points import DIRECTIONS, FrictionPoints
from hydrocrane.identification.profile import Solved
from hydrocrane.identification.result import StaticFit
from hydrocrane.identification.setup import FLOOR_SHARE
from hydrocrane.identification.static_fit import fit_static
from hydrocrane.identification.static_map import Coordinates

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Difference:
    """Friction of one group less that of the reference group, against motion; arrays of shape (n,).

    Attributes
    ----------
    group, reference : str
    velocity : ndarray
        Where both were measured, m/s.
    force, error : ndarray
        Difference of the maps and its standard error, N; positive: more friction than the reference.
    reference_force : ndarray
        Magnitude of the reference's friction, N.
    degrees_of_freedom : float
        Of the errors.
    """

    group: str
    reference: str
    velocity: Array
    force: Array
    error: Array
    reference_force: Array
    degrees_of_freedom: float

    @property
    def share(self) -> Array:
        """Difference over the reference's friction."""
        return self.force / self.reference_force

    def interval(self, level: float = 0.95) -> tuple[Array, Array]:
        """Pointwise confidence interval, N."""
        reach = student.ppf(0.5 + level / 2, self.degrees_of_freedom) * self.error
        return self.force - reach, self.force + reach

    @property
    def largest(self) -> int:
        """Index of the largest difference as a share."""
        return int(np.argmax(np.abs(self.share)))

    def equivalence_p(self, margin: float) -> float:
        """Probability of a difference this small if the true one were `margin` of the friction or more somewhere.

        Two one-sided tests at every velocity; the worst velocity counts.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            room = (margin * self.reference_force - np.abs(self.force)) / self.error
        return float(np.max(student.sf(np.nan_to_num(room, nan=0.0), self.degrees_of_freedom)))


@dataclass(frozen=True)
class FrictionComparison:
    """Comparison of the friction maps of several groups.

    Attributes
    ----------
    fits : dict
        The map of each group.
    differences : tuple of Difference
        Each group against the first.
    p_value : float
        Probability of groups that differ this much if one map holds for all (nested F-test).
    equivalence_p : float
        Probability of differences this small if one of them reached the margin (two one-sided tests).
    statistic, degrees_of_freedom
        Of the F-test.
    margin, significance : float
        Margin of equivalence, as a share of the friction, and significance level of the decision.
    """

    fits: dict[str, StaticFit]
    differences: tuple[Difference, ...]
    p_value: float
    equivalence_p: float
    statistic: float
    degrees_of_freedom: tuple[int, int]
    margin: float
    significance: float

    @property
    def effect(self) -> Difference:
        """The group that differs most from the first."""
        return max(self.differences, key=lambda d: float(np.max(np.abs(d.share))))

    @property
    def conclusion(self) -> str:
        """``different``, ``different-within-margin``, ``equivalent`` or ``undecided``."""
        if self.p_value < self.significance:
            return "different-within-margin" if self.equivalence_p < self.significance else "different"
        return "equivalent" if self.equivalence_p < self.significance else "undecided"

    @property
    def sentence(self) -> str:
        """The conclusion in words, with numbers."""
        d = self.effect
        k = d.largest
        low, high = d.interval(1.0 - self.significance)
        size = (
            f"largest difference {100 * d.share[k]:+.0f} % ({d.force[k]:+.0f} N, "
            f"{100 * (1 - self.significance):g} % interval {low[k]:+.0f} to {high[k]:+.0f} N) at "
            f"{d.velocity[k] * 1e3:.3g} mm/s, {d.group} against {d.reference}"
        )
        margin = f"{100 * self.margin:g} %"
        return {
            "different": f"The groups differ (p = {self.p_value:.2g}), and not by less than {margin}: {size}.",
            "different-within-margin": f"The groups differ (p = {self.p_value:.2g}), by less than {margin}: {size}.",
            "equivalent": (
                f"No difference found (p = {self.p_value:.2g}), and one of {margin} is ruled out "
                f"(p = {self.equivalence_p:.2g}): {size}."
            ),
            "undecided": (
                f"No difference found (p = {self.p_value:.2g}), but one of {margin} is not ruled out either "
                f"(p = {self.equivalence_p:.2g}): {size}. More windows would decide."
            ),
        }[self.conclusion]

    @property
    def verdict(self) -> str:
        """The same as `conclusion`, under its former name."""
        return self.conclusion

    def plot(self) -> Figure:
        """Maps and points of the groups, and their differences with the margin."""
        from hydrocrane.plots.identification import friction_comparison

        return friction_comparison(self)


def compare_friction(
    groups: Mapping[str, FrictionPoints],
    *,
    margin: float = 0.1,
    significance: float = 0.05,
    exponents: Exponents = "chosen",
    held: Mapping[str, ArrayLike] | None = None,
    offset_deviation: float = 0.0,
) -> FrictionComparison:
    """Test whether groups of points (loads, supply pressures, days) share one friction map.

    Parameters
    ----------
    groups : mapping
        Points by the name of their group; the first is the reference.
    margin : float
        Share of the friction below which a difference does not matter.
    significance : float
        Accepted probability of a wrong conclusion.
    exponents, held
        As for :func:`fit_static`; a choice is made once, from the points of all groups.
    offset_deviation : float
        Standard deviation, N, of a constant force error that differs between groups and between directions, such as the
        effect of a span error of the pressure transmitters at another load or supply pressure, or of an inexact weight.
        Zero: all groups have the same error.
    """
    _check(groups, margin, significance, offset_deviation)
    everything = np.concatenate([points.force for points in groups.values()])
    floor = FLOOR_SHARE * float(np.median(np.abs(everything)))
    together = FrictionPoints.joined(list(groups.values()))
    form = fit_static(together, exponents=exponents, held=held, floor=floor).form

    def fitted(points: FrictionPoints, loss: Loss = "soft_l1") -> StaticFit:
        return fit_static(points, exponents=exponents, held=held, form=form, floor=floor, loss=loss)

    fits = {name: fitted(points) for name, points in groups.items()}
    reference, *others = fits
    differences = tuple(_difference(fits, name, reference, offset_deviation) for name in others)
    statistic, freedom = _nested_test(list(fits.values()), lambda points: fitted(points, "linear"), offset_deviation)
    return FrictionComparison(
        fits=fits,
        differences=differences,
        p_value=float(fisher.sf(statistic, *freedom)),
        equivalence_p=max(d.equivalence_p(margin) for d in differences),
        statistic=statistic,
        degrees_of_freedom=freedom,
        margin=margin,
        significance=significance,
    )


def _check(groups: Mapping[str, FrictionPoints], margin: float, significance: float, deviation: float) -> None:
    if len(groups) < 2:
        raise InputError(f"a comparison needs two groups of points or more, got {len(groups)}")
    if not 0.0 < margin < 1.0:
        raise InputError(f"margin is a share of the friction between 0 and 1, got {margin:g}; 0.1 means 10 %")
    if not 0.0 < significance < 0.5:
        raise InputError(f"significance must lie between 0 and 0.5, got {significance:g}; 0.05 is usual")
    if not (np.isfinite(deviation) and deviation >= 0.0):
        raise InputError(f"offset_deviation must be a force of zero or more, N, got {deviation}")


def _solved(fit: StaticFit) -> Solved:
    assert isinstance(fit.solved, Solved) and fit.spread is not None
    return fit.solved


def _nested_test(
    fits: list[StaticFit], fitted: Callable[[FrictionPoints], StaticFit], deviation: float
) -> tuple[float, tuple[int, int]]:
    """F statistic of one common map against one map per group. The scatter of the levels about the separate maps is the
    scale."""
    solved = [_solved(fit) for fit in fits]
    levels = [s.problem.points.levels.count.size for s in solved]
    unknowns = [s.problem.unknowns for s in solved]
    spare = sum(levels) - sum(unknowns)
    if spare < 1:
        raise InputError(
            f"{sum(levels)} velocity levels for {sum(unknowns)} parameters: nothing is left to compare with; add levels"
        )
    expected = [s.sigma / max(fit.spread.scale, 1e-9) for s, fit in zip(solved, fits, strict=True) if fit.spread]
    separate = 0.0
    for s, sigma in zip(solved, expected, strict=True):
        weight, mean, _ = level_means(s.problem.points, s.problem.residuals(s.x)[0], sigma)
        separate += float(np.sum(weight * mean**2))
    scale = float(np.sqrt(separate / spare)) or 1e-9
    sigma = np.concatenate(expected) * scale
    apart = sum(float(np.sum((s.problem.residuals(s.x)[0] / (e * scale)) ** 2)) for s, e in zip(solved, expected))
    together, free = _pooled(solved, sigma, fitted, deviation)
    extra = sum(unknowns) - free
    return max(together - apart, 0.0) / extra, (extra, spare)


def _pooled(
    solved: list[Solved], sigma: Array, fitted: Callable[[FrictionPoints], StaticFit], deviation: float
) -> tuple[float, int]:
    """Least sum of squares of one map for all groups. All groups but the first may have an offset per direction."""
    groups = [s.problem.points for s in solved]
    points = FrictionPoints.joined(groups)
    first = fitted(points)
    coordinates = Coordinates(float(points.speed.max()))
    start = coordinates.of_map(first.law)
    problem = replace(_solved(first).problem, points=points, coordinates=coordinates, start=start)
    member = np.repeat(np.arange(len(groups)), [len(g) for g in groups])
    # Number of the offset of each point; below zero for those of the first group.
    shifted = len(DIRECTIONS) * (member - 1) + points.direction
    offsets = len(DIRECTIONS) * (len(groups) - 1) if deviation > 0.0 else 0
    of_shift = (shifted[:, None] == np.arange(offsets)).astype(float)
    low, high = problem.bounds()

    def residual(u: Array) -> Array:
        shift = u[problem.unknowns :]
        residuals = problem.residuals(u[: problem.unknowns])[0] + of_shift @ shift
        return np.append(residuals / sigma, shift / deviation if offsets else [])

    def slopes(u: Array) -> Array:
        of_map = problem.residuals(u[: problem.unknowns])[1] / sigma[:, None]
        if not offsets:
            return of_map
        prior = np.hstack([np.zeros((offsets, problem.unknowns)), np.eye(offsets) / deviation])
        return np.vstack([np.hstack([of_map, of_shift / sigma[:, None]]), prior])

    wide = np.full(offsets, np.inf)
    begin = np.append(np.clip(problem.begin(start), low, high), np.zeros(offsets))
    found = least_squares(
        residual, begin, jac=slopes, bounds=(np.append(low, -wide), np.append(high, wide)), x_scale="jac"
    )
    return 2.0 * float(found.cost), problem.unknowns


def _difference(fits: Mapping[str, StaticFit], name: str, reference: str, deviation: float) -> Difference:
    one, other = fits[reference], fits[name]
    v = _common_velocities(one, other)
    if v.size == 0:
        raise InputError(f"groups `{name}` and `{reference}` have no velocities in common")
    sign = np.sign(v)
    errors = [other.force_error(v), one.force_error(v)]
    freedoms = [fit.spread.degrees_of_freedom for fit in (other, one) if fit.spread]
    # Welch: degrees of freedom of a sum of two estimated variances; the least over all velocities counts.
    with np.errstate(divide="ignore", invalid="ignore"):
        total = errors[0] ** 2 + errors[1] ** 2
        freedom = total**2 / sum(e**4 / f for e, f in zip(errors, freedoms, strict=True))
    return Difference(
        group=name,
        reference=reference,
        velocity=v,
        force=(other.force(v) - one.force(v)) * sign,
        error=np.sqrt(total + deviation**2),
        reference_force=np.abs(one.force(v)),
        degrees_of_freedom=float(np.min(np.nan_to_num(freedom, nan=min(freedoms), posinf=1e9))),
    )


def _common_velocities(one: StaticFit, other: StaticFit) -> Array:
    """Levels of the first fit within the velocity range of the second, m/s."""
    found = []
    for side in range(len(DIRECTIONS)):
        speeds = [np.abs(f.points.levels.velocity[f.points.levels.direction == side]) for f in (one, other)]
        if all(s.size for s in speeds):
            # A level of the other within a tenth still counts as the same.
            inside = (speeds[0] >= 0.9 * speeds[1].min()) & (speeds[0] <= 1.1 * speeds[1].max()) & (speeds[0] > 0.0)
            found.append(speeds[0][inside] * (1.0 if side == 0 else -1.0))
    return np.concatenate(found) if found else np.array([])
