"""Former names. Modules and keywords still work, with a warning. Attributes are refused."""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Callable, Sequence
from functools import wraps
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Never, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

# Old module -> the modules that hold its names today.
MOVED = {
    "batch": ("simulation.batch",),
    "capacity": ("analysis.capacity",),
    "citation": ("results.citation",),
    "compare": ("results.comparison", "results.difference"),
    "controllers": ("control.controllers", "machine.sensors"),
    "dataset": ("results.dataset",),
    "fitted_tasks": ("benchmark.fitted_tasks",),
    "joystick": ("control.joystick",),
    "metrics": ("benchmark.metrics",),
    "payload": ("scenario.payload",),
    "phases": ("scenario.phases",),
    "result": ("results.run", "results.record", "results.outcome"),
    "samples": ("results.samples",),
    "sensitivity": ("analysis.sensitivity",),
    "simulator": ("simulation.simulator",),
    "summary": ("results.summary",),
    "tasks": ("benchmark.tasks",),
    "tuning": ("benchmark.tuning",),
    "verification": ("results.verification", "results.outcome"),
}


class OldNames:
    """Finds the modules of :data:`MOVED`; a finder and loader of Python's import system."""

    @staticmethod
    def find_spec(name: str, path: Sequence[str] | None = None, target: ModuleType | None = None) -> ModuleSpec | None:
        package, _, old = name.rpartition(".")
        return ModuleSpec(name, OldNames) if package == "hydrocrane" and old in MOVED else None  # type: ignore[arg-type]

    @staticmethod
    def create_module(spec: ModuleSpec) -> None:
        """The default module type is used."""

    @staticmethod
    def exec_module(module: ModuleType) -> None:
        old = module.__name__.rpartition(".")[2]
        homes = [importlib.import_module(f"hydrocrane.{home}") for home in MOVED[old]]

        def look_up(name: str) -> object:
            for home in homes:
                if hasattr(home, name):
                    return getattr(home, name)
            raise AttributeError(f"module {module.__name__!r} has no attribute {name!r}")

        module.__getattr__ = look_up  # type: ignore[method-assign]
        today = " and ".join(home.__name__ for home in homes)
        warnings.warn(f"{module.__name__} has moved: import from {today}", DeprecationWarning, stacklevel=2)


def renamed_keyword(old: str, new: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """A decorator: the function also accepts its argument `new` by its former name `old`."""

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def call(*args: P.args, **kwargs: P.kwargs) -> R:
            if old in kwargs:
                if new in kwargs:
                    raise TypeError(f"{function.__name__} got `{new}` twice: once as `{old}`, its former name")
                warnings.warn(f"the argument `{old}` is called `{new}` now", DeprecationWarning, stacklevel=2)
                kwargs[new] = kwargs.pop(old)
            return function(*args, **kwargs)

        return call

    return decorate


def former_attribute(old: str, new: str) -> property:
    """An attribute by its former name: reading it raises an error that states the present one."""

    def read(self: object) -> Never:
        raise AttributeError(f"`{old}` is called `{new}` now")

    return property(read)
