"""Resolves a dotted key of a study: a value of the machine, or a field of the scenario."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Mapping, Sequence
from typing import cast

import numpy as np

from hydrocrane.errors import InputError, MachineFileError, nearest, translated
from hydrocrane.machine.machine import Machine
from hydrocrane.machine.overrides import Override, plain_overrides
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.studies.changes import changed_plan
from hydrocrane.studies.key import BOTH, COMMAND_FIELDS, COMMAND_LOG, JOYSTICK, NAMED, PLAIN, Key

# Errors of a value that do not concern its key and unit; a case of a study may have them.
OF_THE_VALUE = ("out-of-range", "not-finite", "crossed-limits", "cannot-close", "cannot-build")
# Number of values with which a key is tried.
MOST_TRIED = 200


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
            for value in _distinct(values):
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
    """A key of the machine file, resolved by building the machine with its values.

    For numbers one valid value is sufficient; each word is tried.
    """
    base = plan.load_machine()
    if name.endswith("]") and "[" in name:
        return _element_key(name, base)
    found, failure = None, None
    for value in _distinct(values):
        if found is not None and (found.unit is not None or not isinstance(value, str)):
            continue
        try:
            with translated():
                made = base.core.rebuilt([*plan.machine_overrides.items(), (name, value)])
        except MachineFileError as error:
            if error.slug not in OF_THE_VALUE:
                raise _with_scenario_keys(error, name) from None
            failure = error
            continue
        found = _as_stated(name, Machine(made, base.source, {}))
    if found is None and name in base.keys:
        return _as_stated(name, base)
    if found is None:
        raise failure or InputError(f"key `{name}` has no values")
    return found


def _distinct(values: Sequence[object]) -> list[Override]:
    """Each value once, in the form of overrides."""
    plain = [plain_overrides({"value": cast(Override, value)})["value"] for value in values[:MOST_TRIED]]
    return list({repr(value): value for value in plain}.values())


def _as_stated(name: str, machine: Machine) -> Key:
    if name not in machine.keys:
        return Key(name, None)
    value = machine.value(name)
    return Key(name, value.unit if np.ndim(value.si) == 0 else None)


def _element_key(name: str, base: Machine) -> Key:
    key, _, rest = name.removesuffix("]").partition("[")
    value = base.value(key)
    whole = np.atleast_1d(value.si)
    if not rest.isdigit() or int(rest) >= whole.size:
        raise InputError(f"key `{name}`: {key} has the values [0] to [{whole.size - 1}]")
    return Key(name, value.unit, tuple(map(float, whole)))


def _with_scenario_keys(error: MachineFileError, name: str) -> Exception:
    """The error, or a better one if a key of the scenario was meant."""
    if error.slug in ("unknown-key", "unknown-reference"):
        meant = difflib.get_close_matches(name, PLAIN, n=1, cutoff=0.75)
        if meant:
            return InputError(f"unknown key `{name}`; did you mean `{meant[0]}`?")
    return error
