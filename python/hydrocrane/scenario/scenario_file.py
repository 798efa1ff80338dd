"""Scenarios from files, and the bundled ones."""

from __future__ import annotations

import math
from os import PathLike
from pathlib import Path

from hydrocrane import _core
from hydrocrane._core_types import ControllerEntry, JoystickEntry
from hydrocrane.control.joystick import Joystick, StickFields
from hydrocrane.errors import translated
from hydrocrane.machine.overrides import Overrides, plain_overrides
from hydrocrane.machine.sensors import SensorFault
from hydrocrane.result_warning import ResultWarning
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
        names, warnings, raw = _core.load_scenario(str(source), list(plain_overrides(overrides or {}).items()))
    name, title, machine, recorded_by = names
    beside = Path(source).resolve().parent / machine
    is_bundled = str(source) in _core.bundled_scenarios()
    pressures = raw["pressures"]
    return Scenario(
        machine=str(beside) if not is_bundled and beside.is_file() else machine,
        joints={joint: _Placed.at(place, q) for place, (joint, q) in zip(raw["places"], raw["joints"], strict=True)},
        commands={of: Command(time, spool, _how(linear)) for of, time, spool, linear in raw["commands"]},
        supply=None if raw["supply"] is None else SupplyPressure(*raw["supply"][:2], _how(raw["supply"][2])),
        duration=raw["duration"],
        record_interval=raw["record_interval"],
        pressures="equilibrium" if pressures is None else {of: (p1, p2) for of, (p1, p2) in pressures},
        payload=raw["payload"],
        payload_changes=dict(raw["payload_changes"]),
        overrides=dict(raw["overrides"]),
        solver=Solver(**raw["solver"]),
        name=name,
        title=title,
        seed=raw["seed"],
        goals=tuple(Goal(time, x, z, speed, until) for time, (x, z), speed, until in raw["goals"]),
        sensor_faults=tuple(
            SensorFault(signal, kind, time, size, None if until == math.inf else until)
            for signal, kind, time, until, size in raw["sensor_faults"]
        ),
        bursts=tuple(Burst(*burst) for burst in raw["bursts"]),
        phases=tuple(
            Phase(phase["time"], dict(phase["overrides"]), **_loop(phase["controller"], phase["joystick"]))
            for phase in raw["phases"]
        ),
        recorded_by=recorded_by,
        warnings=tuple(ResultWarning(*entry) for entry in warnings),
        **_loop(raw["controller"], raw["joystick"]),
    )


def _how(linear: bool) -> str:
    return "linear" if linear else "hold"


class _Placed(float):
    """A value of a file that keeps its place, for messages of what is checked later."""

    place: str

    @classmethod
    def at(cls, place: str, value: float) -> _Placed:
        placed = cls(value)
        placed.place = place
        return placed


def _loop(raw: ControllerEntry | None, stick: JoystickEntry | None) -> LoopFields:
    loop: LoopFields = {"joystick": _joystick(stick)}
    if raw is not None:
        loop["controller"], loop["controller_model"] = raw["name"], dict(raw["controller_model"]) or None
        loop["period"], loop["delay"] = raw["period"], raw["delay"]
        loop["sensors"], loop["monitor"] = raw["sensors"], raw["monitor"]
    return loop


def _joystick(raw: JoystickEntry | None) -> Joystick | None:
    if raw is None:
        return None
    about: StickFields = {
        "interpolation": _how(raw["linear"]),
        "dead_zone": raw["dead_zone"],
        "full_speed": raw["full_speed"],
        "ramp": raw["ramp"],
    }
    if raw["log"] is not None:
        return Joystick.from_log(raw["log"], mode=raw["mode"], **about)
    about["precision"] = raw["precision"]
    return Joystick(raw["time"], dict(raw["axes"]), raw["mode"], **about)
