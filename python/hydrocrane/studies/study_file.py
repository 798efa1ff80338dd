"""Reads a study from a TOML file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any, cast

from hydrocrane import _core
from hydrocrane.arrays import checked_name
from hydrocrane.errors import InputError, nearest, translated
from hydrocrane.files.toml_file import TomlTable, TomlValue, read_toml
from hydrocrane.machine.overrides import Override
from hydrocrane.scenario.changes import RunChanges
from hydrocrane.scenario.scenario_file import bundled_scenarios
from hydrocrane.studies.keys import COMMAND_LOG, SUPPLY_LOG
from hydrocrane.studies.study import Study

TABLES = ("study", "keys", "overrides")
STUDY_KEYS = (
    "name", "scenario", "machine", "method", "n", "seed", "measures", "signals", "resample", "ledger", "store"
)  # fmt: skip
TYPES: dict[str, tuple[type, ...]] = {
    "name": (str,), "scenario": (str,), "machine": (str,), "method": (str,), "n": (int,), "seed": (int,),
    "measures": (list,), "signals": (list,), "resample": (str, float, int), "ledger": (bool,), "store": (str,),
}  # fmt: skip
# Keys that mark a table as a range and not as a part of a dotted key.
RANGE = ("low", "high", "values", "distribution")


@dataclass(frozen=True)
class StudyFile:
    """A study from a file, with its name and the folder of its store."""

    name: str
    study: Study
    store: Path


def load_study(path: str | PathLike[str]) -> StudyFile:
    """Read a study file; see docs/howto/run-a-study.md.

    Raises
    ------
    InputError
        With the file and the key.

    Examples
    --------
    >>> from pathlib import Path
    >>> _ = Path("loads.toml").write_text('''
    ... [study]
    ... scenario = "vertical-lift-open-loop"
    ... measures = ["max(tip.z)"]
    ... [keys]
    ... "payload.mass" = ["0 kg", "50 kg"]
    ... ''')
    >>> print(hc.load_study("loads.toml").study.cases.count)
    2
    """
    file = Path(path)
    with translated():
        content = read_toml(file, "study file")
    _known(file, "", content, TABLES)
    for table in ("study", "keys"):
        if not isinstance(content.get(table), dict):
            raise InputError(f"{file}: a study needs the table [{table}]")
    about = cast("dict[str, Any]", content["study"])
    _known(file, "study.", about, STUDY_KEYS)
    for key, value in about.items():
        if not isinstance(value, TYPES[key]) or (isinstance(value, bool) and bool not in TYPES[key]):
            words = " or ".join(kind.__name__ for kind in TYPES[key])
            raise InputError(f"{file}: study.{key} must be of the type {words}; got {value!r}")
    if "scenario" not in about:
        raise InputError(f'{file}: [study] needs scenario = "..."; bundled: {", ".join(bundled_scenarios())}')
    name = checked_name(f"{file}: study.name", about["name"]) if "name" in about else file.stem
    given = {key: value for key, value in about.items() if key not in ("name", "store")}
    keys = _flat(_table(content, "keys"))
    _check_paths(file, {f"study.{key}": [about.get(key)] for key in ("scenario", "machine")})
    _check_paths(file, {key: keys.get(key) for key in (COMMAND_LOG, SUPPLY_LOG)})
    given |= {key: _beside(file, about[key]) for key in ("scenario", "machine") if key in about}
    overrides = _flat(_table(content, "overrides"))
    changes: RunChanges = {"overrides": cast("Mapping[str, Override]", overrides)} if overrides else {}
    study = Study(keys=keys, changes=changes, **given)
    return StudyFile(name, study, _store(file, about.get("store", f"{name}.zarr")))


def _check_paths(file: Path, named: Mapping[str, object]) -> None:
    """Refuses paths that a file may not name, as machine and scenario files do."""
    for key, paths in named.items():
        for path in paths if isinstance(paths, list) else ():
            fault = _core.path_fault(path) if isinstance(path, str) else None
            if fault is not None:
                raise InputError(f"{file}: {key} is `{path}`, which {fault}")


def _store(file: Path, name: str) -> Path:
    """A folder for the results below the present one: a file that somebody sent shall not choose another."""
    for system in (PurePosixPath(name), PureWindowsPath(name)):
        if system.anchor or ".." in system.parts:
            raise InputError(
                f"{file}: study.store is `{name}`, which leads out of the present folder; leave it out, and give "
                "another folder by --store"
            )
    return Path(name)


def _table(content: TomlTable, name: str) -> TomlTable:
    table = content.get(name, {})
    return table if isinstance(table, dict) else {}


def _known(file: Path, path: str, table: Mapping[str, TomlValue], known: tuple[str, ...]) -> None:
    for key in table:
        if key not in known:
            raise InputError(f"{file}: unknown key `{path}{key}`{nearest(key, known)}")


def _flat(table: Mapping[str, TomlValue], path: str = "") -> dict[str, TomlValue]:
    """Dotted keys, also from nested tables of TOML."""
    flat: dict[str, TomlValue] = {}
    for key, value in table.items():
        dotted = f"{path}.{key}" if path else key
        if isinstance(value, Mapping) and not any(word in value for word in RANGE):
            flat |= _flat(value, dotted)
        else:
            flat[dotted] = value
    return flat


def _beside(file: Path, name: str) -> str:
    """A path relative to the study file's folder; a bundled name is unchanged."""
    there = file.resolve().parent / name
    try:
        return str(there) if there.is_file() else name
    except (OSError, ValueError):  # The text is too long for a path, or has an invalid character.
        return name
