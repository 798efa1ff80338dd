"""The search of a fit: least squares with weights from the residuals, from one or several starts.
                                                              theory: docs/theory/identification/fitting.md

With residuals r of the signals, each over its standard deviation, the fit minimises sum w r^2 and the priors' terms.
A crane oscillates on its oil column. If the model has another frequency, the phase error grows and the sum of squares
has many minima. Means over intervals of time have few, so the first searches compare means over long, then over short
intervals.

The standard deviations are not known in advance, because model errors exceed those of the sensors. That of a signal is
the larger one of its noise and of the residuals of the last pass; weights w are Huber's. Both are iterated to
convergence.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from hydrocrane.arrays import Array, rms
from hydrocrane.errors import HydrocraneError
from hydrocrane.identification.records import FittedLog
from hydrocrane.identification.solve import TOLERANCE, Estimate, Unknown
from hydrocrane.identification.solve import fit as output_error_fit
from hydrocrane.identification.values.models import LogModel, SensorReading
from hydrocrane.logs.noise import BY_MEDIAN
from hydrocrane.logs.rates import runs
from hydrocrane.scenario.solver import Solver
from hydrocrane.signals.statistics import correlation_samples

# Like the ``map`` of an executor: a function and sequences of arguments.
RunAll: TypeAlias = "Callable[..., Iterable[Estimate | None]]"
# Residuals above this many standard deviations count linearly and not by their square (Huber 1964).
HUBER = 2.5
# Intervals of the means in the first searches, s.
STRETCHES = (1.0, 0.2)
# Initial standard deviation of a signal, as a share of its range.
FIRST_SHARE = 0.05
# Relative change of cost or unknowns at which a search stops if its weights are not final.
ROUGHLY = 1e-3
# Most passes, and the relative change of the standard deviations at convergence.
PASSES, SETTLED = 8, 0.02
# Spread of further starts, in standard deviations of the priors.
SPREAD = 1.0


@dataclass(frozen=True)
class FitTask:
    """A fit: unknowns, models and logs.

    Attributes
    ----------
    unknowns : tuple of Unknown
        Keys of the machine, inputs' zeros, then errors of the sensors.
    models : tuple of LogModel
        One per log.
    reading : SensorReading
    own, keys : int
        Number of unknowns of the models (the others belong to the reading), and number of keys of the machine file.
    robust : bool
    ties : (a, own) array or None
        From those unknowns to the values of the models; None if they are the same.
    """

    unknowns: tuple[Unknown, ...]
    models: tuple[LogModel, ...]
    reading: SensorReading
    own: int
    keys: int
    robust: bool
    ties: Array | None = None

    @property
    def signals(self) -> tuple[str, ...]:
        """All signals of all logs."""
        return tuple(dict.fromkeys(name for model in self.models for name in model.record.signals))

    def with_solver(self, solver: Solver) -> FitTask:
        """The same fit with another solver of its runs."""
        return replace(self, models=tuple(model.with_solver(solver) for model in self.models))

    def of_models(self, values: Array) -> Array:
        """The values of the models at those of all unknowns (k,)."""
        return values[: self.own] if self.ties is None else self.ties @ values[: self.own]

    def read(self, values: Array) -> list[tuple[Array, Array]]:
        """Predicted readings (m, n) of each log and their derivatives (m, n, k)."""
        found = []
        for log, model in enumerate(self.models):
            y, slopes = model.predict(self.of_models(values))
            slopes = slopes if self.ties is None else slopes @ self.ties
            found.append(self.reading.read(log, model.record, y, slopes, values[self.own :]))
        return found


@dataclass(frozen=True)
class Weights:
    """Weights of the residuals.

    Attributes
    ----------
    deviations : dict of float
        Standard deviation of each signal, SI.
    roots : tuple of (m, n) arrays
        Square root of each reading's weight, by log. Correlated neighbours share one weight: Huber's weight is divided
        by the correlation time of the signal's residuals in samples.
    outliers : tuple of (m, n) arrays of bool
        Readings whose weight Huber's function reduces.
    """

    deviations: dict[str, float]
    roots: tuple[Array, ...]
    outliers: tuple[np.ndarray, ...]


@dataclass(frozen=True)
class SearchResult:
    """Result of a search.

    Attributes
    ----------
    task : FitTask
        With the tolerance of integration that it ended with.
    estimate : Estimate
    weights : Weights
        Of the last pass.
    passes : int
    costs : tuple of float
        Final sum of squares of each start, the best first.
    """

    task: FitTask
    estimate: Estimate
    weights: Weights
    passes: int
    costs: tuple[float, ...]


def searched(task: FitTask, starts: int, seed: int, run_all: RunAll, tell: Callable[[str], None]) -> SearchResult:
    """The best of several starts, with weights from its residuals.

    Searches with different weights are compared by :func:`scatter`. One of them frees the keys one by one, each from
    what those before it gave, so that a key more does not end in a worse minimum than without it.
    """
    first = first_weights(task)
    rng = np.random.default_rng(seed)
    others = [tuple(_drawn(unknown, rng) for unknown in task.unknowns) for _ in range(starts - 1)]
    tell(f"fitting {len(task.unknowns)} parameters from {starts} start{'s' * (starts > 1)}")
    tasks = [task, *(replace(task, unknowns=unknowns) for unknowns in others)]
    given = [i == 0 for i in range(starts)]
    ended = [e for e in run_all(_one_pass, tasks, [first] * starts, given) if e is not None]
    best = min(ended, key=lambda e: e.variance)
    found = SearchResult(task, best, first, 0, tuple(sorted(e.variance for e in ended)))
    one = refined(found, tell)
    if task.keys < 2:
        return one
    tell("freeing the parameters one by one")
    other = _one_by_one(found, tell)
    return one if other is None or scatter(one) <= scatter(other) else other


def scatter(found: SearchResult) -> float:
    """Mean logarithm of the residuals' standard deviations: the likelihood of a fit with weights from its residuals."""
    counts = [model.record.used.sum(axis=0) for model in found.task.models]
    logs = [np.log([found.weights.deviations[s] for s in model.record.signals]) for model in found.task.models]
    return float(np.sum([n @ log for n, log in zip(counts, logs, strict=True)]) / np.sum([n.sum() for n in counts]))


def _one_by_one(found: SearchResult, tell: Callable[[str], None]) -> SearchResult | None:
    """The search with one key, then two, and so on; None if it fails."""
    task, weights = found.task, found.weights
    values = np.array([unknown.start for unknown in task.unknowns])
    try:
        for count in range(1, task.keys):
            free = np.r_[:count, task.keys : len(task.unknowns)]
            values = _freed(task, weights, values, free)
            weights = next_weights(task, values, weights)
        return refined(replace(found, estimate=replace(found.estimate, values=values), weights=weights), tell)
    except HydrocraneError:
        return None


def _freed(task: FitTask, weights: Weights, values: Array, free: np.ndarray) -> Array:
    """`values` (k,) of all unknowns after a search for the `free` ones."""

    def function(some: Array) -> tuple[Array, Array]:
        values[free] = some
        rows, slopes, _ = residuals(task, weights, values)
        return rows, slopes[:, free]

    unknowns = [task.unknowns[i].started(values[i]) for i in free]
    values[free] = output_error_fit(unknowns, function, tolerance=ROUGHLY).values
    return values


def refined(found: SearchResult, tell: Callable[[str], None]) -> SearchResult:
    """The search carried on with the weights of its own residuals, until these are settled."""
    task, estimate, weights, passes = found.task, found.estimate, found.weights, 0
    for passes in range(1, PASSES + 1):
        before, weights = weights, next_weights(task, estimate.values, weights)
        changes = [abs(weights.deviations[s] / before.deviations[s] - 1.0) for s in task.signals]
        if max(changes) < SETTLED:
            break
        estimate = _fitted(_started(task, estimate.values), weights, ROUGHLY)
        tell(f"pass {passes}: {estimate.evaluations} evaluations")
    estimate = _fitted(_started(task, estimate.values), weights, TOLERANCE)
    return replace(found, estimate=estimate, weights=weights, passes=passes)


def first_weights(task: FitTask) -> Weights:
    """Initial weights: signals by their range, equal for all readings of a signal."""
    deviations = {}
    for signal in task.signals:
        columns = [readings(model, signal) for model in task.models if signal in model.record.signals]
        spread = float(np.ptp(np.concatenate(columns)))
        deviations[signal] = max(FIRST_SHARE * spread, _noise(task, signal), 1e-300)
    roots = tuple(1.0 / np.sqrt(np.maximum(_rests(model.record), 1.0)) for model in task.models)
    return Weights(deviations, roots, tuple(np.zeros(root.shape, dtype=bool) for root in roots))


def next_weights(task: FitTask, values: Array, before: Weights) -> Weights:
    """Weights from the residuals at `values`."""
    records = [model.record for model in task.models]
    differences = [y - record.readings for record, (y, _) in zip(records, task.read(values), strict=True)]
    deviations, shares = {}, {}
    for signal in task.signals:
        places = [(i, r.signals.index(signal)) for i, r in enumerate(records) if signal in r.signals]
        columns = [differences[i][_modelled(records[i])[:, k], k] for i, k in places]
        rest = np.concatenate(columns)
        if rest.size and task.robust:
            spread = BY_MEDIAN * float(np.median(np.abs(rest)))
        else:
            spread = rms(rest) if rest.size else 0.0
        deviations[signal] = max(spread, _noise(task, signal), 1e-9 * before.deviations[signal])
        shares[signal] = max([correlated(column) for column in columns if column.size > 3], default=1.0)
    found = Weights(deviations, (), ())
    roots, outliers = [], []
    for record, difference in zip(records, differences, strict=True):
        size = np.nan_to_num(np.abs(difference)) / (HUBER * _deviations(record, found)) * float(task.robust)
        shared = np.where(_rests(record) > 0, _rests(record), [shares[signal] for signal in record.signals])
        roots.append(1.0 / np.sqrt(np.maximum(size, 1.0) * shared))
        outliers.append(size > 1.0)
    return replace(found, roots=tuple(roots), outliers=tuple(outliers))


def correlated(rest: Array) -> float:
    """Correlation time of residuals (n,), in samples; an outlier, which is like no neighbour, must not hide it."""
    most = HUBER * BY_MEDIAN * float(np.median(np.abs(rest)))
    return correlation_samples(np.clip(rest, -most, most))


def _modelled(record: FittedLog) -> np.ndarray:
    """(m, n) True where a reading is fitted and the model describes it."""
    return np.asarray(record.used & (_rests(record) == 0))


def _rests(record: FittedLog) -> np.ndarray:
    """(m, n) number of readings in a contiguous stretch that the model does not describe, for all of its readings; else
    0."""
    missing = np.broadcast_to(record.unmodelled, record.used.shape) > 0.0
    lengths = np.zeros(missing.shape, dtype=int)
    for k, column in enumerate(missing.T):
        for a, b in runs(column):
            lengths[a:b, k] = b - a
    return lengths


def means(task: FitTask, weights: Weights, values: Array, stretch: float) -> tuple[Array, Array]:
    """Weighted residuals and their derivatives: means over intervals of time (s) times the root of the number of
    readings."""
    rows, slopes = [], []
    for i, (model, (y, by)) in enumerate(zip(task.models, task.read(values), strict=True)):
        record, scale = model.record, _scale(weights, i, model.record)
        part = (record.time / stretch).astype(int)
        for k in range(len(record.signals)):
            used = record.used[:, k]
            number = np.unique(part[used], return_inverse=True)[1]
            root = np.sqrt(np.bincount(number))
            rest = ((y[:, k] - record.readings[:, k]) * scale[:, k])[used]
            rows.append(np.bincount(number, rest) / root)
            each = (by[:, k] * scale[:, k, None])[used]
            slopes.append(np.stack([np.bincount(number, column) / root for column in each.T], axis=1))
    return np.concatenate(rows), np.concatenate(slopes)


def residuals(task: FitTask, weights: Weights, values: Array) -> tuple[Array, Array, Array]:
    """Weighted residuals (r,) of all readings used, their derivatives (r, k), and the log and time of each (r, 2)."""
    differences, slopes, places = [], [], []
    for i, (model, (y, by)) in enumerate(zip(task.models, task.read(values), strict=True)):
        record, used = model.record, model.record.used
        differences.append(y - record.readings)
        slopes.append((by * _scale(weights, i, record)[:, :, None])[used])
        time = np.broadcast_to(record.time[:, None], used.shape)[used]
        places.append(np.column_stack([np.full(time.size, i), time]))
    return weighted(task, weights, differences), np.concatenate(slopes), np.concatenate(places)


def weighted(task: FitTask, weights: Weights, differences: Sequence[Array]) -> Array:
    """Differences (m, n) of each log's signals as residuals (r,)."""
    records = [model.record for model in task.models]
    return np.concatenate(
        [(d * _scale(weights, i, r))[r.used] for i, (d, r) in enumerate(zip(differences, records, strict=True))]
    )


def _scale(weights: Weights, log: int, record: FittedLog) -> Array:
    """What the differences of a log's signals (m, n) are multiplied by."""
    return np.asarray(weights.roots[log] / _deviations(record, weights))


def readings(model: LogModel, signal: str) -> Array:
    """The fitted readings of a signal (r,)."""
    column = model.record.signals.index(signal)
    return model.record.readings[model.record.used[:, column], column]


def _deviations(record: FittedLog, weights: Weights) -> Array:
    """(m, n) standard deviations of a record's readings."""
    of_signals = np.array([weights.deviations[signal] for signal in record.signals])
    return np.asarray(np.broadcast_to(np.hypot(of_signals, record.unmodelled), record.readings.shape))


def _noise(task: FitTask, signal: str) -> float:
    """Fast noise of a signal in the log with the least noise."""
    logs = [m.record for m in task.models if signal in m.record.signals]
    return min(float(record.noise[record.signals.index(signal)]) for record in logs)


def _one_pass(task: FitTask, weights: Weights, given: bool) -> Estimate | None:
    """A search with constant weights; None if a random start, one that is not `given`, cannot be run."""
    try:
        for stretch in STRETCHES:
            coarse = output_error_fit(task.unknowns, partial(means, task, weights, stretch=stretch), tolerance=ROUGHLY)
            task = _started(task, coarse.values)
        return _fitted(task, weights, ROUGHLY)
    except HydrocraneError:
        if given:
            raise
        return None


def _started(task: FitTask, values: Array) -> FitTask:
    """The task from another start."""
    return replace(task, unknowns=tuple(u.started(v) for u, v in zip(task.unknowns, values, strict=True)))


def _fitted(task: FitTask, weights: Weights, tolerance: float) -> Estimate:
    return output_error_fit(task.unknowns, lambda values: residuals(task, weights, values)[:2], tolerance=tolerance)


def _drawn(unknown: Unknown, rng: np.random.Generator) -> Unknown:
    """A random start: positive quantities are drawn by their logarithm, the others by their value."""
    low, high = unknown.bounds
    draw = float(rng.standard_normal())
    if low == 0.0 and unknown.start > 0.0:
        share = min(unknown.scale / unknown.start, 1.0)
        start = unknown.start * float(np.exp(SPREAD * share * draw))
    else:
        start = unknown.start + SPREAD * unknown.scale * draw
    return unknown.started(np.clip(start, low, high))
