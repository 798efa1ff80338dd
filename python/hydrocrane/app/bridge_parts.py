"""What the bridge serves: a crane under spool commands, a crane that its controller drives, or a controller alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

import hydrocrane as hc
from hydrocrane.arrays import Array
from hydrocrane.control.controllers import tip_read
from hydrocrane.errors import InputError


@dataclass(frozen=True)
class BridgeSignal:
    """A value of the packets; `low` and `high` bound what a program may send."""

    name: str
    unit: str
    low: float = -math.inf
    high: float = math.inf
    # NaN says that there is no reading.
    may_miss: bool = False


class Part(Protocol):
    """Something with inputs and outputs that goes on by a period at each step."""

    role: str
    machine: hc.Machine
    inputs: tuple[BridgeSignal, ...]
    outputs: tuple[BridgeSignal, ...]
    period: float
    # Whether it goes on with the clock of this computer, or with each packet.
    by_clock: bool

    @property
    def time(self) -> float:
        """Of the last step, s; minus infinity before a controller's first."""

    def reset(self) -> None:
        """Start anew."""

    def step(self, time: float, values: Sequence[float]) -> list[float]:
        """Outputs after a period with these inputs; an error where it cannot go on."""

    def now(self) -> list[float]:
        """Outputs as they are."""

    @property
    def fault(self) -> str | None:
        """Why the last step gave no command."""


def _readings(machine: hc.Machine, signals: Sequence[str]) -> list[BridgeSignal]:
    units = dict(zip(machine.state_names, machine.state_units, strict=True))
    return [BridgeSignal(f"measured.{name}", units.get(name, "N")) for name in signals]


def _seen(machine: hc.Machine, obs: hc.Observation) -> list[BridgeSignal]:
    """What a crane tells."""
    units = dict(zip(machine.state_names, machine.state_units, strict=True))
    joints = [f"joint.{joint}.{kind}" for kind in ("q", "qd") for joint in machine.joint_names]
    pressures = [f"cylinder.{cylinder}.p{side}" for cylinder in machine.cylinder_names for side in (1, 2)]
    told = [BridgeSignal(name, units[name]) for name in joints + pressures]
    return [
        *told,
        *(BridgeSignal(f"tip.{axis}", "m") for axis in machine.tip_axes),
        *_readings(machine, list(obs.measured)),
    ]


def _values(obs: hc.Observation) -> list[float]:
    return [*obs.q.tolist(), *obs.qd.tolist(), *obs.p.ravel().tolist(), *obs.tip.tolist(), *obs.measured.values()]


def _commands(machine: hc.Machine) -> tuple[BridgeSignal, ...]:
    strokes = zip(machine.cylinder_names, np.abs(machine.spool_strokes).tolist(), strict=True)
    return tuple(BridgeSignal(f"cylinder.{name}.command", "m", -stroke, stroke) for name, stroke in strokes)


class Plant:
    """A crane under spool commands."""

    role, by_clock, fault = "plant", True, None

    def __init__(
        self,
        machine: hc.Machine,
        start: Array,
        period: float,
        *,
        sensors: str,
        payload: float | None = None,
        seed: int = 0,
        solver: hc.Solver | None = None,
    ) -> None:
        solver = solver or hc.Solver()
        self.machine, self.period, self._start = machine, period, start
        self._simulator = hc.Simulator(
            machine,
            period,
            payload=payload,
            sensors=sensors,
            seed=seed,
            method=solver.method,
            rtol=solver.rtol,
            step=solver.step,
        )
        self.reset()
        self.inputs, self.outputs = _commands(machine), tuple(_seen(machine, self._obs))

    @property
    def time(self) -> float:
        return self._simulator.time

    def reset(self) -> None:
        self._obs = self._simulator.reset(state=self._start)

    def step(self, time: float, values: Sequence[float]) -> list[float]:
        self._obs = self._simulator.step(values)
        return self.now()

    def now(self) -> list[float]:
        return _values(self._obs)


class Driven:
    """A scenario's crane with its controller, under sticks: hoses burst and sensors fail as the scenario states."""

    role, by_clock, fault = "crane with controller", True, None

    def __init__(self, scenario: hc.Scenario) -> None:
        self._scenario = scenario
        self.reset()
        self.machine, self.period = self._live.machine, self._live.period
        self.inputs = tuple(BridgeSignal(f"stick.{axis}", "1", -1.0, 1.0) for axis in self._live.axes)
        self.outputs = tuple(_seen(self.machine, self._obs))

    @property
    def time(self) -> float:
        return self._live.time

    def reset(self) -> None:
        self._live = hc.LiveSimulator(self._scenario)
        self._obs = self._live.observation

    def step(self, time: float, values: Sequence[float]) -> list[float]:
        self._live.set_stick(**dict(zip(self._live.axes, values, strict=True)))
        self._obs = self._live.step()
        return self.now()

    def now(self) -> list[float]:
        return _values(self._obs)


class Control:
    """A controller that waits for measurements and sticks."""

    role, by_clock = "controller", False

    def __init__(self, name: str, machine: hc.Machine) -> None:
        self.machine = machine
        self._controller = hc.NamedController(name, machine)
        self.period = self._controller.period
        lever = name == "lever"
        self._mode = "lever" if lever else "tip"
        axes = machine.cylinder_names if lever else ("x", "z")
        joints = [f"joint.{joint}.q" for joint in machine.joint_names]
        self._signals = joints + [f"cylinder.{c}.p{side}" for c in machine.cylinder_names for side in (1, 2)]
        readings = [BridgeSignal(s.name, s.unit, may_miss=True) for s in _readings(machine, self._signals)]
        self.inputs = (*readings, *(BridgeSignal(f"stick.{axis}", "1", -1.0, 1.0) for axis in axes))
        self.outputs = _commands(machine)
        self.reset()

    @property
    def fault(self) -> str | None:
        return self._controller.fault

    def reset(self) -> None:
        self.time = -math.inf
        self._command = [0.0] * len(self.outputs)

    def step(self, time: float, values: Sequence[float]) -> list[float]:
        n = len(self.machine.joint_names)
        read = np.array(values[: len(self._signals)])
        q, p = read[:n], read[n:].reshape(-1, 2)
        measured = dict(zip(self._signals, read.tolist(), strict=True))
        obs = hc.Observation(t=time, q=q, qd=np.full(n, np.nan), p=p, tip=tip_read(self.machine, q), measured=measured)
        if self.time == -math.inf:
            self._controller.reset(self.machine, obs)
        self.time = time
        self._command = self._controller.step(obs, hc.Stick(self._mode, np.array(values[len(self._signals) :])))
        return self.now()

    def now(self) -> list[float]:
        return self._command


def checked(part: Part, values: Sequence[float]) -> None:
    """An :class:`InputError` for inputs that are no numbers or out of their range."""
    for signal, value in zip(part.inputs, values, strict=True):
        if math.isnan(value) and signal.may_miss:
            continue
        if not math.isfinite(value) or not signal.low <= value <= signal.high:
            bounds = f" between {signal.low:g} and {signal.high:g}" if math.isfinite(signal.low) else ""
            raise InputError(f"`{signal.name}` is a number{bounds}, unit {signal.unit}; got {value!r}")
