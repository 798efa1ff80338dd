"""Intervals by profile likelihood: one parameter is moved, and all others are fitted again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.identification.least_squares import Problem, Row
from hydrocrane.identification.static_map import LABELS, LOGARITHMIC

# A parameter is held at its target to within this share of the first step.
HOLD = 1e-3
# The step is doubled at most this many times; then the end counts as infinite.
DOUBLINGS = 12
# Most iterations of the method of false position, and its tolerance as a share of the reach.
CLOSINGS = 12
CLOSE = 0.005
# Other parameters replace one whose standard deviation exceeds that with the others held by this factor.
REPLACED = 1e5
# Parameters whose unknown has bounds of its own; the others are forces and coefficients not below zero.
BOXED = ("stribeck-velocity", "stribeck-exponent", "viscous-exponent")


NATURAL, LOG = "natural", "logarithm"


@dataclass(frozen=True)
class Handle:
    """The parameter of a profile.

    Attributes
    ----------
    index : int
        Index among the parameters.
    scale : str
        Whether steps are in the parameter or in its logarithm.
    """

    problem: Problem
    index: int
    scale: str

    def value(self, x: Array) -> float:
        """The parameter at the unknowns `x`, SI."""
        return float(self.problem.coordinates.to_map(self.problem.theta(x)).values[self.index])

    def place(self, x: Array) -> float:
        return float(np.log(self.value(x))) if self.scale is LOG else self.value(x)

    def back(self, place: float) -> float:
        return float(np.exp(place)) if self.scale is LOG else place

    def edge(self, upper: bool) -> float:
        """Last physical value in one direction."""
        if self.problem.column[self.index] >= 0 and LABELS[self.index].split(".")[0] in BOXED:
            return float(self.problem.bounds()[upper][self.problem.column[self.index]])
        return np.inf if upper else 0.0

    def hold(self, target: float, width: float) -> Row:
        """A residual that holds the parameter at `target` to within `width`."""

        def row(x: Array) -> tuple[float, Array]:
            over_theta = self.problem.coordinates.slopes(self.problem.theta(x))[self.index]
            slopes = np.zeros(x.size)
            for i in np.flatnonzero(self.problem.column >= 0):
                slopes[self.problem.column[i]] += over_theta[i]
            unit = width * (self.value(x) if self.scale is LOG else 1.0)
            return (self.place(x) - target) / width, slopes / unit

        return row


@dataclass(frozen=True)
class Moved:
    """A fit with one parameter held away from its best value.

    Attributes
    ----------
    x : ndarray
        Unknowns.
    excess : float
        Decrease of the likelihood in standard deviations, less the required one.
    """

    place: float
    x: Array
    excess: float


@dataclass(frozen=True)
class Solved:
    """A fit at its minimum, from which profiles start.

    Attributes
    ----------
    problem : Problem
    x : ndarray
        Unknowns at the minimum.
    sigma : ndarray, shape (n,)
        Standard deviation of each point as estimated, N.
    """

    problem: Problem
    x: Array
    sigma: Array

    def edges(self, label: str) -> tuple[float, float]:
        """Bounds of a parameter, SI."""
        handle = Handle(self.problem, LABELS.index(label), LOG if label.split(".")[0] in LOGARITHMIC else NATURAL)
        return handle.back(handle.edge(False)), handle.back(handle.edge(True))

    def ends(self, label: str, deviation: float, reach: float) -> tuple[float, float]:
        """Values of a parameter at which the log likelihood is lower by reach^2/2, or the physical bound.

        Parameters
        ----------
        deviation : float
            Standard deviation of the parameter, a first guess.
        reach : float
            Half width in standard deviations, such as Student's t.

        Returns
        -------
        low, high : float
            `high` is infinite if the likelihood never decreases that much.
        """
        scale = LOG if label.split(".")[0] in LOGARITHMIC else NATURAL
        handle = Handle(self.problem, LABELS.index(label), scale)
        over = self.problem.coordinates.to_map(self.problem.theta(self.x)).evaluate(self.problem.points.velocity)[2]
        if deviation * float(np.linalg.norm(over[:, handle.index] / self.sigma)) > REPLACED:
            return handle.back(handle.edge(False)), handle.back(handle.edge(True))
        step = deviation / handle.value(self.x) if scale is LOG else deviation
        return self._end(handle, -step, reach), self._end(handle, step, reach)

    def _end(self, handle: Handle, step: float, reach: float) -> float:
        """Step outwards until the likelihood is low enough, then interpolate."""
        edge = handle.edge(step > 0.0)
        near = Moved(handle.place(self.x), self.x, -reach)
        stride = reach * step
        for _ in range(DOUBLINGS):
            target = near.place + stride
            target = min(target, edge) if step > 0.0 else max(target, edge)
            far = self._moved(handle, target, abs(step), reach, near.x)
            if far.excess > 0.0:
                return handle.back(self._between(handle, near, far, abs(step), reach))
            if target == edge:
                return handle.back(edge)
            near, stride = far, 2.0 * stride
        return np.inf if step > 0.0 else 0.0

    def _between(self, handle: Handle, near: Moved, far: Moved, step: float, reach: float) -> float:
        """The zero of the excess by false position; it is nearly linear, so few iterations suffice."""
        for _ in range(CLOSINGS):
            share = float(np.clip(-near.excess / (far.excess - near.excess), 0.1, 0.9))
            place = near.place + share * (far.place - near.place)
            middle = self._moved(handle, place, step, reach, near.x)
            if abs(middle.excess) < CLOSE * reach:
                return middle.place
            near, far = (middle, far) if middle.excess < 0.0 else (near, middle)
        return near.place

    def _moved(self, handle: Handle, place: float, step: float, reach: float, begin: Array) -> Moved:
        x = self.problem.solve(begin, self.sigma, extra=handle.hold(place, HOLD * step)).x
        fallen = np.sqrt(max(self._cost(x) - self._cost(self.x), 0.0))
        return Moved(place, x, float(fallen) - reach)

    def _cost(self, x: Array) -> float:
        """Sum of squares, the sensor priors included."""
        r = self.problem.weighted_residuals(x, self.sigma)[0]
        return float(r @ r)
