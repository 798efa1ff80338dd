"""The hydraulic circuit of a machine as its file states it: the supply, and a section for each cylinder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hydrocrane.machine.machine import Machine

# Tables of parts on a line between a valve and a chamber, in the order from the valve to the cylinder. Each names its
# `cylinder` and its `side`.
ON_LINES = (
    "line", "hose-leak", "hose-burst", "pilot-check", "counterbalance", "port-relief", "crossover-relief",
    "anti-cavitation",
)  # fmt: skip
SIDES = ("piston-side", "rod-side")
# Tables of the circuit, and tables without relation to it. All others are reported as left out.
READ = {"supply", "mains", "pump", "accumulator", "tank-line", "priority", "cylinder", "valve", *ON_LINES}
OTHERS = {
    "extends", "include", "without", "machine", "environment", "link", "joint", "friction", "fluid", "sensor",
    "payload", "equilibrium", "keep-out", "ground", "control", "errata",
}  # fmt: skip


@dataclass(frozen=True)
class CircuitTable:
    """A table of a machine file.

    Attributes
    ----------
    kind, name : str
        Of ``[kind.name]``; empty for a table without a name.
    numbers : mapping
        Key to value in SI, one number or several.
    words : mapping
        Key to name or choice.
    """

    kind: str
    name: str
    numbers: Mapping[str, tuple[float, ...]]
    words: Mapping[str, str]

    def number(self, key: str) -> float | None:
        """A number in SI; None if the file does not state it."""
        return self.numbers[key][0] if key in self.numbers else None

    def word(self, key: str, default: str = "") -> str:
        return self.words.get(key, default)

    @property
    def is_stated(self) -> bool:
        return bool(self.numbers or self.words)


@dataclass(frozen=True)
class CircuitSection:
    """A cylinder with its valve.

    Attributes
    ----------
    cylinder, motor, valve : CircuitTable
        The motor is stated where one stands in the place of the piston.
    stroke : float
        Stroke of the piston, m.
    on_lines : tuple of (side, CircuitTable)
        Parts on the lines of the piston side (0) and of the rod side (1), from the valve to the cylinder.
    priority : CircuitTable
        ``[priority]`` of the machine.
    """

    cylinder: CircuitTable
    motor: CircuitTable
    valve: CircuitTable
    stroke: float
    on_lines: tuple[tuple[int, CircuitTable], ...]
    priority: CircuitTable

    @property
    def is_served_first(self) -> bool:
        return self.priority.word("cylinder") == self.cylinder.name

    @property
    def gives_way(self) -> bool:
        """Whether another section is served before this one."""
        return self.priority.is_stated and not self.is_served_first

    @property
    def compensator(self) -> str:
        """``none``, ``before-spool`` or ``behind-spool``."""
        return self.valve.word("compensator", "none")

    @property
    def has_load_check(self) -> bool:
        """Whether there is a load check valve; a compensated section always has one."""
        return self.compensator != "none" or self.valve.word("load-check") == "yes"


@dataclass(frozen=True)
class Circuit:
    """The hydraulic circuit of a machine.

    Attributes
    ----------
    supply, mains : CircuitTable
        ``[supply]`` and ``[mains]``.
    pump : CircuitTable or None
        None if the supply pressure is constant or measured.
    further : tuple of CircuitTable
        Pumps beside it.
    relief_pressure : float or None
        Of the main relief valve, Pa, also if the file does not state it; None without a pump.
    accumulator : CircuitTable or None
        Gas on the mains.
    tank_line, return_filter : CircuitTable
        ``[tank-line]`` and ``[tank-line.filter]``.
    sections : tuple of CircuitSection
    left_out : tuple of str
        Tables of the file that are not included.
    """

    supply: CircuitTable
    mains: CircuitTable
    pump: CircuitTable | None
    further: tuple[CircuitTable, ...]
    relief_pressure: float | None
    accumulator: CircuitTable | None
    tank_line: CircuitTable
    return_filter: CircuitTable
    sections: tuple[CircuitSection, ...]
    left_out: tuple[str, ...] = ()

    @property
    def senses_load(self) -> bool:
        """Whether the pump is controlled by the highest load pressure."""
        return self.pump is not None and self.pump.number("ls-margin") is not None

    @property
    def shares_flow(self) -> bool:
        """Whether compensators behind the spool have the highest load pressure of all sections."""
        return any(section.compensator == "behind-spool" for section in self.sections)


def read(machine: Machine) -> Circuit:
    """The circuit in a machine file."""
    pumps = [pump for pump in named(machine, "pump") if pump.word("type") != "constant-pressure"]
    relief = machine.core.relief_pressure
    strokes = np.diff(machine.stroke_limits, axis=1)[:, 0].tolist()
    sections = (_section(machine, c, stroke) for c, stroke in zip(machine.cylinder_names, strokes, strict=True))
    return Circuit(
        table(machine, "supply"),
        table(machine, "mains"),
        pumps[0] if pumps and relief is not None else None,
        tuple(pumps[1:]),
        relief,
        next(iter(named(machine, "accumulator")), None),
        table(machine, "tank-line"),
        table(machine, "tank-line", "filter"),
        tuple(sections),
        tuple(sorted({key.split(".")[0] for key in (*machine.words, *machine.keys)} - READ - OTHERS)),
    )


def table(machine: Machine, kind: str, name: str = "") -> CircuitTable:
    """The table ``[kind.name]``, or ``[kind]``, without its sub-tables; empty if the file has none."""
    head = f"{kind}.{name}." if name else f"{kind}."

    def inside(key: str) -> bool:
        return key.startswith(head) and "." not in key[len(head) :]

    numbers = {key[len(head) :]: tuple(np.atleast_1d(machine.value(key).si)) for key in machine.keys if inside(key)}
    words = {key[len(head) :]: word for key, word in machine.words.items() if inside(key)}
    return CircuitTable(kind, name, numbers, words)


def named(machine: Machine, kind: str) -> list[CircuitTable]:
    """The tables ``[kind.<name>]``."""
    keys = [key.split(".") for key in (*machine.words, *machine.keys) if key.startswith(f"{kind}.")]
    return [table(machine, kind, name) for name in dict.fromkeys(parts[1] for parts in keys if len(parts) > 2)]


def _section(machine: Machine, cylinder: str, stroke: float) -> CircuitSection:
    valve = next(valve for valve in named(machine, "valve") if valve.word("cylinder") == cylinder)
    found = [part for kind in ON_LINES for part in named(machine, kind) if part.word("cylinder") == cylinder]
    on_lines = tuple((SIDES.index(part.word("side")), part) for part in found)
    piston, motor = table(machine, "cylinder", cylinder), table(machine, "cylinder", f"{cylinder}.motor")
    return CircuitSection(piston, motor, valve, stroke, on_lines, table(machine, "priority"))
