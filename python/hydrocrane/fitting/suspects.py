"""What the residuals of a fit look like: effects that are not fitted, each tested by itself.
                                                              theory: docs/theory/identification/fitting.md

A run with one thing changed shows what that does to the readings. What the unknowns cannot follow of it may explain a
share of the sum of squares (the score test, Rao, Proc. Cambridge Phil. Soc. 44, 1948, with differences).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.stats import chi2

from hydrocrane.errors import HydrocraneError
from hydrocrane.fitting.search import SearchResult, residuals, weighted
from hydrocrane.machine.machine import Machine
from hydrocrane.scenario.command import INTERPOLATIONS

# Changes that are tried: softer oil by this factor, a wider closed zone by this share of the spool's stroke.
SOFTER, WIDER = 0.8, 0.01
# An effect is named if it explains this share of the sum of squares, and if chance does so in one of a thousand fits.
EXPLAINS, CHANCE = 0.1, 1e-3


def suspected(found: SearchResult, machine: Machine, interpolation: str) -> tuple[str, ...]:
    """The effects that explain a clear share of the residuals, in words, the largest first."""
    task, values = found.task, found.estimate.values[: found.task.own]
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
