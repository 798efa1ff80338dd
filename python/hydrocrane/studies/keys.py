"""Keys of a study: values of the machine or fields of the scenario, and a scenario with other values of them."""

from __future__ import annotations

import dataclasses
import difflib
import json
from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, MachineFileError, nearest
from hydrocrane.machine.keys import Key, distinct, machine_key, put_value
from hydrocrane.machine.machine import Machine
from hydrocrane.machine.overrides import Override
from hydrocrane.scenario.changes import ScenarioFields
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.scenario.series import Command, read_commands, read_supply
from hydrocrane.units import converted


def si_numbers(value: Override, unit: str | None) -> Override:
    """Numbers, or lists of them, in SI; words if there is no unit."""
    if unit is None:
        return value
    if isinstance(value, list | tuple):
        return [si_numbers(item, unit) for item in value]
    return converted("a value of a list", value, unit) if isinstance(value, str) else value


def axis_values(values: Sequence[Override]) -> Array | list[str] | list[bool]:
    """Values as a coordinate: numbers, switches or words; lists are written out."""
    if all(isinstance(value, float) for value in values):
        return np.array(values, dtype=np.float64)
    if all(isinstance(value, bool) for value in values):
        return [bool(value) for value in values]
    return [value if isinstance(value, str) else json.dumps(value) for value in values]


# Key of a scenario file -> field of a Scenario, SI unit; None if the value is a word or a switch.
FIELDS: dict[str, tuple[str, str | None]] = {
    "duration": ("duration", "s"),
    "record-interval": ("record_interval", "s"),
    "payload": ("payload", "kg"),
    "seed": ("seed", ""),
    "controller.name": ("controller", None),
    "controller.period": ("period", "s"),
    "controller.delay": ("delay", "s"),
    "controller.sensors": ("sensors", None),
    "controller.monitor": ("monitor", None),
}
SOLVER: dict[str, tuple[str, str | None]] = {
    "solver.method": ("method", None),
    "solver.rtol": ("rtol", ""),
    "solver.atol": ("atol", ""),
    "solver.max-step": ("max_step", "s"),
}
JOYSTICK: dict[str, tuple[str, str | None]] = {
    "joystick.full-speed": ("full_speed", "m/s"),
    "joystick.dead-zone": ("dead_zone", ""),
    "joystick.ramp": ("ramp", "s"),
    "joystick.interpolation": ("interpolation", None),
}
# A file with the commands of all cylinders.
COMMAND_LOG = "command.log"
# A file with the measured pressure of the supply.
SUPPLY_LOG = "supply.log"
PLAIN = FIELDS | SOLVER | JOYSTICK | {COMMAND_LOG: ("commands", None), SUPPLY_LOG: ("supply", None)}
# Tables that machine files have too.
BOTH = {"payload", "supply"}
# Tables of a scenario file whose keys hold names.
NAMED = ("initial.joint", "initial.pressure", "command", "controller.model")
_BEGINNINGS = tuple(f"{table}." for table in NAMED)
COMMAND_FIELDS: dict[str, str | None] = {"time": "s", "spool": "m", "interpolation": None}


def of_scenario(key: Key) -> bool:
    """Whether a key is one of the scenario, and not of its machine."""
    return key.name in PLAIN or key.name.startswith(_BEGINNINGS)


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


def resolved_key(name: str, values: Sequence[object], plan: Scenario, machine: Machine) -> Key:
    """The key `name` of a study of `plan` on `machine`, tried with some of its `values`.

    Raises
    ------
    InputError, MachineFileError
        If there is no such key (the message has the nearest one), or no value is valid.
    """
    name = name.removeprefix("scenario.")
    if name in PLAIN:
        if name in JOYSTICK and plan.joystick is None:
            raise InputError(f"key `{name}`: this scenario has no joystick")
        if name == COMMAND_LOG and plan.closed_loop:
            raise InputError(f"key `{name}`: this scenario has a controller in place of commands")
        if name.startswith("controller.") and name != "controller.name" and not plan.closed_loop:
            raise InputError(f"key `{name}`: this scenario has no controller")
        key = Key(name, PLAIN[name][1])
        if key.unit is None:
            # Tried here, because a misspelt word would fail in every case.
            for value in distinct(values):
                changed_plan(plan, [key], [value])
        return key
    for table in NAMED:
        if name.startswith(f"{table}."):
            return _named_key(table, name, values, plan, machine)
    if "." not in name or name.split(".")[0] in {known.split(".")[0] for known in (*PLAIN, *NAMED)} - BOTH:
        raise InputError(f"unknown key `{name}`{nearest(name, [*PLAIN, *_examples(plan, machine), *machine.keys])}")
    return _machine_key(name, values, plan)


def _examples(plan: Scenario, machine: Machine) -> list[str]:
    """Keys of a scenario that contain names."""
    joints = [f"initial.joint.{name}" for name in machine.joint_names]
    pressures = [f"initial.pressure.{name}" for name in machine.cylinder_names]
    commands = [f"command.{name}.{field}" for name in machine.cylinder_names for field in COMMAND_FIELDS]
    return joints + pressures + commands


def _named_key(table: str, name: str, values: Sequence[object], plan: Scenario, machine: Machine) -> Key:
    rest = name.removeprefix(f"{table}.")
    known = [key for key in _examples(plan, machine) if key.startswith(f"{table}.")]
    if table == "controller.model":
        if not plan.closed_loop:
            raise InputError(f"key `{name}`: this scenario has no controller, so no controller model")
        if not (plan.controller_model is None or isinstance(plan.controller_model, Mapping)):
            raise InputError(f"key `{name}`: the controller model is another machine here; state it as overrides")
        return dataclasses.replace(_machine_key(rest, values, plan), name=name)
    if name not in known:
        raise InputError(f"unknown key `{name}`{nearest(name, known)}")
    if table == "initial.joint":
        return Key(name, machine.joint_units[machine.joint_names.index(rest)])
    if table == "command" and plan.closed_loop:
        raise InputError(f"key `{name}`: this scenario has a controller in place of commands")
    return Key(name, None)


def _machine_key(name: str, values: Sequence[object], plan: Scenario) -> Key:
    try:
        return machine_key(name, values, plan.load_machine())
    except MachineFileError as error:
        raise _with_scenario_keys(error, name) from None


def _with_scenario_keys(error: MachineFileError, name: str) -> Exception:
    """The error, or a better one if a key of the scenario was meant."""
    if error.slug in ("unknown-key", "unknown-reference"):
        meant = difflib.get_close_matches(name, PLAIN, n=1, cutoff=0.75)
        if meant:
            return InputError(f"unknown key `{name}`; did you mean `{meant[0]}`?")
    return error
