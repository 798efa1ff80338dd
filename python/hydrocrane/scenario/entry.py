"""Conversion of scenarios to the arguments of the core."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane._core_types import (
    CommandEntry,
    ControllerEntry,
    JoystickEntry,
    Pairs,
    PhaseEntry,
    ScenarioEntry,
)
from hydrocrane.arrays import Array
from hydrocrane.control.controllers import AnyController
from hydrocrane.control.joystick import Joystick
from hydrocrane.errors import InputError, unknown
from hydrocrane.machine.machine import Machine
from hydrocrane.machine.overrides import Override, plain_overrides
from hydrocrane.machine.sensors import SensorFault
from hydrocrane.scenario.changes import Pressures
from hydrocrane.scenario.command import Command, split_table
from hydrocrane.scenario.events import Burst, Goal
from hydrocrane.scenario.phases import ControllerSettings, Phase
from hydrocrane.scenario.solver import Solver
from hydrocrane.scenario.supply import SupplyPressure


class Plan(ControllerSettings, Protocol):
    """The fields of a scenario that the core needs."""

    @property
    def overrides(self) -> Mapping[str, Override]: ...
    @property
    def payload(self) -> float | None: ...
    @property
    def payload_changes(self) -> Mapping[float, float]: ...
    @property
    def duration(self) -> float: ...
    @property
    def record_interval(self) -> float: ...
    @property
    def joints(self) -> Mapping[str, float]: ...
    @property
    def pressures(self) -> Pressures: ...
    @property
    def commands(self) -> Mapping[str, Command] | Sequence[ArrayLike]: ...
    @property
    def supply(self) -> SupplyPressure | None: ...
    @property
    def closed_loop(self) -> bool: ...
    @property
    def driver(self) -> AnyController | None: ...
    @property
    def joystick(self) -> Joystick | None: ...
    @property
    def goals(self) -> Sequence[Goal]: ...
    @property
    def phases(self) -> Sequence[Phase]: ...
    @property
    def sensor_faults(self) -> Sequence[SensorFault]: ...
    @property
    def bursts(self) -> Sequence[Burst]: ...
    @property
    def solver(self) -> Solver: ...
    @property
    def seed(self) -> int: ...


def scenario_entry(plan: Plan, cylinders: tuple[str, ...] | None = None) -> ScenarioEntry:
    """`plan` for a machine with these `cylinders`; commands in one table need them."""
    return {
        "overrides": list(plan.overrides.items()),
        "payload": None if plan.payload is None else float(plan.payload),
        "payload_changes": list(plan.payload_changes.items()),
        "duration": float(plan.duration),
        "record_interval": float(plan.record_interval),
        "joints": [(name, _one(f"start of joint {name}", q)) for name, q in plan.joints.items()],
        "places": [getattr(q, "place", "") for q in plan.joints.values()],
        "pressures": _pressures(plan),
        "commands": _commands(plan, cylinders),
        "supply": None if plan.supply is None else plan.supply.entry,
        "controller": _controller(plan, plan.driver, 0) if plan.closed_loop else None,
        "joystick": _joystick(plan.joystick),
        "goals": [(goal.time, (goal.x, goal.z), goal.speed, goal.until) for goal in plan.goals],
        "phases": [_phase(phase, number) for number, phase in enumerate(plan.phases, start=1)],
        "sensor_faults": [fault.entry for fault in plan.sensor_faults],
        "bursts": [burst.entry for burst in plan.bursts],
        "solver": plan.solver.entry,
        "seed": plan.seed,
    }


def own_controllers(plan: Plan) -> dict[int, AnyController]:
    """Your own controllers, by their numbers in the core."""
    drivers = [plan.driver, *(phase.controller for phase in plan.phases)]
    return {number: driver for number, driver in enumerate(drivers) if not isinstance(driver, str | None)}


def _one(what: str, value: ArrayLike) -> float:
    try:
        return float(np.asarray(value, dtype=np.float64))
    except (TypeError, ValueError):
        raise InputError(f"{what} must be one number; got {value!r}") from None


def _pressures(plan: Plan) -> list[tuple[str, tuple[float, float]]] | None:
    if isinstance(plan.pressures, str):
        if plan.pressures != "equilibrium":
            raise unknown("start of the pressures", plan.pressures, ("equilibrium",))
        return None
    table = []
    for name, pair in plan.pressures.items():
        values = np.asarray(pair, dtype=np.float64)
        if values.shape != (2,):
            raise InputError(f"the start pressures of cylinder {name} must be two, (p1, p2); got {pair!r}")
        table.append((name, (float(values[0]), float(values[1]))))
    return table


def _commands(plan: Plan, cylinders: tuple[str, ...] | None) -> list[CommandEntry]:
    commands = plan.commands
    if not isinstance(commands, Mapping):
        commands = split_table(commands, cylinders or ())
    return [(name, *_series(command), command.interpolation == "linear") for name, command in commands.items()]


def _series(command: Command) -> tuple[Array, Array]:
    return command.time, command.spool


def _controller(own: ControllerSettings, driver: AnyController | None, number: int) -> ControllerEntry:
    other: Machine | None = None
    changes: Pairs = []
    if isinstance(own.controller_model, Machine):
        other = own.controller_model
    elif own.controller_model is not None:
        changes = list(plain_overrides(own.controller_model).items())
    return {
        "name": driver if isinstance(driver, str) else "",
        "own": None if isinstance(driver, str) else number,
        "period": None if own.period is None else float(own.period),
        "delay": float(own.delay),
        "sensors": own.sensors,
        "controller_model": changes,
        "other_model": None if other is None else (other.source, list(other.overrides.items())),
        "monitor": own.monitor,
    }


def _joystick(stick: Joystick | None) -> JoystickEntry | None:
    if stick is None:
        return None
    return {
        "mode": stick.mode,
        "time": stick.time,
        "axes": list(stick.axes.items()),
        "linear": stick.interpolation == "linear",
        "dead_zone": float(stick.dead_zone),
        "full_speed": None if stick.full_speed is None else float(stick.full_speed),
        "ramp": float(stick.ramp),
        "precision": stick.precision,
    }


def _phase(phase: Phase, number: int) -> PhaseEntry:
    return {
        "time": phase.time,
        "overrides": list(plain_overrides(phase.overrides).items()),
        "controller": None if phase.controller is None else _controller(phase, phase.controller, number),
        "joystick": _joystick(phase.joystick),
    }
