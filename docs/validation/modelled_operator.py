"""A model of an operator who drives the tip of a crane from place to place, with one tip stick or a lever per cylinder.

The model is a crossover model with limited hand rates: the operator sees tip and pose with a delay, wants a velocity
proportional to the distance to the next place, and moves the hands with a limited rate. Perception, delay and hands are
the same for both interfaces; only the conversion from wanted tip velocity to deflections differs. Source of the
structure: D. T. McRuer and H. R. Jex, *A review of quasi-linear pilot models*, IEEE Transactions on Human Factors in
Electronics, 1967. The numbers are assumptions, stated at each field.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np

from hydrocrane.arrays import Array, positive_number, real_array
from hydrocrane.errors import InputError, check_known
from hydrocrane.machine.machine import Machine

INTERFACES = ("lever", "tip")
# Time between two movements of the hands, s; well below any reaction time; also the period of all observations.
PERIOD = 0.05
# Longest reaction time, s.
LATEST = 2.0
# Averaging time of the observed tip velocity, s: an operator cannot follow the oil's oscillation by eye.
GLANCE = 0.2
# Speed below which the operator sees the tip at rest, m/s.
STANDING = 0.03
# Share of a tolerance within which the operator does not move the sticks.
CONTENT = 0.7
# Other levers must be faster by this factor to replace those in use.
RELUCTANCE = 1.25
# Share of a joint's range before its end within which its lever is not deflected towards that end.
NEAR_END = 0.03
# Least determinant, as a share of the squared trace, for two levers to count as independent; and a number that keeps a
# quotient finite.
ALIKE, TINY = 1e-3, 1e-12
# Time after which the operator estimates the effect of each lever again, s.
JUDGED = 2.0


@dataclass(frozen=True)
class Operator:
    """Abilities of the operator, the same for both interfaces unless stated otherwise.

    Attributes
    ----------
    gain : float
        Wanted velocity per distance to the way-point, 1/s. The defaults of this and the next two are the start of a
        search: :func:`log_loading.tune_operator` finds them for each interface.
    anticipation : float
        Time over which the operator extrapolates the tip along its velocity, s; initially the whole reaction time.
    speed : float
        Highest wanted tip speed, m/s; that of a full tip stick. Initially about the highest of the laboratory crane in
        its working area.
    reaction : float
        Delay from perception to the movement of the hand, s, rounded to ``PERIOD``. Assumed, between 0.2 and 0.3 s.
    hand_rate : float
        Fastest movement of a stick, full deflections per second; assumed: centre to end in a quarter of a second.
    hand_step : float
        Resolution of the hand: deflections are multiples of it, a share of the full one. Assumed.
    grapple_time : float
        Time to close or open the grapple with centred sticks, s. Assumed.
    levers : int
        Levers moved at the same time, 1 to 3; the tip stick does not use it. Two mean one per hand.
    picture_error : float
        Standard deviation of the error in the direction in which the operator expects a lever to move the tip, rad;
        drawn anew for each lever every ``JUDGED`` s. Half of it is also the standard deviation of the logarithm
        of the speed assumed. The tip stick does not use it. The default is 15 degrees, assumed.

    Examples
    --------
    >>> from modelled_operator import Operator
    >>> Operator(reaction=0.3).delay
    6
    """

    gain: float = 1.0
    anticipation: float = 0.25
    speed: float = 0.3
    reaction: float = 0.25
    hand_rate: float = 4.0
    hand_step: float = 0.02
    grapple_time: float = 1.0
    levers: int = 2
    picture_error: float = 0.26

    def __post_init__(self) -> None:
        for name in ("gain", "speed", "hand_rate", "hand_step"):
            positive_number(name, getattr(self, name))
        for name in ("anticipation", "grapple_time", "picture_error"):
            number = real_array(getattr(self, name), name)
            if number.ndim or number < 0.0:
                raise InputError(f"{name} must be one number, zero or greater; got {getattr(self, name)!r}")
        reaction = real_array(self.reaction, "reaction")
        if reaction.ndim or not PERIOD <= reaction <= LATEST:
            raise InputError(f"reaction must be one time from {PERIOD:g} to {LATEST:g} s; got {self.reaction!r}")
        if self.levers not in (1, 2, 3):
            raise InputError(f"levers must be 1, 2 or 3, those that move at the same time; got {self.levers!r}")

    @property
    def delay(self) -> int:
        """Reaction time in periods of the hands."""
        return round(self.reaction / PERIOD)

    def seen_at(self, decision: int) -> tuple[int, int]:
        """Indices of the sample that a decision uses, and of that one ``GLANCE`` earlier."""
        late = max(0, decision - self.delay)
        return late, max(0, late - round(GLANCE / PERIOD))

    def changed(self, **values: float) -> Operator:
        """A copy with some attributes replaced."""
        names = [f.name for f in fields(self)]
        for name in values:
            check_known("attribute of an operator", name, names)
        return replace(self, **values)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Waypoint:
    """A way-point of the tip.

    Attributes
    ----------
    place : (x, z)
        In the inertial frame, m.
    tolerance : float
        Distance within which the place counts as reached, m.
    payload : float or None
        Payload after the way-point, kg: the tip stops, and the grapple closes or opens. ``None``: no change.
    stop : bool
        Whether the tip must stop there; it always does if the payload changes.
    """

    place: tuple[float, float]
    tolerance: float
    payload: float | None = None
    stop: bool = False

    @property
    def stops(self) -> bool:
        """Whether the tip must stop there."""
        return self.stop or self.payload is not None


@dataclass
class Driver:
    """An operator at work; :meth:`decide` is called once per ``PERIOD``, and a shallow copy is an independent driver.

    Attributes
    ----------
    machine : Machine
    interface : {"lever", "tip"}
    operator : Operator
    waypoints : sequence of Waypoint
    seed : int
        Seed of the errors of the picture.
    payload : float
        Load in the grapple, kg.
    sticks : (2,) or (n_cyl,) array
        Current deflections, -1 to 1.
    aim : int
        Index of the current way-point; past the last one when the task is done.
    """

    machine: Machine
    interface: str
    operator: Operator
    waypoints: Sequence[Waypoint]
    seed: int
    payload: float = 0.0
    aim: int = 0
    sticks: Array = field(init=False)
    _grappling: int = 0
    _levers: tuple[int, ...] = ()
    _decided: int = 0

    def __post_init__(self) -> None:
        check_known("interface of an operator", self.interface, INTERFACES)
        self.sticks = np.zeros(2 if self.interface == "tip" else len(self.machine.cylinder_names))

    @property
    def done(self) -> bool:
        """Whether the last way-point has been reached."""
        return self.aim >= len(self.waypoints)

    def decide(self, tip: Array, velocity: Array, q: Array) -> Array:
        """Deflections for the next ``PERIOD`` from the observation one reaction time ago: tip (2,), m, m/s, pose q
        (n,)."""
        self._decided += 1
        wanted = self._wanted(tip, velocity)
        deflections = self._deflections(wanted, q) if wanted.any() else np.zeros_like(self.sticks)
        most, finest = self.operator.hand_rate * PERIOD, self.operator.hand_step
        moved = np.clip(deflections, self.sticks - most, self.sticks + most)
        self.sticks = np.clip(finest * np.round(moved / finest), -1.0, 1.0)
        return self.sticks

    def _wanted(self, tip: Array, velocity: Array) -> Array:
        """Tip velocity (2,) that the operator wants, m/s; selects the next way-point when one is reached."""
        still = np.zeros(2)
        if self._grappling:
            self._grappling -= 1
            if not self._grappling:
                self._grasp()
            return still
        if self.done:
            return still
        aim, operator = self.waypoints[self.aim], self.operator
        away = np.asarray(aim.place) - tip
        distance = float(np.hypot(*away))
        if not aim.stops:
            if distance < CONTENT * aim.tolerance:
                self.aim += 1
                return self._wanted(tip, velocity)
            # No slow-down for a way-point without a stop.
            return operator.speed * away / distance
        if distance < CONTENT * aim.tolerance and float(np.hypot(*velocity)) < STANDING and not self.sticks.any():
            self._grappling = round(operator.grapple_time / PERIOD) if aim.payload is not None else 0
            if not self._grappling:
                self._grasp()
            return still
        ahead = away - operator.anticipation * velocity
        left = float(np.hypot(*ahead))
        if left < CONTENT * aim.tolerance:
            return still
        return ahead * min(operator.gain, operator.speed / left)

    def _grasp(self) -> None:
        """Completes the current way-point."""
        held = self.waypoints[self.aim].payload
        self.payload = self.payload if held is None else held
        self.aim += 1

    def _deflections(self, wanted: Array, q: Array) -> Array:
        if self.interface == "tip":
            return wanted / self.operator.speed
        slopes = np.diagonal(self.machine.stroke_jacobian(q))
        column = self._picture(q, slopes)
        tried = {
            used: _shares(column, wanted, used)
            for used in itertools.combinations(range(len(slopes)), self.operator.levers)
        }
        for used, (_, deflections) in tried.items():
            if self._blocked(q, deflections * np.sign(slopes)):
                tried[used] = (0.0, np.zeros_like(deflections))
        best = max(tried, key=lambda used: tried[used][0])
        if self._levers not in tried or tried[best][0] > RELUCTANCE * tried[self._levers][0]:
            self._levers = best
        return tried[self._levers][1]

    def _blocked(self, q: Array, turning: Array) -> bool:
        """Whether a joint near its end is moved further; `turning` (n,) has the signs of the rates."""
        lower, upper = self.machine.joint_limits.T
        near = NEAR_END * (upper - lower)
        return bool((((q > upper - near) & (turning > 0.0)) | ((q < lower + near) & (turning < 0.0))).any())

    def _picture(self, q: Array, slopes: Array) -> Array:
        """Tip velocity (2, n_cyl) that the operator expects of each lever at full deflection, m/s.

        The true one without a load, equal in both directions, rotated and scaled by errors.
        """
        speed = np.abs(self.machine.piston_speeds(q)).mean(axis=1)
        columns = self.machine.tip_jacobian(q) * (speed / np.where(np.abs(slopes) < 1e-3, np.inf, slopes))
        random = np.random.default_rng((self.seed, int(self._decided * PERIOD / JUDGED)))
        error = self.operator.picture_error
        angle = error * random.standard_normal(speed.size)
        scale = np.exp(0.5 * error * random.standard_normal(speed.size))
        x, z = scale * columns
        return np.array([np.cos(angle) * x - np.sin(angle) * z, np.sin(angle) * x + np.cos(angle) * z])


def _shares(column: Array, wanted: Array, used: tuple[int, ...]) -> tuple[float, Array]:
    """Expected speed towards `wanted` (2,) with the levers `used` only, m/s, and the deflections (n_cyl,).

    One lever moves the tip as near to `wanted` as possible. Two and more reach it exactly with the least deflections,
    which are all scaled if one would exceed its end.
    """
    chosen = column[:, used]
    if len(used) == 1:
        found = chosen.T @ wanted / max(float((chosen**2).sum()), TINY)
    else:
        (xx, xz), (_, zz) = chosen @ chosen.T
        # Levers that move the tip along one line cannot be combined to another direction; their result is zero.
        found = chosen.T @ np.array([zz * wanted[0] - xz * wanted[1], xx * wanted[1] - xz * wanted[0]])
        found = found / max(xx * zz - xz**2, ALIKE * (xx + zz) ** 2, TINY)
    found = found / max(1.0, float(np.abs(found).max()))
    deflections = np.zeros(column.shape[1])
    deflections[list(used)] = found
    return float(chosen @ found @ wanted / np.hypot(*wanted)), deflections
