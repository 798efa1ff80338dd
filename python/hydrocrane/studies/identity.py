"""Identity of a study: all that its results depend on, the code of its own functions included.

Two that have the same digest give the same numbers. Libraries count by their version; of one's own modules counts what
is used. Where that cannot be found out, the reason stands in place of the digest.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import inspect
import json
import os.path
import sys
import sysconfig
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import (
    BuiltinFunctionType,
    ClassMethodDescriptorType,
    CodeType,
    FunctionType,
    GetSetDescriptorType,
    MemberDescriptorType,
    MethodDescriptorType,
    MethodType,
    MethodWrapperType,
    ModuleType,
    WrapperDescriptorType,
)
from typing import TypeAlias, cast

import numpy as np

from hydrocrane.machine.machine import Machine
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.studies.case import digest_of
from hydrocrane.studies.design import Cases
from hydrocrane.studies.keys import COMMAND_LOG, SUPPLY_LOG, axis_values
from hydrocrane.studies.measures import Measure

# Begins what stands in place of a digest.
UNKNOWN = "not known: "
# Most objects that one may lead to.
MOST = 200_000
_PLAIN = (type(None), type(...), type(NotImplemented), bool, int, float, complex, bytes, bytearray, range, slice)
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
}
_LIBRARIES = {sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")}


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


def content_of(path: Path) -> str:
    """The digest of a file's content; empty if it is no regular file."""
    # A text that is too long for a path is none.
    if not os.path.isfile(path):  # noqa: PTH113
        return ""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:16]


class _Walk:
    """Goes through all that a value leads to, each object once."""

    def __init__(self) -> None:
        self.digest = hashlib.sha256(f"python {sys.version_info[:2]}".encode())
        # By identity; the objects are kept, so that no other takes the place of one.
        self._seen: dict[int, tuple[int, object]] = {}

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
        if isinstance(value, _PLAIN):
            self._put(type(value).__qualname__, repr(value))
            return
        if isinstance(value, str | Path):
            self._text(value)
            return
        if id(value) in self._seen:
            self._put("again", self._seen[id(value)][0])
            return
        if len(self._seen) >= MOST:
            raise _Unknown(f"it leads to more than {MOST} objects")
        self._seen[id(value)] = len(self._seen), value
        self._object(value)

    def _text(self, value: str | Path) -> None:
        """A text; of the path of a file its content too."""
        text = str(value)
        self._put(type(value).__name__, text)
        if 0 < len(text) < 1024 and text.isprintable():
            self._put(content_of(Path(text)))

    def _object(self, value: object) -> None:
        if isinstance(value, Machine):
            self._put("machine", value.core.resolved)
        elif isinstance(value, ModuleType):
            self._put("module", value.__name__, _version(value.__name__))
        elif isinstance(value, FunctionType):
            self._function(value)
        elif isinstance(value, MethodType):
            self._each("method", (value.__func__, value.__self__))
        elif isinstance(value, functools.partial):
            self._each("partial", (value.func, value.args, value.keywords))
        elif isinstance(value, _COMPILED):
            self._put("built in", getattr(value, "__module__", ""), getattr(value, "__qualname__", value.__name__))
            owner = getattr(value, "__self__", None)
            if owner is not None and not isinstance(owner, ModuleType):
                self.take(owner)
        elif isinstance(value, CodeType):
            self._code(value)
        elif isinstance(value, type):
            self._class(value)
        elif isinstance(value, np.ndarray) and not value.dtype.hasobject:
            self._put("array", value.dtype.str, value.shape, np.ascontiguousarray(value).tobytes())
        elif isinstance(value, Mapping) and type(value) is dict:
            self._each("mapping", (part for item in value.items() for part in item))
        elif isinstance(value, list | tuple) and type(value) in (list, tuple):
            self._each(type(value).__name__, value)
        elif isinstance(value, set | frozenset):
            # Without an order.
            self._put("set", sorted(fingerprint(item) for item in value))
        elif isinstance(value, property | staticmethod | classmethod | functools.cached_property):
            parts = ("fget", "fset", "fdel", "__func__", "func")
            self._each("descriptor", (getattr(value, part, None) for part in parts))
        else:
            self._instance(value)

    def _instance(self, value: object) -> None:
        """By what `copy` and `pickle` would make it of."""
        try:
            made = value.__reduce_ex__(4)
        except TypeError:
            raise _Unknown(f"a {type(value).__qualname__} does not tell its state") from None
        self.take(type(value))
        self._each("state", [made] if isinstance(made, str) else map(_listed, made))

    def _class(self, value: type) -> None:
        self._put("class", value.__module__, value.__qualname__)
        if _is_library(value.__module__):
            self._put(_version(value.__module__))
            return
        self._each("bases", value.__bases__)
        own = {name: part for name, part in vars(value).items() if name not in _OF_ITSELF}
        self._each("own", (part for name in sorted(own) for part in (name, own[name])))

    def _function(self, value: FunctionType) -> None:
        if hasattr(value, "__wrapped__"):
            self.take(value.__wrapped__)
        self._put("function", value.__module__, value.__qualname__)
        if _is_library(value.__module__ or "") and "<locals>" not in value.__qualname__:
            self._put(_version(value.__module__ or ""))
            return
        cells = [_content(cell) for cell in value.__closure__ or ()]
        self._each("function", (value.__code__, value.__defaults__, value.__kwdefaults__, *cells))
        for name in sorted(_names(value.__code__)):
            if name in value.__globals__:
                self._global(name, value.__globals__[name], value.__code__)

    def _global(self, name: str, value: object, code: CodeType) -> None:
        """A global that a function uses; of a module of one's own those parts that are named."""
        self._put("global", name)
        self.take(value)
        if isinstance(value, ModuleType) and not _is_library(value.__name__):
            for part in sorted(_names(code) & vars(value).keys()):
                self._put(part)
                self.take(vars(value)[part])

    def _code(self, value: CodeType) -> None:
        self._put("code", value.co_code, value.co_names, value.co_flags, value.co_argcount, value.co_exceptiontable)
        self._each("constants", value.co_consts)


def _names(code: CodeType) -> set[str]:
    """Globals and attributes that a function names, with those of functions in it."""
    inner = (constant for constant in code.co_consts if isinstance(constant, CodeType))
    return {*code.co_names}.union(*map(_names, inner))


def _content(cell: object) -> object:
    try:
        return cell.cell_contents  # type: ignore[attr-defined]
    except ValueError:
        return "not set yet"


def _listed(part: object) -> object:
    """Lists in place of iterators, which can be walked once."""
    return list(part) if hasattr(part, "__next__") else part  # type: ignore[call-overload]


@functools.cache
def _is_library(module: str) -> bool:
    """Whether a module belongs to Python, to this package, or to one that was installed: its version stands for it."""
    root = module.partition(".")[0]
    if root in sys.stdlib_module_names or root in (__name__.partition(".")[0], "builtins"):
        return True
    file = getattr(sys.modules.get(root), "__file__", None)
    return file is not None and any(Path(file).is_relative_to(folder) for folder in _LIBRARIES)


def _version(module: str) -> str:
    return str(getattr(sys.modules.get(module.partition(".")[0]), "__version__", ""))


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
    if value is None or isinstance(value, bool | int | float | str):
        return value if not isinstance(value, float) or np.isfinite(value) else str(value)
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, Machine):
        return {"name": value.name, "digest": digest_of(value.core)}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return _shortened([plain(item) for item in value])
    return fingerprint(value)


def contents(files: Iterable[object]) -> list[str]:
    """The digests of files' contents."""
    return [content_of(Path(str(file))) for file in files]


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
