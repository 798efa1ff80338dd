"""Residuals of a fit: whether a map describes its levels, and what else friction depends on.

Sources. Each cause is tested by itself, by the F-test of one more term in a regression: Draper and Smith, Applied
Regression Analysis, 1998, section 6.1. Correlation along time and velocity: the ratio of quadratic forms of Durbin and
Watson, Biometrika 37, 1950, with its exact mean and variance, corrected for the effect of the fit itself; the effective
number of readings: Bayley and Hammersley, Supplement to the Journal of the Royal Statistical Society 8, 1946.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.stats import chi2, norm
from scipy.stats import f as fisher

from hydrocrane.arrays import Array, rms
from hydrocrane.asked import ask
from hydrocrane.identification.static.points import EXTENDING, RETRACTING, FrictionPoints
from hydrocrane.identification.static.problem import Problem, floor_is_found, level_means, scatter

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Significance level: the probability of a false alarm of the test of the map, and of all tests of causes together.
UNLIKELY = 0.01
# Least change of friction over the range of a cause, and least scatter about the map, that are reported, as shares of
# the friction.
NOTABLE, NOTABLE_SCATTER = 0.03, 0.01


def chance_text(p_value: float) -> str:
    """A probability in words, limited to 1e-12."""
    return "chance below 1e-12" if p_value < 1e-12 else f"chance {p_value:.1g}"


@dataclass(frozen=True)
class Cause:
    """A possible dependence of friction that is not in the map; arrays over the points (n,).

    Attributes
    ----------
    name : {"velocity", "position", "time", "pressure", "load"}
    values : ndarray
        Values of the quantity, SI.
    p_value : float
        Probability of a dependence this strong if there is none; NaN if the points do not identify it.
    change : float
        Relative change of friction from the least to the greatest of the values; for the velocity the root mean square
        of the smooth curve that is added to the map.
    fitted : ndarray
        The dependence, as a share of the friction.
    hidden : float
        Least change that these points would show if the map can represent most of the dependence; infinite if all of
        it, else zero. Zero for the velocity and without enough points too.
    """

    name: str
    values: Array
    p_value: float
    change: float
    fitted: Array
    hidden: float = 0.0

    @property
    def shows(self) -> bool:
        """Whether it is significant, given the five tests, and large enough to matter."""
        least = NOTABLE_SCATTER if self.name == "velocity" else NOTABLE
        return self.p_value < SIGNIFICANT and abs(self.change) >= least

    @property
    def hides(self) -> bool:
        """Whether the plan of the levels would hide a change that matters: it changes together with the speed."""
        return self.name in PLANS and not self.shows and self.hidden > NOTABLE

    @property
    def sentence(self) -> str:
        """The dependence in words."""
        chance = chance_text(self.p_value)
        if self.name == "velocity":
            return f"a smooth function of velocity, by {100 * self.change:.2g} % of it ({chance})"
        factor, unit = UNITS[self.name]
        low, high = self.values.min() * factor, self.values.max() * factor
        return f"{self.name}, by {100 * self.change:+.2g} % from {low:.3g} to {high:.3g} {unit} ({chance})"


@dataclass(frozen=True)
class ResidualAnalysis:
    """Residuals of the levels about a map, and tests of their causes.

    Attributes
    ----------
    p_value : float
        Probability of residuals this large with the stated errors.
    spare : int
        Levels less the parameters of the map; below one only the bounds check it.
    floor, point_error, force : float
        Scatter of the levels beyond their errors (about the map if `spare` is small), median error of a point, median
        friction, N.
    shares : ndarray, shape (n,)
        Measured less fitted friction of each point, as a share of that of the map.
    direction : ndarray of int, shape (n,)
        0 extending, 1 retracting.
    causes : tuple of Cause
        The tested causes, the likeliest first.
    confounded : tuple of Cause
        Those of which the plan of the levels would hide a change that matters.
    """

    p_value: float
    spare: int
    floor: float
    point_error: float
    force: float
    shares: Array
    direction: NDArray[np.int_]
    causes: tuple[Cause, ...]
    confounded: tuple[Cause, ...] = ()

    @property
    def notable(self) -> bool:
        """Whether the residuals are significant and large enough to matter."""
        return self.p_value < UNLIKELY and self.floor > NOTABLE_SCATTER * self.force

    @property
    def likely(self) -> tuple[Cause, ...]:
        """The significant causes, the likeliest first."""
        return tuple(cause for cause in self.causes if cause.shows)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings with cause and cure."""
        found = []
        if self.notable:
            errors = f"{self.point_error:.2g} N; {chance_text(self.p_value)}"
            found.append(
                f"the map does not describe these data: its levels scatter by {self.floor:.3g} N "
                f"({100 * self.floor / self.force:.2g} % of the friction) beyond the errors of their points "
                f"({errors}), and the intervals are widened accordingly"
            )
        if self.likely:
            first, *others = self.likely
            also = f"; or, less likely: {'; '.join(cause.sentence for cause in others)}" if others else ""
            found.append(f"friction changes with {first.sentence}{also}. {CURES[first.name]}")
        elif self.notable:
            tested = ", ".join(cause.name for cause in self.causes)
            found.append(
                f"no cause of these residuals was found among {tested}; look at the residuals, and repeat levels in "
                "another order"
                if tested
                else "too few levels to look for a cause of the residuals; repeat levels in another order"
            )
        for cause in self.confounded:
            size = f"below {100 * cause.hidden:.2g} %" if np.isfinite(cause.hidden) else "of any size"
            found.append(
                f"{cause.name} and speed change together in these levels: a change of friction with {cause.name} "
                f"{size} would not show, but count as one with speed, outside the intervals. {PLANS[cause.name]}"
            )
        return tuple(found)

    def plot(self) -> Figure:
        """Residuals over each tested cause, with the fitted dependence."""
        return cast("Figure", ask("plots", "residual-causes", self))


# Cure where a cause changes together with the speed.
PLANS = {
    "position": "Measure the levels at places that do not depend on their speed, or each one at several",
    "time": "Measure the levels in a shuffled order, or repeat some at the end",
}
# Cure for each cause; UNITS holds factor and unit for its values.
CURES = {
    "velocity": (
        "Look at the residuals over the speed: the map has another form, or some levels are not steady; "
        "`exponents` may be free in each direction"
    ),
    "position": "Fit the map to levels from one part of the stroke, or look for what varies along it",
    "time": "Warm up until a repeated level reads the same, and repeat the first level at the end",
    "pressure": "Measure at one supply and return pressure, or fit logs of different pressures apart",
    "load": "Fit logs of different loads apart, or check the masses",
}
UNITS = {"position": (1e3, "mm"), "time": (1.0, "s"), "pressure": (1.0, "N against the motion"), "load": (1.0, "kg")}
# Significance level of a single cause.
SIGNIFICANT = UNLIKELY / len(CURES)


# Least correlation that matters: readings then count for less than two thirds.
NOTABLE_CORRELATION = 0.2
# Tested orders: the neighbours in each, and the cure.
ORDERS = {
    "time": (
        "consecutive windows of a log",
        "windows",
        "Something drifts over the windows: warm up, repeat levels in another order, or zero the sensors more often",
    ),
    "samples": (
        "consecutive samples",
        "samples, or means of samples,",
        "The model lacks an effect that lasts for several of them: check the sensors, delay, load and oil",
    ),
    "velocity": (
        "levels that are neighbours in velocity",
        "levels",
        "The form of the map does not fit these data: look at the residuals over the speed, free an exponent, or leave "
        "out levels that are not steady",
    ),
}


@dataclass(frozen=True)
class Succession:
    """Correlation of neighbouring residuals in one order.

    Attributes
    ----------
    order : {"time", "velocity", "samples"}
        `time`: windows of a log in sequence, less the mean of their level. `velocity`: means of the levels of a
        direction, by speed. `samples`: samples of one signal of a log, or means of several while the signals hardly
        change.
    correlation : float
        At lag one, less the part caused by the fit itself; at most as strong as if all readings were one.
    p_value : float
        Probability of a correlation this strong between independent readings.
    count : int
        Readings.
    """

    order: str
    correlation: float
    p_value: float
    count: int

    @property
    def effective(self) -> float:
        """Number of independent readings with the same information on a mean, by (1 - r)/(1 + r)."""
        r = max(self.correlation, 0.0)
        return self.count * (1.0 - r) / (1.0 + r)

    @property
    def shows(self) -> bool:
        """Whether it is significant, given the number of tested orders, and large enough to matter."""
        return self.p_value < UNLIKELY / len(ORDERS) and self.correlation > NOTABLE_CORRELATION

    @property
    def warning(self) -> str:
        """The correlation in words, with its consequence and the cure."""
        neighbours, readings, cure = ORDERS[self.order]
        return (
            f"residuals of {neighbours} are correlated: {self.correlation:.2f} ({chance_text(self.p_value)}). The "
            f"{self.count} {readings} count as about {self.effective:.0f}, and intervals may be too narrow by a factor "
            f"of {np.sqrt(self.count / self.effective):.2g}. {cure}"
        )


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


# Least number of pairs of neighbours and of degrees of freedom for a test.
LEAST_PAIRS = 6


def successions(problem: Problem, x: Array) -> tuple[Succession, ...]:
    """Correlations of the residuals of a fit at its solution `x`, for each order with enough readings."""
    points = problem.points
    residuals, slopes = problem.residuals(x)
    stated = replace(problem, floor=0.0).standard_deviation(problem.theta(x))
    stated = np.maximum(stated, 1e-9 * float(np.abs(points.force).max()))
    weight, _, level = level_means(points, residuals, stated)
    width = np.sqrt(1.0 / weight + problem.floor**2)
    both = np.column_stack([residuals, slopes[:, : problem.unknowns + len(problem.sensors.offsets)]])
    means = np.stack([level_means(points, column, stated)[1] for column in both.T], axis=-1)
    found = []
    if points.time is not None:
        # The scatter of windows within their level differs from that of levels about the map.
        counts = np.bincount(level)
        total = scatter(points, residuals, stated, problem.unknowns)
        inner = stated * np.sqrt(np.nan_to_num(total.within, nan=1.0) or 1.0)
        outer = np.sqrt(counts) * width * _size(means[:, 0] / width, problem.unknowns)
        white = (both - means[level]) / inner[:, None] + (means / outer[:, None])[level]
        found.append(succession("time", white, _in_time(points)))
    found.append(succession("velocity", means / width[:, None], _by_speed(points, level)))
    return tuple(s for s in found if s is not None)


def _size(means: Array, unknowns: int) -> float:
    """Scatter of standardised means about a map; one without degrees of freedom."""
    spare = means.size - unknowns
    found = float(np.sqrt(np.sum(means**2) / spare)) if spare > 0 else 1.0
    return found if found > 1e-9 else 1.0


def _in_time(points: FrictionPoints) -> Iterator[NDArray[np.intp]]:
    """Indices of the points of each log, in order of time."""
    assert points.time is not None
    for log in range(points.logs):
        here = np.flatnonzero(points.log == log)
        yield here[np.argsort(points.time[here], kind="stable")]


def _by_speed(points: FrictionPoints, level: NDArray[np.intp]) -> Iterator[NDArray[np.intp]]:
    """Indices of the levels of each direction, the slowest first."""
    for side in (EXTENDING, RETRACTING):
        yield np.unique(level[points.direction == side])


def succession(order: str, white: Array, rows: Iterable[NDArray[np.intp]]) -> Succession | None:
    """The correlation of residuals along rows of neighbours; None if there are too few.

    Parameters
    ----------
    order : str
        One of :data:`~hydrocrane.identification.static.residuals.ORDERS`.
    white : (n, 1 + k) array
        Residuals in standard deviations, then their derivatives by the k fitted unknowns.
    rows : iterable of int arrays
        Indices of residuals, in the order of neighbours.
    """
    pairs = [np.stack([row[:-1], row[1:]]) for row in rows]
    first, second = np.concatenate(pairs, axis=1) if pairs else np.zeros((2, 0), dtype=int)
    residuals, slopes = white[:, 0], white[:, 1:]
    size = np.linalg.norm(slopes, axis=0)
    u, s, _ = np.linalg.svd(slopes / np.where(size > 0.0, size, 1.0), full_matrices=False)
    basis = u[:, s > 1e-9 * s[0]]
    freedom = residuals.size - basis.shape[1]
    power = float(residuals @ residuals)
    if first.size < LEAST_PAIRS or freedom < LEAST_PAIRS or power == 0.0:
        return None
    half = np.full(first.size, 0.5)
    entries = np.concatenate([half, half]), (np.concatenate([first, second]), np.concatenate([second, first]))
    neighbours = coo_array(entries, shape=(residuals.size, residuals.size)).tocsr()
    # Traces of M A and (M A)^2 with A the matrix of neighbours and M = 1 - Q Q^T the projection that removes the fitted
    # part.
    moved = neighbours @ basis
    within = basis.T @ moved
    trace = -float(np.trace(within))
    square = float(np.sum(neighbours.data**2) - 2.0 * np.sum(moved**2) + np.sum(within**2))
    mean = trace / freedom
    variance = (2.0 * square + trace**2) / (freedom * (freedom + 2.0)) - mean**2
    excess = float(residuals @ (neighbours @ residuals)) / power - mean
    # A chain of n has n - 1 pairs: their sum is scaled to the n squares.
    count = residuals.size
    correlation = float(np.clip(excess * count / first.size, -1.0, (count - 1) / (count + 1)))
    return Succession(order, correlation, float(norm.sf(excess / np.sqrt(variance))), count)


# Least number of predicted levels for a statement on all of them.
LEAST_PREDICTED = 4
# Ratio of the errors (root mean square) to the promised ones above which a warning is given; the second is for a single
# level.
FACTOR, SINGLE = 1.5, 4.0
# Errors below this share of the friction do not matter.
SHARE = 0.01


@dataclass(frozen=True)
class HeldOut:
    """Levels predicted by fits of the same form to the other levels; arrays over the levels (k,).

    Attributes
    ----------
    velocity, direction : ndarray
        Median velocity of each level, m/s; 0 extending, 1 retracting.
    error : ndarray
        Mean of the measured less the predicted force, N; NaN where the other levels cannot predict the level.
    promised : ndarray
        Standard deviation of `error`, N, from the covariance of the fit without the level and the errors of the level.
    within : ndarray
        Mean of the measured less the force of the fit to all levels, N.
    force : float
        Median magnitude of the friction, N.
    reach : float
        Greatest less least force of the levels of both directions, N.
    fits : int
        Number of fits; equals the number of levels if each was left out by itself.
    """

    velocity: Array
    direction: NDArray[np.int_]
    error: Array
    promised: Array
    within: Array
    force: float
    reach: float
    fits: int

    @property
    def known(self) -> NDArray[np.bool_]:
        """Levels that can be predicted from the others."""
        return np.isfinite(self.error)

    @property
    def rms(self) -> float:
        """Root mean square of `error`, N; NaN where no level can be predicted."""
        return rms(self.error[self.known])

    @property
    def rms_promised(self) -> float:
        """Root mean square of `promised`, N."""
        return rms(self.promised[self.known])

    @property
    def rms_within(self) -> float:
        """Root mean square of `within` over the same levels, N."""
        return rms(self.within[self.known])

    @property
    def ratio(self) -> float:
        """Root mean square of the errors over the promised deviations; about one if the form predicts well."""
        return rms(self.error[self.known] / self.promised[self.known])

    @property
    def notable(self) -> bool:
        """Whether the errors of held-out levels exceed the promised ones and are large enough to matter."""
        here = self.known
        if np.count_nonzero(here) < LEAST_PREDICTED or not self.rms > SHARE * self.force:
            return False
        return self.ratio > FACTOR or float(np.max(np.abs(self.error[here]) / self.promised[here])) > SINGLE

    @property
    def sentence(self) -> str:
        """The numbers in a sentence."""
        if not self.known.any():
            return "No level can be predicted from the others: as many parameters as levels."
        how = "one after the other" if self.fits == self.error.size else f"in {self.fits} groups"
        lost = int(np.count_nonzero(~self.known))
        return (
            f"Levels were left out of the fit {how} and predicted by the same form from the rest: "
            f"rms {self.rms:.3g} N, where {self.rms_promised:.3g} N is promised and the fit to all levels leaves "
            f"{self.rms_within:.3g} N; the forces reach over {self.reach:.3g} N."
            + (f" {lost} of {self.error.size} levels cannot be predicted from the others." if lost else "")
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings with cause and cure."""
        if not self.notable:
            return ()
        share = np.where(self.known, np.abs(self.error) / self.promised, 0.0)
        at = int(np.argmax(share))
        return (
            "the form does not predict levels that it was not fitted to: predicted from the others, the level at "
            f"{self.velocity[at] * 1e3:.3g} mm/s is off by {self.error[at]:+.3g} N, {share[at]:.2g} promised standard "
            f"deviations (root mean square of all levels {self.ratio:.2g}; {self.rms:.3g} N, {self.rms_within:.3g} N "
            "within the fit). Either the map follows its levels too closely or has another form: do not trust it "
            "between or beyond the levels. Hold exponents that are known, add levels near this one, and repeat it",
        )
