"""Difference of one quantity between a run and a log."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import Array, brief, rms


@dataclass(frozen=True)
class Difference:
    """Run minus log for one quantity, at the log's times inside the run.

    Attributes
    ----------
    time, run, log : (k,) arrays
        s, and the two values in `unit`.
    left_out : int
        Samples of the log that are not compared: outside of the run, or without a value.
    rms, maximum : float
        Root mean square and largest absolute difference, in `unit`.
    maximum_time : float
        Time of the largest one, s.
    """

    name: str
    unit: str
    time: Array
    run: Array
    log: Array
    left_out: int = 0

    @property
    def compared(self) -> int:
        """Samples compared."""
        return int(self.time.size)

    __repr__ = brief

    @property
    def rms(self) -> float:
        return rms(self.run - self.log)

    @property
    def maximum(self) -> float:
        return float(np.abs(self.run - self.log).max())

    @property
    def maximum_time(self) -> float:
        return float(self.time[np.argmax(np.abs(self.run - self.log))])
