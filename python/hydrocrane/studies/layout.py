"""The arrays of a study in its Zarr group."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypedDict

import numpy as np
import zarr
from numpy.typing import ArrayLike
from zarr.core.common import JSON

from hydrocrane.arrays import Array
from hydrocrane.studies.design import CASE, Cases
from hydrocrane.studies.identity import Json
from hydrocrane.studies.integrity import compressors
from hydrocrane.studies.values import axis_values

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
