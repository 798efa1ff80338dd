"""Which value counts where a scenario and the overrides of its machine state the same.

What is given later counts: a call or the command line before the scenario, the scenario before its machine. Two
different values given at once are an error. The payload, a named controller's period, and its speed at full stick have
two such places: a field of the scenario, and a key of the machine.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Protocol

from hydrocrane import _core
from hydrocrane.control.controllers import AnyController
from hydrocrane.control.joystick import Joystick
from hydrocrane.errors import InputError
from hydrocrane.machine.overrides import Override
from hydrocrane.scenario.changes import ScenarioFields

# Machine key -> field of a scenario that states the same, and its SI unit.
SHARED = {"payload.mass": ("payload", "kg"), "control.period": ("period", "s")}


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


def full_speed_key(driver: AnyController | None) -> str | None:
    """Machine key of the speed that a joystick's `full_speed` states, of controllers that have one."""
    return f"control.{driver}.full-speed" if isinstance(driver, str) and driver != "lever" else None


def stated_fields(plan: Statements) -> dict[str, tuple[str, float, str]]:
    """Machine key to field, value and unit of what the fields of a scenario state in the machine's place."""
    named = isinstance(plan.driver, str)
    stated = {
        key: (field, float(getattr(plan, field)), unit)
        for key, (field, unit) in SHARED.items()
        if getattr(plan, field) is not None and (field != "period" or named)
    }
    key = full_speed_key(plan.driver)
    if key is not None and plan.joystick is not None and plan.joystick.full_speed is not None:
        stated[key] = ("joystick.full_speed", float(plan.joystick.full_speed), "m/s")
    return stated


def check_agreement(plan: Statements, overrides: Mapping[str, Override]) -> None:
    """An error where a field of the scenario and one of `overrides` state different values."""
    for key, (field, value, unit) in stated_fields(plan).items():
        check_equal(field, value, unit, key, overrides)


def check_equal(field: str, value: float | str | None, unit: str, key: str, overrides: Mapping[str, Override]) -> None:
    """An error where `value` (SI, or a text with its unit) of `field` and the override of `key` differ."""
    if value is None or key not in overrides:
        return
    numbers = [_si(value), _si(overrides[key])]
    # What is no quantity at all is an error of the machine's own check, with its place.
    if numbers[0] is None or numbers[1] is None or math.isclose(numbers[0], numbers[1], rel_tol=1e-12):
        return
    said, given = (each if isinstance(each, str) else f"{each:g} {unit}" for each in (value, overrides[key]))
    raise InputError(f"`{field}` is {said}, and the override `{key}` is {given}: both state the same; leave one out")


def _si(value: Override) -> float | None:
    if isinstance(value, str):
        try:
            return _core.quantity(value)[0]
        except ValueError:
            return None
    return float(value) if isinstance(value, float | int) else None


def later_counts(plan: Statements, changes: ScenarioFields) -> ScenarioFields:
    """`changes` of the fields of `plan`, with whatever they take the place of taken out of the fields and overrides."""
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
