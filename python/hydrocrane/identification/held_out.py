"""Prediction of held-out levels by a form of the map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrocrane.arrays import Array, rms

# Least number of predicted levels for a statement on all of them.
LEAST = 4
# Ratio of the errors (root mean square) to the promised ones above which a warning is given; the second is for a single
# level.
FACTOR, SINGLE = 1.5, 4.0
# Errors below this share of the friction do not matter.
SHARE = 0.01


@dataclass(frozen=True)
class HeldOut:
    """Levels predicted by fits of the same form to the other levels; arrays over the levels (k,).

    Attributes
    ----------
    velocity, direction : ndarray
        Median velocity of each level, m/s; 0 extending, 1 retracting.
    error : ndarray
        Mean of the measured less the predicted force, N; NaN where the other levels cannot predict the level.
    promised : ndarray
        Standard deviation of `error`, N, from the covariance of the fit without the level and the errors of the level.
    within : ndarray
        Mean of the measured less the force of the fit to all levels, N.
    force : float
        Median magnitude of the friction, N.
    reach : float
        Greatest less least force of the levels of both directions, N.
    fits : int
        Number of fits; equals the number of levels if each was left out by itself.
    """

    velocity: Array
    direction: NDArray[np.int_]
    error: Array
    promised: Array
    within: Array
    force: float
    reach: float
    fits: int

    @property
    def known(self) -> NDArray[np.bool_]:
        """Levels that can be predicted from the others."""
        return np.isfinite(self.error)

    @property
    def rms(self) -> float:
        """Root mean square of `error`, N; NaN where no level can be predicted."""
        return rms(self.error[self.known])

    @property
    def rms_promised(self) -> float:
        """Root mean square of `promised`, N."""
        return rms(self.promised[self.known])

    @property
    def rms_within(self) -> float:
        """Root mean square of `within` over the same levels, N."""
        return rms(self.within[self.known])

    @property
    def ratio(self) -> float:
        """Root mean square of the errors over the promised deviations; about one if the form predicts well."""
        return rms(self.error[self.known] / self.promised[self.known])

    @property
    def notable(self) -> bool:
        """Whether the errors of held-out levels exceed the promised ones and are large enough to matter."""
        here = self.known
        if np.count_nonzero(here) < LEAST or not self.rms > SHARE * self.force:
            return False
        return self.ratio > FACTOR or float(np.max(np.abs(self.error[here]) / self.promised[here])) > SINGLE

    @property
    def sentence(self) -> str:
        """The numbers in a sentence."""
        if not self.known.any():
            return "No level can be predicted from the others: as many parameters as levels."
        how = "one after the other" if self.fits == self.error.size else f"in {self.fits} groups"
        lost = int(np.count_nonzero(~self.known))
        return (
            f"Levels were left out of the fit {how} and predicted by the same form from the rest: "
            f"rms {self.rms:.3g} N, where {self.rms_promised:.3g} N is promised and the fit to all levels leaves "
            f"{self.rms_within:.3g} N; the forces reach over {self.reach:.3g} N."
            + (f" {lost} of {self.error.size} levels cannot be predicted from the others." if lost else "")
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings with cause and cure."""
        if not self.notable:
            return ()
        share = np.where(self.known, np.abs(self.error) / self.promised, 0.0)
        at = int(np.argmax(share))
        return (
            "the form does not predict levels that it was not fitted to: predicted from the others, the level at "
            f"{self.velocity[at] * 1e3:.3g} mm/s is off by {self.error[at]:+.3g} N, {share[at]:.2g} promised standard "
            f"deviations (root mean square of all levels {self.ratio:.2g}; {self.rms:.3g} N, {self.rms_within:.3g} N "
            "within the fit). Either the map follows its levels too closely or has another form: do not trust it "
            "between or beyond the levels. Hold exponents that are known, add levels near this one, and repeat it",
        )
