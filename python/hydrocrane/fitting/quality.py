"""Agreement of a fitted model with a signal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


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
