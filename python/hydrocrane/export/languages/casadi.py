"""CasADi: a file of Python that builds `casadi.Function` objects without hydrocrane."""

from __future__ import annotations

from hydrocrane._core_types import FunctionEntry
from hydrocrane.export.languages.arrays import python_head
from hydrocrane.export.tape import ARITHMETIC, Language, Tape, calls

CASADI = Language(
    {
        **ARITHMETIC,
        **calls("ca.", root="sqrt", exp="exp", ln="log", sin="sin", cos="cos", tanh="tanh"),
        # With the slope 1 at zero.
        "magnitude": "ca.if_else({0} < 0.0, -{0}, {0})",
        # With the slope 1/2 at zero.
        "positive": "ca.if_else(0.0 < {0}, {0}, ca.if_else({0} < 0.0, 0.0, 0.5 * {0}))",
        "and": "ca.logic_and({0}, {1})",
        "or": "ca.logic_or({0}, {1})",
        "not": "ca.logic_not({0})",
        "select": "ca.if_else({0}, {1}, {2})",
        "place": "_place(STARTS_{0}, {1})",
        "entry": "_entry(COLUMN_{0}_{1}, {2})",
    },
    infinity="ca.inf",
    nan="ca.nan",
)
_ABOUT = """
    derivative(x, u, p) -> dx       casadi.Function: the state derivative
    linearise(x, u, p) -> dx, dfdx  the same, and its derivatives by the states, sparse
    outputs(x, u, p) -> y           what OUTPUTS names

p is empty without parameters; VALUES are those of the file."""
_TABLES = """

def _place(starts, x):
    return sum(start <= x for start in starts)


def _entry(column, place):
    found = ca.SX(column[0])
    for i, value in enumerate(column[1:], start=1):
        found = ca.if_else(place < i, found, value)
    return found
"""


def casadi_text(tape: Tape) -> str:
    """The file."""
    counts = {"x": len(tape.states), "u": len(tape.commands), "p": len(tape.parameters)}
    lines = [f'{letter} = ca.SX.sym("{letter}", {count})' for letter, count in counts.items()]
    functions = {"derivative": tape.derivative, "outputs": tape.output}
    for name, function in functions.items():
        lines += ["", "", f"def _{name}(x, u, p):", *_steps(tape, function)]
        found = ",\n        ".join(CASADI.results(function))
        lines += [f"    return ca.vertcat(\n        {found}\n    )" if found else "    return ca.SX(0, 1)"]
    lines += ["", ""]
    given = '[x, u, p], [{0}], ["x", "u", "p"]'
    for name, result in (("derivative", "dx"), ("outputs", "y")):
        lines.append(f'{name} = ca.Function("{name}", {given.format(f"_{name}(x, u, p)")}, ["{result}"])')
    if tape.places:
        lines += [
            "_dx = _derivative(x, u, p)",
            f'linearise = ca.Function("linearise", {given.format("_dx, ca.jacobian(_dx, x)")}, ["dx", "dfdx"])',
        ]
    tables = _TABLES + "\n\n" if tape.tables else ""
    return python_head(tape, _ABOUT, "import casadi as ca") + tables + "\n".join(lines) + "\n"


def _steps(tape: Tape, function: FunctionEntry) -> list[str]:
    """The prologue and a function as statements over the symbols."""
    lines = []
    for letter, signals in (("x", tape.states), ("u", tape.commands), ("p", tape.parameters)):
        lines += [f"    {letter}{i} = {letter}[{i}]" for i in range(len(signals))]
    # Both count their steps from zero.
    lines += [f"    {name} = {text}" for name, text in CASADI.steps(tape.prologue)]
    lines += [f"    c{i} = {text}" for i, text in enumerate(CASADI.results(tape.prologue))]
    return lines + [f"    {name} = {text}" for name, text in CASADI.steps(function)]
