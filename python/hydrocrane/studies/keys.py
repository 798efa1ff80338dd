"""What a dotted key of a study means: a value of the machine, or a field of the scenario."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from hydrocrane import _core
from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, MachineFileError, nearest, translated
from hydrocrane.machine import Machine
from hydrocrane.scenario import Command, Scenario

# Key of a scenario file -> field of a Scenario, SI unit; None where the value is a word or a switch.
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
PLAIN = FIELDS | SOLVER | JOYSTICK
# Tables of a scenario file whose keys hold names.
NAMED = ("initial.joint", "initial.pressure", "command", "controller.believed")
COMMAND_FIELDS: dict[str, str | None] = {"time": "s", "spool": "m", "interpolation": None}
# A machine key -> field of the scenario that would hide it.
HIDING = {"payload.mass": "payload", "control.period": "period"}
# Mistakes of a value that leave its key and unit beyond doubt: a case of a study may have them.
OF_THE_VALUE = ("out-of-range", "not-finite", "crossed-limits", "cannot-close", "cannot-build")


@dataclass(frozen=True)
class Key:
    """A dotted key.

    Attributes
    ----------
    name : str
        As it was given.
    unit : str or None
        SI unit, empty for a plain number; None for words, switches and lists.
    whole : tuple of float or None
        Where `name` means one value of a list, ``friction.lift.coulomb[0]``, the whole list, SI.
    """

    name: str
    unit: str | None
    whole: tuple[float, ...] | None = None

    @property
    def of_scenario(self) -> bool:
        return self.name in PLAIN or self.name.startswith(tuple(f"{table}." for table in NAMED))


def resolved_key(name: str, values: Sequence[Any], plan: Scenario, crane: Machine) -> Key:
    """The key `name` of a study of `plan` on `crane`, tried out with some of its `values`.

    Raises
    ------
    InputError, MachineFileError
        Where there is no such key, with the nearest one; where no value fits it.
    """
    name = name.removeprefix("scenario.")
    if name in PLAIN:
        if name in JOYSTICK and plan.joystick is None:
            raise InputError(f"key `{name}`: this scenario has no joystick")
        return Key(name, PLAIN[name][1])
    for table in NAMED:
        if name.startswith(f"{table}."):
            return _named_key(table, name, values, plan, crane)
    if "." not in name or name.split(".")[0] in {known.split(".")[0] for known in (*PLAIN, *NAMED)} - {"payload"}:
        raise InputError(f"unknown key `{name}`{nearest(name, [*PLAIN, *_examples(plan, crane), *crane.keys])}")
    return _machine_key(name, values, plan)


def _examples(plan: Scenario, crane: Machine) -> list[str]:
    """Keys of a scenario that hold names."""
    joints = [f"initial.joint.{name}" for name in crane.joint_names]
    pressures = [f"initial.pressure.{name}" for name in crane.cylinder_names]
    commands = [f"command.{name}.{field}" for name in crane.cylinder_names for field in COMMAND_FIELDS]
    return joints + pressures + commands


def _named_key(table: str, name: str, values: Sequence[Any], plan: Scenario, crane: Machine) -> Key:
    rest = name.removeprefix(f"{table}.")
    known = [key for key in _examples(plan, crane) if key.startswith(f"{table}.")]
    if table == "controller.believed":
        if not plan.closed_loop:
            raise InputError(f"key `{name}`: this scenario has no controller that could believe something")
        if not (plan.believed is None or isinstance(plan.believed, Mapping)):
            raise InputError(f"key `{name}`: what the controller believes is a machine here; give it as overrides")
        return dataclasses.replace(_machine_key(rest, values, plan), name=name)
    if name not in known:
        raise InputError(f"unknown key `{name}`{nearest(name, known)}")
    if table == "initial.joint":
        return Key(name, crane.joint_units[crane.joint_names.index(rest)])
    if table == "command" and plan.closed_loop:
        raise InputError(f"key `{name}`: this scenario has a controller in place of commands")
    return Key(name, None)


def _machine_key(name: str, values: Sequence[Any], plan: Scenario) -> Key:
    """A key of the machine file; the machine is built with the first values until one tells the unit."""
    base = plan.load_machine()
    if name.endswith("]") and "[" in name:
        return _element_key(name, base)
    failure: MachineFileError | None = None
    for value in values:
        try:
            with translated():
                made = _core.load_machine(plan.machine, [*plan.machine_overrides.items(), (name, value)])
        except MachineFileError as error:
            if error.slug not in OF_THE_VALUE:
                raise _with_scenario_keys(error, name) from None
            failure = failure or error
            continue
        return _as_stated(name, Machine(made, base.source, {}))
    if name in base.keys:
        return _as_stated(name, base)
    raise failure or InputError(f"key `{name}` has no values")


def _as_stated(name: str, crane: Machine) -> Key:
    if name not in crane.keys:
        return Key(name, None)
    value = crane.value(name)
    return Key(name, value.unit if np.ndim(value.si) == 0 else None)


def _element_key(name: str, base: Machine) -> Key:
    key, _, rest = name.removesuffix("]").partition("[")
    value = base.value(key)
    whole = np.atleast_1d(value.si)
    if not rest.isdigit() or int(rest) >= whole.size:
        raise InputError(f"key `{name}`: {key} has the values [0] to [{whole.size - 1}]")
    return Key(name, value.unit, tuple(map(float, whole)))


def _with_scenario_keys(error: MachineFileError, name: str) -> Exception:
    """The error, or a better one where a key of the scenario was meant."""
    if error.slug in ("unknown-key", "unknown-reference"):
        import difflib

        meant = difflib.get_close_matches(name, PLAIN, n=1, cutoff=0.75)
        if meant:
            return InputError(f"unknown key `{name}`; did you mean `{meant[0]}`?")
    return error


def si_value(key: Key, value: Any) -> Any:
    """`value` in SI where the key has a unit: a number as it is, a text with its unit converted; else as it is."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, list | tuple | np.ndarray):
        return [si_value(key, item) for item in value] if key.unit is None else _not_one_number(key, value)
    if isinstance(value, bool):
        return value if key.unit is None else _not_one_number(key, value)
    if isinstance(value, int | float):
        return float(value)
    if not isinstance(value, str):
        return _not_one_number(key, value)
    return value if key.unit is None else converted(key.name, value, key.unit)


def _not_one_number(key: Key, value: Any) -> Any:
    raise InputError(f"a value of `{key.name}` must be one number (SI) or a text with its unit; got {value!r}")


def converted(what: str, text: str, unit: str) -> float:
    """A text with its unit in SI; `unit` is the SI unit that it must have the dimension of."""
    try:
        number, dimension = _core.quantity(text)
    except ValueError as error:
        raise InputError(f"`{what}`: {error}") from None
    if dimension != _dimension(unit):
        raise InputError(f"`{what}` is in {unit or 'plain numbers'}; `{text}` is another quantity")
    return float(number)


@cache
def _dimension(unit: str) -> str:
    return str(_core.quantity(f"1 {unit}".strip())[1])


def changed_plan(plan: Scenario, keys: Sequence[Key], values: Sequence[Any]) -> Scenario:
    """`plan` with `values` of the `keys` in place of its own."""
    fields: dict[str, Any] = {}
    machine: dict[str, Any] = {}
    for key, value in zip(keys, values, strict=True):
        if key.of_scenario:
            _change_scenario(fields, plan, key, value)
        else:
            _change_machine(machine, key, value)
            _uncover(fields, plan, key)
    if machine:
        fields["overrides"] = {**plan.overrides, **machine}
    return dataclasses.replace(plan, **fields) if fields else plan


def _change_machine(overrides: dict[str, Any], key: Key, value: Any) -> None:
    if key.whole is None:
        overrides[key.name] = value
        return
    name, _, index = key.name.removesuffix("]").partition("[")
    whole = list(overrides.get(name, key.whole))
    whole[int(index)] = value
    overrides[name] = whole if len(whole) > 1 else whole[0]


def _uncover(fields: dict[str, Any], plan: Scenario, key: Key) -> None:
    """A swept key of the machine counts, also where a field of the scenario would take its place."""
    if key.name in HIDING:
        fields[HIDING[key.name]] = None
    elif key.name.startswith("control.") and key.name.endswith(".full-speed") and plan.joystick is not None:
        joystick: Any = fields.get("joystick", plan.joystick)
        fields["joystick"] = dataclasses.replace(joystick, full_speed=None)


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
        commands[second] = _command(commands.get(second), rest[0], _numbers(value, COMMAND_FIELDS[rest[0]]))
        fields["commands"] = commands
    elif second == "believed":
        fields["believed"] = {**(fields.get("believed", plan.believed) or {}), ".".join(rest): value}
    elif second == "joint":
        fields["joints"] = {**fields.get("joints", plan.joints), rest[0]: value}
    else:
        stated = fields.get("pressures", plan.pressures)
        others = {} if isinstance(stated, str) else stated
        fields["pressures"] = {**others, rest[0]: _numbers(value, "Pa")}


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


def _numbers(value: Any, unit: str | None) -> Any:
    if unit is None:
        return value
    if isinstance(value, list | tuple):
        return [_numbers(item, unit) for item in value]
    return converted("a value of a list", value, unit) if isinstance(value, str) else value


def axis_values(values: Sequence[Any]) -> Array | list[str] | list[bool]:
    """Values as a coordinate: numbers, switches or words; lists are written out."""
    import json

    if all(isinstance(value, float) for value in values):
        return np.array(values, dtype=np.float64)
    if all(isinstance(value, bool) for value in values):
        return list(values)
    return [value if isinstance(value, str) else json.dumps(value) for value in values]
