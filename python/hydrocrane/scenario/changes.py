"""Keyword arguments that change a scenario, and which of two statements of one value counts.

The later statement has priority: a call or the command line over the scenario, the scenario over its machine. Two
different values given at once are an error. The payload, a named controller's period, and its speed at full stick have
two such places: a field of the scenario, and a key of the machine.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple, Protocol, TypeAlias, TypedDict

from hydrocrane import _core
from hydrocrane.control.controllers import AnyController
from hydrocrane.control.joystick import Joystick
from hydrocrane.errors import InputError, translated
from hydrocrane.machine.machine import MachineLike
from hydrocrane.machine.overrides import Override, Overrides
from hydrocrane.machine.sensors import SensorFault
from hydrocrane.result_warning import ResultWarning
from hydrocrane.scenario.events import Burst, Goal
from hydrocrane.scenario.phases import LoopFields, Phase
from hydrocrane.scenario.series import Commands, SupplyLike
from hydrocrane.scenario.solver import Solver

Pressures: TypeAlias = str | Mapping[str, tuple[float, float]]


class CommonFields(LoopFields, total=False):
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
    goals: Iterable[Goal]
    sensor_faults: Iterable[SensorFault]
    bursts: Iterable[Burst]
    payload_changes: Mapping[float, float]
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


class Statements(Protocol):
    """The fields of a scenario that a machine states too."""

    @property
    def payload(self) -> float | None: ...
    @property
    def period(self) -> float | None: ...
    @property
    def joystick(self) -> Joystick | None: ...
    @property
    def driver(self) -> AnyController | None: ...
    @property
    def overrides(self) -> Mapping[str, Override]: ...


class ReplacedKey(NamedTuple):
    """A field of a scenario that replaces a key of its machine."""

    field: str
    value: float
    unit: str


def stated_fields(plan: Statements) -> dict[str, ReplacedKey]:
    """Values that the fields of a scenario state in place of the machine, by its keys."""
    name = plan.driver if isinstance(plan.driver, str) else None
    speed = None if plan.joystick is None else plan.joystick.full_speed
    payload, period, speed = (
        None if number is None else float(number) for number in (plan.payload, plan.period, speed)
    )
    stated = _core.stated_fields(name, payload, period, speed)
    return {key: ReplacedKey(field, value, unit) for key, field, value, unit in stated}


def check_agreement(plan: Statements, overrides: Mapping[str, Override]) -> None:
    """Raises an error if a field of the scenario and one of `overrides` state different values."""
    for key, (field, value, unit) in stated_fields(plan).items():
        check_equal(field, value, unit, key, overrides)


def check_equal(field: str, value: float | str | None, unit: str, key: str, overrides: Mapping[str, Override]) -> None:
    """Raises an error if `value` (SI, or a text with its unit) of `field` and the override of `key` differ."""
    if value is None or key not in overrides:
        return
    with translated():
        wrong = _core.contradiction(value, unit, key, overrides[key])
    if wrong is not None:
        raise InputError(f"`{field}` {wrong}; omit one")


def later_counts(plan: Statements, changes: ScenarioFields) -> ScenarioFields:
    """`changes` of the fields of `plan`; the fields and overrides that they replace are removed."""
    later, older = changes.get("overrides", {}), dict(plan.overrides)
    freed: ScenarioFields = {}
    if "payload.mass" in later:
        freed["payload"] = None
    elif changes.get("payload") is not None:
        older.pop("payload.mass", None)
    if "control.period" in later and isinstance(plan.driver, str):
        freed["period"] = None
    elif changes.get("period") is not None:
        older.pop("control.period", None)
    speeds = [key for key in (*older, *later) if key.startswith("control.") and key.endswith(".full-speed")]
    before, stick = plan.joystick, changes.get("joystick", plan.joystick)
    if stick is not None and stick.full_speed is not None and (before is None or stick.full_speed != before.full_speed):
        older = {key: value for key, value in older.items() if key not in speeds}
    elif stick is not None and any(key in later for key in speeds):
        changes = {**changes, "joystick": dataclasses.replace(stick, full_speed=None)}
    return {**freed, **changes, "overrides": {**older, **later}}
