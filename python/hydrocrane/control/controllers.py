"""Controllers: those of the package by name, and your own in the sampled loop."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array, brief
from hydrocrane.control.joystick import Stick
from hydrocrane.errors import InputError, check_known
from hydrocrane.machine.machine import Machine

NAMES = ("tip", "heinze-pid", "lever")
DEFAULT_PERIOD = 0.01
ON_ERROR = ("raise", "stop", "neutral")
PACKAGE = Path(__file__).parents[1]


@dataclass(frozen=True)
class Observation:
    """Input of a controller at a sample.

    Attributes
    ----------
    t : float
        s.
    q, qd : (n,) arrays
        Joint coordinates and rates, rad or m, and per second. In a scenario q is the sensor reading and qd the
        difference of the last two readings; from :class:`hydrocrane.Simulator` both are the crane's true values.
    p : (n_cyl, 2) array
        Chamber pressures p1, p2, Pa gauge; measured or true like q.
    tip : (2,) array
        x, z in the inertial frame at q, m.
    measured : dict
        Sensor readings by signal.

    Examples
    --------
    >>> crane = hc.Simulator("rottne-f9-lab", sample_time=0.01)
    >>> obs = crane.reset(q=crane.machine.home)
    >>> print(obs.t, obs.q.shape, obs.p.shape, obs.tip.round(2))
    0.0 (3,) (3, 2) [ 2.05 -1.01]
    """

    t: float
    q: Array
    qd: Array
    p: Array
    tip: Array
    measured: dict[str, float]

    __repr__ = brief


@runtime_checkable
class Controller(Protocol):
    """Your own controller: an object with these two methods, or a function like `step`.

    It may also have an attribute ``set_point``, (x, z) of the tip in m, (x, y, z) on a machine in space, which is then
    recorded.

    Examples
    --------
    >>> class Proportional:
    ...     def reset(self, machine, obs):
    ...         self.machine, self.goal = machine, machine.strokes(obs.q)
    ...     def step(self, obs, command):
    ...         return 0.1 * (self.goal - self.machine.strokes(obs.q))
    >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
    >>> run = hc.simulate(hc.Scenario(joints=start, controller=Proportional(), duration=1.0))
    >>> print(run.outcome.kind)
    completed
    """

    def reset(self, machine: Machine, obs: Observation, /) -> None:
        """Restart on a crane.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> controller = hc.NamedController("tip")
        >>> controller.reset(crane, hc.Simulator(crane).reset(q=crane.home))
        >>> print(isinstance(controller, hc.Controller))
        True
        """

    def step(self, obs: Observation, command: Stick, /) -> ArrayLike:
        """Spool commands (n_cyl,), m, positive extends.

        Examples
        --------
        >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
        >>> def hold(obs, command):
        ...     return [0.0, 0.0, 0.0]
        >>> run = hc.simulate(hc.Scenario(joints=start, controller=hold, duration=0.1))
        >>> print(run.outcome.kind)
        completed
        """


StepFunction: TypeAlias = Callable[["Observation", Stick], ArrayLike]


class Stepping(Protocol):
    """A controller without internal state: `reset` may be omitted."""

    def step(self, obs: Observation, command: Stick, /) -> ArrayLike:
        """As in :class:`Controller`."""


# An own controller, and any controller that a scenario accepts.
OwnController: TypeAlias = Controller | Stepping | StepFunction
AnyController: TypeAlias = str | OwnController


class SampledController:
    """The adapter through which the core's loop calls an own controller.

    Attributes
    ----------
    error : BaseException or None
        Last exception of the controller, with its traceback.
    """

    def __init__(
        self, law: OwnController, machine: Machine, mode: str, full_speed: float | None, *, on_error: str = "raise"
    ) -> None:
        self._law, self._crane, self._mode, self._full_speed = law, machine, mode, full_speed
        self._step: StepFunction = getattr(law, "step", law)  # type: ignore[arg-type]
        signals = [f"joint.{j}.q" for j in machine.joint_names]
        self._signals = signals + [f"cylinder.{c}.p{side}" for c in machine.cylinder_names for side in (1, 2)]
        self._last: tuple[float, Array] | None = None
        self._set_point: tuple[float, float, float] | None = None
        self._on_error = on_error
        self.error: BaseException | None = None

    def reset(self, t: float, q: list[float], p: list[list[float]]) -> None:
        with self._noted():
            self._last = None
            obs = self._observe(t, np.array(q), np.array(p))
            if hasattr(self._law, "reset"):
                self._law.reset(self._crane, obs)

    def step(self, t: float, q: list[float], p: list[list[float]], axes: list[float]) -> list[float]:
        with self._noted():
            obs = self._observe(t, np.array(q), np.array(p))
            command = self._checked(self._step(obs, Stick(self._mode, np.array(axes), self._full_speed)))
            point = getattr(self._law, "set_point", None)
            self._set_point = None if point is None or callable(point) else self._place(point)
        return command

    def set_point(self) -> tuple[float, float, float] | None:
        return self._set_point

    def _place(self, point: Sequence[float]) -> tuple[float, float, float]:
        axes = self._crane.tip_axes
        if len(point) != len(axes):
            raise InputError(f"set_point of the controller must be ({', '.join(axes)}) of the tip, m; got {point!r}")
        place = dict(zip(axes, map(float, point), strict=True))
        return place["x"], place.get("y", 0.0), place["z"]

    def failure(self) -> tuple[str, bool]:
        """Text and place of the last exception, and whether it ends the run."""
        assert self.error is not None
        # Ctrl-C and the like are no fault of the controller and always end the run.
        ends = self._on_error != "neutral" or not isinstance(self.error, Exception)
        return _reported(self.error), ends

    def _checked(self, command: ArrayLike) -> list[float]:
        cylinders = len(self._crane.cylinder_names)
        try:
            values = [float(u) for u in np.ravel(command)]
        except (TypeError, ValueError) as error:
            fault = f"the controller returned {command!r}, which is not a list of {cylinders} spool commands in m"
            raise InputError(f"{fault} ({type(error).__name__}: {error})") from None
        if len(values) != cylinders:
            names = ", ".join(self._crane.cylinder_names)
            raise InputError(
                f"the controller returned {len(values)} spool commands for {cylinders} cylinders ({names})"
            )
        return values

    @contextmanager
    def _noted(self) -> Iterator[None]:
        try:
            yield
        except BaseException as error:
            self.error = error
            raise

    def _observe(self, t: float, q: Array, p: Array) -> Observation:
        qd = np.zeros_like(q)
        if self._last is not None and t > self._last[0]:
            qd = (q - self._last[1]) / (t - self._last[0])
        self._last = (t, q)
        readings = dict(zip(self._signals, [*q, *p.ravel()], strict=True))
        measured = {name: float(value) for name, value in readings.items()}
        return Observation(t=t, q=q, qd=qd, p=p, tip=tip_read(self._crane, q), measured=measured)


def tip_read(machine: Machine, q: Array) -> Array:
    """Tip by readings (n,) of the joints, which may lie anywhere; NaN if one is missing."""
    if not np.isfinite(q).all():
        return np.full(len(machine.tip_axes), np.nan)
    return np.asarray(machine.core.tip(q[np.newaxis])[0])


def _reported(error: BaseException) -> str:
    """Kind and text of an exception, and the line that raised it; only the text for an exception of this module."""
    head = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    frames = traceback.extract_tb(error.__traceback__)
    if not frames or frames[-1].filename == __file__:
        return head
    return f"{head} ({_named(frames[-1].filename)}, line {frames[-1].lineno}, in {frames[-1].name})"


def _named(file: str) -> str:
    """A file name in messages; files of this package without the installation folder."""
    path = Path(file)
    return path.relative_to(PACKAGE.parent).as_posix() if path.is_relative_to(PACKAGE) else file


def check_controller(controller: AnyController | None) -> None:
    """Raises an :class:`InputError` if `controller` is neither a known name nor can be stepped."""
    if isinstance(controller, str):
        check_known("controller", controller, NAMES)
    elif isinstance(controller, type):
        raise InputError(f"controller is the class {controller.__name__}; give an instance, {controller.__name__}()")
    elif controller is not None and not hasattr(controller, "step") and not callable(controller):
        raise InputError(f"a controller is a name, a function, or an object with reset and step; got {controller!r}")
