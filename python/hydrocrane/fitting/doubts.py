"""What makes a fit doubtful, each with its cause and its cure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.fitting.information import LEAST_BLOCKS, Information
from hydrocrane.fitting.quality import SignalQuality
from hydrocrane.fitting.search import Found, Task
from hydrocrane.results.difference import Difference

# A model that leaves more than this share of a signal's variation is no model of it.
USELESS = 0.5
# Readings that go against the model: correlation below this. Below the next they are held against other columns, which
# must correlate by so much more.
AGAINST, ALIKE, BETTER = -0.6, 0.6, 0.3
MANY_OUTLIERS = 0.2
# Residuals beyond so many times the noise are the model's; so many signals are named.
MISFIT, NAMED = 4.0, 3
# Held-out residuals larger than the fitted ones by this factor.
WORSE = 2.0
# Correlation of two parameters beyond which each stands for the other.
TOGETHER = 0.98


def doubts(
    task: Task,
    found: Found,
    known: Information,
    quality: Sequence[SignalQuality],
    differences: Mapping[tuple[str, str], Difference],
) -> tuple[str, ...]:
    """All of them, the most important first."""
    return (
        *_search(task, found),
        *doubtful_columns(differences),
        *_quality(quality),
        *_misfit(quality),
        *(f"the logs do not tell {text}: its prior decides; add logs that separate them" for text in known.untold),
        *_together(task, known),
        *_blocks(known),
    )


def _search(task: Task, found: Found) -> Iterator[str]:
    if not found.estimate.converged:
        yield f"the search has not converged ({found.estimate.message}); start nearer, or fit fewer parameters"
    for name in found.estimate.at_bound:
        yield (
            f"`{name}` ended at the end of what the machine file allows, {found.estimate[name]:.4g}; its interval "
            "means nothing: check sign, unit and model, and values that bound it, as break-away bounds Coulomb friction"
        )
    for unknown in task.unknowns:
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
        yield f"{apart} of {len(found.costs)} starts ended elsewhere, with larger residuals; the best is given"


def doubtful_columns(differences: Mapping[tuple[str, str], Difference]) -> Iterator[str]:
    """Readings that go against the model, and columns that fit another signal better."""
    for (log, signal), d in differences.items():
        own = _correlation(d.run, d.log)
        if own < AGAINST:
            found = f"{log}: `{signal}` runs against the model (correlation {own:.2f})"
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
                "fit does not carry over: fewer parameters, or a longer part to fit"
            )
        if q.outliers > MANY_OUTLIERS:
            yield (
                f"{q.log}: {q.outliers:.0%} of the readings of `{q.signal}` are weighed down as outliers; look at the "
                "picture for a part that the model does not describe"
            )


def _misfit(quality: Sequence[SignalQuality]) -> Iterator[str]:
    """Residuals that are no noise, all in one sentence."""
    beyond = {f"`{q.signal}` {q.rms / q.noise:.0f}": q.rms / q.noise for q in quality if q.rms > MISFIT * q.noise > 0.0}
    if beyond:
        worst = sorted(beyond, key=lambda text: -beyond[text])[:NAMED]
        more = f" and {len(beyond) - NAMED} more" if len(beyond) > NAMED else ""
        yield (
            f"residuals are many times the signals' noise ({', '.join(worst)} times{more}): something that is not "
            "fitted is wrong too, the fitted values take up a part of it, and the intervals do not hold that; look at "
            "the picture, and free what may be wrong"
        )


def _together(task: Task, known: Information) -> Iterator[str]:
    names = [u.name for u in task.unknowns]
    correlation = known.correlation
    for i, j in zip(*np.triu_indices(len(names), 1), strict=True):
        # Of two errors of sensors nobody asks which it is.
        if i < task.keys and abs(correlation[i, j]) > TOGETHER:
            pair = f"`{names[i]}` and `{names[j]}` have the same effect"
            yield f"{pair} (correlation {correlation[i, j]:.3f}); hold one of them"


def _blocks(known: Information) -> Iterator[str]:
    if known.blocks <= LEAST_BLOCKS:
        yield (
            f"residuals stay alike for {known.correlation_time:.3g} s, long against the logs: intervals rest on "
            f"{known.blocks} blocks of time and are rough; longer logs or a better model make them trustworthy"
        )


def _correlation(one: Array, other: Array) -> float:
    if one.size < 3 or np.ptp(one) == 0.0 or np.ptp(other) == 0.0:
        return 1.0
    return float(np.corrcoef(one, other)[0, 1])
