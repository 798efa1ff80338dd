"""Scenarios from files, and the bundled ones."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import cast

from hydrocrane import _core
from hydrocrane._core_types import ControllerTable, JoystickTable, PhaseTable
from hydrocrane.control.joystick import TIP_AXES, Joystick, StickFields
from hydrocrane.errors import translated
from hydrocrane.machine.overrides import Overrides, plain_overrides
from hydrocrane.machine.sensors import SensorFault
from hydrocrane.result_warning import ResultWarning
from hydrocrane.scenario.changes import SolverFields
from hydrocrane.scenario.events import Burst, Goal
from hydrocrane.scenario.phases import LoopFields, Phase
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.scenario.series import Command, SupplyPressure
from hydrocrane.scenario.solver import Solver


def bundled_scenarios() -> tuple[str, ...]:
    """Names of the bundled scenarios.

    Examples
    --------
    >>> "vertical-lift-open-loop" in hc.bundled_scenarios()
    True
    """
    return tuple(_core.bundled_scenarios())


def load_scenario(source: str | PathLike[str], overrides: Overrides | None = None) -> Scenario:
    """Load a scenario by bundled name or path; `overrides` set keys of the scenario file itself.

    A path of a machine is relative to the scenario file.

    Examples
    --------
    >>> plan = hc.load_scenario("vertical-lift-open-loop")
    >>> print(plan.duration, plan.load_machine().name)
    5.0 rottne-f9-lab
    """
    with translated():
        raw = _core.load_scenario(str(source), list(plain_overrides(overrides or {}).items()))
    beside = Path(source).resolve().parent / raw["machine"]
    is_bundled = str(source) in _core.bundled_scenarios()
    machine = str(beside) if not is_bundled and beside.is_file() else raw["machine"]
    solver = cast(SolverFields, {key: value for key, value in raw["solver"].items() if value is not None})
    return Scenario(
        machine=machine,
        joints=dict(zip(raw["joints"], map(_Placed.at, raw["places"], raw["joints"].values()), strict=True)),
        commands={name: Command(**command) for name, command in raw["commands"].items()},
        supply=None if raw["supply"] is None else SupplyPressure(**raw["supply"]),
        duration=raw["duration"],
        record_interval=raw["record_interval"],
        pressures=raw["pressures"],
        payload=raw["payload"],
        payload_changes=dict(raw["payload_changes"]),
        overrides=dict(raw["overrides"]),
        solver=Solver(**solver),
        name=raw["name"],
        title=raw["title"],
        seed=raw["seed"],
        goals=tuple(Goal(time, x, z, speed, until) for time, (x, z), speed, until in raw["goals"]),
        sensor_faults=tuple(SensorFault(**fault) for fault in raw["sensor_faults"]),
        bursts=tuple(Burst(*burst) for burst in raw["bursts"]),
        phases=tuple(_phase(phase, raw["cylinders"]) for phase in raw["phases"]),
        recorded_by=raw["recorded_by"] or "",
        warnings=tuple(ResultWarning(*entry) for entry in raw["warnings"]),
        **_loop(raw["controller"], raw["joystick"], raw["cylinders"]),
    )


class _Placed(float):
    """A value of a file that keeps its place, for messages of what is checked later."""

    place: str

    @classmethod
    def at(cls, place: str, value: float) -> _Placed:
        placed = cls(value)
        placed.place = place
        return placed


def _phase(raw: PhaseTable, cylinders: list[str]) -> Phase:
    return Phase(raw["time"], dict(raw["overrides"]), **_loop(raw["controller"], raw["joystick"], cylinders))


def _loop(raw: ControllerTable | None, stick: JoystickTable | None, cylinders: list[str]) -> LoopFields:
    loop: LoopFields = {"joystick": _joystick(stick, cylinders)}
    if raw is not None:
        loop["controller"], loop["controller_model"] = raw["name"], dict(raw["controller_model"]) or None
        loop["period"], loop["delay"] = raw["period"], raw["delay"]
        loop["sensors"], loop["monitor"] = raw["sensors"], raw["monitor"]
    return loop


def _joystick(raw: JoystickTable | None, cylinders: list[str]) -> Joystick | None:
    if raw is None:
        return None
    about: StickFields = {
        "interpolation": raw["interpolation"],
        "dead_zone": raw["dead_zone"],
        "full_speed": raw["full_speed"],
        "ramp": raw["ramp"],
    }
    if raw["log"] is not None:
        return Joystick.from_log(raw["log"], mode=raw["mode"], **about)
    names = TIP_AXES[: len(raw["axes"])] if raw["mode"] == "tip" else cylinders
    about["precision"] = raw["precision"]
    return Joystick(raw["time"], dict(zip(names, raw["axes"], strict=True)), raw["mode"], **about)
