"""Correlation of the residuals of neighbouring readings: these then tell less than as many independent ones.

Source of the effective number: Bayley and Hammersley, Supplement to the Journal of the Royal Statistical Society 8,
1946.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrocrane.identification.misfit import UNLIKELY, chance_text

# Correlation that matters: readings then count for less than two thirds.
NOTABLE = 0.2
# Orders that are looked at: what stands next to each other there, and what to do.
ORDERS = {
    "time": (
        "consecutive windows of a log",
        "windows",
        "Something drifts over the windows: warm up, repeat levels in another order, or zero the sensors more often",
    ),
    "samples": (
        "consecutive samples",
        "samples, or means of samples,",
        "The model lacks something that lasts for several of them: check the sensors, delay, load and oil",
    ),
    "velocity": (
        "levels that are neighbours in velocity",
        "levels",
        "The map has another form than these data: look at the residuals over the speed, free an exponent, or leave "
        "out levels that are not steady",
    ),
}


@dataclass(frozen=True)
class Succession:
    """Correlation of residuals that are neighbours in one order.

    Attributes
    ----------
    order : {"time", "velocity", "samples"}
        Windows of a log one after the other, the share that their levels have in common taken away; means of the
        levels of a direction by speed; samples of one signal of a log, where nothing happens means of several.
    correlation : float
        At lag one, less what the fit itself brings about.
    p_value : float
        Chance of a correlation as strong between independent readings.
    count : int
        Readings.
    """

    order: str
    correlation: float
    p_value: float
    count: int

    @property
    def effective(self) -> float:
        """Number of independent readings that tell as much about a mean, by (1 - r)/(1 + r)."""
        r = float(np.clip(self.correlation, 0.0, 0.99))
        return self.count * (1.0 - r) / (1.0 + r)

    @property
    def shows(self) -> bool:
        """Whether it is beyond chance, of the orders that are looked at, and large enough to matter."""
        return self.p_value < UNLIKELY / len(ORDERS) and self.correlation > NOTABLE

    @property
    def warning(self) -> str:
        """The correlation in words, with what follows and what to do."""
        neighbours, readings, cure = ORDERS[self.order]
        return (
            f"residuals of {neighbours} are correlated: {self.correlation:.2f} ({chance_text(self.p_value)}). The "
            f"{self.count} {readings} count as about {self.effective:.0f}, and intervals may be too narrow by a factor "
            f"of {np.sqrt(self.count / self.effective):.2g}. {cure}"
        )
