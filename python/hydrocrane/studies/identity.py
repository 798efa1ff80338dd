"""Identity of a study: all data that its results depend on; and the differences of two studies."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TypeAlias, cast

import numpy as np

from hydrocrane.machine.machine import Machine
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.studies.case import digest_of
from hydrocrane.studies.design import Cases
from hydrocrane.studies.fingerprint import UNKNOWN, content_of, fingerprint
from hydrocrane.studies.key import COMMAND_LOG, SUPPLY_LOG
from hydrocrane.studies.measures import Measure
from hydrocrane.studies.values import axis_values

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
