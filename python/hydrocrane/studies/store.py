"""Where the results of a study lie: a Zarr group, one array per variable, one chunk per block of cases.

A block's chunks are written one by one, each put in place by renaming a whole file; the chunk of `outcome` comes
last. So a block is done exactly where its outcomes are, whenever the process may have been killed, and what was half
written is written again.
"""

from __future__ import annotations

import json
import shutil
import uuid
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import zarr
from zarr.storage import MemoryStore

from hydrocrane.arrays import Array
from hydrocrane.errors import ResultFileError
from hydrocrane.studies.case import BlockResult
from hydrocrane.studies.design import CASE, Cases, Place, blocks
from hydrocrane.studies.identity import differences
from hydrocrane.studies.values import axis_values

OUTCOME, MESSAGE, TIME = "outcome", "message", "time"
# Attribute that makes a Zarr group a study.
IDENTITY = "study"


@dataclass(frozen=True)
class Layout:
    """What a store is made from.

    Attributes
    ----------
    cases : Cases
    block : tuple of int
        Cases of a block along each dimension.
    times : (n_times,) array
    signals, figures : dict
        Name to (unit, meaning).
    identity : dict
    about : dict
        Attributes for people.
    """

    cases: Cases
    block: tuple[int, ...]
    times: Array
    signals: Mapping[str, tuple[str, str]]
    figures: Mapping[str, tuple[str, str]]
    identity: Mapping[str, Any]
    about: Mapping[str, Any]


class Store:
    """The results of a study, done and to come."""

    def __init__(self, group: zarr.Group, path: Path | None) -> None:
        self._group, self.path = group, path
        self._outcome = _array(group, OUTCOME)
        self._arrays = dict(group.arrays())
        self._dims = tuple(json.loads(str(group.attrs["dimensions"])))

    @classmethod
    def at(cls, path: str | PathLike[str] | None, layout: Layout, *, overwrite: bool = False) -> Store:
        """The store at a path, made where it is not there; in memory without a path.

        Raises
        ------
        ResultFileError
            Where something else is there, or another study.
        """
        if path is None:
            return cls(_created(MemoryStore(), layout), None)
        folder = Path(path)
        if folder.exists() and not _is_empty(folder):
            stored = _opened(folder)
            if not overwrite:
                return cls._continued(stored, folder, layout)
            shutil.rmtree(folder)
        elif folder.exists():
            folder.rmdir()
        # Made beside its place and renamed, so that a store is whole or not there.
        beside = folder.with_name(f".{folder.name}.{uuid.uuid4().hex}")
        folder.parent.mkdir(parents=True, exist_ok=True)
        _created(beside, layout)
        beside.rename(folder)
        return cls(_opened(folder), folder)

    @classmethod
    def _continued(cls, stored: zarr.Group, folder: Path, layout: Layout) -> Store:
        difference = differences(json.loads(str(stored.attrs[IDENTITY])), layout.identity)
        if difference:
            raise ResultFileError(
                f"{folder} holds another study: {difference}. Choose another store, or overwrite=True (--overwrite) "
                "to lose what is there"
            )
        for left in folder.rglob("*.partial"):
            left.unlink(missing_ok=True)
        return cls(stored, folder)

    @property
    def total(self) -> int:
        """How many cases there are."""
        return int(self._outcome.size)

    def pending(self) -> list[Place]:
        """Places of the blocks that are not done, in order."""
        done = np.asarray(self._outcome[...]) != ""
        return [place for place in blocks(self._outcome.shape, self._outcome.chunks) if not done[place].all()]

    def write(self, place: Place, result: BlockResult) -> None:
        """Keep the results of the block at `place`."""
        shape = tuple(part.stop - part.start for part in place)
        for name, values in result.figures.items():
            self._variable(name)[place] = values.reshape(shape)
        if result.signals.size:
            names = [str(name) for name in json.loads(str(self._group.attrs["signals"]))]
            for name, values in zip(names, result.signals, strict=True):
                self._arrays[name][place] = values.reshape(*shape, -1)
        self._arrays[MESSAGE][place] = _texts(result.messages, shape)
        self._outcome[place] = _texts(result.outcomes, shape)

    def dataset(self) -> xr.Dataset:
        """What is done, read from the store when it is used; cases that are not done have an empty outcome."""
        data = xr.open_zarr(self._group.store, consolidated=False, chunks=None)
        data = data[sorted(map(str, data.data_vars))]
        # Texts as Python has them: many tools do not know the strings of Zarr. They are few beside the signals.
        for name, entry in data.variables.items():
            if entry.dtype.kind not in "biufO":
                data[name] = entry.dims, entry.values.astype(object), entry.attrs
        return data.load() if self.path is None else data

    def _variable(self, name: str) -> zarr.Array:
        """The array of a figure; functions of one's own tell their names as they go."""
        if name not in self._arrays:
            outcome = self._outcome
            self._arrays[name] = _figure(self._group, name, self._dims, outcome.shape, outcome.chunks, "", "")
        return self._arrays[name]


def open_study(path: str | PathLike[str]) -> xr.Dataset:
    """Open the results of a study, also of one that is not done."""
    folder = Path(path)
    if not folder.exists():
        raise ResultFileError(f"no such store: {folder}")
    return Store(_opened(folder), folder).dataset()


def _array(group: zarr.Group, name: str) -> zarr.Array:
    array = group[name]
    assert isinstance(array, zarr.Array)
    return array


def _is_empty(folder: Path) -> bool:
    return folder.is_dir() and not any(folder.iterdir())


def _opened(folder: Path) -> zarr.Group:
    """The study at a path; anything else there is left alone."""
    try:
        group = zarr.open_group(folder, mode="r+")
    except (OSError, ValueError, KeyError):
        group = None
    if group is None or IDENTITY not in group.attrs:
        raise ResultFileError(f"{folder} is there and is no study; choose another path for the store")
    return group


def _created(where: Any, layout: Layout) -> zarr.Group:
    group = zarr.open_group(where, mode="w")
    cases = layout.cases
    for key, axis in zip(cases.keys, cases.axes, strict=True):
        about = {"long_name": f"key {key.name}"} | ({} if key.unit is None else {"units": key.unit or "1"})
        _coordinate(group, key.name, axis_values(axis), key.name if cases.grid else CASE, about)
    if not cases.grid:
        _coordinate(group, CASE, np.arange(cases.count), CASE, {"long_name": "number of the case"})
    for name, (unit, meaning) in layout.figures.items():
        _figure(group, name, cases.dims, cases.shape, layout.block, unit, meaning)
    if layout.signals:
        _coordinate(group, TIME, layout.times, TIME, {"units": "s", "long_name": "time"})
        shape, block = (*cases.shape, layout.times.size), (*layout.block, layout.times.size)
        for name, (unit, meaning) in layout.signals.items():
            _figure(group, name, (*cases.dims, TIME), shape, block, unit, meaning)
    for name, meaning in ((MESSAGE, "what went wrong"), (OUTCOME, "how the run ended; empty: not run yet")):
        group.create_array(
            name, shape=cases.shape, chunks=layout.block, dtype=str, fill_value="", dimension_names=cases.dims,
            attributes={"long_name": meaning},
        )  # fmt: skip
    names = {} if cases.grid else {"coordinates": " ".join(key.name for key in cases.keys)}
    lists = {"dimensions": json.dumps(cases.dims), "signals": json.dumps(list(layout.signals))}
    group.attrs.update({**layout.about, **names, **lists, IDENTITY: json.dumps(layout.identity)})
    return group


def _coordinate(group: zarr.Group, name: str, values: Any, dim: str, about: dict[str, Any]) -> None:
    array = np.asarray(values)
    if array.dtype.kind == "U":
        made = group.create_array(name, shape=array.shape, dtype=str, dimension_names=(dim,), attributes=about)
        made[:] = array.astype(object)
    else:
        group.create_array(name, data=array, dimension_names=(dim,), attributes=about)


def _figure(
    group: zarr.Group,
    name: str,
    dims: Iterable[str],
    shape: Sequence[int],
    block: Sequence[int],
    unit: str,
    meaning: str,
) -> zarr.Array:
    about: dict[str, Any] = {key: text for key, text in (("units", unit), ("long_name", meaning)) if text}
    return group.create_array(
        name, shape=tuple(shape), chunks=tuple(block), dtype="f8", fill_value=np.nan, dimension_names=tuple(dims),
        attributes=about,
    )  # fmt: skip


def _texts(values: list[str], shape: tuple[int, ...]) -> np.ndarray:
    return np.array(values, dtype=object).reshape(shape)
