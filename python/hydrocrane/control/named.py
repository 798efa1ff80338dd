"""The controllers of the package, stepped by your own program."""

from __future__ import annotations

from hydrocrane import _core
from hydrocrane.arrays import real_array
from hydrocrane.control.controllers import NAMES, Observation
from hydrocrane.control.joystick import Stick
from hydrocrane.errors import InputError, SimulationError, check_known, translated
from hydrocrane.machine.machine import Machine, MachineLike, as_machine


class NamedController:
    """A controller by name, sample by sample: with your own simulation, with a real machine, or inside another
    controller.

    It has the methods of every controller, `reset` and `step`, so a scenario accepts it too.

    Parameters
    ----------
    name : {"tip", "heinze-pid", "lever"}
    machine : Machine, str or path, optional
        Controller model, with its gains and its period (``control.period``); default is the machine that
        :meth:`reset` is given.
    monitor : bool, optional
        Whether readings are checked, and the spools centred if they are not plausible; default is as in a scenario:
        not for ``lever``, which reads no sensors.
    delay : float
        Time from a sample until the command leaves, s, which the monitor assumes.

    Attributes
    ----------
    monitored : bool
        Whether readings are checked.

    Raises
    ------
    InputError
        An unknown name, or an invalid delay.

    Examples
    --------
    >>> import numpy as np
    >>> import hydrocrane as hc
    >>> crane = hc.load_machine("rottne-f9-lab")
    >>> plant = hc.Simulator(crane, sample_time=0.01)
    >>> controller = hc.NamedController("tip")
    >>> obs = plant.reset(q=np.array([np.deg2rad(100), np.deg2rad(100), 0.0]))
    >>> controller.reset(crane, obs)
    >>> start = obs.tip
    >>> for _ in range(100):
    ...     obs = plant.step(controller.step(obs, hc.Stick("tip", np.array([0.0, 0.2]))))
    >>> print(f"up by {obs.tip[1] - start[1]:.2f} m")
    up by 0.05 m
    """

    def __init__(
        self, name: str, machine: MachineLike | None = None, *, monitor: bool | None = None, delay: float = 0.0
    ) -> None:
        check_known("controller", name, NAMES)
        time = real_array(delay, "delay")
        if time.ndim or time < 0:
            raise InputError(f"delay must be one number of zero or more seconds; got {delay!r}")
        self.name = name
        self.delay = float(time)
        self.monitored = name != "lever" if monitor is None else monitor
        self._known = None if machine is None else as_machine(machine)
        self._core: _core.SteppedController | None = None
        self._signals: list[str] = []
        self._fault: str | None = None
        self._news: list[str] = []

    @property
    def period(self) -> float:
        """Time between samples that the controller assumes, s."""
        return self._made().period

    @property
    def set_point(self) -> tuple[float, ...] | None:
        """Set-point of the tip after the last step, m, if the controller has one: (x, z), or (x, y, z) in space."""
        place = None if self._core is None else self._core.set_point
        return None if place is None else tuple(place)

    @property
    def fault(self) -> str | None:
        """Why the last step gave no command, so the spools go to their centres; ``None`` if it gave one."""
        return self._fault

    @property
    def notices(self) -> tuple[str, ...]:
        """Events since :meth:`reset`, for the operator of the machine."""
        return tuple(self._news)

    def reset(self, machine: MachineLike, obs: Observation) -> None:
        """Restart on a crane with a first observation.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> plant, controller = hc.Simulator(crane), hc.NamedController("tip")
        >>> controller.reset(crane, plant.reset(q=crane.home))
        >>> print(controller.period, controller.notices)
        0.01 ()
        """
        machine = self._known or as_machine(machine)
        joints = [f"joint.{joint}.q" for joint in machine.joint_names]
        self._signals = joints + [f"cylinder.{c}.p{side}" for c in machine.cylinder_names for side in (1, 2)]
        self._joints, self._fault, self._news = len(joints), None, []
        self._core = self._make(machine)
        self._core.reset(obs.t, *self._readings(obs))

    def step(self, obs: Observation, command: Stick) -> list[float]:
        """Spool commands (n_cyl,), m, positive extends, for an observation and the sticks.

        It uses the sensor readings, ``obs.measured``; signals that are not among them are taken from
        ``obs.q`` and ``obs.p``. If the controller has no command, all are zero and :attr:`fault` states the reason.

        Raises
        ------
        SimulationError
            Before the first :meth:`reset`.
        InputError
            A stick with another shape than its mode, or an observation of another crane.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> plant, controller = hc.Simulator(crane), hc.NamedController("lever")
        >>> obs = plant.reset(q=crane.home)
        >>> controller.reset(crane, obs)
        >>> print(controller.step(obs, hc.Stick("lever", np.array([0.5, 0.0, 0.0]))))
        [0.025, 0.0, 0.0]
        """
        if self._core is None:
            raise SimulationError("call reset(machine, obs) before the first step")
        axes = [float(axis) for axis in command.axes]
        with translated():
            spools, self._fault, news = self._core.step(obs.t, *self._readings(obs), command.mode, axes)
        self._news += news
        return spools

    def _readings(self, obs: Observation) -> tuple[list[float], list[list[float]]]:
        """Joint coordinates and chamber pressures as measured."""
        true = [*obs.q, *obs.p.ravel()]
        if len(true) != len(self._signals):
            joints = "joint" if self._joints == 1 else "joints"
            raise InputError(
                f"the controller knows a crane of {self._joints} {joints}; the observation has {len(obs.q)}"
            )
        read = [float(obs.measured.get(name, value)) for name, value in zip(self._signals, true, strict=True)]
        q, p = read[: self._joints], read[self._joints :]
        return q, [p[i : i + 2] for i in range(0, len(p), 2)]

    def _made(self) -> _core.SteppedController:
        if self._core is None:
            if self._known is None:
                raise SimulationError("the period is that of a machine: give one, or call reset(machine, obs)")
            return self._make(self._known)
        return self._core

    def _make(self, machine: Machine) -> _core.SteppedController:
        with translated():
            return _core.SteppedController(machine.core, self.name, self.monitored, self.delay)
