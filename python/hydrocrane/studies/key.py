"""The keys that scenarios have."""

from __future__ import annotations

from hydrocrane.machine.keys import Key

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
