"""Prediction of a log by a model and by the errors of the sensors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.fitting.parameters import SensorError
from hydrocrane.fitting.records import FittedLog
from hydrocrane.machine.overrides import Overrides
from hydrocrane.scenario.solver import Solver

# Half step of a central difference for smooth functions, in standard deviations of a parameter.
DIFFERENCE = 1e-2


class LogModel(Protocol):
    """A model of one log, as a function of its own unknowns."""

    @property
    def record(self) -> FittedLog: ...
    @property
    def solver(self) -> Solver | None:
        """Of its runs; None if it has no runs."""
        ...

    def predict(self, values: Array) -> tuple[Array, Array]:
        """Signals (m, n) at the record's times and their derivatives (m, n, k) by the values (k,), SI."""
        ...

    def varied(self, values: Array, overrides: Overrides, interpolation: str = "") -> Array:
        """Signals (m, n) at these values with further `overrides`, or with commands interpolated differently."""
        ...

    def with_solver(self, solver: Solver) -> LogModel:
        """The same model with another solver of its runs."""
        ...


@dataclass(frozen=True)
class SensorReading:
    """Sensors between signals and readings: ``reading = (1 + span) signal(t - delay) + zero``."""

    errors: tuple[SensorError, ...]

    def read(self, log: int, record: FittedLog, y: Array, slopes: Array, values: Array) -> tuple[Array, Array]:
        """Readings (m, n) of a log by its number and their derivatives (m, n, k + e) by the model's unknowns and by the
        errors' `values` (e,)."""
        m, n, k = slopes.shape
        out, by = y.copy(), np.zeros((m, n, k + len(self.errors)))
        by[:, :, :k] = slopes
        for i, signal in enumerate(record.signals):
            mine = {
                e.kind: (k + j, values[j])
                for j, e in enumerate(self.errors)
                if e.signal == signal and e.log in (None, log)
            }
            _delayed(record.time, out[:, i], by[:, i], mine.get("delay"))
            column, span = mine.get("span", (None, 0.0))
            if column is not None:
                by[:, i] *= 1.0 + span
                by[:, i, column] = out[:, i]
                out[:, i] *= 1.0 + span
            for kind in ("zero", "start"):
                column, zero = mine.get(kind, (None, 0.0))
                if column is not None:
                    by[:, i, column] = 1.0
                    out[:, i] += zero
        return out, by


def _delayed(time: Array, y: Array, by: Array, delay: tuple[int, float] | None) -> None:
    """Shift a signal (m,) and its derivatives (m, k) to later times, in place."""
    if delay is None:
        return
    column, late = delay
    rate = np.gradient(y, time)
    earlier = time - late
    y[:] = np.interp(earlier, time, y)
    for j in np.flatnonzero(np.any(by != 0.0, axis=0)):
        by[:, j] = np.interp(earlier, time, by[:, j])
    by[:, column] = -np.interp(earlier, time, rate)


def by_differences(
    function: Callable[[Array], Array], values: Array, scales: Sequence[float], share: float = DIFFERENCE
) -> tuple[Array, Array]:
    """A function's value (m, n) and its derivatives (m, n, k) by central differences over a `share` of `scales` (k,).

    If one side cannot be evaluated, the difference is one-sided.
    """
    y = function(values)
    slopes = np.zeros((*y.shape, values.size))
    for j, scale in enumerate(scales):
        ends = []
        for sign in (1.0, -1.0):
            moved = values.copy()
            moved[j] += sign * share * scale
            try:
                ends.append((moved[j], function(moved)))
            except ValueError:
                ends.append((values[j], y))
        (high, above), (low, below) = ends
        if high != low:
            slopes[:, :, j] = (above - below) / (high - low)
    return y, slopes
