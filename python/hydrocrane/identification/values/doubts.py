"""What a fit says of itself: agreement with the logs, covariance, accuracy of integration, warnings.
                                                              theory: docs/theory/identification/fitting.md

Residuals of a real log are not white noise: neighbours are correlated, because a model error lasts longer than a
sample. The covariance is therefore estimated from sums over blocks of time that are much longer than the correlation
time of the residuals (the sandwich estimate with clusters: Huber 1967; Liang and Zeger, Biometrika 73, 1986).

Errors of integration move the least sum of squares and roughen its neighbourhood, so a search may end anywhere within
them. Residuals and derivatives of a repeat with a tighter tolerance say how far the fit is from the least sum of the
repeat. This distance is judged by the standard deviations that follow from the logs' noise.

An effect that is not fitted is tested by itself: a run with one thing changed shows what that does to the readings.
What the unknowns cannot follow of it may explain a share of the sum of squares (the score test, Rao, Proc. Cambridge
Phil. Soc. 44, 1948, with differences).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2
from scipy.stats import t as student

from hydrocrane.arrays import Array
from hydrocrane.errors import HydrocraneError
from hydrocrane.identification.solve import Estimate, correlation_of, inverse
from hydrocrane.identification.values.search import (
    FitTask,
    SearchResult,
    Weights,
    correlated,
    refined,
    residuals,
    weighted,
)
from hydrocrane.machine.machine import Machine
from hydrocrane.results.comparison import Difference
from hydrocrane.scenario.series import INTERPOLATIONS


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


# Changes that are tried: softer oil by this factor, a wider closed zone by this share of the spool's stroke.
SOFTER, WIDER = 0.8, 0.01
# An effect is named if it explains this share of the sum of squares, and if chance does so in one of a thousand fits.
EXPLAINS, CHANCE = 0.1, 1e-3


def suspected(found: SearchResult, machine: Machine, interpolation: str) -> tuple[str, ...]:
    """The effects that explain a clear share of the residuals, in words, the largest first."""
    task, values = found.task, found.task.of_models(found.estimate.values)
    rows, slopes, _ = residuals(task, found.weights, found.estimate.values)
    followed = np.linalg.qr(slopes)[0]
    fitted = {unknown.name.partition("[")[0] for unknown in task.unknowns}
    left = float(rows @ rows)
    shares: dict[str, float] = {}
    for key, value, most, looks in _effects(machine, interpolation):
        if key in fitted:
            continue
        change = ({}, key) if key in INTERPOLATIONS else ({key: value}, "")
        try:
            moved = [model.varied(values, *change) - model.varied(values, {}) for model in task.models]
        except HydrocraneError:
            continue
        column = weighted(task, found.weights, moved)
        column -= followed @ (followed.T @ column)
        size = float(column @ column)
        gain = float(np.clip(-(column @ rows) / size, -most, most)) if size > 0.0 else 0.0
        less = -2.0 * gain * float(column @ rows) - gain**2 * size
        # Commands are interpolated differently as a whole or not at all.
        if less > max(EXPLAINS * left, float(chi2.isf(CHANCE, 1))) and not (key in INTERPOLATIONS and gain < 0.5):
            signs = ("higher", "narrower") if gain < 0.0 else ("lower", "wider")
            shares[looks.format(*signs)] = less / left
    return tuple(f"{text} ({shares[text]:.0%})" for text in sorted(shares, key=lambda text: -shares[text]))


def _effects(machine: Machine, interpolation: str) -> Iterator[tuple[str, float, float, str]]:
    """Key or interpolation, its value, most multiples of that change, and what such a change looks like."""
    for key in ("fluid.bulk-modulus", "fluid.bulk-modulus-max"):
        if key in machine.keys:
            looks = f"a {{0}} `{key}`, as air, hoses and a frame that give way make it appear"
            yield key, SOFTER * float(machine.value(key).si), 1.0 / (1.0 - SOFTER), looks
    for name in machine.cylinder_names:
        key, stroke = f"valve.{name}.overlap", f"valve.{name}.stroke"
        if stroke in machine.keys:
            now = float(machine.value(key).si) if key in machine.keys else 0.0
            yield key, now + WIDER * float(machine.value(stroke).si), 1.0 / WIDER, f"a {{1}} dead zone, `{key}`"
    other = next(word for word in INTERPOLATIONS if word != interpolation)
    yield other, 0.0, 1.0, f'commands between samples as with interpolation="{other}"'


# A model does not describe a signal if the residuals exceed this share of its range.
USELESS = 0.5
# Correlation with the model below which a reading has the wrong sign; below which it is compared with other columns;
# and by how much another column must correlate better.
AGAINST, ALIKE, BETTER = -0.6, 0.6, 0.3
MANY_OUTLIERS = 0.2
# Residuals above this multiple of the noise are model errors; and the most signals that are named.
BEYOND_NOISE, MOST_NAMED = 4.0, 3
# Ratio of held-out to fitted residuals above which a warning is given.
WORSE = 2.0
# Correlation of two parameters above which they have the same effect.
TOGETHER = 0.98


def doubts(
    found: SearchResult,
    known: Information,
    accuracy: Accuracy | None,
    quality: Sequence[SignalQuality],
    differences: Mapping[tuple[str, str], Difference],
    looks: Sequence[str],
) -> tuple[str, ...]:
    """All warnings, the most important first."""
    return (
        *_search(found),
        *_integration(accuracy),
        *doubtful_columns(differences),
        *_quality(quality),
        *_beyond_noise(quality),
        *_looks(looks),
        *_unidentified(known),
        *_together(found.task, known),
        *_few_blocks(known),
    )


def _search(found: SearchResult) -> Iterator[str]:
    if not found.estimate.converged:
        yield f"the search has not converged ({found.estimate.message}); start nearer, or fit fewer parameters"
    for name in found.estimate.at_bound:
        yield (
            f"`{name}` ended at the bound of the machine file, {found.estimate[name]:.4g}; its interval "
            "is meaningless: check sign, unit and model, and values that bound it (break-away bounds Coulomb friction)"
        )
    for unknown in found.task.unknowns:
        value = found.estimate[unknown.name]
        if unknown.prior is not None and abs(value - unknown.prior[0]) > 3.0 * unknown.prior[1]:
            away = abs(value - unknown.prior[0]) / unknown.prior[1]
            yield (
                f"`{unknown.name}` moved by {away:.1f} standard deviations of its prior, from "
                f"{unknown.prior[0]:.4g} to {value:.4g}: is it the right machine, log and unit? If the file is wrong, "
                "say so with priors="
            )
    if len(found.costs) > 1 and found.costs[-1] > 1.1 * found.costs[0]:
        apart = sum(cost > 1.1 * found.costs[0] for cost in found.costs)
        yield f"{apart} of {len(found.costs)} starts ended at other values with larger residuals; the best is given"


def _integration(accuracy: Accuracy | None) -> Iterator[str]:
    if accuracy is None or accuracy.negligible:
        return
    cover = "" if accuracy.trouble else "; the intervals cover this distance"
    yield (
        f'errors of integration are not negligible: {accuracy}{cover}; use method="rodas5p" and a smaller rtol or step'
    )


def doubtful_columns(differences: Mapping[tuple[str, str], Difference]) -> Iterator[str]:
    """Readings with the wrong sign, and columns that fit another signal better."""
    for (log, signal), d in differences.items():
        own = _correlation(d.run, d.log)
        if own < AGAINST:
            found = f"{log}: `{signal}` moves against the model (correlation {own:.2f})"
            yield f"{found}; is its sign wrong? Map sign = -1"
        if own < ALIKE:
            others = {
                s: o for (other, s), o in differences.items() if other == log and s != signal and o.unit == d.unit
            }
            for name, other in others.items():
                here = _correlation(np.interp(d.time, other.time, other.run), d.log)
                there = _correlation(np.interp(other.time, d.time, d.run), other.log)
                better = here > own + BETTER and there > _correlation(other.run, other.log)
                if better and signal < name:
                    yield f"{log}: `{signal}` looks like `{name}`: are the columns exchanged?"


def _quality(quality: Sequence[SignalQuality]) -> Iterator[str]:
    for q in quality:
        if q.share > USELESS:
            yield (
                f"{q.log}: the model does not describe `{q.signal}`: its residuals are {q.share:.0%} of its range; "
                "check column, unit, sign, machine and window"
            )
        if np.isfinite(q.held_out) and q.held_out > WORSE * q.rms:
            yield (
                f"{q.log}: held-out residuals of `{q.signal}` are {q.held_out / q.rms:.1f} times the fitted ones; the "
                "fit does not predict: use fewer parameters, or fit a longer part"
            )
        if q.outliers > MANY_OUTLIERS:
            yield (
                f"{q.log}: {q.outliers:.0%} of the readings of `{q.signal}` are outliers with a reduced weight; "
                "look at the picture for a part that the model does not describe"
            )


def _beyond_noise(quality: Sequence[SignalQuality]) -> Iterator[str]:
    """One warning on all signals with residuals above their noise."""
    large = [q for q in quality if q.rms > BEYOND_NOISE * q.noise > 0.0]
    beyond = {f"`{q.signal}` {q.rms / q.noise:.0f}": q.rms / q.noise for q in large}
    if beyond:
        worst = sorted(beyond, key=lambda text: -beyond[text])[:MOST_NAMED]
        more = f" and {len(beyond) - MOST_NAMED} more" if len(beyond) > MOST_NAMED else ""
        yield (
            f"residuals are many times the signals' noise ({', '.join(worst)} times{more}): something that is not "
            "fitted is wrong too; the fitted values are effective ones that compensate a part of it, and the intervals "
            "do not cover that; look at the picture, and free what may be wrong"
        )


def _looks(looks: Sequence[str]) -> Iterator[str]:
    if looks:
        yield (
            f"the residuals look like {'; or like '.join(looks)} of the sum of squares, which is not fitted: until it "
            "is corrected or freed, the fitted values are effective ones"
        )


def _unidentified(known: Information) -> Iterator[str]:
    for text in known.not_identifiable:
        yield f"the logs do not identify {text}: the prior determines it; add logs that separate them"


def _together(task: FitTask, known: Information) -> Iterator[str]:
    names = [u.name for u in task.unknowns]
    correlation = known.correlation
    for i, j in zip(*np.triu_indices(len(names), 1), strict=True):
        # Two sensor errors need not be distinguished.
        if i < task.keys and abs(correlation[i, j]) > TOGETHER:
            pair = f"`{names[i]}` and `{names[j]}` have the same effect"
            yield f"{pair} (correlation {correlation[i, j]:.3f}); hold one of them"


def _few_blocks(known: Information) -> Iterator[str]:
    if known.blocks <= LEAST_BLOCKS:
        yield (
            f"residuals are correlated over {known.correlation_time:.3g} s, long against the logs: intervals "
            f"follow from {known.blocks} blocks of time and are inaccurate; use longer logs or a better model"
        )


def _correlation(one: Array, other: Array) -> float:
    if one.size < 3 or np.ptp(one) == 0.0 or np.ptp(other) == 0.0:
        return 1.0
    return float(np.corrcoef(one, other)[0, 1])
