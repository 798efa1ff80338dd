"""Does friction change with load or supply pressure?   Thesis 5.2.4, Figures 74 and 75, as a statistical test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import OptimizeResult
from scipy.stats import f as fisher
from scipy.stats import t as student

from hydrocrane.arrays import Array
from hydrocrane.asked import ask
from hydrocrane.errors import InputError
from hydrocrane.identification.solve import invert, minimise
from hydrocrane.identification.static.fit import best_map, fit_static
from hydrocrane.identification.static.intervals import Solved
from hydrocrane.identification.static.maps import Exponents, FormRequest
from hydrocrane.identification.static.points import DIRECTIONS, FrictionPoints
from hydrocrane.identification.static.problem import FLOOR_SHARE, Bias, Problem, level_means, sensor_errors
from hydrocrane.identification.static.result import StaticFit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class FrictionDifference:
    """Friction of one group less that of the reference group, against motion; arrays of shape (n,).

    The maps compared are those of the joint fit, in which all groups share the errors of the sensors.

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
    differences : tuple of FrictionDifference
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
    differences: tuple[FrictionDifference, ...]
    p_value: float
    equivalence_p: float
    statistic: float
    degrees_of_freedom: tuple[int, int]
    margin: float
    significance: float

    @property
    def effect(self) -> FrictionDifference:
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
                f"(p = {self.equivalence_p:.2g}): {size}. More windows, or sensors with less error, would decide."
            ),
        }[self.conclusion]

    def plot(self) -> Figure:
        """Maps and points of the groups, and their differences with the margin."""
        return cast("Figure", ask("plots", "friction-comparison", self))


def compare_friction(
    groups: Mapping[str, FrictionPoints],
    *,
    margin: float = 0.1,
    significance: float = 0.05,
    exponents: Exponents = "chosen",
    held: Mapping[str, ArrayLike] | None = None,
    bias: Bias = None,
    span: float = 0.0,
    linearity_error: float = 0.0,
) -> FrictionComparison:
    """Test whether groups of points (loads, supply pressures, days) share one friction map.

    Errors of the sensors are common to all groups but affect them differently: at another supply pressure a wrong span
    shifts the friction, and each zero calibration has its own error. They are unknowns of both models.

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
    bias, span, linearity_error
        Errors of the sensors, as for :func:`fit_static`. A list of `bias` has one entry for each log of all groups, in
        their order. Without them the sensors count as exact.
    """
    _check(groups, margin, significance)
    everything = np.concatenate([points.force for points in groups.values()])
    floor = FLOOR_SHARE * float(np.median(np.abs(everything)))
    together = FrictionPoints.joined(list(groups.values()))
    sensors = sensor_errors(together, bias, span, linearity_error)

    request = FormRequest.of(exponents, held)
    form = best_map(together, request, None, sensors, floor=floor)[0].form
    starts = np.cumsum([0, *(points.logs for points in groups.values())])
    fits, apart = {}, []
    for (name, points), first in zip(groups.items(), starts, strict=False):
        own = bias[first : first + points.logs] if isinstance(bias, Sequence) else bias
        fits[name] = fit_static(
            points,
            exponents=exponents,
            held=held,
            form=form,
            bias=own,
            span=span,
            linearity_error=linearity_error,
            floor=floor,
        )
        problem = _solved(fits[name]).problem
        kept = replace(problem.points, of_log=problem.points.log + first)
        apart.append(replace(problem, points=kept, sensors=sensors))
    reference, *others = fits
    places = {name: _common_velocities(fits, name, reference) for name in others}
    used = FrictionPoints.joined([problem.points for problem in apart])
    used = replace(used, of_log=np.concatenate([problem.points.log for problem in apart]))
    of_used = sensor_errors(used, bias, span, linearity_error)
    whole, _ = best_map(used, request, form, of_used, loss="linear", floor=floor)
    one = replace(_solved(whole).problem, points=used, start=_solved(whole).problem.coordinates.of_map(whole.law))
    separate, statistic, freedom = _nested_test(list(fits.values()), apart, one)
    differences = tuple(_difference(list(fits), separate, v, name, reference) for name, v in places.items())
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


def _check(groups: Mapping[str, FrictionPoints], margin: float, significance: float) -> None:
    if len(groups) < 2:
        raise InputError(f"a comparison needs two groups of points or more, got {len(groups)}")
    if not 0.0 < margin < 1.0:
        raise InputError(f"margin is a share of the friction between 0 and 1, got {margin:g}; 0.1 means 10 %")
    if not 0.0 < significance < 0.5:
        raise InputError(f"significance must lie between 0 and 0.5, got {significance:g}; 0.05 is usual")


def _solved(fit: StaticFit) -> Solved:
    assert isinstance(fit.solved, Solved) and fit.spread is not None
    return fit.solved


@dataclass(frozen=True)
class _Joint:
    """Fit of several problems that share the errors of the sensors.

    Attributes
    ----------
    problems : list of Problem
    found : OptimizeResult
        Unknowns of each problem's map in turn, then the errors of the sensors.
    degrees_of_freedom : float
        Of the scale of the errors.
    """

    problems: list[Problem]
    found: OptimizeResult
    degrees_of_freedom: float

    @classmethod
    def of(cls, problems: list[Problem], sigma: Sequence[Array], freedom: float) -> _Joint:
        """Least squares with points of standard deviation `sigma`, N, (n,) for each problem."""
        joint = cls(problems, OptimizeResult(), freedom)
        priors = list(problems[0].priors.values())
        mean, deviation = np.array([p.mean for p in priors]), np.array([p.deviation for p in priors])

        def function(u: Array) -> tuple[Array, Array]:
            residuals, rows = [], []
            for k, (p, s) in enumerate(zip(problems, sigma, strict=True)):
                left, slopes = p.residuals(joint.unknowns(k, u))
                residuals.append(left / s)
                rows.append(np.zeros((s.size, u.size)))
                rows[-1][:, joint.columns(k, u)] = slopes / s[:, None]
            residuals.append((u[joint.ends[-1] :] - mean) / deviation)
            rows.append(np.eye(u.size)[joint.ends[-1] :] / deviation[:, None])
            return np.concatenate(residuals), np.vstack(rows)

        begins = [np.clip(p.begin(p.start), *p.bounds())[: p.unknowns] for p in problems]
        bounds = [[end[: p.unknowns] for end in p.bounds()] for p in problems]
        free = np.full(mean.size, np.inf)
        low, high = (
            np.concatenate([*(ends[side] for ends in bounds), sign * free]) for side, sign in ((0, -1), (1, 1))
        )
        begin = np.concatenate([*begins, mean])
        return replace(joint, found=minimise(function, begin, (low, high), x_scale="jac"))

    @property
    def ends(self) -> Array:
        """Numbers of the first unknown of each problem's map, and of the sensors."""
        return np.cumsum([0, *(problem.unknowns for problem in self.problems)])

    def columns(self, k: int, u: Array) -> Array:
        """Numbers of the unknowns of one problem."""
        ends = self.ends
        return np.concatenate([np.arange(ends[k], ends[k + 1]), np.arange(ends[-1], u.size)])

    def unknowns(self, k: int, u: Array) -> Array:
        """Unknowns of one problem."""
        return u[self.columns(k, u)]

    def force(self, k: int, v: Array) -> tuple[Array, Array]:
        """Friction (n,), N, of one map at velocities v, m/s, and its derivatives by all unknowns."""
        problem, u = self.problems[k], self.found.x
        theta = problem.theta(self.unknowns(k, u))
        force, _, over_parameters = problem.coordinates.to_map(theta).evaluate(v)
        over_theta = over_parameters @ problem.coordinates.slopes(theta)
        slopes = np.zeros((v.size, u.size))
        for i in np.flatnonzero(problem.column >= 0):
            slopes[:, self.ends[k] + problem.column[i]] += over_theta[:, i]
        return force, slopes

    def error(self, slopes: Array) -> Array:
        """Standard error (n,) of a quantity with the derivatives `slopes` (n, unknowns)."""
        deviation = np.array([prior.deviation for prior in self.problems[0].priors.values()])
        inverse = invert(self.found.jac[: self.found.jac.shape[0] - deviation.size], deviation)
        variance = np.einsum("ni,ij,nj->n", slopes, inverse.whole, slopes)
        variance[(slopes[:, inverse.undetermined] != 0.0).any(axis=1)] = np.inf
        return np.sqrt(np.maximum(variance, 0.0))


def _nested_test(fits: list[StaticFit], apart: list[Problem], one: Problem) -> tuple[_Joint, float, tuple[int, int]]:
    """F statistic of one common map against one map per group, with the fit of the latter.

    The scatter of the levels about the separate maps is the scale.
    """
    solved = [_solved(fit) for fit in fits]
    levels = [problem.points.levels.count.size for problem in apart]
    unknowns = [problem.unknowns for problem in apart]
    spare = sum(levels) - sum(unknowns)
    if spare < 1:
        raise InputError(
            f"{sum(levels)} velocity levels for {sum(unknowns)} parameters: nothing is left to compare with; add levels"
        )
    expected = [s.sigma / max(fit.spread.scale, 1e-9) for s, fit in zip(solved, fits, strict=True) if fit.spread]
    scatter = 0.0
    for s, sigma in zip(solved, expected, strict=True):
        weight, mean, _ = level_means(s.problem.points, s.problem.residuals(s.x)[0], sigma)
        scatter += float(np.sum(weight * mean**2))
    scale = float(np.sqrt(scatter / spare)) or 1e-9
    sigmas = [sigma * scale for sigma in expected]
    separate = _Joint.of([replace(p, start=p.theta(s.x)) for p, s in zip(apart, solved, strict=True)], sigmas, spare)
    common = _Joint.of([one], [np.concatenate(sigmas)], spare)
    extra = sum(unknowns) - one.unknowns
    gained = 2.0 * float(common.found.cost - separate.found.cost)
    return separate, max(gained, 0.0) / extra, (extra, spare)


def _difference(names: list[str], separate: _Joint, v: Array, name: str, reference: str) -> FrictionDifference:
    (other, over_other), (one, over_one) = (separate.force(names.index(group), v) for group in (name, reference))
    return FrictionDifference(
        group=name,
        reference=reference,
        velocity=v,
        force=(other - one) * np.sign(v),
        error=separate.error(over_other - over_one),
        reference_force=np.abs(one),
        degrees_of_freedom=separate.degrees_of_freedom,
    )


def _common_velocities(fits: Mapping[str, StaticFit], name: str, reference: str) -> Array:
    """Levels of the reference within the velocity range of the other group, m/s."""
    found = []
    for side in range(len(DIRECTIONS)):
        levels = [fits[group].points.levels for group in (reference, name)]
        speeds = [np.abs(each.velocity[each.direction == side]) for each in levels]
        if all(s.size for s in speeds):
            # A level of the other within a tenth still counts as the same.
            inside = (speeds[0] >= 0.9 * speeds[1].min()) & (speeds[0] <= 1.1 * speeds[1].max()) & (speeds[0] > 0.0)
            found.append(speeds[0][inside] * (1.0 if side == 0 else -1.0))
    if not any(part.size for part in found):
        raise InputError(f"groups `{name}` and `{reference}` have no velocities in common")
    return np.concatenate(found)
