"""Changes during a run: controller, sticks, values of the machine; timed entries in order of time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import Protocol, TypedDict, TypeVar

from hydrocrane._core_types import Override, StageTable
from hydrocrane.arrays import scenario_quantity
from hydrocrane.control.controllers import AnyController
from hydrocrane.control.joystick import Joystick
from hydrocrane.errors import InputError, check_known
from hydrocrane.machine.machine import Machine
from hydrocrane.machine.overrides import Overrides, plain_overrides
from hydrocrane.machine.sensors import SENSORS


class Due(Protocol):
    """An entry with a time, s."""

    @property
    def time(self) -> float: ...


D = TypeVar("D", bound=Due)


def in_order_of_time(given: Iterable[D] | D, kind: type[D], name: str, twice: str) -> tuple[D, ...]:
    """The entries `given` of one `kind`, in order of time.

    In messages `name` is the name of the argument, and `twice` says what two entries do at one time.
    """
    listed = list(given) if isinstance(given, Iterable) else [given]
    if not all(isinstance(one, kind) for one in listed):
        raise InputError(f"{name} must be a list of {kind.__name__}; got {given!r}")
    ordered = sorted(listed, key=lambda one: one.time)
    for early, late in zip(ordered[:-1], ordered[1:], strict=True):
        if early.time == late.time:
            raise InputError(f"two {name} {twice} at {late.time:g} s; give each a different time")
    return tuple(ordered)


@dataclass(frozen=True)
class ScenarioStage:
    """What holds from a time on: the start of a scenario, or one of its phases with all that stays.

    Attributes
    ----------
    driver : str, object or None
        The controller; ``None`` under spool commands.
    sensors : {"ideal", "data-sheet"}
    stick_mode : {"tip", "lever"}
    stick_times : int
        Times at which the sticks are stated.
    machine_overrides : mapping
        Of the scenario and all phases until here, with those that a named controller's period and full speed make.
    """

    driver: AnyController | None
    sensors: str
    stick_mode: str
    stick_times: int
    machine_overrides: Mapping[str, Override]

    @classmethod
    def of(cls, stage: StageTable, own: Mapping[int, AnyController]) -> ScenarioStage:
        """From the core's data; `own` are your controllers by their numbers."""
        number = stage["own"]
        driver = stage["controller"] if number is None else own[number]
        return cls(driver, stage["sensors"], stage["mode"], stage["stick_times"], dict(stage["overrides"]))


class LoopFields(TypedDict, total=False):
    """Fields of a :class:`ControlLoop`."""

    controller: AnyController | None
    joystick: Joystick | None
    period: float | None
    delay: float
    sensors: str
    controller_model: Machine | Overrides | None
    monitor: bool | None


@dataclass(frozen=True, kw_only=True)
class ControlLoop:
    """Sticks and controller with its settings, of a scenario and of a phase; described there."""

    controller: AnyController | None = None
    joystick: Joystick | None = None
    period: float | None = None
    delay: float = 0.0
    sensors: str = "ideal"
    controller_model: Machine | Overrides | None = None
    monitor: bool | None = None

    def _check_values(self) -> None:
        if self.joystick is not None and not isinstance(self.joystick, Joystick):
            raise InputError(f"joystick must be a Joystick, got {self.joystick!r}")
        check_known("kind of sensors", self.sensors, SENSORS)
        if not (self.monitor is None or isinstance(self.monitor, bool)):
            raise InputError(f"monitor must be True, False or None; got {self.monitor!r}")
        if self.period is not None:
            scenario_quantity("controller.period", "period", self.period)
        scenario_quantity("controller.delay", "delay", self.delay)


@dataclass(frozen=True)
class Phase(ControlLoop):
    """From a given time on the crane has another controller or other sticks, or other values.

    A phase continues with the state, the load, the energies, the sticks and the commands under way; its
    controller and its sensors restart as at the start of a run.

    Parameters
    ----------
    time : float
        When it begins, s.
    overrides : mapping
        Machine keys that change, added to those in force.
    controller : str or object, optional
        As in a scenario; `period`, `delay`, `sensors`, `controller_model` and `monitor` belong to it. By default all
        of them are unchanged, the period also if only the controller is given.
    joystick : Joystick, optional
        By default the sticks are unchanged; if the controller needs sticks of the other mode, they are centred.
        A joystick of the other mode without `controller` selects the controller of its mode.

    Examples
    --------
    >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
    >>> up = hc.Joystick([0.5], {"z": [1.0]}, full_speed=0.1)
    >>> less = hc.Phase(1.0, overrides={"supply.pressure": "100 bar"})
    >>> run = hc.simulate(hc.Scenario(joints=start, joystick=up, phases=[less], duration=2.0))
    >>> print(run.outcome.kind)
    completed
    """

    time: float
    overrides: Overrides = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", scenario_quantity("phase.<name>.time", "time of a phase", self.time))
        object.__setattr__(self, "overrides", plain_overrides(self.overrides))
        if self.controller is None:
            of_it = [f.name for f in fields(ControlLoop) if f.name not in ("controller", "joystick")]
            stated = [name for name in of_it if getattr(self, name) != getattr(ControlLoop, name)]
            if stated:
                raise InputError(f"`{stated[0]}` of a phase belongs to its controller, which it does not name")
        self._check_values()
