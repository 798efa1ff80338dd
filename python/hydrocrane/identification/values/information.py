"""How well a model agrees with a log, how well a fit determines its parameters, and which it cannot.
                                                              theory: docs/theory/identification/fitting.md

Residuals of a real log are not white noise: neighbours are correlated, because a model error lasts longer than a
sample. The covariance is therefore estimated from sums over blocks of time that are much longer than the correlation
time of the residuals (the sandwich estimate with clusters: Huber 1967; Liang and Zeger, Biometrika 73, 1986).

Errors of integration move the least sum of squares and roughen its neighbourhood, so a search may end anywhere within
them. Residuals and derivatives of a repeat with a tighter tolerance say how far the fit is from the least sum of the
repeat. This distance is judged by the standard deviations that follow from the logs' noise.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import t as student

from hydrocrane.arrays import Array
from hydrocrane.errors import HydrocraneError
from hydrocrane.identification.solve import Estimate, correlation_of, inverse
from hydrocrane.identification.values.search import FitTask, SearchResult, Weights, correlated, refined, residuals


@dataclass(frozen=True)
class SignalQuality:
    """Agreement of the fitted model with a signal of a log.

    Attributes
    ----------
    log, signal, unit : str
    rms, held_out : float
        Root mean square of the fitted residuals, and of the held-out ones (NaN without any), in `unit`.
    span : float
        Range of the readings, in `unit`.
    noise : float
        Standard deviation of the signal's fast noise, in `unit`.
    outliers : float
        Share of the readings with a reduced weight.
    """

    log: str
    signal: str
    unit: str
    rms: float
    held_out: float
    span: float
    noise: float
    outliers: float

    @property
    def share(self) -> float:
        """`rms` over the range of the readings."""
        return self.rms / self.span if self.span > 0.0 else np.inf

    @property
    def held_out_share(self) -> float:
        """`held_out` over the range of the readings."""
        return self.held_out / self.span if self.span > 0.0 else np.inf


# Most and least number of blocks of time in all logs together; the correlation time decides between them.
MOST_BLOCKS, LEAST_BLOCKS = 40, 6
# Length of a block in correlation times.
BLOCK = 4.0
# The data identify a combination of parameters if they reduce the deviation of its prior to less than this share.
IDENTIFIED = 0.7
# A component of a combination below this share of the largest is not named.
NAMED = 0.15
# Without a prior a combination is not identifiable if its deviation exceeds this many scales.
UNBOUNDED = 10.0


@dataclass(frozen=True)
class Information:
    """Covariance of a fit and what follows from it.

    Attributes
    ----------
    covariance : (k, k) array
        Of all unknowns, SI.
    blocks : int
        Number of blocks of time that it was estimated from.
    correlation_time : float
        Correlation time of the residuals, s; the longest of all signals and logs.
    not_identifiable : tuple of str
        Combinations of keys that the data do not identify, the least known first.
    narrowed : (k,) array
        Standard deviation after the fit over that of the prior; 0 without a prior.
    moved : float
        Largest distance of an unknown from where the sum of squares is least, in standard deviations. The covariance
        contains these distances.
    """

    covariance: Array
    blocks: int
    correlation_time: float
    not_identifiable: tuple[str, ...]
    narrowed: Array
    moved: float

    @property
    def deviations(self) -> Array:
        """(k,) standard deviations, SI."""
        return np.sqrt(np.diag(self.covariance))

    def factor(self, level: float) -> float:
        """Half width of an interval of this `level`, in standard deviations (Student's t by the number of blocks)."""
        return float(student.ppf(0.5 + 0.5 * level, max(self.blocks - 1, 1)))

    @property
    def correlation(self) -> Array:
        """(k, k) correlations."""
        return correlation_of(self.covariance)


def information(task: FitTask, weights: Weights, estimate: Estimate) -> Information:
    """The covariance at the fitted values, by the residuals of a `task` that may have a tighter tolerance."""
    rows, derivatives, places = residuals(task, weights, estimate.values)
    scales = np.array([u.scale for u in task.unknowns])
    prior_weight = np.array([1.0 / u.prior[1] if u.prior is not None else 0.0 for u in task.unknowns]) * scales
    derivatives = derivatives * scales
    longest, labels = _blocks(task, rows, places)
    count = int(labels.max()) + 1
    sums = np.zeros((count, scales.size))
    np.add.at(sums, labels, derivatives * rows[:, None])
    # Not below the covariance that the weights imply: a few blocks may agree by chance.
    meat = _larger(sums.T @ sums * count / max(count - 1, 1), derivatives.T @ derivatives)
    bread = inverse(np.vstack([derivatives, np.diag(prior_weight)]))
    mean = np.array([u.prior[0] if u.prior is not None else u.start for u in task.unknowns])
    slope = derivatives.T @ rows + prior_weight**2 * (estimate.values - mean) / scales
    # What ended on a bound stays there.
    step = -bread @ slope * [name not in estimate.at_bound for name in estimate.names]
    covariance = bread @ (meat + np.diag(prior_weight**2)) @ bread
    moved = float(np.max(np.abs(step) / np.sqrt(np.diag(covariance))))
    covariance += np.diag(step**2)
    names = [u.name for u in task.unknowns]
    before = np.where(prior_weight > 0.0, 1.0 / np.where(prior_weight > 0.0, prior_weight, 1.0), UNBOUNDED)
    deviations = np.sqrt(np.diag(covariance))
    return Information(
        covariance=covariance * np.outer(scales, scales),
        blocks=count,
        correlation_time=longest,
        not_identifiable=_not_identifiable(
            names[: task.keys], covariance[: task.keys, : task.keys], before[: task.keys]
        ),
        narrowed=np.where(prior_weight > 0.0, deviations * prior_weight, 0.0),
        moved=moved,
    )


def _blocks(task: FitTask, rows: Array, places: Array) -> tuple[float, np.ndarray]:
    """The longest correlation time of the residuals, s, and the block of each."""
    longest = 0.0
    start = 0
    for model in task.models:
        used, time = model.record.used, model.record.time
        mine = rows[start : start + used.sum()]
        table = np.full(used.shape, np.nan)
        table[used] = mine
        start += used.sum()
        interval = float(np.median(np.diff(time)))
        for column in table.T:
            rest = column[np.isfinite(column)]
            if rest.size > 3:
                longest = max(longest, correlated(rest) * interval)
    whole = sum(float(model.record.time[-1]) for model in task.models)
    wanted = int(np.clip(whole / max(BLOCK * longest, 1e-12), LEAST_BLOCKS, MOST_BLOCKS))
    length = whole / wanted
    begun = np.concatenate([[0.0], np.cumsum([float(model.record.time[-1]) for model in task.models])])
    since = begun[places[:, 0].astype(int)] + places[:, 1]
    numbers = np.minimum((since / length).astype(int), wanted - 1)
    return longest, np.unique(numbers, return_inverse=True)[1]


def _larger(one: Array, other: Array) -> Array:
    """The smallest covariance that is not below either, found in the axes in which `other` is the unit matrix."""
    values, axes = np.linalg.eigh(other)
    root = axes * np.sqrt(np.maximum(values, 1e-12 * max(values[-1], 1e-300)))
    back = np.linalg.inv(root)
    shares, turn = np.linalg.eigh(back @ one @ back.T)
    return np.asarray(root @ (turn * np.maximum(shares, 1.0)) @ turn.T @ root.T)


def _not_identifiable(names: Sequence[str], covariance: Array, before: Array) -> tuple[str, ...]:
    """Combinations of keys that the fit knows no better than the prior; all in scales of the unknowns.

    They are eigenvectors of the covariance (k, k) after the fit, scaled by the standard deviations `before` (k,) it.
    """
    values, axes = np.linalg.eigh(covariance / np.outer(before, before))
    return tuple(_sentence(names, axes[:, i]) for i in np.argsort(-values) if values[i] > IDENTIFIED**2)


def _sentence(names: Sequence[str], axis: Array) -> str:
    """A direction in the space of the unknowns, in words."""
    order = [i for i in np.argsort(-np.abs(axis)) if abs(axis[i]) > NAMED * np.abs(axis).max()]
    if len(order) == 1:
        return f"`{names[order[0]]}` alone"
    sign = np.sign(axis[order[0]])
    parts = [f"{'more' if sign * axis[i] > 0 else 'less'} `{names[i]}`" for i in order]
    return " with ".join([", ".join(parts[:-1]), parts[-1]])


# Distance to the least sum of the repeat that needs no tighter tolerance, in standard deviations: an interval that
# covers it is sqrt(1 + 0.2^2) = 1.02 times as wide.
NEGLIGIBLE = 0.2
# Most changes to a tighter tolerance: each is a hundredth of the one before, or half the step.
TIGHTENINGS = 2


@dataclass(frozen=True)
class Accuracy:
    """What a repeat with a tighter tolerance says of a fit.

    Attributes
    ----------
    used, repeat : str
        Tolerances of the fit and of the repeat, in words.
    moved : float
        Distance from the fit to the least sum of squares of the repeat, in standard deviations.
    trouble : str
        Why there is no repeat; empty if there is one.
    """

    used: str
    repeat: str
    moved: float = 0.0
    trouble: str = ""

    @property
    def negligible(self) -> bool:
        """Whether the intervals need no errors of integration."""
        return not self.trouble and self.moved <= NEGLIGIBLE

    def __str__(self) -> str:
        if self.trouble:
            return f"integrated with {self.used}; a repeat with {self.repeat} is not possible: {self.trouble}"
        return f"integrated with {self.used}; {self.repeat} would move it by {self.moved:.2g} standard deviations"


def accurate(found: SearchResult, tell: Callable[[str], None]) -> tuple[SearchResult, Information, Accuracy | None]:
    """The search carried on with tighter tolerances until a repeat with the next one agrees, its intervals, and what
    the last repeat says; None for a fit without runs."""
    for left in reversed(range(TIGHTENINGS + 1)):
        solver = found.task.models[0].solver
        if solver is None:
            break
        finer = found.task.with_solver(solver.tightened())
        accuracy = Accuracy(solver.settings, solver.tightened().settings)
        try:
            known = information(finer, found.weights, found.estimate)
        except HydrocraneError as error:
            return found, information(found.task, found.weights, found.estimate), replace(accuracy, trouble=str(error))
        accuracy = replace(accuracy, moved=known.moved)
        if accuracy.negligible or not left:
            return found, known, accuracy
        tell(f"{accuracy}: searching with {accuracy.repeat}")
        found = refined(replace(found, task=finer), tell)
    return found, information(found.task, found.weights, found.estimate), None
