"""The store of a study's results: a Zarr group, one array per variable, one chunk per block of cases.

A block's chunks are written one by one, each atomically by renaming a complete file; the chunk of `outcome` is last. So
a block is done if and only if its outcomes exist, even if the process was killed, and an incomplete block is written
again. A finished block has a chunk with a checksum in every array, also without values. Missing or changed chunks are
found when the store is opened, and computed again when the study continues.
"""

from __future__ import annotations

import json
import re
import shutil
import uuid
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
import xarray as xr
import zarr
from numpy.typing import ArrayLike
from zarr.core.common import JSON
from zarr.storage import MemoryStore, StoreLike

from hydrocrane.arrays import Array
from hydrocrane.errors import ResultFileError
from hydrocrane.files.received import readable
from hydrocrane.files.whole_file import cannot_write
from hydrocrane.studies.case import CRASHED, TIME_LIMIT, BlockResult
from hydrocrane.studies.design import CASE, Cases, Place, blocks
from hydrocrane.studies.identity import Json, differences, unknown_parts
from hydrocrane.studies.integrity import (
    AXES,
    BLOCK_ARRAYS,
    CHECKSUM,
    chunk_file,
    compressors,
    description,
    names_in,
    seal,
    study_faults,
)
from hydrocrane.studies.keys import axis_values
from hydrocrane.studies.measures import DESCRIPTION

OUTCOME, MESSAGE, TIME = "outcome", "message", "time"
# Attribute with the longest time that a case may take.
LIMIT = "time_limit"


@dataclass(frozen=True)
class Layout:
    """Data for a new store.

    Attributes
    ----------
    cases : Cases
    block : tuple of int
        Shape of a block.
    times : (n_times,) array
    signals, figures : dict
        Name to (unit, meaning).
    identity : dict
    about : dict
        Attributes for readers.
    """

    cases: Cases
    block: tuple[int, ...]
    times: Array
    signals: Mapping[str, tuple[str, str]]
    figures: Mapping[str, tuple[str, str]]
    identity: Mapping[str, Json]
    about: Mapping[str, str | int]


class Size(TypedDict):
    """Dimensions of an array, its shape, and the shape of a block."""

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    block: tuple[int, ...]


def makers(layout: Layout) -> dict[str, Callable[[zarr.Group], None]]:
    """Functions that make the arrays of a study in its group."""
    cases = layout.cases
    found: dict[str, Callable[[zarr.Group], None]] = {}
    about: dict[str, JSON]
    for key, axis in zip(cases.keys, cases.axes, strict=True):
        about = {"long_name": f"key {key.name}", **({} if key.unit is None else {"units": key.unit or "1"})}
        dim = key.name if cases.grid else CASE
        found[key.name] = partial(_coordinate, name=key.name, values=axis_values(axis), dim=dim, about=about)
    if not cases.grid:
        about = {"long_name": "number of the case"}
        found[CASE] = partial(_coordinate, name=CASE, values=np.arange(cases.count), dim=CASE, about=about)
    size: Size = {"dims": cases.dims, "shape": cases.shape, "block": layout.block}
    for name, (unit, meaning) in layout.figures.items():
        found[name] = partial(figure, name=name, unit=unit, meaning=meaning, **size)
    if layout.signals:
        about = {"units": "s", "long_name": "time"}
        found[TIME] = partial(_coordinate, name=TIME, values=layout.times, dim=TIME, about=about)
        count = layout.times.size
        longer: Size = {
            "dims": (*cases.dims, TIME), "shape": (*cases.shape, count), "block": (*layout.block, count),
        }  # fmt: skip
        for name, (unit, meaning) in layout.signals.items():
            found[name] = partial(figure, name=name, unit=unit, meaning=meaning, **longer)
    found[MESSAGE] = partial(_words, name=MESSAGE, meaning="what went wrong", **size)
    found[OUTCOME] = partial(_words, name=OUTCOME, meaning="how the run ended; empty: not run yet", **size)
    return found


def _coordinate(group: zarr.Group, name: str, values: ArrayLike, dim: str, about: dict[str, JSON]) -> None:
    array = np.asarray(values)
    words = array.dtype.kind == "U"
    made = group.create_array(
        name, shape=array.shape, chunks=array.shape, dtype=str if words else array.dtype, compressors=compressors(),
        dimension_names=(dim,), attributes=about, config={"write_empty_chunks": True},
    )  # fmt: skip
    made[:] = array.astype(object) if words else array


def figure(
    group: zarr.Group,
    name: str,
    dims: Iterable[str],
    shape: Sequence[int],
    block: Sequence[int],
    unit: str,
    meaning: str,
) -> None:
    # What a process that was killed had made of it, and not yet listed, does not count.
    about: dict[str, JSON] = {key: text for key, text in (("units", unit), ("long_name", meaning)) if text}
    group.create_array(
        name, shape=tuple(shape), chunks=tuple(block), dtype="f8", fill_value=np.nan, compressors=compressors(),
        dimension_names=tuple(dims), attributes=about, overwrite=True,
    )  # fmt: skip


def _words(
    group: zarr.Group, name: str, dims: Iterable[str], shape: Sequence[int], block: Sequence[int], meaning: str
) -> None:
    group.create_array(
        name, shape=tuple(shape), chunks=tuple(block), dtype=str, fill_value="", compressors=compressors(),
        dimension_names=tuple(dims), attributes={"long_name": meaning},
    )  # fmt: skip


# Attribute that makes a Zarr group a study.
IDENTITY = "study"
# Attribute that says what was taken on trust to be the same when the study was resumed.
TRUSTED = "resumed_on_trust"
# Ways to go on with a study in a store.
RESUME = ("same", "trust")


class StudyRepaired(UserWarning):
    """A part of a store was damaged; its cases are computed again."""


class Store:
    """The results of a study, finished and pending."""

    def __init__(self, group: zarr.Group, path: Path | None) -> None:
        self._group, self.path = group, path
        listed = group.attrs.get(BLOCK_ARRAYS)
        names = sorted(group.array_keys()) if listed is None else names_in(str(listed))
        self._block = _array(group, OUTCOME).chunks
        self._arrays = {name: self._array(name) for name in names}
        self._outcome = self._arrays[OUTCOME]
        self._dims = tuple(json.loads(str(group.attrs["dimensions"])))
        self._signals = [str(name) for name in json.loads(str(group.attrs["signals"]))]

    @classmethod
    def at(
        cls, path: str | PathLike[str] | None, layout: Layout, *, overwrite: bool = False, resume: str = "same"
    ) -> Store:
        """The store at a path, which is made if it does not exist; in memory without a path.

        With ``resume="trust"`` what has no digest is taken to be the same as before, and the store says so.

        Only one process at a time may open it, see :func:`hydrocrane.studies.integrity.written_by_one`.

        Raises
        ------
        ResultFileError
            If the path has something else or another study, or cannot be written.
        """
        if path is None:
            return cls(_created(MemoryStore(), layout), None)
        folder = Path(path)
        try:
            _sweep_remains(folder)
            if folder.exists() and not _is_empty(folder):
                with readable(folder, "a study that can go on"):
                    stored = _opened(folder)
                    if not overwrite:
                        return cls._continued(stored, folder, layout, resume)
            _put(folder, layout)
        except OSError as error:
            raise cannot_write(folder, error) from None
        return cls(_opened(folder), folder)

    @classmethod
    def _continued(cls, stored: zarr.Group, folder: Path, layout: Layout, resume: str) -> Store:
        difference = differences(json.loads(str(stored.attrs[IDENTITY])), layout.identity)
        if difference:
            raise ResultFileError(
                f"{folder} holds another study: {difference}. Choose another store, or overwrite=True (--overwrite) "
                "to lose what is there"
            )
        if CHECKSUM not in stored.attrs:
            raise ResultFileError(
                f"{folder} was written without checksums, by an earlier version; choose another store, or "
                "overwrite=True (--overwrite) to compute it again"
            )
        for left in folder.rglob("*.partial*"):
            left.unlink(missing_ok=True)
        _repair(folder, layout)
        if unknown := unknown_parts(layout.identity):
            if resume != "trust":
                raise ResultFileError(
                    f'{folder} may hold another study: {unknown}. If it is the same, give resume="trust" (--resume '
                    "trust), which the store then says; else choose another store, or overwrite=True (--overwrite)"
                )
            seal(folder, **{TRUSTED: unknown})
        kept = cls(_opened(folder), folder)
        again = {CRASHED}
        if stored.attrs.get(LIMIT) != layout.about[LIMIT]:
            again.add(TIME_LIMIT)
            seal(folder, **{LIMIT: str(layout.about[LIMIT])})
        kept._forget(again)
        return kept

    @property
    def total(self) -> int:
        """Number of cases."""
        return int(self._outcome.size)

    def pending(self) -> list[Place]:
        """Indices of the blocks that are not done, in order."""
        return [place for place in self._places() if not self._is_done(place)]

    def write(self, place: Place, result: BlockResult) -> None:
        """Store the results of the block at `place`."""
        shape = tuple(part.stop - part.start for part in place)
        for name in result.figures:
            self._make_sure_of(name)
        for name, array in self._arrays.items():
            if name in (OUTCOME, MESSAGE):
                continue
            if name in self._signals:
                array[place] = result.signals[self._signals.index(name)].reshape(*shape, -1)
            else:
                array[place] = result.figures.get(name, np.full(shape, np.nan)).reshape(shape)
        self._arrays[MESSAGE][place] = _texts(result.messages, shape)
        self._outcome[place] = _texts(result.outcomes, shape)

    def dataset(self) -> xr.Dataset:
        """The finished results, read from the store on use; cases that are not done have an empty outcome."""
        with readable(Path(str(self.path)), "a study that can be read"):
            data = xr.open_zarr(self._group.store, consolidated=False, chunks=None)
            data = data[sorted(name for name in self._arrays if name in data.data_vars)]
            # Texts as Python strings, because many tools do not support the strings of Zarr. They are few compared with
            # the signals.
            for name, entry in data.variables.items():
                if self.path is None and name in self._arrays:
                    data[name] = entry.dims, self._arrays[str(name)], entry.attrs
                elif entry.dtype.kind not in "biufO":
                    data[name] = entry.dims, entry.values.astype(object), entry.attrs
        for attributes in (data.attrs, *(entry.attrs for entry in data.variables.values())):
            attributes.pop(CHECKSUM, None)
        return data.load() if self.path is None else data

    def _places(self) -> Iterable[Place]:
        return blocks(self._outcome.shape, self._block)

    def _is_done(self, place: Place) -> bool:
        if self.path is None:
            return bool((np.asarray(self._outcome[place]) != "").all())
        return self._file_of(place).exists()

    def _forget(self, outcomes: set[str]) -> None:
        """Cases with these outcomes are to be computed again, with those of their blocks."""
        for place in self._places():
            if self._is_done(place) and outcomes.intersection(np.asarray(self._outcome[place]).ravel().tolist()):
                self._file_of(place).unlink(missing_ok=True)

    def _array(self, name: str) -> zarr.Array[Any] | np.ndarray:
        """Where the results of this name are kept; in memory a plain array: Zarr takes 6 ms of one core per block."""
        array = _array(self._group, name)
        if self.path is not None:
            return array
        if name in (MESSAGE, OUTCOME):
            return np.full(array.shape, "", dtype=object)
        return np.full(array.shape, np.nan)

    def _file_of(self, place: Place) -> Path:
        index = tuple(part.start // step for part, step in zip(place, self._block, strict=True))
        return chunk_file(Path(str(self.path)) / OUTCOME, index)

    def _make_sure_of(self, name: str) -> None:
        """Makes the array of a figure if it is missing; your own functions define their names when they run."""
        if name in self._arrays:
            return
        figure(self._group, name, self._dims, self._outcome.shape, self._block, "", "")
        made = self._array(name)
        for place in self._places():
            if self._is_done(place):
                made[place] = np.full([part.stop - part.start for part in place], np.nan)
        self._arrays[name] = made
        listed = json.dumps(list(self._arrays))
        if self.path is None:
            self._group.attrs[BLOCK_ARRAYS] = listed
        else:
            # Listed when it is complete; an array that is not listed does not count.
            seal(self.path / name)
            seal(self.path, **{BLOCK_ARRAYS: listed})


def open_study(path: str | PathLike[str]) -> xr.Dataset:
    """Open the results of a study, also of an unfinished one.

    Every finished block is checked first.

    Raises
    ------
    ResultFileError
        If there is no study, or if a part of it is missing or changed; the message names it.

    Warns
    -----
    UserWarning
        If the store has no checksums because an earlier version wrote it; damage cannot be detected then.

    Examples
    --------
    >>> loads = {"payload.mass": [0.0, 50.0]}
    >>> _ = hc.sweep("vertical-lift-open-loop", loads, measures=["max(tip.z)"], store="loads", duration=1.0)
    >>> print(dict(hc.open_study("loads").sizes))
    {'payload.mass': 2}
    """
    folder = Path(path)
    if not folder.exists():
        raise ResultFileError(f"no such store: {folder}")
    with readable(folder, "a study that can be read"):
        stored = _opened(folder)
        if CHECKSUM not in stored.attrs:
            odd = [name for name in stored if description(folder / name) is None]
            if odd:
                raise ResultFileError(f"{folder} is damaged: {odd[0]}/{DESCRIPTION} was cut off or changed")
            text = f"{folder} has no checksums, since an earlier version wrote it: damage cannot be detected; "
            warnings.warn(f"{text}run the study again with overwrite=True (--overwrite) to have them", stacklevel=2)
        elif faults := study_faults(folder, OUTCOME):
            raise ResultFileError(
                f"{folder} is damaged: {faults}. Run the same study with this store again: it computes the damaged "
                "blocks again and keeps the others"
            )
        return Store(stored, folder).dataset()


def _array(group: zarr.Group, name: str) -> zarr.Array[Any]:
    """An array that writes every chunk, so that a missing chunk is known to be lost."""
    array = group[name]
    assert isinstance(array, zarr.Array)
    return array.with_config({"write_empty_chunks": True})


def _is_empty(folder: Path) -> bool:
    return folder.is_dir() and not any(folder.iterdir())


def _opened(folder: Path) -> zarr.Group:
    """The study at a path; anything else is not changed."""
    if (folder / DESCRIPTION).exists() and description(folder) is None:
        raise ResultFileError(
            f"{folder} is damaged: its {DESCRIPTION} was cut off or changed, so it is unknown which study it "
            "holds. Copy it back from elsewhere, or delete the folder and run the study again"
        )
    try:
        group = zarr.open_group(folder, mode="r+", zarr_format=3)
    except (OSError, ValueError, KeyError):
        group = None
    if group is None or IDENTITY not in group.attrs:
        raise ResultFileError(f"{folder} exists and is not a study; choose another path for the store")
    return group


def _beside(folder: Path) -> Path:
    return folder.with_name(f".{folder.name}.{uuid.uuid4().hex}")


def _sweep_remains(folder: Path) -> None:
    """Remove temporary files of a killed process that made or replaced this store."""
    pattern = re.compile(rf"\.{re.escape(folder.name)}\.[0-9a-f]{{32}}")
    if folder.parent.is_dir():
        for left in folder.parent.iterdir():
            if pattern.fullmatch(left.name):
                shutil.rmtree(left, ignore_errors=True)


def _put(folder: Path, layout: Layout) -> None:
    """Make a store at a temporary path and rename it, so that no incomplete store exists."""
    made, old = _beside(folder), _beside(folder)
    folder.parent.mkdir(parents=True, exist_ok=True)
    try:
        _created(made, layout)
        for name in makers(layout):
            seal(made / name)
        seal(made)
        if folder.exists():
            folder.rename(old)
        made.rename(folder)
    finally:
        shutil.rmtree(made, ignore_errors=True)
        shutil.rmtree(old, ignore_errors=True)


def _repair(folder: Path, layout: Layout) -> None:
    """Make damaged arrays again, and mark damaged blocks as not done."""
    faults = study_faults(folder, OUTCOME)
    if not faults:
        return
    group, known, listed = _opened(folder), makers(layout), json.loads(str(_opened(folder).attrs[BLOCK_ARRAYS]))
    for place in faults.blocks:
        chunk_file(folder / OUTCOME, place).unlink(missing_ok=True)
    if any(name in listed for name in faults.arrays):
        # A damaged array loses its part of each block.
        shutil.rmtree(folder / OUTCOME / "c", ignore_errors=True)
    seal(folder, **{BLOCK_ARRAYS: json.dumps([n for n in listed if n in known or n not in faults.arrays])})
    for name in faults.arrays:
        if (folder / name).is_symlink():
            (folder / name).unlink()
        shutil.rmtree(folder / name, ignore_errors=True)
        if name in known:
            known[name](group)
            seal(folder / name)
    warnings.warn(StudyRepaired(f"{folder}: {faults}; the cases concerned are computed again"), stacklevel=2)


def _created(where: StoreLike, layout: Layout) -> zarr.Group:
    group = zarr.open_group(where, mode="w")
    known, cases = makers(layout), layout.cases
    for make in known.values():
        make(group)
    kept = [*layout.figures, *layout.signals, MESSAGE, OUTCOME]
    names = {} if cases.grid else {"coordinates": " ".join(key.name for key in cases.keys)}
    lists = {
        "dimensions": cases.dims, "signals": list(layout.signals),
        BLOCK_ARRAYS: kept, AXES: [name for name in known if name not in kept],
    }  # fmt: skip
    plain = {name: json.dumps(value) for name, value in lists.items()}
    group.attrs.update({**layout.about, **names, **plain, IDENTITY: json.dumps(layout.identity)})
    return group


def _texts(values: list[str], shape: tuple[int, ...]) -> np.ndarray:
    return np.array(values, dtype=object).reshape(shape)
