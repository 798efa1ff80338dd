"""Integrity of a store on disk: checksums of its chunks and of its descriptions.

Each chunk ends with a CRC-32C (codec `crc32c` of Zarr), which other programs check too. Zarr has no checksum for
``zarr.json``, so each such file has a digest of its other content among its attributes.
"""

from __future__ import annotations

import hashlib
import itertools
import json
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

import google_crc32c
from zarr.codecs import Crc32cCodec, ZstdCodec

from hydrocrane.files.whole_file import write_text

# Attribute with the digest of a description.
CHECKSUM = "checksum"
# Attributes of the group: the arrays with a chunk per block, and the common ones.
BLOCK_ARRAYS, AXES = "block_arrays", "axes"
DESCRIPTION = "zarr.json"
_CRC_BYTES = 4
_MISSING, _CHANGED = "is missing", "was cut off or changed"
# Most damaged files that a message names.
_SHOWN = 5


class ChunkShape(TypedDict):
    chunk_shape: list[int]


class ChunkGrid(TypedDict):
    configuration: ChunkShape


class Description(TypedDict):
    """The fields of the ``zarr.json`` of a group or array that are used."""

    attributes: dict[str, str]
    shape: list[int]
    chunk_grid: ChunkGrid


def compressors() -> tuple[ZstdCodec, Crc32cCodec]:
    """The codecs of every array: the checksum is last, so it covers the bytes of the file."""
    return ZstdCodec(), Crc32cCodec()


def seal(node: Path, **attributes: str) -> None:
    """Set attributes of a group's or an array's description together with the digest of the whole, in one step."""
    file = node / DESCRIPTION
    content: Description = json.loads(file.read_text(encoding="utf-8"))
    content["attributes"] |= attributes
    content["attributes"][CHECKSUM] = _digest(content)
    write_text(file, json.dumps(content, indent=2))


def description(node: Path) -> Description | None:
    """The description of a group or array; None if it cannot be read or does not match its digest."""
    try:
        content: Description = json.loads((node / DESCRIPTION).read_text(encoding="utf-8"))
        stated = content["attributes"].get(CHECKSUM)
        return content if stated is None or stated == _digest(content) else None
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return None


@dataclass(frozen=True)
class Faults:
    """The damage of a store.

    Attributes
    ----------
    arrays : dict
        Arrays with a damaged description, or with damaged values outside all blocks, and the finding.
    blocks : dict
        Index of each damaged block, and the findings in its chunks.
    count : int
        Number of blocks.
    """

    arrays: dict[str, str]
    blocks: dict[tuple[int, ...], list[str]]
    count: int

    def __bool__(self) -> bool:
        return bool(self.arrays or self.blocks)

    def __str__(self) -> str:
        found = [*self.arrays.values(), *itertools.chain(*self.blocks.values())]
        more = [f"and {len(found) - _SHOWN} more"] if len(found) > _SHOWN else []
        head = f"{len(self.blocks)} of {self.count} blocks damaged: " if self.blocks else ""
        return head + ", ".join([*found[:_SHOWN], *more])


def study_faults(folder: Path, outcome: str) -> Faults:
    """Check every finished block of a study, and all its descriptions.

    Parameters
    ----------
    folder : Path
        A store with a valid description.
    outcome : str
        The array whose chunk is written last; without this chunk a block is not finished.
    """
    own = description(folder)
    assert own is not None, "a store is checked once its own description is found sound"
    about = own["attributes"]
    names, axes = json.loads(about[BLOCK_ARRAYS]), json.loads(about[AXES])
    read = {name: description(folder / name) for name in [*names, *axes]}
    arrays = {name: _description_fault(folder / name) for name, content in read.items() if content is None}
    known = {name: content for name, content in read.items() if content is not None}
    for name in axes:
        faults = _chunk_faults(folder / name, _grid(known[name])) if name in known else []
        arrays |= {name: ", ".join(faults)} if faults else {}
    if outcome not in known:
        return Faults(arrays, {}, 0)
    places = _grid(known[outcome])
    blocks: dict[tuple[int, ...], list[str]] = {}
    for place in places:
        if chunk_file(folder / outcome, place).exists():
            # Signals have one more dimension, which is not divided into blocks.
            indices = {name: place + (0,) * (len(known[name]["shape"]) - len(place)) for name in names if name in known}
            faults = [fault for name, index in indices.items() for fault in _chunk_faults(folder / name, [index])]
            blocks |= {place: faults} if faults else {}
    return Faults(arrays, blocks, len(places))


def chunk_file(array: Path, place: tuple[int, ...]) -> Path:
    """The file of a chunk."""
    return array.joinpath(*_chunk(place))


def _chunk(index: tuple[int, ...]) -> list[str]:
    return ["c", *map(str, index)]


def _grid(content: Description) -> list[tuple[int, ...]]:
    chunk = content["chunk_grid"]["configuration"]["chunk_shape"]
    counts = [range(-(-length // step)) for length, step in zip(content["shape"], chunk, strict=True)]
    return list(itertools.product(*counts))


def _description_fault(array: Path) -> str:
    file = array / DESCRIPTION
    return f"{array.name}/{DESCRIPTION} {_CHANGED if file.exists() else _MISSING}"


def _chunk_faults(array: Path, indices: list[tuple[int, ...]]) -> list[str]:
    """Faults of the chunks of the array in a folder, each with its name."""
    faults = []
    for index in indices:
        try:
            raw = chunk_file(array, index).read_bytes()
            sound = len(raw) > _CRC_BYTES and _crc(raw[:-_CRC_BYTES]) == raw[-_CRC_BYTES:]
            reason = "" if sound else _CHANGED
        except FileNotFoundError:
            reason = _MISSING
        except OSError as error:
            reason = f"cannot be read ({error.strerror})"
        if reason:
            faults.append(f"{'/'.join([array.name, *_chunk(index)])} {reason}")
    return faults


def _crc(raw: bytes) -> bytes:
    return int(google_crc32c.value(raw)).to_bytes(_CRC_BYTES, "little")


def _digest(content: Description) -> str:
    attributes = {name: value for name, value in content["attributes"].items() if name != CHECKSUM}
    text = json.dumps({**content, "attributes": attributes}, sort_keys=True)
    return f"sha256 {hashlib.sha256(text.encode()).hexdigest()}"
