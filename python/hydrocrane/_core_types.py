"""Types of the arguments and results of the compiled core, for its stub and its callers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NotRequired, Protocol, TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from hydrocrane import _core

Array: TypeAlias = NDArray[np.float64]
# A value of a machine key; numbers are SI.
Override: TypeAlias = "float | str | bool | Sequence[Override]"
Pairs: TypeAlias = list[tuple[str, Override]]
# Kind, text, cure, time.
WarningEntry: TypeAlias = tuple[str, str, str, float, str | None]
# Name, kind and its number, use, unit, description, start, range, nominal value.
FmuVariableEntry: TypeAlias = tuple[
    str, str, int, str, str, str, float | None, tuple[float, float] | None, float | None
]
# Kind, time, message.
OutcomeEntry: TypeAlias = tuple[str, float, str]
# Name, unit, meaning.
SignalEntry: TypeAlias = tuple[str, str, str]
# Result, operation and operands of each step of a tape, and its results.
FunctionEntry: TypeAlias = tuple[list[tuple[str, str, list[str]]], list[str]]
# Time, payload before and after, velocity of the tip before and after, loss.
PayloadEntry: TypeAlias = tuple[float, Sequence[float], Sequence[Sequence[float]], float]
# Cylinder, side, time, opening.
BurstEntry: TypeAlias = tuple[str, str, float, float]
# Signal, kind, from, until, size.
FaultEntry: TypeAlias = tuple[str, str, float, float, float]


class Samples(TypedDict):
    """Inputs and outputs of a controller in one phase, a row per sample."""

    t: Array
    measured: Array
    sticks: Array
    set_points: Array
    commands: Array
    learnt: Array
    valves: list[str]
    signals: list[str]


class FinishedRun(TypedDict):
    """What every run has, with or without sensitivities."""

    t: Array
    commands: Array
    payloads: Array
    payload_changes: list[PayloadEntry]
    warnings: list[WarningEntry]
    outcome: OutcomeEntry
    method: str
    stats: dict[str, int]


class RunRecord(FinishedRun):
    """A run as the core recorded it; `stages` and `samples` have one entry per stage that began."""

    states: Array
    ledger: Array
    tip_error: float | None
    doubts: list[WarningEntry]
    stages: list[StageTable]
    samples: list[Samples]
    events: list[tuple[float, str]]


class SensitivityRecord(FinishedRun):
    """A run with its sensitivities, as the core recorded it."""

    values: Array
    sensitivities: Array
    signals: list[SignalEntry]
    parameters: list[tuple[str, float, str]]


class LoopController(Protocol):
    """Your own controller, as the core's loop calls it."""

    def reset(self, t: float, q: list[float], p: list[list[float]], /) -> None: ...
    def step(self, t: float, q: list[float], p: list[list[float]], axes: list[float], /) -> list[float]: ...
    def set_point(self) -> tuple[float, float, float] | None: ...
    def failure(self) -> tuple[str, bool]: ...


class SolverEntry(TypedDict):
    """Settings of the integration."""

    method: str
    rtol: float
    atol: float | None
    max_step: float
    step: float | None


class ControllerEntry(TypedDict):
    """A controller by name, or your own one by its number."""

    name: str
    own: int | None
    period: float | None
    delay: float
    sensors: str
    controller_model: Pairs
    other_model: tuple[str, Pairs] | None
    monitor: bool | None


class JoystickEntry(TypedDict):
    """Sticks against time, by axis."""

    mode: str
    time: Array
    axes: list[tuple[str, Array]]
    # Of a file.
    log: str | None
    linear: bool
    dead_zone: float
    full_speed: float | None
    ramp: float
    precision: Array


class PhaseEntry(TypedDict):
    """Fields of a phase."""

    time: float
    overrides: Pairs
    controller: ControllerEntry | None
    joystick: JoystickEntry | None


# Time, place, speed and end of a goal.
GoalEntry: TypeAlias = tuple[float, tuple[float, float], float | None, float | None]
# Cylinder, times, spool positions, and whether they are interpolated linearly.
CommandEntry: TypeAlias = tuple[str, Array, Array, bool]
# Times, pressures, and whether they are interpolated linearly.
SupplyEntry: TypeAlias = tuple[Array, Array, bool]


class ScenarioEntry(TypedDict):
    """A scenario without its names and its machine, to the core and from a file."""

    overrides: Pairs
    payload: float | None
    payload_changes: list[tuple[float, float]]
    duration: float
    record_interval: float
    joints: list[tuple[str, float]]
    places: list[str]
    pressures: list[tuple[str, tuple[float, float]]] | None
    commands: list[CommandEntry]
    supply: SupplyEntry | None
    controller: ControllerEntry | None
    joystick: JoystickEntry | None
    goals: list[GoalEntry]
    phases: list[PhaseEntry]
    sensor_faults: list[FaultEntry]
    bursts: list[BurstEntry]
    solver: SolverEntry
    seed: int


# `from` is a keyword of Python, hence this form.
StageTable = TypedDict(
    "StageTable",
    {
        "from": float,
        "mode": str,
        "overrides": Pairs,
        "controller": "str | None",
        "own": "int | None",
        "sensors": str,
        "stick_times": int,
        "machine": NotRequired["_core.Machine"],
        "changes": NotRequired["list[tuple[float, _core.Machine]]"],
        "controller_model": NotRequired["_core.Machine"],
    },
)


# Begin of a stage and its sticks as they were moved; `stated` are dead zone, full speed and ramp of its joystick.
DrivenStage = TypedDict(
    "DrivenStage",
    {
        "from": float,
        "mode": str,
        "names": list[str],
        "linear": bool,
        "time": Array,
        "axes": Array,
        "precision": Array,
        "stated": tuple[float, float | None, float] | None,
    },
)


class DriveRecord(TypedDict):
    """The inputs of a drive until its last sample, stage by stage."""

    end: float
    goals: list[GoalEntry]
    payload: float
    stages: list[DrivenStage]


# Name, title, machine and version of its recorder, warnings, and the rest of a scenario file.
ScenarioFile: TypeAlias = tuple[tuple[str, str, str, str], list[WarningEntry], ScenarioEntry]


class TapeTable(TypedDict):
    """A machine as operations; functions: the derivative, the same with its slopes at `places`, outputs."""

    parameters: list[tuple[str, float, str]]
    outputs: list[SignalEntry]
    places: list[list[int]]
    tables: list[tuple[list[float], list[list[float]]]]
    prologue: FunctionEntry
    kept: list[float]
    functions: list[FunctionEntry]


class Passivity(TypedDict):
    """Whether the friction of a cylinder only dissipates, and up to which velocity, m/s."""

    cylinder: str
    holds: bool
    velocity_limit: float | None
    checked_to: float
