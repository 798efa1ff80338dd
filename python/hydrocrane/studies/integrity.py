"""What keeps a store whole: a lock for its one writer, checksums of its chunks and descriptions.

The system releases such a lock when its process ends in any way, so no stale lock remains. A file with a process number
could be stale.

Each chunk ends with a CRC-32C (codec `crc32c` of Zarr), which other programs check too. Zarr has no checksum for
``zarr.json``, so each such file has a digest of its other content among its attributes.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import os
import platform
import sys
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

import google_crc32c
from zarr.codecs import Crc32cCodec, ZstdCodec

from hydrocrane.errors import ResultFileError
from hydrocrane.files.received import MOST_VALUES, received
from hydrocrane.files.whole_file import cannot_write, write_text
from hydrocrane.studies.measures import DESCRIPTION, is_unfit

# On Windows other processes cannot read locked bytes, so a byte far behind the text is locked.
_BEYOND = 1 << 30


@contextmanager
def written_by_one(store: Path | None) -> Iterator[None]:
    """Prevent other processes from writing to the store at a path.

    Raises
    ------
    ResultFileError
        If another process writes to it; the message has its number.
    """
    place = None if store is None else Path(os.path.abspath(store))
    if place is None or not place.name:
        yield
        return
    file = place.with_name(f".{place.name}.lock")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        descriptor = _locked(file)
    except OSError as error:
        raise cannot_write(file, error) from None
    if descriptor is None:
        raise ResultFileError(f"{store} is being written by {_holder(file)}; wait for it, or choose another store")
    try:
        yield
    finally:
        _release(file, descriptor)


def _locked(file: Path) -> int | None:
    """An open descriptor of the locked file, or None if another process has the lock."""
    while True:
        descriptor = os.open(file, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            if not _taken(descriptor):
                os.close(descriptor)
                return None
            # The previous owner may have removed the file between opening and locking it here.
            with suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(descriptor), os.stat(file)):
                    _sign(descriptor)
                    return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)


def _taken(descriptor: int) -> bool:
    if sys.platform == "win32":
        import msvcrt

        os.lseek(descriptor, _BEYOND, os.SEEK_SET)
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True
    import fcntl

    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError as error:
        warnings.warn(f"this file system has no locks ({error.strerror}): start no second sweep on it", stacklevel=2)
    return True


def _sign(descriptor: int) -> None:
    os.ftruncate(descriptor, 0)
    os.lseek(descriptor, 0, os.SEEK_SET)
    text = f"process {os.getpid()} on {platform.node()} since {time.strftime('%Y-%m-%d %H:%M:%S')}"
    os.write(descriptor, text.encode())


def _holder(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8", errors="replace") or "another process"
    except OSError:
        return "another process"


def _release(file: Path, descriptor: int) -> None:
    # On POSIX the file is removed while it is locked. Windows refuses to remove an open file, also one that the next
    # process has opened.
    if sys.platform != "win32":
        file.unlink(missing_ok=True)
    os.close(descriptor)
    if sys.platform == "win32":
        with suppress(OSError):
            file.unlink()


# Attribute with the digest of a description.
CHECKSUM = "checksum"
# Attributes of the group: the arrays with a chunk per block, and the common ones.
BLOCK_ARRAYS, AXES = "block_arrays", "axes"
_CRC_BYTES = 4
_MISSING, _CHANGED = "is missing", "was cut off or changed"
# Largest description, bytes; most chunks of an array; and the codecs of arrays and those that Zarr adds by itself.
LARGEST, MOST_CHUNKS, CODECS = 2**24, 2**20, {"bytes", "vlen-utf8", "zstd", "crc32c"}
# Most damaged files that a message names.
_SHOWN = 5


class ChunkShape(TypedDict):
    chunk_shape: list[int]


class ChunkGrid(TypedDict):
    configuration: ChunkShape


class Codec(TypedDict):
    name: str


class StoreDescription(TypedDict):
    """The fields of the ``zarr.json`` of a group or array that are used; a group has the first two."""

    node_type: str
    attributes: dict[str, str]
    data_type: str
    codecs: list[Codec]
    shape: list[int]
    chunk_grid: ChunkGrid


def compressors() -> tuple[ZstdCodec, Crc32cCodec]:
    """The codecs of every array: the checksum is last, so it covers the bytes of the file."""
    return ZstdCodec(), Crc32cCodec()


def seal(node: Path, **attributes: str) -> None:
    """Set attributes of a group's or an array's description together with the digest of the whole, in one step."""
    file = node / DESCRIPTION
    content: StoreDescription = json.loads(file.read_text(encoding="utf-8"))
    content["attributes"] |= attributes
    content["attributes"][CHECKSUM] = _digest(content)
    write_text(file, json.dumps(content, indent=2))


def description(node: Path) -> StoreDescription | None:
    """The description of a group or array; None if it cannot be read, does not match its digest, or states what no
    study has."""
    try:
        content: StoreDescription = json.loads(received(node / DESCRIPTION, LARGEST).read_text(encoding="utf-8"))
        stated = content["attributes"].get(CHECKSUM)
        return content if stated in (None, _digest(content)) and _is_own(content) else None
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return None


def _is_own(content: StoreDescription) -> bool:
    """Whether an array is unpacked by the codecs of studies alone, to no more than is read at once."""
    if content["node_type"] != "array":
        return True
    shape, chunk = content["shape"], content["chunk_grid"]["configuration"]["chunk_shape"]
    if min(chunk, default=1) < 1:
        return False
    parts = math.prod(-(-length // step) for length, step in zip(shape, chunk, strict=True))
    at_once = math.prod(shape if content["data_type"] == "string" else chunk)
    codecs = {codec["name"] for codec in content["codecs"]}
    return codecs <= CODECS and parts <= MOST_CHUNKS and at_once <= MOST_VALUES


def names_in(text: str) -> list[str]:
    """The names of arrays in an attribute of a group; each is that of a folder in its own."""
    found: list[str] = json.loads(text)
    for name in found:
        if is_unfit(name):
            raise ResultFileError(f"a study has no array `{name}`: its name would be a path; delete the store")
    return found


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
    names, axes = names_in(about[BLOCK_ARRAYS]), names_in(about[AXES])
    read = {name: None if (folder / name).is_symlink() else description(folder / name) for name in [*names, *axes]}
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


def _grid(content: StoreDescription) -> list[tuple[int, ...]]:
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
            if not chunk_file(array, index).exists():
                raise FileNotFoundError
            raw = received(chunk_file(array, index)).read_bytes()
            sound = len(raw) > _CRC_BYTES and _crc(raw[:-_CRC_BYTES]) == raw[-_CRC_BYTES:]
            reason = "" if sound and _unpacked(raw) <= 8 * MOST_VALUES else _CHANGED
        except FileNotFoundError:
            reason = _MISSING
        except ResultFileError as error:
            reason = f"cannot be read ({error})"
        except OSError as error:
            reason = f"cannot be read ({error.strerror})"
        if reason:
            faults.append(f"{'/'.join([array.name, *_chunk(index)])} {reason}")
    return faults


def _unpacked(raw: bytes) -> float:
    """The number of bytes that a chunk states it unpacks to, for which room is made (RFC 8878, 3.1.1.1)."""
    if len(raw) < 5 or raw[:4] != b"\x28\xb5\x2f\xfd":
        return math.inf
    single, size = raw[4] >> 5 & 1, raw[4] >> 6
    at = 5 + (1 - single) + (0, 1, 2, 4)[raw[4] & 3]
    width = (single, 2, 4, 8)[size]
    return int.from_bytes(raw[at : at + width], "little") if width else math.inf


def _crc(raw: bytes) -> bytes:
    return int(google_crc32c.value(raw)).to_bytes(_CRC_BYTES, "little")


def _digest(content: StoreDescription) -> str:
    attributes = {name: value for name, value in content["attributes"].items() if name != CHECKSUM}
    text = json.dumps({**content, "attributes": attributes}, sort_keys=True)
    return f"sha256 {hashlib.sha256(text.encode()).hexdigest()}"
