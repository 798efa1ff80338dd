"""Python over arrays: NumPy, vectorised over leading axes, and JAX, pure functions."""

from __future__ import annotations

from hydrocrane._core_types import FunctionEntry
from hydrocrane.export.tape import ARITHMETIC, Language, Tape, calls, head, wrapped

ARRAYS = Language(
    {
        **ARITHMETIC,
        **calls("np.", root="sqrt", exp="exp", ln="log", sin="sin", cos="cos", tanh="tanh"),
        # With the slope 1 at zero.
        "magnitude": "np.where({0} < 0.0, -{0}, {0})",
        # In JAX with the slope 1/2 at zero.
        "positive": "np.maximum({0}, 0.0)",
        "and": "{0} & {1}",
        "or": "{0} | {1}",
        "not": "~{0}",
        "select": "np.where({0}, {1}, {2})",
        "place": 'np.searchsorted(np.array(STARTS_{0}), {1}, side="right")',
        "entry": "np.array(COLUMN_{0}_{1})[{2}]",
    },
    infinity="np.inf",
    nan="np.nan",
)
# Both sides of a selection are computed, and the one that is not taken may overflow.
_QUIET = '@np.errstate(all="ignore")\n'
_JAX = """\
import jax
import jax.numpy as np

# Pressures and bristles need double precision.
jax.config.update("jax_enable_x64", True)"""
_ABOUT = """
    derivative(x, u, p)  the state derivative
    linearise(x, u, p)   the same, and its derivatives by the states (..., states, states)
    outputs(x, u, p)     what OUTPUTS names

x, u, p and results have their numbers along the last axis{axes}. Without p the parameters have the VALUES of
the file."""
_LINEARISE = '''

def linearise(x, u, p=None):
    """State derivative and its derivatives by the states."""
    found = _linearised(x, u, p)
    dx, values = found[..., : len(STATES)], found[..., len(STATES) :]
    dfdx = np.zeros((*dx.shape, len(STATES)))
    {fill}
    return dx, dfdx
'''
_IN_PLACE = "dfdx[..., list(ROWS), list(COLUMNS)] = values"
_PURE = "dfdx = dfdx.at[..., np.array(ROWS), np.array(COLUMNS)].set(values)"


def numpy_text(tape: Tape) -> str:
    """A module of functions of NumPy arrays."""
    about = _ABOUT.format(axes="; any axes may stand before it")
    return python_head(tape, about, "import numpy as np") + _functions(tape, _QUIET, _IN_PLACE)


def jax_text(tape: Tape) -> str:
    """A module of pure functions for JAX."""
    return python_head(tape, _ABOUT.format(axes="; use jax.vmap for many"), _JAX) + _functions(tape, "", _PURE)


def python_head(tape: Tape, about: str, imports: str) -> str:
    """What a file of Python says of itself, and its names and numbers."""
    text = "\n".join(line.rstrip() for line in [*head(tape), *about.splitlines()])
    lines = [f'"""{text.replace(chr(92), "/").replace(chr(34), chr(39))}\n"""', "", imports, ""]
    for name, signals in (("STATES", tape.states), ("INPUTS", tape.commands), ("OUTPUTS", tape.outputs)):
        lines.append(_tuple(name, [repr(signal[0]) for signal in signals]))
    lines.append(_tuple("PARAMETERS", [repr(key) for key, _, _ in tape.parameters]))
    lines.append(_tuple("VALUES", [*map(repr, tape.values)]))
    for i, (starts, columns) in enumerate(tape.tables):
        lines.append(_tuple(f"STARTS_{i}", [*map(repr, starts)]))
        lines += [_tuple(f"COLUMN_{i}_{k}", [*map(repr, own)]) for k, own in enumerate(columns)]
    return "\n".join(lines) + "\n"


def _tuple(name: str, items: list[str]) -> str:
    return f"{name} = (\n    {wrapped(items)},\n)" if items else f"{name} = ()"


def _functions(tape: Tape, before: str, fill: str) -> str:
    """Decorators stand `before` each; `fill` puts the derivatives in their places."""
    results = ARRAYS.results(tape.prologue)
    prologue = ["def _prologue(p):", *_steps(tape.prologue, {"p": len(tape.parameters)})]
    lines = [_tuple("_KEPT", [*map(repr, tape.kept)]), "", "", *prologue]
    lines.append(f"    return [{wrapped(results, ' ' * 8)}]")
    derivative = before + _function("derivative", tape, tape.derivative, "State derivative.")
    outputs = before + _function("outputs", tape, tape.output, "What OUTPUTS names.")
    text = "\n".join([*lines, "", "", derivative, "", outputs])
    if not tape.places:
        return text
    places = [_tuple(name, [str(place[k]) for place in tape.places]) for k, name in enumerate(("ROWS", "COLUMNS"))]
    linearised = before + _function("_linearised", tape, tape.linearise, "State derivative, then its derivatives.")
    return "\n".join([text, *places, "", "", linearised]) + _LINEARISE.format(fill=fill)


def _function(name: str, tape: Tape, function: FunctionEntry, about: str) -> str:
    lines = [f"def {name}(x, u, p=None):", f'    """{about}"""']
    counts = {"x": len(tape.states), "u": len(tape.commands), "c": len(tape.kept)}
    if tape.kept:
        lines.append("    c = _KEPT if p is None else _prologue(p)")
    lines += _steps(function, counts)
    if function[1]:
        lines.append(f"    found = [{wrapped(ARRAYS.results(function), ' ' * 8)}]")
        lines.append("    return np.stack(np.broadcast_arrays(*found), axis=-1)")
    else:
        lines.append("    return np.zeros((*np.shape(x)[:-1], 0))")
    return "\n".join(lines) + "\n"


def _steps(function: FunctionEntry, counts: dict[str, int]) -> list[str]:
    lines = []
    for letter, count in counts.items():
        if count:
            every = wrapped([f"{letter}{i}" for i in range(count)], " " * 8)
            source = letter if letter == "c" else f"np.moveaxis(np.asarray({letter}, dtype=float), -1, 0)"
            lines.append(f"    ({every},) = {source}")
    return lines + [f"    {name} = {text}" for name, text in ARRAYS.steps(function)]
