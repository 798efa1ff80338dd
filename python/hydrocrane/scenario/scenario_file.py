"""Scenarios from files, and those that come with the package."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from hydrocrane import _core
from hydrocrane.control.joystick import TIP_AXES, Joystick
from hydrocrane.errors import translated
from hydrocrane.machine.overrides import plain_overrides
from hydrocrane.machine.sensors import SensorFault
from hydrocrane.scenario.command import Command
from hydrocrane.scenario.phases import Phase
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.scenario.solver import Solver


def bundled_scenarios() -> tuple[str, ...]:
    """Names of the scenarios that come with the package."""
    return tuple(_core.bundled_scenarios())


def load_scenario(source: str | PathLike[str], overrides: Mapping[str, Any] | None = None) -> Scenario:
    """Load a scenario by bundled name or path; `overrides` set keys of the scenario file itself.

    A machine named by a path is looked for beside the scenario file.
    """
    with translated():
        raw = _core.load_scenario(str(source), list(plain_overrides(overrides or {}).items()))
    beside = Path(source).resolve().parent / raw["machine"]
    is_bundled = str(source) in _core.bundled_scenarios()
    machine = str(beside) if not is_bundled and beside.is_file() else raw["machine"]
    solver = {key: value for key, value in raw["solver"].items() if value is not None}
    return Scenario(
        machine=machine,
        joints=dict(raw["joints"]),
        commands={name: Command(**command) for name, command in raw["commands"].items()},
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
        joystick=_joystick(raw["joystick"], raw["cylinders"]),
        sensor_faults=tuple(SensorFault(**fault) for fault in raw["sensor_faults"]),
        phases=tuple(_phase(phase, raw["cylinders"]) for phase in raw["phases"]),
        recorded_by=raw["recorded_by"] or "",
        **_loop(raw["controller"]),
    )


def _phase(raw: dict[str, Any], cylinders: list[str]) -> Phase:
    stick = _joystick(raw["joystick"], cylinders)
    return Phase(raw["time"], dict(raw["overrides"]), joystick=stick, **_loop(raw["controller"]))


def _loop(raw: dict[str, Any] | None) -> dict[str, Any]:
    if raw is None:
        return {}
    known = {key: raw[key] for key in ("period", "delay", "sensors", "monitor")}
    return {"controller": raw["name"], "believed": dict(raw["believed"]) or None, **known}


def _joystick(raw: dict[str, Any] | None, cylinders: list[str]) -> Joystick | None:
    if raw is None:
        return None
    about = {key: raw[key] for key in ("mode", "interpolation", "dead_zone", "full_speed", "ramp")}
    if raw["log"] is not None:
        return Joystick.from_log(raw["log"], **about)
    names = TIP_AXES if raw["mode"] == "tip" else cylinders
    return Joystick(raw["time"], dict(zip(names, raw["axes"], strict=True)), **about)
