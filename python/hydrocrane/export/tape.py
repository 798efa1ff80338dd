"""The right-hand side of a machine as a list of operations, from which writers make other languages."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version

from hydrocrane import _core
from hydrocrane._core_types import FunctionEntry, SignalEntry
from hydrocrane.errors import translated
from hydrocrane.machine.machine import Machine

# Outputs that are left out unless they are named: energies, one of which comes from a large table.
_ENERGY = "energy."
# Items on a line of a list.
_PER_LINE = 6


@dataclass(frozen=True)
class Tape:
    """A machine as functions of states `x`, spool commands `u` and parameters `p`.

    Names are ``x0``, ``u0``, ``p0`` for these, ``t0``, ``m0``, ``i0`` for numbers, truth values and places in tables
    that a function computes, and ``c0`` for what depends on parameters alone: the prologue's results, in the functions.
    """

    name: str
    title: str
    digest: str
    # Name, unit, meaning.
    states: tuple[SignalEntry, ...]
    commands: tuple[SignalEntry, ...]
    outputs: tuple[SignalEntry, ...]
    # Key, value, unit.
    parameters: tuple[tuple[str, float, str], ...]
    # Row and column of each derivative that `linearise` computes after the rates, column by column.
    places: tuple[tuple[int, int], ...]
    # Starts of the rows and columns.
    tables: tuple[tuple[list[float], list[list[float]]], ...]
    prologue: FunctionEntry
    # Its results for the values of the file.
    kept: tuple[float, ...]
    derivative: FunctionEntry
    linearise: FunctionEntry
    output: FunctionEntry

    @property
    def values(self) -> tuple[float, ...]:
        """The parameters' values in the file."""
        return tuple(value for _, value, _ in self.parameters)


def tape_of(machine: Machine, parameters: Sequence[str], outputs: Sequence[str] | None, derivatives: bool) -> Tape:
    """Trace a machine. `outputs`: names; default is all but energies.

    Raises
    ------
    InputError
        A key that can be no parameter, an output that is none, and friction that jumps.
    """
    core = machine.core
    wanted = [name for name, _, _ in core.output_info if not name.startswith(_ENERGY)] if outputs is None else outputs
    with translated():
        found = _core.tape(core, list(parameters), list(wanted), derivatives)
        text = core.to_toml()
    derivative, (steps, results), output = found["functions"]
    # By columns, as sparse matrices have them.
    order = sorted(range(len(found["places"])), key=lambda k: found["places"][k][::-1])
    rates, slopes = results[: len(core.state_names)], results[len(core.state_names) :]
    return Tape(
        name=machine.name,
        title=machine.title,
        digest=hashlib.sha256(text.encode()).hexdigest()[:16],
        states=tuple(zip(core.state_names, core.state_units, core.state_long_names, strict=True)),
        commands=tuple((f"cylinder.{c}.command", "m", f"{c}, positive extends") for c in core.cylinder_names),
        outputs=tuple(found["outputs"]),
        parameters=tuple(found["parameters"]),
        places=tuple((row, column) for row, column in (found["places"][k] for k in order)),
        tables=tuple(found["tables"]),
        prologue=found["prologue"],
        kept=tuple(found["kept"]),
        derivative=derivative,
        linearise=(steps, [*rates, *(slopes[k] for k in order)]),
        output=output,
    )


@dataclass(frozen=True)
class Language:
    """How a language writes the operations: a template each, with ``{0}``, ``{1}``, ``{2}`` for the operands."""

    operations: Mapping[str, str]
    infinity: str
    nan: str

    def spelt(self, operand: str) -> str:
        """A name, an index or a constant."""
        return {"inf": self.infinity, "-inf": f"-{self.infinity}", "NaN": self.nan}.get(operand, operand)

    def steps(self, function: FunctionEntry) -> Iterator[tuple[str, str]]:
        """Name and expression of each step."""
        for result, operation, operands in function[0]:
            yield result, self.operations[operation].format(*map(self.spelt, operands))

    def results(self, function: FunctionEntry) -> list[str]:
        return [self.spelt(result) for result in function[1]]


# What all languages write alike.
ARITHMETIC = {
    "add": "{0} + {1}",
    "subtract": "{0} - {1}",
    "multiply": "{0} * {1}",
    "divide": "{0} / {1}",
    "negate": "-{0}",
    "less": "{0} < {1}",
    "less_or_equal": "{0} <= {1}",
}


def calls(prefix: str, **names: str) -> dict[str, str]:
    """Templates of functions of one number, by the name of the operation."""
    return {operation: f"{prefix}{name}({{0}})" for operation, name in names.items()}


def head(tape: Tape) -> list[str]:
    """What stands at the head of every export: where it comes from, and each input and result with its unit."""
    lines = [
        f"{tape.name}: {tape.title}",
        f"Written by hydrocrane {version('hydrocrane')}; SHA-256 of the machine's text begins with {tape.digest}.",
        "hydrocrane claims no rights in this file: its licence is yours to choose.",
        "Units are SI and radians; pressures are gauge.",
    ]
    parameters = tuple((key, unit, f"{value!r} in the file") for key, value, unit in tape.parameters)
    for letter, what, signals in (
        ("x", "States", tape.states),
        ("u", "Spool commands", tape.commands),
        ("p", "Parameters, keys of the machine file", parameters),
        ("y", "Outputs", tape.outputs),
    ):
        lines += ["", f"{what}:" if signals else f"{what}: none"]
        lines += [f"  {letter}[{i}] {name} ({unit or '1'}): {text}" for i, (name, unit, text) in enumerate(signals)]
    return lines


def names(signals: Sequence[tuple[str, ...] | tuple[str, float, str]]) -> list[str]:
    """The first entries of signals or parameters."""
    return [str(signal[0]) for signal in signals]


def wrapped(items: Sequence[str], indent: str = "    ") -> str:
    """Items of a list, with commas between them, a few on each line."""
    rows = [", ".join(items[i : i + _PER_LINE]) for i in range(0, len(items), _PER_LINE)]
    return f",\n{indent}".join(rows)
