"""Keyword arguments that change a scenario: its fields, and those of its solver."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias, TypedDict

from hydrocrane.control.controllers import AnyController
from hydrocrane.control.joystick import Joystick
from hydrocrane.machine.machine import Machine, MachineLike
from hydrocrane.machine.overrides import Overrides
from hydrocrane.machine.sensors import SensorFault
from hydrocrane.result_warning import ResultWarning
from hydrocrane.scenario.bursts import Burst
from hydrocrane.scenario.command import Commands
from hydrocrane.scenario.goals import Goal
from hydrocrane.scenario.phases import Phase
from hydrocrane.scenario.solver import Solver
from hydrocrane.scenario.supply import SupplyLike

Pressures: TypeAlias = str | Mapping[str, tuple[float, float]]


class CommonFields(TypedDict, total=False):
    """Fields of a :class:`~hydrocrane.Scenario` except machine and seed."""

    joints: Mapping[str, float]
    commands: Commands
    duration: float
    record_interval: float
    pressures: Pressures
    payload: float | None
    overrides: Overrides
    solver: Solver
    name: str
    title: str
    controller: AnyController | None
    joystick: Joystick | None
    goals: Iterable[Goal]
    period: float | None
    delay: float
    sensors: str
    sensor_faults: Iterable[SensorFault]
    bursts: Iterable[Burst]
    payload_changes: Mapping[float, float]
    controller_model: Machine | Overrides | None
    monitor: bool | None
    phases: Iterable[Phase]
    supply: SupplyLike | None
    recorded_by: str
    record_limit: float | str | None
    warnings: Sequence[ResultWarning]


class CommonSettings(TypedDict, total=False):
    """Fields of a :class:`~hydrocrane.Solver` except the method."""

    rtol: float
    atol: float | None
    max_step: float
    step: float | None


class ScenarioFields(CommonFields, total=False):
    """Fields of a :class:`~hydrocrane.Scenario`."""

    machine: MachineLike
    seed: int


class SolverFields(CommonSettings, total=False):
    """Fields of a :class:`~hydrocrane.Solver`."""

    method: str


class Changes(ScenarioFields, SolverFields, total=False):
    """Arguments of :meth:`hydrocrane.Scenario.changed`."""


class SweepChanges(CommonFields, CommonSettings, total=False):
    """Changes in :func:`hydrocrane.sweep`, which has its own arguments machine, method and seed."""


class RunChanges(SweepChanges, total=False):
    """Changes in :func:`hydrocrane.simulate`, which has its own argument `machine`."""

    seed: int
    method: str
