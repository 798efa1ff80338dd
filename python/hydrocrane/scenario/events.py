"""What happens once during a run: goals of the tip, hoses that burst."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from hydrocrane import _core
from hydrocrane.arrays import one_number, scenario_quantity
from hydrocrane.errors import InputError, check_known

SIDES = tuple(_core.scenario_choices("burst.<name>.side"))


@dataclass(frozen=True)
class Burst:
    """A hose that bursts: from `time` on oil leaves through a hole of the area `opening` to the outside.

    A valve that holds the load stands at the cylinder, before the hose. The output
    ``cylinder.<cylinder>.lost1`` (piston side) or ``.lost2`` is the flow that leaves, m^3/s; a warning ``oil-lost``
    states its volume.

    Parameters
    ----------
    cylinder : str
        The cylinder to which the hose leads.
    side : {"piston-side", "rod-side"}
    time : float
        s.
    opening : float
        m^2; that of the bore where the hose is torn off.

    Examples
    --------
    >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
    >>> torn = hc.Burst("lift", "piston-side", time=0.5, opening=20e-6)
    >>> run = hc.simulate(hc.Scenario(joints=start, bursts=[torn], duration=1.0))
    >>> lost = run.columns["cylinder.lift.lost1"].values
    >>> print(bool(lost[40] == 0.0), bool(lost[60] > 0.0), run.warnings[0].kind)
    True True oil-lost
    """

    cylinder: str
    side: str
    time: float
    opening: float

    def __post_init__(self) -> None:
        check_known("side of a cylinder", self.side, SIDES)
        for name in ("time", "opening"):
            number = scenario_quantity(f"burst.<name>.{name}", f"{name} of a burst", getattr(self, name))
            object.__setattr__(self, name, number)

    @property
    def entry(self) -> tuple[str, str, float, float]:
        """In the form of the core."""
        return self.cylinder, self.side, self.time, self.opening


def as_bursts(given: Iterable[Burst] | Burst) -> tuple[Burst, ...]:
    """The bursts of a scenario."""
    listed = (given,) if isinstance(given, Burst) else tuple(given)
    if not all(isinstance(one, Burst) for one in listed):
        raise InputError(f"bursts must be a list of Burst; got {given!r}")
    return listed


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
