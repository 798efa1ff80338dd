"""A scenario with values of some keys in place of its own."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hydrocrane.errors import InputError
from hydrocrane.scenario.command import Command
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.studies.key import COMMAND_FIELDS, FIELDS, JOYSTICK, SOLVER, Key
from hydrocrane.studies.values import si_numbers


def changed_plan(plan: Scenario, keys: Sequence[Key], values: Sequence[Any]) -> Scenario:
    """`plan` with `values` of the `keys` in place of its own; a key counts before what `plan` states."""
    fields: dict[str, Any] = {}
    machine: dict[str, Any] = {}
    for key, value in zip(keys, values, strict=True):
        if key.of_scenario:
            _change_scenario(fields, plan, key, value)
        else:
            _change_machine(machine, key, value)
    if machine:
        fields["overrides"] = machine
    return plan.changed(**fields) if fields else plan


def _change_machine(overrides: dict[str, Any], key: Key, value: Any) -> None:
    if key.whole is None:
        overrides[key.name] = value
        return
    name, _, index = key.name.removesuffix("]").partition("[")
    whole = list(overrides.get(name, key.whole))
    whole[int(index)] = value
    overrides[name] = whole if len(whole) > 1 else whole[0]


def _change_scenario(fields: dict[str, Any], plan: Scenario, key: Key, value: Any) -> None:
    name = key.name
    if name in FIELDS:
        whole = name == "seed" and isinstance(value, float) and value.is_integer()
        fields[FIELDS[name][0]] = int(value) if whole else value
    elif name in SOLVER:
        solver = fields.get("solver", plan.solver)
        fields["solver"] = dataclasses.replace(solver, **{SOLVER[name][0]: value})
    elif name in JOYSTICK:
        joystick: Any = fields.get("joystick", plan.joystick)
        fields["joystick"] = dataclasses.replace(joystick, **{JOYSTICK[name][0]: value})
    else:
        _change_named(fields, plan, name, value)


def _change_named(fields: dict[str, Any], plan: Scenario, name: str, value: Any) -> None:
    first, second, *rest = name.split(".")
    if first == "command":
        commands = dict(fields.get("commands", _command_table(plan)))
        commands[second] = _command(commands.get(second), rest[0], si_numbers(value, COMMAND_FIELDS[rest[0]]))
        fields["commands"] = commands
    elif second == "believed":
        fields["believed"] = {**(fields.get("believed", plan.believed) or {}), ".".join(rest): value}
    elif second == "joint":
        fields["joints"] = {**fields.get("joints", plan.joints), rest[0]: value}
    else:
        stated = fields.get("pressures", plan.pressures)
        others = {} if isinstance(stated, str) else stated
        fields["pressures"] = {**others, rest[0]: si_numbers(value, "Pa")}


def _command_table(plan: Scenario) -> Mapping[str, Any]:
    if not isinstance(plan.commands, Mapping):
        raise InputError("commands given as one table have no keys; give them by cylinder")
    return plan.commands


def _command(old: Any, field: str, value: Any) -> Command:
    """A command with one field replaced; a single spool value holds throughout."""
    if field == "spool" and np.ndim(value) == 0:
        return Command(np.array([0.0]), np.array([value]))
    if old is None:
        raise InputError(f"a cylinder without a command has no `{field}` to change")
    return dataclasses.replace(old, **{field: value})
