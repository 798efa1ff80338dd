"""Intervals of a map's parameters: reach of an error with several sources, one interval of several forms, profiles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri
from scipy.stats import t as student

from hydrocrane.arrays import Array
from hydrocrane.identification.static.maps import LABELS, LOGARITHMIC, Form
from hydrocrane.identification.static.problem import Problem, Row

# Points of the grid for the convolution of distributions, and its extent in standard deviations of the scatter.
GRID, FARTHEST = 4001, 12.0
# Bound of a uniform distribution in standard deviations.
BOUND = np.sqrt(3.0)


def reach(level: float, deviation: float, freedom: float, bounds: Array) -> float:
    """Largest error at a confidence `level`, in standard deviations of the sum.

    Parameters
    ----------
    level : float
        As 0.95.
    deviation, freedom : float
        Standard deviation of the part that follows Student's t, and its degrees of freedom; infinite for a normal
        distribution.
    bounds : ndarray, shape (k,)
        Bounds of further errors, each uniformly distributed within them. Such an error never exceeds the bound of a
        data sheet; a normal error of the same deviation exceeds it in one of twelve cases.
    """
    bounds = np.abs(bounds)
    whole = float(np.sqrt(deviation**2 + np.sum(bounds**2) / BOUND**2))
    if whole == 0.0 or not np.isfinite(whole):
        return float(student.ppf(0.5 + level / 2, freedom))
    # The grid does not resolve narrow distributions.
    width = max(deviation / whole, 1e-3)
    bounds = bounds[bounds > 0.02 * whole] / whole
    if not bounds.size:
        return float(student.ppf(0.5 + level / 2, freedom))
    x = np.linspace(0.0, FARTHEST * width + float(bounds.sum()), GRID)
    x = np.concatenate([-x[:0:-1], x])
    below = student.cdf(x / width, freedom)
    for bound in bounds:
        below = _averaged(x, below, bound)
    return float(np.interp(0.5 + level / 2, below, x))


def _averaged(x: Array, below: Array, bound: float) -> Array:
    """A distribution function over x (n,) after the addition of a uniform error within +-`bound`."""
    step = x[1] - x[0]
    area = np.concatenate([[0.0], np.cumsum(0.5 * step * (below[1:] + below[:-1]))])
    # Beyond the grid the function is zero to the left and one to the right.
    upper = np.interp(x + bound, x, area) + np.maximum(x + bound - x[-1], 0.0)
    return np.asarray((upper - np.interp(x - bound, x, area)) / (2.0 * bound))


Ends = tuple[float, float]


def akaike_weights(aicc: ArrayLike) -> Array:
    """Weights (n,) of models by their criteria (n,); they add up to one (Burnham and Anderson 2002, section 2.9)."""
    behind = np.asarray(aicc, dtype=float) - np.min(aicc)
    weights = np.exp(-0.5 * behind)
    return np.asarray(weights / weights.sum())


def averaged(weights: ArrayLike, values: Sequence[float], intervals: Sequence[Ends], level: float) -> Ends:
    """The interval with probability (1 - level)/2 on either side, averaged over all models by their weights.

    Turek and Fletcher, Computational Statistics and Data Analysis 56, 2012. Each model's distribution is taken as two
    half normal distributions about its value, whose widths follow from both ends of its interval. A single model keeps
    its own interval.

    Parameters
    ----------
    weights : (n,) array_like
        Add up to one.
    values, intervals : sequences of n
        Of each model, finite; the intervals at the confidence `level`.
    """
    outside = 0.5 * (1.0 - level)
    far = -float(ndtri(outside))

    def below(x: float) -> float:
        """Weighted share of all models below x."""
        shares = [
            ndtr(far * (x - value) / max(value - low if x < value else high - value, 1e-12 * (1.0 + abs(value))))
            for value, (low, high) in zip(values, intervals, strict=True)
        ]
        return float(np.dot(np.asarray(weights, dtype=float), shares))

    low, high = min(intervals, key=lambda ends: ends[1] - ends[0])
    lows, highs = [ends[0] for ends in intervals], [ends[1] for ends in intervals]
    width = high - low
    return (
        _between(lows, low, width, lambda x: below(x) - outside),
        _between(highs, high, width, lambda x: below(x) - (1.0 - outside)),
    )


def _between(ends: Sequence[float], near: float, width: float, excess: Callable[[float], float]) -> float:
    """The zero of the excess, between the least and the greatest of the ends.

    Ends may lie many orders of magnitude apart. The search therefore uses the logarithm of the distance from the end
    `near` of the narrowest interval, in units of its `width`.
    """
    target = min(ends) if excess(near) >= 0.0 else max(ends)
    sign = 1.0 if target > near else -1.0
    # At the last end the excess has its final sign for every model; only rounding can hide this.
    if width <= 0.0 or target == near or sign * excess(target) <= 0.0:
        return target

    def place(u: float) -> float:
        return near + sign * width * float(np.expm1(u))

    distance = float(np.log1p(abs(target - near) / width))
    return place(float(brentq(lambda u: sign * excess(place(u)), 0.0, distance, xtol=1e-12)))


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
    """A form of the map at the minimum of its fit, from which profiles start.

    Attributes
    ----------
    problem : Problem
        With the floor as estimated.
    x : ndarray
        Unknowns at the minimum.
    sigma : ndarray, shape (n,)
        Standard deviation of each point as estimated, N.
    form : Form
    aicc : float
        Akaike's criterion, corrected for few levels.
    scale, freedom : float
        As from :func:`~hydrocrane.identification.static.problem.scale_of`; `sigma` contains the scale.
    """

    problem: Problem
    x: Array
    sigma: Array
    form: Form
    aicc: float
    scale: float
    freedom: float

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
