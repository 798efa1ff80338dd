"""MATLAB, and Octave: one function file."""

from __future__ import annotations

from hydrocrane._core_types import FunctionEntry
from hydrocrane.export.tape import ARITHMETIC, Language, Tape, calls, head, names

MATLAB = Language(
    {
        **ARITHMETIC,
        **calls("", root="sqrt", exp="exp", ln="log", sin="sin", cos="cos", tanh="tanh", magnitude="abs"),
        "positive": "pick({0} < 0, 0, {0})",
        "and": "{0} && {1}",
        "or": "{0} || {1}",
        "not": "~{0}",
        "select": "pick({0}, {1}, {2})",
        "place": "1 + sum(STARTS_{0} <= {1})",
        "entry": "COLUMN_{0}_{1}({2})",
    },
    infinity="Inf",
    nan="NaN",
)
_BODY = """\
if nargin == 0
    dx = struct( ...
{names});
    return
end
if nargin < 3 || isempty(p)
    c = [{kept}];
else
    c = prologue(p);
end
{derivatives}
if nargout > 2
    y = outputs(x, u, c);
end
end

function picked = pick(condition, first, second)
if condition
    picked = first;
else
    picked = second;
end
end
"""
_DERIVATIVES = """\
if nargout < 2
    dx = derivative(x, u, c);
else
    found = linearised(x, u, c);
    dx = found(1:{n});
    dfdx = full(sparse([{rows}], [{columns}], found({n} + 1:end), {n}, {n}));
end"""
_NONE = """\
dx = derivative(x, u, c);
if nargout > 1
    error('hydrocrane:derivatives', 'this file was exported without derivatives');
end"""
_ABOUT = """
dx = {name}(x, u) is the state derivative (column), [dx, dfdx] = {name}(x, u, p) with its derivatives by the
states, and [dx, dfdx, y] with the outputs. Without p the parameters have the values of the file. {name}() is a struct
of the names of states, inputs, parameters and outputs, and of these values."""


def matlab_text(tape: Tape, name: str) -> str:
    """The file of the function `name`."""
    about = _ABOUT.format(name=name).splitlines()
    lines = [f"function [dx, dfdx, y] = {name}(x, u, p)"]
    lines += [f"% {line}".rstrip() for line in [*about[1:], "", *head(tape)]]
    listed = {
        "states": names(tape.states),
        "inputs": names(tape.commands),
        "parameters": names(tape.parameters),
        "outputs": names(tape.outputs),
    }
    texts = [f"        '{key}', {{{{{_cells(items)}}}}}, ...\n" for key, items in listed.items()]
    numbers = {
        "n": len(tape.states),
        "rows": _column([row + 1 for row, _ in tape.places]),
        "columns": _column([column + 1 for _, column in tape.places]),
    }
    body = _BODY.format(
        names="".join(texts) + f"        'values', [{_column(tape.values)}]",
        kept=_column(tape.kept),
        derivatives=_DERIVATIVES.format(**numbers) if tape.places else _NONE,
    )
    counts = {"x": len(tape.states), "u": len(tape.commands), "c": len(tape.kept)}
    every = {"derivative": tape.derivative, "outputs": tape.output, "linearised": tape.linearise}
    functions = [_function("prologue", {"p": len(tape.parameters)}, tape, tape.prologue)]
    functions += [_function(own, counts, tape, every[own]) for own in every if tape.places or own != "linearised"]
    return "\n".join([*lines, body, *functions])


def _cells(items: list[str]) -> str:
    return "".join(f" ...\n        '{item}'" for item in items)


def _column(numbers: tuple[float, ...] | list[int]) -> str:
    return "".join(f"\n    {number!r}" for number in numbers)


def _function(name: str, given: dict[str, int], tape: Tape, function: FunctionEntry) -> str:
    lines = [f"function found = {name}({', '.join(given)})"]
    if any(operation == "place" for _, operation, _ in function[0]):
        for i, (starts, columns) in enumerate(tape.tables):
            lines.append(f"STARTS_{i} = [{_column(tuple(starts))}];")
            lines += [f"COLUMN_{i}_{k} = [{_column(tuple(own))}];" for k, own in enumerate(columns)]
    lines += [f"{letter}{i} = {letter}({i + 1});" for letter, count in given.items() for i in range(count)]
    lines += [f"{name} = {text};" for name, text in MATLAB.steps(function)]
    found = "".join(f"\n    {text}" for text in MATLAB.results(function))
    return "\n".join([*lines, f"found = [{found}];", "end\n"])
