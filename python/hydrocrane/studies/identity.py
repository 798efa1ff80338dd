"""Identity of a study: all that its results depend on, the code of its own functions included.

Two that have the same digest give the same numbers. Libraries count by their version; of one's own modules counts what
is used. Where that cannot be found out, the reason stands in place of the digest.
"""

from __future__ import annotations

import builtins
import copyreg
import dataclasses
import dis
import enum
import functools
import hashlib
import importlib
import importlib.metadata
import inspect
import itertools
import json
import operator
import os
import pickle
import site
import sys
import sysconfig
import typing
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path, PurePath
from types import (
    BuiltinFunctionType,
    ClassMethodDescriptorType,
    CodeType,
    FunctionType,
    GetSetDescriptorType,
    MappingProxyType,
    MemberDescriptorType,
    MethodDescriptorType,
    MethodType,
    MethodWrapperType,
    ModuleType,
    WrapperDescriptorType,
)
from typing import TypeAlias, cast

import numpy as np

from hydrocrane.errors import InputError
from hydrocrane.machine.machine import Machine
from hydrocrane.results.record import Record
from hydrocrane.scenario.scenario import Scenario, own_controllers
from hydrocrane.studies.case import Job, digest_of
from hydrocrane.studies.design import Cases
from hydrocrane.studies.keys import COMMAND_LOG, SUPPLY_LOG, axis_values
from hydrocrane.studies.measures import Measure

# Begins what stands in place of a digest.
UNKNOWN = "not known: "
# Most objects that one may lead to.
MOST = 200_000
_PLAIN = {type(None), type(...), type(NotImplemented), bool, int, float, complex, bytes, bytearray, range, slice}
_COMPILED = (
    BuiltinFunctionType,
    MethodWrapperType,
    GetSetDescriptorType,
    MemberDescriptorType,
    MethodDescriptorType,
    ClassMethodDescriptorType,
    WrapperDescriptorType,
    np.ufunc,
)
# What a class has of itself without being told.
_OF_ITSELF = {
    "__dict__",
    "__weakref__",
    "__doc__",
    "__module__",
    "__annotations__",
    "__firstlineno__",
    "__static_attributes__",
    "__slotnames__",
    "_abc_impl",
}
# What leads to anything, by texts that are made when it runs, or to what may be otherwise at the next call.
_OPEN = {
    id(value): name
    for name, value in {
        "eval": eval,
        "exec": exec,
        "globals": globals,
        "__import__": __import__,
        "importlib.import_module": importlib.import_module,
        "os.environ": os.environ,
        "os.getenv": os.getenv,
    }.items()
}
# Of these what is asked of the environment counts, where its name stands in the code.
_ENVIRONMENT = {id(os.environ), id(os.getenv)}
_LIBRARIES = {
    *(sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")),
    *site.getsitepackages(),
    site.getusersitepackages(),
    str(Path(__file__).parents[1]),
}
# Instructions that load a global, and those that read an attribute of what was loaded.
_LOADS = ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_FROM_DICT_OR_GLOBALS")
_READS = ("LOAD_ATTR", "LOAD_METHOD")


class _Unknown(Exception):
    """Why a digest cannot be had."""


def fingerprint(value: object) -> str:
    """The name of a function or of an object's class, and its digest."""
    kind = value if inspect.isroutine(value) else type(value)
    name = f"{getattr(kind, '__module__', '')}.{getattr(kind, '__qualname__', type(value).__qualname__)}"
    walk = _Walk()
    try:
        walk.take(value)
    except _Unknown as reason:
        return f"{name}, {UNKNOWN}{reason}"
    except Exception as error:  # Whatever an object raises when it is asked for its state.
        return f"{name}, {UNKNOWN}{type(error).__name__}: {error}"
    return f"{name}, {walk.digest.hexdigest()[:16]}"


def content_of(path: str | bytes | PurePath) -> str:
    """The digest of a file's content; empty if it is no regular file."""
    # A text that is too long for a path is none.
    if not os.path.isfile(path):  # noqa: PTH113
        return ""
    with open(path, "rb") as file:  # noqa: PTH123
        return hashlib.file_digest(file, "sha256").hexdigest()[:16]


class _Walk:
    """Goes through all that a value leads to, each object once; `seen` are those that another walk has met before."""

    def __init__(self, seen: Mapping[int, tuple[int, object]] | None = None) -> None:
        self.digest = hashlib.sha256(f"python {sys.version_info[:2]}".encode())
        # By identity; the objects are kept, so that no other takes the place of one.
        self._seen = dict(seen or {})

    def _put(self, *facts: object) -> None:
        for fact in facts:
            data = fact if isinstance(fact, bytes) else str(fact).encode("utf-8", "surrogatepass")
            self.digest.update(b"%d:" % len(data))
            self.digest.update(data)

    def _each(self, what: str, values: Iterable[object]) -> None:
        listed = list(values)
        self._put(what, len(listed))
        for value in listed:
            self.take(value)

    def take(self, value: object) -> None:
        if type(value) in _PLAIN:
            self._put(type(value).__qualname__, repr(value))
            return
        if type(value) is str or (isinstance(value, PurePath) and _is_library(type(value).__module__)):
            self._text(value)
            return
        if id(value) in self._seen:
            self._put("again", self._seen[id(value)][0])
            return
        if len(self._seen) >= MOST:
            raise _Unknown(f"it leads to more than {MOST} objects")
        self._seen[id(value)] = len(self._seen), value
        self._object(value)

    def _text(self, value: str | PurePath) -> None:
        """A text; of the path of a file its content too."""
        text = str(value)
        self._put(type(value).__name__, text)
        if 0 < len(text) < 1024 and text.isprintable():
            self._put(content_of(text))

    def _object(self, value: object) -> None:
        if id(value) in _OPEN:
            raise _Unknown(f"it uses {_OPEN[id(value)]}, which leads to what cannot be told before it runs")
        if isinstance(value, Machine):
            self._put("machine", value.core.resolved)
        elif isinstance(value, Record):
            self._record(value)
        elif isinstance(value, ModuleType):
            self._module(value)
        elif isinstance(value, FunctionType):
            self._function(value)
        elif isinstance(value, MethodType):
            self._each("method", (value.__func__, value.__self__))
        elif isinstance(value, functools.partial):
            self._each("partial", (value.func, value.args, value.keywords, vars(value)))
        elif isinstance(value, _COMPILED):
            self._compiled(value)
        elif isinstance(value, CodeType):
            self._code(value)
        elif isinstance(value, type):
            self._class(value)
        elif isinstance(value, enum.Enum):
            self._each("choice", (type(value), vars(value)))
        elif type(value) is np.ndarray and not value.dtype.hasobject:
            self._put("array", value.dtype, value.shape, np.ascontiguousarray(value).tobytes())
        elif type(value) in (dict, MappingProxyType):
            items = cast("Mapping[object, object]", value).items()
            self._each("mapping", (part for item in items for part in item))
        elif type(value) in (list, tuple):
            self._each(type(value).__name__, cast("Iterable[object]", value))
        elif type(value) in (set, frozenset):
            # Without an order, so each by itself.
            self._put("set", *sorted(map(self._apart, cast("Iterable[object]", value))))
        elif isinstance(value, property | staticmethod | classmethod | functools.cached_property):
            parts = ("fget", "fset", "fdel", "__func__", "func")
            self._each("descriptor", (getattr(value, part, None) for part in parts))
        else:
            self._instance(value)

    def _apart(self, value: object) -> str:
        walk = _Walk(None if type(value) in _PLAIN or type(value) is str else self._seen)
        walk.take(value)
        return walk.digest.hexdigest()

    def _instance(self, value: object) -> None:
        """By what `copy` and `pickle` would make it of."""
        kind = type(value)
        reduced = copyreg.dispatch_table.get(kind)
        try:
            made = value.__reduce_ex__(4) if reduced is None else reduced(value)
        except TypeError:
            raise _Unknown(f"a {kind.__qualname__} does not tell its state") from None
        if isinstance(made, str):
            self._by_its_name(value, made)
            return
        self.take(kind)
        parts = list(map(_listed, made))
        if len(parts) > 2 and type(parts[2]) is tuple and len(parts[2]) == 2 and isinstance(parts[2][1], dict):
            # Of a class with slots: attributes, and slots.
            parts[2] = {**(parts[2][0] or {}), **parts[2][1]}
        self._each("state", parts)

    def _by_its_name(self, value: object, name: str) -> None:
        """What tells a name for its state: a library's own, a function behind a cache, a type without a value."""
        self._put("named", type(value).__qualname__, name)
        if isinstance(value, typing.TypeVar | typing.ParamSpec | typing.TypeVarTuple):
            return
        if hasattr(value, "__wrapped__"):
            self.take(value.__wrapped__)
        elif _of_library(value):
            self._put(_version(value.__module__))
        else:
            raise _Unknown(f"a {type(value).__qualname__} tells its name only")

    def _record(self, value: Record) -> None:
        """A run, without the time that it took."""
        columns = value.columns
        self._put("run", value.machine.core.resolved)
        self.take({name: text for name, text in columns.attrs.items() if name != "wall_time"})
        self.take({name: columns[name].values for name in columns})

    def _compiled(self, value: object) -> None:
        name, module = getattr(value, "__name__", ""), getattr(value, "__module__", None)
        self._put("built in", module, getattr(value, "__qualname__", name))
        if isinstance(value, np.ufunc) and not any(getattr(home, name, None) is value for home in _of_ufuncs()):
            raise _Unknown(f"the ufunc {name} does not tell its function")
        if module and not _is_library(module):
            self._put(content_of(getattr(sys.modules.get(module), "__file__", None) or ""))
        owner = getattr(value, "__self__", None)
        if owner is not None and not isinstance(owner, ModuleType):
            self.take(owner)

    def _module(self, value: ModuleType) -> None:
        """A module that may be asked for anything: one's own with all that it has."""
        self._put("module", value.__name__, _version(value.__name__))
        if not _is_library(value.__name__):
            own = {name: part for name, part in vars(value).items() if not name.startswith("__")}
            self._each("own", (part for name in sorted(own) for part in (name, own[name])))

    def _class(self, value: type) -> None:
        self._put("class", value.__module__, value.__qualname__)
        if _of_library(value):
            self._put(_version(value.__module__))
            return
        self._each("bases", (type(value), *value.__bases__))
        # Slots are told by their names.
        slots = MemberDescriptorType, GetSetDescriptorType
        own = {name: part for name, part in vars(value).items() if name not in _OF_ITSELF and type(part) not in slots}
        self._each("own", (part for name in sorted(own) for part in (name, own[name])))

    def _function(self, value: FunctionType) -> None:
        self._put("function", value.__module__, value.__qualname__)
        if _of_library(value):
            self._put(_version(value.__module__))
            return
        cells = [_content(cell) for cell in value.__closure__ or ()]
        self._each("given", (value.__defaults__, value.__kwdefaults__, vars(value), *cells))
        self.take(value.__code__)
        if _in_library(str(value.__globals__.get("__file__", ""))):
            return
        for name, reads, kind, word in sorted(set(_names(value.__code__))):
            found = value.__globals__.get(name, vars(builtins).get(name))
            argument = value.__globals__.get(word) if kind in _LOADS else word if kind == "LOAD_CONST" else ""
            self._put("global", name)
            self._named(found, reads, argument)
        package = str(value.__globals__.get("__package__") or "")
        for name, parts in _imports(value.__code__):
            self._put("import", name)
            self._imported(name, parts, package)

    def _named(self, value: object, reads: tuple[str, ...], argument: object = "") -> None:
        """A global of which these attributes are read in turn, and what follows; of one's own modules only what is
        read counts."""
        for part in reads:
            if not isinstance(value, ModuleType):
                break
            if _is_library(value.__name__):
                if id(found := vars(value).get(part)) in _OPEN:
                    value = found
                break
            self._put(part)
            value = getattr(value, part, None)
        if argument and isinstance(argument, str) and id(value) in _ENVIRONMENT:
            self._put("environment", argument, dict(os.environ).get(argument))
        else:
            self.take(value)

    def _imported(self, name: str, parts: tuple[str, ...], package: str) -> None:
        """What a function imports when it runs: these parts of a module, or all of it."""
        try:
            module = importlib.import_module(name, package)
            for part in parts:
                if not hasattr(module, part):
                    importlib.import_module(f"{module.__name__}.{part}")
        except Exception:  # Where it is imported this may be caught.
            self._put("cannot be imported")
            return
        if not parts:
            self.take(sys.modules[module.__name__.partition(".")[0]])
        for part in parts:
            self._named(module, (part,))

    def _code(self, value: CodeType) -> None:
        self._put("code", value.co_code, value.co_names, value.co_flags, value.co_argcount, value.co_exceptiontable)
        self._put(value.co_posonlyargcount, value.co_varnames[: value.co_argcount + value.co_kwonlyargcount])
        self._each("constants", value.co_consts)


def _names(code: CodeType) -> Iterator[tuple[str, tuple[str, ...], str, str]]:
    """Globals that a function names, with the attributes that are read of each at once; what is loaded next, and its
    name or text."""
    steps = _steps(code)
    for i, step in enumerate(steps):
        if step.opname in _LOADS:
            later = itertools.islice(steps, i + 1, None)
            reads = tuple(read.argval for read in itertools.takewhile(lambda read: read.opname in _READS, later))
            after = steps[i + 1 + len(reads)]
            yield step.argval, reads, after.opname, after.argval if isinstance(after.argval, str) else ""
    for inner in _inner(code):
        yield from _names(inner)


def _imports(code: CodeType) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Modules that a function imports, with the names that it takes of them; with functions in it."""
    steps = _steps(code)
    for level, parts, step in zip(steps, steps[1:], steps[2:], strict=False):
        if step.opname == "IMPORT_NAME":
            yield "." * level.argval + step.argval, parts.argval or ()
    for inner in _inner(code):
        yield from _imports(inner)


def _steps(code: CodeType) -> list[dis.Instruction]:
    return [step for step in dis.get_instructions(code) if step.opname not in ("EXTENDED_ARG", "PUSH_NULL")]


def _inner(code: CodeType) -> Iterator[CodeType]:
    return (constant for constant in code.co_consts if isinstance(constant, CodeType))


def _content(cell: object) -> object:
    try:
        return cell.cell_contents  # type: ignore[attr-defined]
    except ValueError:
        return "not set yet"


def _listed(part: object) -> object:
    """Lists in place of iterators, which can be walked once."""
    return list(part) if hasattr(type(part), "__next__") else part  # type: ignore[call-overload]


def _of_library(value: object) -> bool:
    """Whether a class or function is what a library has under its name: then the version stands for it."""
    module, name = getattr(value, "__module__", None), getattr(value, "__qualname__", "")
    if not isinstance(module, str) or not _is_library(module):
        return False
    try:
        return bool(operator.attrgetter(name)(sys.modules[module]) is value)
    except (AttributeError, KeyError):
        return False


def _of_ufuncs() -> tuple[ModuleType | None, ...]:
    """Libraries that have ufuncs by their names."""
    return np, sys.modules.get("scipy.special")


@functools.cache
def _in_library(file: str) -> bool:
    """Whether a file belongs to Python, to this package, or to one that was installed: its version stands for it."""
    return any(Path(file).is_relative_to(folder) for folder in _LIBRARIES)


def _is_library(module: str) -> bool:
    root = module.partition(".")[0]
    file = getattr(sys.modules.get(root), "__file__", None)
    if root == "__main__" or file is None:
        # Without a file: what is compiled into Python.
        return root in sys.stdlib_module_names or root == "builtins"
    return _in_library(file)


@functools.cache
def _version(module: str) -> str:
    root = module.partition(".")[0]
    stated = getattr(sys.modules.get(root), "__version__", None)
    try:
        return str(stated or importlib.metadata.version(root))
    except importlib.metadata.PackageNotFoundError:
        return ""


def own_parts(job: Job) -> dict[str, str]:
    """The fingerprints of a study's own controllers and measures, where they are known."""
    parts = {f"controller {number}": fingerprint(law) for number, law in own_controllers(job.plan).items()}
    parts |= {f"measure `{measure.name}`": fingerprint(measure.own) for measure in job.measures if measure.own}
    return {name: found for name, found in parts.items() if UNKNOWN not in found}


def received(sent: bytes) -> Job:
    """The job that another process sent with its :func:`own_parts`.

    Raises
    ------
    InputError
        If it cannot be made here, or if one of the parts is another one here: what is found by its name may differ from
        what the sender has in memory.
    """
    try:
        study, parts = pickle.loads(sent)
        job: Job = pickle.loads(study)
    except Exception as error:
        raise InputError(
            f"the study cannot be made in another process: {type(error).__name__}: {error}; put what it needs into a "
            'module that is found there, or choose scheduler="threads"'
        ) from None
    here = own_parts(job) if parts else {}
    for name, its in parts.items():
        if here.get(name) != its:
            raise InputError(
                f"{name} is {its}, but {here.get(name)} in the process that computes cases: a module that it uses "
                "was changed after it was imported, or is another one there; write the change into the module, or "
                'choose scheduler="threads"'
            )
    return job


Json: TypeAlias = "None | bool | int | float | str | list[Json] | dict[str, Json]"

# Longer tables are compared by their digest.
SHOWN_NUMBERS = 40
SHOWN_DIFFERENCES = 5
# Fields without effect on results, such as the path of the machine file.
NOT_OF_THE_SCENARIO = ("machine", "overrides", "name", "title", "record_limit")
# Keys whose values are paths of files.
LOGS = (COMMAND_LOG, SUPPLY_LOG)


def identity(
    plan: Scenario, machine: Machine, cases: Cases, measures: tuple[Measure, ...], settings: Mapping[str, object]
) -> dict[str, Json]:
    """All data that the results of a study depend on, in a form that JSON preserves."""
    from hydrocrane import __version__

    fields = {field.name: getattr(plan, field.name) for field in dataclasses.fields(plan)}
    values = {key: plain(machine.value(key).si) for key in machine.keys}
    axes = list(zip(cases.keys, cases.axes, strict=True))
    whole: dict[str, object] = {
        "hydrocrane": __version__,
        "scenario": {name: plain(value) for name, value in fields.items() if name not in NOT_OF_THE_SCENARIO},
        "machine": {"name": machine.name, "values": values, "digest": digest_of(machine.core)},
        "keys": {key.name: plain(axis_values(axis)) for key, axis in axes},
        "logs": {key.name: plain(contents(axis_values(axis))) for key, axis in axes if key.name in LOGS},
        "measures": {measure.name: plain(measure.own) for measure in measures},
        **{name: plain(value) for name, value in settings.items()},
    }
    stored: dict[str, Json] = json.loads(json.dumps(whole))
    return stored


def plain(value: object) -> Json:
    """`value` in a form for JSON; functions and objects by their name and digest."""
    if isinstance(value, np.generic):
        return plain(value.item())
    if not _is_library(type(value).__module__):
        return fingerprint(value)
    if value is None or isinstance(value, bool | int | float | str):
        return value if not isinstance(value, float) or np.isfinite(value) else str(value)
    if isinstance(value, Machine):
        return {"name": value.name, "digest": digest_of(value.core)}
    if dataclasses.is_dataclass(value) and type(value).__module__.partition(".")[0] == __name__.partition(".")[0]:
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return _shortened([plain(item) for item in value])
    return fingerprint(value)


def contents(files: Iterable[object]) -> list[str]:
    """The digests of files' contents."""
    return [content_of(str(file)) for file in files]


def unknown_parts(wanted: Mapping[str, Json]) -> str:
    """What nobody can tell to be the same as before, in words; empty if there is nothing."""
    leaves = [f"{name} is {leaf}" for name, leaf in _leaves(wanted) if isinstance(leaf, str) and UNKNOWN in leaf]
    return "; ".join(leaves[:SHOWN_DIFFERENCES])


def _shortened(values: list[Json]) -> Json:
    text = json.dumps(values)
    if len(values) <= SHOWN_NUMBERS:
        return values
    return f"{len(values)} values, sha256 {hashlib.sha256(text.encode()).hexdigest()[:16]}"


def differences(stored: Mapping[str, Json], wanted: Mapping[str, Json]) -> str:
    """Differences of two studies in words; empty if they are equal."""
    before, after = dict(_leaves(stored)), dict(_leaves(wanted))
    absent = object()
    every = dict.fromkeys([*before, *after])
    names = [name for name in every if before.get(name, absent) != after.get(name, absent)]
    # The digest is reported only if the values show no difference.
    if len(names) > 1 and "machine.digest" in names:
        names.remove("machine.digest")
    shown = [_difference(name, before, after) for name in names[:SHOWN_DIFFERENCES]]
    more = len(names) - len(shown)
    return "; ".join([*shown, *([f"and {more} more"] if more > 0 else [])])


def _difference(name: str, before: Mapping[str, Json], after: Mapping[str, Json]) -> str:
    if name not in before:
        return f"{name} was not there"
    if name not in after:
        return f"{name} is not there"
    return f"{name} was {before[name]}, is {after[name]}"


def _leaves(tree: Json | Mapping[str, Json], path: str = "") -> Iterator[tuple[str, Json]]:
    if isinstance(tree, Mapping) and tree:
        for name, branch in tree.items():
            yield from _leaves(branch, f"{path}.{name}" if path else str(name))
    else:
        yield path, cast(Json, tree)
