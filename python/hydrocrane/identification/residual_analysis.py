"""Residuals of a fit: whether a map describes its levels, and how neighbouring readings are correlated.

Source of the effective number: Bayley and Hammersley, Supplement to the Journal of the Royal Statistical Society 8,
1946.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from hydrocrane.arrays import Array
from hydrocrane.asked import ask

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Significance level: the probability of a false alarm of the test of the map, and of all tests of causes together.
UNLIKELY = 0.01
# Least change of friction over the range of a cause, and least scatter about the map, that are reported, as shares of
# the friction.
NOTABLE, NOTABLE_SCATTER = 0.03, 0.01


def chance_text(p_value: float) -> str:
    """A probability in words, limited to 1e-12."""
    return "chance below 1e-12" if p_value < 1e-12 else f"chance {p_value:.1g}"


@dataclass(frozen=True)
class Cause:
    """A possible dependence of friction that is not in the map; arrays over the points (n,).

    Attributes
    ----------
    name : {"velocity", "position", "time", "pressure", "load"}
    values : ndarray
        Values of the quantity, SI.
    p_value : float
        Probability of a dependence this strong if there is none; NaN if the points do not identify it.
    change : float
        Relative change of friction from the least to the greatest of the values; for the velocity the root mean square
        of the smooth curve that is added to the map.
    fitted : ndarray
        The dependence, as a share of the friction.
    hidden : float
        Least change that these points would show if the map can represent most of the dependence; infinite if all of
        it, else zero. Zero for the velocity and without enough points too.
    """

    name: str
    values: Array
    p_value: float
    change: float
    fitted: Array
    hidden: float = 0.0

    @property
    def shows(self) -> bool:
        """Whether it is significant, given the five tests, and large enough to matter."""
        least = NOTABLE_SCATTER if self.name == "velocity" else NOTABLE
        return self.p_value < SIGNIFICANT and abs(self.change) >= least

    @property
    def hides(self) -> bool:
        """Whether the plan of the levels would hide a change that matters: it changes together with the speed."""
        return self.name in PLANS and not self.shows and self.hidden > NOTABLE

    @property
    def sentence(self) -> str:
        """The dependence in words."""
        chance = chance_text(self.p_value)
        if self.name == "velocity":
            return f"a smooth function of velocity, by {100 * self.change:.2g} % of it ({chance})"
        factor, unit = UNITS[self.name]
        low, high = self.values.min() * factor, self.values.max() * factor
        return f"{self.name}, by {100 * self.change:+.2g} % from {low:.3g} to {high:.3g} {unit} ({chance})"


@dataclass(frozen=True)
class ResidualAnalysis:
    """Residuals of the levels about a map, and tests of their causes.

    Attributes
    ----------
    p_value : float
        Probability of residuals this large with the stated errors.
    spare : int
        Levels less the parameters of the map; below one only the bounds check it.
    floor, point_error, force : float
        Scatter of the levels beyond their errors (about the map if `spare` is small), median error of a point, median
        friction, N.
    shares : ndarray, shape (n,)
        Measured less fitted friction of each point, as a share of that of the map.
    direction : ndarray of int, shape (n,)
        0 extending, 1 retracting.
    causes : tuple of Cause
        The tested causes, the likeliest first.
    confounded : tuple of Cause
        Those of which the plan of the levels would hide a change that matters.
    """

    p_value: float
    spare: int
    floor: float
    point_error: float
    force: float
    shares: Array
    direction: NDArray[np.int_]
    causes: tuple[Cause, ...]
    confounded: tuple[Cause, ...] = ()

    @property
    def notable(self) -> bool:
        """Whether the residuals are significant and large enough to matter."""
        return self.p_value < UNLIKELY and self.floor > NOTABLE_SCATTER * self.force

    @property
    def likely(self) -> tuple[Cause, ...]:
        """The significant causes, the likeliest first."""
        return tuple(cause for cause in self.causes if cause.shows)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings with cause and cure."""
        found = []
        if self.notable:
            errors = f"{self.point_error:.2g} N; {chance_text(self.p_value)}"
            found.append(
                f"the map does not describe these data: its levels scatter by {self.floor:.3g} N "
                f"({100 * self.floor / self.force:.2g} % of the friction) beyond the errors of their points "
                f"({errors}), and the intervals are widened accordingly"
            )
        if self.likely:
            first, *others = self.likely
            also = f"; or, less likely: {'; '.join(cause.sentence for cause in others)}" if others else ""
            found.append(f"friction changes with {first.sentence}{also}. {CURES[first.name]}")
        elif self.notable:
            tested = ", ".join(cause.name for cause in self.causes)
            found.append(
                f"no cause of these residuals was found among {tested}; look at the residuals, and repeat levels in "
                "another order"
                if tested
                else "too few levels to look for a cause of the residuals; repeat levels in another order"
            )
        for cause in self.confounded:
            size = f"below {100 * cause.hidden:.2g} %" if np.isfinite(cause.hidden) else "of any size"
            found.append(
                f"{cause.name} and speed change together in these levels: a change of friction with {cause.name} "
                f"{size} would not show, but count as one with speed, outside the intervals. {PLANS[cause.name]}"
            )
        return tuple(found)

    def plot(self) -> Figure:
        """Residuals over each tested cause, with the fitted dependence."""
        return cast("Figure", ask("plots", "residual-causes", self))


# Cure where a cause changes together with the speed.
PLANS = {
    "position": "Measure the levels at places that do not depend on their speed, or each one at several",
    "time": "Measure the levels in a shuffled order, or repeat some at the end",
}
# Cure for each cause; UNITS holds factor and unit for its values.
CURES = {
    "velocity": (
        "Look at the residuals over the speed: the map has another form, or some levels are not steady; "
        "`exponents` may be free in each direction"
    ),
    "position": "Fit the map to levels from one part of the stroke, or look for what varies along it",
    "time": "Warm up until a repeated level reads the same, and repeat the first level at the end",
    "pressure": "Measure at one supply and return pressure, or fit logs of different pressures apart",
    "load": "Fit logs of different loads apart, or check the masses",
}
UNITS = {"position": (1e3, "mm"), "time": (1.0, "s"), "pressure": (1.0, "N against the motion"), "load": (1.0, "kg")}
# Significance level of a single cause.
SIGNIFICANT = UNLIKELY / len(CURES)


# Least correlation that matters: readings then count for less than two thirds.
NOTABLE_CORRELATION = 0.2
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
        return self.p_value < UNLIKELY / len(ORDERS) and self.correlation > NOTABLE_CORRELATION

    @property
    def warning(self) -> str:
        """The correlation in words, with its consequence and the cure."""
        neighbours, readings, cure = ORDERS[self.order]
        return (
            f"residuals of {neighbours} are correlated: {self.correlation:.2f} ({chance_text(self.p_value)}). The "
            f"{self.count} {readings} count as about {self.effective:.0f}, and intervals may be too narrow by a factor "
            f"of {np.sqrt(self.count / self.effective):.2g}. {cure}"
        )
