"""Correlation of the residuals of neighbouring readings: correlated readings have less information than independent
ones.

Source of the effective number: Bayley and Hammersley, Supplement to the Journal of the Royal Statistical Society 8,
1946.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrocrane.identification.residual_analysis import UNLIKELY, chance_text

# Least correlation that matters: readings then count for less than two thirds.
NOTABLE = 0.2
# Tested orders: the neighbours in each, and the cure.
ORDERS = {
    "time": (
        "consecutive windows of a log",
        "windows",
        "Something drifts over the windows: warm up, repeat levels in another order, or zero the sensors more often",
    ),
    "samples": (
        "consecutive samples",
        "samples, or means of samples,",
        "The model lacks an effect that lasts for several of them: check the sensors, delay, load and oil",
    ),
    "velocity": (
        "levels that are neighbours in velocity",
        "levels",
        "The form of the map does not fit these data: look at the residuals over the speed, free an exponent, or leave "
        "out levels that are not steady",
    ),
}


@dataclass(frozen=True)
class Succession:
    """Correlation of neighbouring residuals in one order.

    Attributes
    ----------
    order : {"time", "velocity", "samples"}
        `time`: windows of a log in sequence, less the mean of their level. `velocity`: means of the levels of a
        direction, by speed. `samples`: samples of one signal of a log, or means of several while the signals hardly
        change.
    correlation : float
        At lag one, less the part caused by the fit itself; at most as strong as if all readings were one.
    p_value : float
        Probability of a correlation this strong between independent readings.
    count : int
        Readings.
    """

    order: str
    correlation: float
    p_value: float
    count: int

    @property
    def effective(self) -> float:
        """Number of independent readings with the same information on a mean, by (1 - r)/(1 + r)."""
        r = max(self.correlation, 0.0)
        return self.count * (1.0 - r) / (1.0 + r)

    @property
    def shows(self) -> bool:
        """Whether it is significant, given the number of tested orders, and large enough to matter."""
        return self.p_value < UNLIKELY / len(ORDERS) and self.correlation > NOTABLE

    @property
    def warning(self) -> str:
        """The correlation in words, with its consequence and the cure."""
        neighbours, readings, cure = ORDERS[self.order]
        return (
            f"residuals of {neighbours} are correlated: {self.correlation:.2f} ({chance_text(self.p_value)}). The "
            f"{self.count} {readings} count as about {self.effective:.0f}, and intervals may be too narrow by a factor "
            f"of {np.sqrt(self.count / self.effective):.2g}. {cure}"
        )
