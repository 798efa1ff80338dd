"""Goals of the tip."""

from __future__ import annotations

from dataclasses import dataclass

from hydrocrane.arrays import one_number
from hydrocrane.errors import InputError


@dataclass(frozen=True)
class Goal:
    """A point to which the tip moves from a given time on, on a straight line, and stops there.

    The controller ``tip`` does this until another goal is given or a stick is moved. Events of the run report when the
    tip is there, or why it stops before.

    Parameters
    ----------
    time : float
        When the motion starts, s.
    x, z : float
        The goal, m.
    speed : float, optional
        Speed towards the goal, m/s; default is the speed at full stick.
    until : float, optional
        When the goal is cancelled, s, if the tip is not there before: the tip stops where it is.

    Examples
    --------
    >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
    >>> run = hc.simulate(hc.Scenario(joints=start, goals=[hc.Goal(0.5, 2.7, 0.2, speed=0.3)], duration=5.0))
    >>> print(run.columns["tip.x"].values[-1].round(2), run.columns["tip.z"].values[-1].round(2))
    2.7 0.2
    """

    time: float
    x: float
    z: float
    speed: float | None = None
    until: float | None = None

    def __post_init__(self) -> None:
        for name in ("time", "x", "z"):
            object.__setattr__(self, name, one_number(f"`{name}` of a goal", getattr(self, name)))
        if self.time < 0:
            raise InputError(f"a goal is given at zero seconds or later; got {self.time!r}")
        if self.speed is not None:
            object.__setattr__(self, "speed", one_number("`speed` of a goal", self.speed))
            if not self.speed > 0:
                raise InputError(f"the speed to a goal must be greater than zero, in m/s; got {self.speed!r}")
        if self.until is not None:
            object.__setattr__(self, "until", one_number("`until` of a goal", self.until))
            if not self.until > self.time:
                raise InputError(f"a goal is cancelled after it is given, at {self.time!r} s; got until={self.until!r}")
