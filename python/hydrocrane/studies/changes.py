"""A scenario with other values of some keys."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np

from hydrocrane.errors import InputError
from hydrocrane.machine.keys import Key, put_value
from hydrocrane.machine.overrides import Override
from hydrocrane.scenario.changes import ScenarioFields
from hydrocrane.scenario.command import Command, read_commands
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.scenario.supply import read_supply
from hydrocrane.studies.key import COMMAND_FIELDS, COMMAND_LOG, FIELDS, JOYSTICK, SOLVER, SUPPLY_LOG, of_scenario
from hydrocrane.studies.values import si_numbers


def changed_plan(plan: Scenario, keys: Sequence[Key], values: Sequence[Override]) -> Scenario:
    """`plan` with `values` of the `keys`; they have priority over those of `plan`."""
    fields: ScenarioFields = {}
    machine: dict[str, Override] = {}
    for key, value in zip(keys, values, strict=True):
        if of_scenario(key):
            _change_scenario(fields, plan, key, value)
        else:
            put_value(machine, key, value)
    if machine:
        fields["overrides"] = machine
    return plan.changed(**fields) if fields else plan


def _change_scenario(fields: ScenarioFields, plan: Scenario, key: Key, value: Override) -> None:
    name = key.name
    if name in FIELDS:
        whole = name == "seed" and isinstance(value, float) and value.is_integer()
        stated: dict[str, Any] = {FIELDS[name][0]: int(cast(float, value)) if whole else value}
        fields.update(cast(ScenarioFields, stated))
    elif name == COMMAND_LOG:
        fields["commands"] = read_commands(str(value), plan.machine)
    elif name == SUPPLY_LOG:
        fields["supply"] = read_supply(str(value))
    elif name in SOLVER:
        solver = fields.get("solver", plan.solver)
        setting: dict[str, Any] = {SOLVER[name][0]: value}
        fields["solver"] = dataclasses.replace(solver, **setting)
    elif name in JOYSTICK:
        joystick = fields.get("joystick", plan.joystick)
        assert joystick is not None, "keys of the joystick are refused without one"
        held: dict[str, Any] = {JOYSTICK[name][0]: value}
        fields["joystick"] = dataclasses.replace(joystick, **held)
    else:
        _change_named(fields, plan, name, value)


def _change_named(fields: ScenarioFields, plan: Scenario, name: str, value: Override) -> None:
    first, second, *rest = name.split(".")
    if first == "command":
        commands = dict(cast("Mapping[str, Command]", fields.get("commands", _command_table(plan))))
        commands[second] = _command(commands.get(second), rest[0], si_numbers(value, COMMAND_FIELDS[rest[0]]))
        fields["commands"] = commands
    elif second == "model":
        before = cast("Mapping[str, Override]", fields.get("controller_model", plan.controller_model) or {})
        fields["controller_model"] = {**before, ".".join(rest): value}
    elif second == "joint":
        fields["joints"] = {**fields.get("joints", plan.joints), rest[0]: cast(float, value)}
    else:
        pressures = fields.get("pressures", plan.pressures)
        others = {} if isinstance(pressures, str) else pressures
        fields["pressures"] = {**others, rest[0]: cast("tuple[float, float]", si_numbers(value, "Pa"))}


def _command_table(plan: Scenario) -> Mapping[str, Command]:
    if not isinstance(plan.commands, Mapping):
        raise InputError("commands given as one table have no keys; give them by cylinder")
    return plan.commands


def _command(old: Command | None, field: str, value: Override) -> Command:
    """A command with one field replaced; a single spool value is constant."""
    if field == "spool" and np.ndim(value) == 0:
        return Command(np.array([0.0]), np.array([value]))
    if old is None:
        raise InputError(f"a cylinder without a command has no `{field}` to change")
    changed: dict[str, Any] = {field: value}
    return dataclasses.replace(old, **changed)
