"""Whether a map describes its levels, and if not, what the rest of friction depends on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hydrocrane.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# A map that describes the levels lies so far off them by chance in one of a hundred cases; one of the causes shows by
# chance in as many cases, all of them together.
UNLIKELY = 0.01
# Changes of friction over a range that are called a cause, and scatter about the map that is told, as shares of the
# friction.
NOTABLE, MISFIT_SHARE = 0.03, 0.01


def chance_text(p_value: float) -> str:
    """A chance in words; what is far beyond any doubt has no number."""
    return "chance below 1e-12" if p_value < 1e-12 else f"chance {p_value:.1g}"


@dataclass(frozen=True)
class Cause:
    """What friction may depend on beside the map, arrays over the points (n,).

    Attributes
    ----------
    name : {"velocity", "position", "time", "pressure", "load"}
    values : ndarray
        Of it, SI.
    p_value : float
        Chance of a dependence as strong as this where there is none; NaN where the points cannot tell.
    change : float
        By how much friction changes from the least to the greatest of the values, as a share; for the velocity the
        root mean square of what a smooth curve adds to the map.
    fitted : ndarray
        The dependence, as a share of the friction.
    """

    name: str
    values: Array
    p_value: float
    change: float
    fitted: Array

    @property
    def shows(self) -> bool:
        """Whether it is beyond chance, of five causes that were tested, and large enough to matter."""
        least = MISFIT_SHARE if self.name == "velocity" else NOTABLE
        return self.p_value < UNLIKELY / len(CURES) and abs(self.change) >= least

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
class Misfit:
    """How far the levels lie off a map.

    Attributes
    ----------
    p_value : float
        Chance of levels as far off by their stated errors.
    spare : int
        Levels less the parameters of the map; below one nothing checks it but its bounds.
    floor, point_error, force : float
        Scatter of the levels beyond their errors (about the map where few are to spare), median error of a point,
        median friction, N.
    shares : ndarray, shape (n,)
        What is left of each point's friction, measured less fitted, as a share of the map's.
    direction : ndarray of int, shape (n,)
        0 extending, 1 retracting.
    causes : tuple of Cause
        The likeliest first; those that could not be tested are not among them.
    """

    p_value: float
    spare: int
    floor: float
    point_error: float
    force: float
    shares: Array
    direction: NDArray[np.int_]
    causes: tuple[Cause, ...]

    @property
    def notable(self) -> bool:
        """Whether the levels are further off than their errors explain, and further than matters."""
        return self.p_value < UNLIKELY and self.floor > MISFIT_SHARE * self.force

    @property
    def likely(self) -> tuple[Cause, ...]:
        """The causes that show, the likeliest first."""
        return tuple(cause for cause in self.causes if cause.shows)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is to be said of it, with cause and cure."""
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
        return tuple(found)

    def plot(self) -> Figure:
        """What is left over each cause that was tested, with the dependence that was fitted."""
        from hydrocrane.plots.misfit import residual_causes

        return residual_causes(self)


# What to do about each cause; UNITS shows its values.
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
UNITS = {"position": (1e3, "mm"), "time": (1.0, "s"), "pressure": (1.0, "N of both chambers"), "load": (1.0, "kg")}
