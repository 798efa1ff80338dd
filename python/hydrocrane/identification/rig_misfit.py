"""All logs of a rig against their predictions, as one least-squares problem.
theory: docs/theory/identification/dynamic.md"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.identification.rig_model import SIGNALS, LogModel
from hydrocrane.identification.rig_sensors import NUISANCES, OF_A_LOG, gains, read

Progress = Callable[[int, float], None]


class RigMisfit:
    """Residuals of all logs, in standard deviations, with their slopes by keys and nuisances.

    Parameters
    ----------
    models : sequence of LogModel
        With the same keys.
    progress : callable, optional
        Called with the number of evaluations and the root-mean-square residual.
    """

    def __init__(self, models: Sequence[LogModel], progress: Progress | None = None) -> None:
        self.models = tuple(models)
        self.keys = len(models[0].experiment.keys)
        self.progress = progress
        self.evaluations = 0

    def __call__(self, theta: Array) -> tuple[Array, Array]:
        residuals: list[Array] = []
        slopes: list[Array] = []
        for k, model in enumerate(self.models):
            seen, row = self._readings(theta, k)
            residuals += model.weighted(seen - model.measured)
            slopes += model.weighted(row)
        found = np.concatenate(residuals)
        self.evaluations += 1
        if self.progress is not None:
            self.progress(self.evaluations, float(np.sqrt(np.mean(found**2))))
        return found, np.concatenate(slopes)

    def restarted(self, theta: Array) -> RigMisfit:
        """The same logs, simulated from the starts that `theta` says."""
        models = [model.restarted(theta[self._own(k)][1:3], theta[: self.keys]) for k, model in enumerate(self.models)]
        moved = RigMisfit(models, self.progress)
        moved.evaluations = self.evaluations
        return moved

    def predicted(self, theta: Array, log: int) -> Array:
        """Readings x, p1, p2 (b, 3) of one log, SI."""
        return self._readings(theta, log)[0]

    def of_signals(self, theta: Array) -> Iterator[tuple[str, str, float]]:
        """Log, signal, and the root-mean-square residual of the one in the other."""
        for k, model in enumerate(self.models):
            residuals = model.weighted(self.predicted(theta, k) - model.measured)
            for signal, values in zip(SIGNALS, residuals, strict=True):
                yield model.source, signal, float(np.sqrt(np.mean(values**2)))

    def _readings(self, theta: Array, log: int) -> tuple[Array, Array]:
        """Readings of one log (b, 3) and their slopes by all unknowns (b, 3, k)."""
        model, common = self.models[log], self.keys + len(NUISANCES)
        own = self._own(log)
        y, dy = model.predict(theta[: self.keys])
        seen, by_nuisance = read(y, model.turned, model.by_start, theta[self.keys : common], theta[own])
        row = np.zeros((*y.shape, theta.size))
        row[:, :, : self.keys] = dy * gains(y, theta[self.keys : common])[:, :, np.newaxis]
        row[:, :, self.keys : common] = by_nuisance[:, :, : len(NUISANCES)]
        row[:, :, own] = by_nuisance[:, :, len(NUISANCES) :]
        return seen, row

    def _own(self, log: int) -> slice:
        """Where :data:`OF_A_LOG` of a log stands among the unknowns."""
        first = self.keys + len(NUISANCES) + log * len(OF_A_LOG)
        return slice(first, first + len(OF_A_LOG))
