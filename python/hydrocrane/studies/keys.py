"""Resolves a dotted key of a study: a value of the machine, or a field of the scenario."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Mapping, Sequence

from hydrocrane.errors import InputError, MachineFileError, nearest
from hydrocrane.machine.keys import Key, distinct, machine_key
from hydrocrane.machine.machine import Machine
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.studies.changes import changed_plan
from hydrocrane.studies.key import BOTH, COMMAND_FIELDS, COMMAND_LOG, JOYSTICK, NAMED, PLAIN


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
