"""Machines as functions in other languages: the right-hand side, its derivatives and outputs, written from a tape."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Sequence
from os import PathLike
from pathlib import Path
from types import ModuleType

from hydrocrane.errors import InputError, unknown
from hydrocrane.export.fmu import default_keys
from hydrocrane.export.languages.arrays import jax_text, numpy_text
from hydrocrane.export.languages.c import c_text
from hydrocrane.export.languages.casadi import casadi_text
from hydrocrane.export.languages.cuda import cuda_text
from hydrocrane.export.languages.matlab import matlab_text
from hydrocrane.export.languages.self_test import self_test
from hydrocrane.export.tape import Tape, tape_of
from hydrocrane.files.whole_file import write_text
from hydrocrane.machine.machine import Machine, MachineLike, as_machine

# Suffix of the file of each language.
LANGUAGES = {"c": ".c", "casadi": ".py", "jax": ".py", "numpy": ".py", "matlab": ".m", "cuda": ".cu"}
_IN_PYTHON: dict[str, Callable[[Tape], str]] = {"casadi": casadi_text, "jax": jax_text, "numpy": numpy_text}
_PAYLOAD = "payload.mass"


def export_model(
    machine: MachineLike,
    path: str | PathLike[str],
    *,
    to: str = "c",
    parameters: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    derivatives: bool = True,
) -> Path:
    """Write a machine's right-hand side as a function in another language. Returns the path of the file.

    The function takes the state ``x`` (n_states), the spool commands ``u`` (n_cylinders), m, and parameters ``p``, and
    gives the state derivative, as :meth:`~hydrocrane.Machine.state_derivative` does. The file needs nothing of
    hydrocrane. Its head lists every input and result with name and unit; theory in ``docs/theory/tape.md``.

    Where the supply's pressure is measured, it is a state whose derivative is zero: set it in ``x``. The payload is
    held constant; to pick one up, change ``p``.

    Parameters
    ----------
    machine : Machine, str or path
    path : path
        File to write: ``.c``, ``.py`` for CasADi, JAX and NumPy, ``.m``, ``.cu``. In MATLAB it names the function.
    to : {"c", "casadi", "jax", "numpy", "matlab", "cuda"}
        The language.
    parameters : sequence of str, optional
        Keys of the machine file whose numbers are inputs, and tables, all of whose numbers are that can be: those
        that decide which laws act are left out. Default is what an FMU offers: supply, friction and payload. With
        ``[]`` there are none, and the function is fastest.
    outputs : sequence of str, optional
        Names of outputs (``crane.outputs``); default is all but the energies. ``ledger.lift.friction`` and its like are
        the powers of the terms of the energy ledger, W; those that need the elastic energy of the oil are refused.
    derivatives : bool
        Whether to write the derivatives by the states too.

    Raises
    ------
    InputError
        An unknown language, another suffix, a key that can be no parameter, an output that is none, and friction that
        jumps (``errata.friction-map = "as-printed"`` without a smoothing velocity).
    ResultFileError
        A file that cannot be written.

    Examples
    --------
    >>> import hydrocrane as hc
    >>> hc.export_model("rottne-f9-lab", "crane.c").name
    'crane.c'
    """
    if to not in LANGUAGES:
        raise unknown("language", to, tuple(LANGUAGES))
    file, crane = Path(path), as_machine(machine)
    if file.suffix.lower() != LANGUAGES[to]:
        raise InputError(f"the file of a model in {to} ends in {LANGUAGES[to]}, unlike `{file.name}`")
    if to == "matlab" and not (file.stem.isascii() and file.stem.isidentifier()):
        raise InputError(f"MATLAB names the function after its file, and `{file.stem}` is no name; use letters")
    tape = _traced(crane, parameters, outputs, derivatives)
    if to == "matlab":
        text = matlab_text(tape, file.stem)
    elif to == "c":
        text = c_text(tape) + self_test(crane, tape)
    else:
        text = cuda_text(tape) if to == "cuda" else _IN_PYTHON[to](tape)
    return write_text(file, text)


def model_in(
    machine: Machine, language: str, parameters: Sequence[str] | None, outputs: Sequence[str] | None
) -> ModuleType:
    """The model as a module of the running program.

    Raises
    ------
    InputError
        If the library of the language is not installed, and as :func:`export_model`.
    """
    try:
        importlib.import_module(language)
    except ImportError:
        raise InputError(f"{language} is not installed; install it, `pip install {language}`") from None
    tape = _traced(machine, parameters, outputs, True)
    module = ModuleType(f"{language}_model", f"{machine.name} for {language}.")
    exec(compile(_IN_PYTHON[language](tape), f"<{machine.name} for {language}>", "exec"), module.__dict__)
    return module


def _traced(
    machine: Machine, parameters: Sequence[str] | None, outputs: Sequence[str] | None, derivatives: bool
) -> Tape:
    for what, given in (("parameters", parameters), ("outputs", outputs)):
        if isinstance(given, str) or not (given is None or isinstance(given, Iterable)):
            raise InputError(f"{what} are a list of names; write [{given!r}]")
        if wrong := [name for name in given or () if not isinstance(name, str)]:
            raise InputError(f"{what} are names, and {wrong[0]!r} is none; write it as the machine file does")
    if not isinstance(derivatives, bool):
        raise InputError(f"derivatives are written or not: True or False, not {derivatives!r}")
    if parameters is None:
        return tape_of(machine, [*default_keys(machine), _PAYLOAD], outputs, derivatives)
    tape = tape_of(machine, parameters, outputs, derivatives)
    for key in parameters:
        if not any(name == key or name.startswith((f"{key}.", f"{key}[")) for name, _, _ in tape.parameters):
            raise InputError(f"none of the numbers of `{key}` can be a parameter of this machine; leave it out")
    return tape
