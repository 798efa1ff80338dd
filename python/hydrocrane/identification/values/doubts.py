"""Warnings of a fit, each with its cause and its cure; effects that are not fitted, each tested by itself.
                                                              theory: docs/theory/identification/fitting.md

A run with one thing changed shows what that does to the readings. What the unknowns cannot follow of it may explain a
share of the sum of squares (the score test, Rao, Proc. Cambridge Phil. Soc. 44, 1948, with differences).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from scipy.stats import chi2

from hydrocrane.arrays import Array
from hydrocrane.errors import HydrocraneError
from hydrocrane.identification.values.information import LEAST_BLOCKS, Accuracy, Information, SignalQuality
from hydrocrane.identification.values.search import FitTask, SearchResult, residuals, weighted
from hydrocrane.machine.machine import Machine
from hydrocrane.results.comparison import Difference
from hydrocrane.scenario.series import INTERPOLATIONS

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
BEYOND_NOISE, NAMED = 4.0, 3
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
        *_not_identifiable(known),
        *_together(found.task, known),
        *_blocks(known),
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
        worst = sorted(beyond, key=lambda text: -beyond[text])[:NAMED]
        more = f" and {len(beyond) - NAMED} more" if len(beyond) > NAMED else ""
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


def _not_identifiable(known: Information) -> Iterator[str]:
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


def _blocks(known: Information) -> Iterator[str]:
    if known.blocks <= LEAST_BLOCKS:
        yield (
            f"residuals are correlated over {known.correlation_time:.3g} s, long against the logs: intervals "
            f"follow from {known.blocks} blocks of time and are inaccurate; use longer logs or a better model"
        )


def _correlation(one: Array, other: Array) -> float:
    if one.size < 3 or np.ptp(one) == 0.0 or np.ptp(other) == 0.0:
        return 1.0
    return float(np.corrcoef(one, other)[0, 1])
