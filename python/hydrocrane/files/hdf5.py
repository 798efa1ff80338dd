"""HDF5 files from elsewhere: what the file itself holds, within a budget.

An HDF5 file can name other files, whose bytes HDF5 then hands out as values; state sizes that no disk has; and link its
groups to each other in circles. None of it is followed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TypeAlias

import h5py
import numpy as np

from hydrocrane.errors import ResultFileError
from hydrocrane.files.received import check_values, plain

Node: TypeAlias = "h5py.Group | h5py.Dataset"

# Most groups, values and links that are visited, and most groups inside each other.
MOST_OBJECTS, DEEPEST = 20_000, 50
# Numbers that are read in the time that a chunk takes.
CHUNK = 256
# Most bytes of a single text or attribute.
LONGEST = 2**24
# Most texts without a fixed length in one attribute: each may be as long as the file.
MOST_TEXTS = 64


class Hdf5Walk:
    """One way through a file: through each group once, whatever links lead to it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._objects = self._values = 0
        self._seen: set[int] = set()

    def members(self, group: h5py.Group, level: int = 0) -> Iterator[tuple[str, Node]]:
        """Names and members of a group. Links are left out where what they name has another name."""
        self.count(level, len(group))
        self._seen.add(h5py.h5o.get_info(group.id).addr)
        for name in group:
            link = group.get(name, getlink=True)
            if isinstance(link, h5py.ExternalLink):
                raise self._outside(f"{group.name}/{name}", link.filename)
            member = group[name] if isinstance(link, h5py.HardLink) else None
            if isinstance(member, h5py.Group) and h5py.h5o.get_info(member.id).addr in self._seen:
                continue
            if isinstance(member, h5py.Group | h5py.Dataset):
                yield plain(name), member

    def count(self, level: int, more: int = 1) -> None:
        """So many more objects, at a level.

        Raises
        ------
        ResultFileError
            If there are too many, or too many inside each other.
        """
        self._objects += more
        if self._objects > MOST_OBJECTS or level > DEEPEST:
            most = f"{MOST_OBJECTS} members" if level <= DEEPEST else f"{DEEPEST} levels of groups"
            raise ResultFileError(f"{self.path} has more than {most}; export the signals alone")

    def fixed(self, dataset: h5py.Dataset) -> bool:
        """Whether the values of a dataset can be read: they are here, not too many, and each has a fixed length.

        Raises
        ------
        ResultFileError
            If they are in another file, or too many.
        """
        if dataset.is_virtual or dataset.external:
            raise self._outside(dataset.name, (dataset.external or [["?"]])[0][0])
        try:
            kind = dataset.dtype
        except TypeError:  # A type that NumPy does not have.
            return False
        size, chunk = dataset.size or 0, int(np.prod(dataset.chunks or (0,), dtype=object))
        # A chunk is unpacked whole, however few of its values count.
        self._values += max(size, chunk) * max(1, kind.itemsize // 8) + (CHUNK * size // chunk if chunk else 0)
        check_values(self.path, self._values)
        return dataset.size is not None and (dataset.shape == () or _of_fixed_length(kind))

    def _outside(self, name: str | None, file: object) -> ResultFileError:
        text = f"{self.path} keeps `{name}` in another file, `{file}`, and is not followed there"
        return ResultFileError(f"{text}; export it into one file, for example with h5repack")


def check_content(path: Path) -> list[str]:
    """Check a whole file before another reader opens it; names of members of its root that are better left out.

    These are links, and texts without a fixed length.

    Raises
    ------
    ResultFileError
        As for :class:`Hdf5Walk`.
    """
    walk = Hdf5Walk(path)
    with h5py.File(path, "r") as stored:
        unread = [str(name) for name in stored if not isinstance(stored.get(name, getlink=True), h5py.HardLink)]
        _check_attributes(walk, stored)
        _check_group(walk, stored, unread, 0)
    return unread


def _check_group(walk: Hdf5Walk, group: h5py.Group, unread: list[str], level: int) -> None:
    for name, member in walk.members(group, level):
        _check_attributes(walk, member)
        if isinstance(member, h5py.Group):
            _check_group(walk, member, unread, level + 1)
        elif not walk.fixed(member) and not level:
            unread.append(name)


def _check_attributes(walk: Hdf5Walk, node: Node) -> None:
    walk.count(0, len(node.attrs))
    for name in node.attrs:
        stated = node.attrs.get_id(name)
        size = int(np.prod(stated.shape, dtype=object))
        if name in SCALES and not SCALES[name](stated.dtype):
            raise ResultFileError(f"{walk.path} is damaged: the attribute `{name}` of `{node.name}` is none of HDF5")
        if size * stated.dtype.itemsize > LONGEST or (size > MOST_TEXTS and not _of_fixed_length(stated.dtype)):
            raise ResultFileError(f"{walk.path} has an attribute `{plain(name)}` of {size} values; remove it")


def _is_text(kind: np.dtype) -> bool:
    return h5py.check_string_dtype(kind) is not None


def _is_list(kind: np.dtype) -> bool:
    """Whether values are lists of references."""
    inner = h5py.check_vlen_dtype(kind)
    return inner is not None and refers(inner)


def _is_place(kind: np.dtype) -> bool:
    """Whether values are a reference with a number, as HDF5 notes where a scale is used."""
    parts = [part[0] for part in (kind.fields or {}).values()]
    return len(parts) == 2 and refers(parts[0]) and parts[1].kind in "iu"


# Attributes by which HDF5 finds dimensions, and what they are: it reads others as these, beyond their end.
SCALES: Mapping[str, Callable[[np.dtype], bool]] = {
    "DIMENSION_LIST": _is_list,
    "REFERENCE_LIST": _is_place,
    **dict.fromkeys(("DIMENSION_LABELS", "CLASS", "NAME"), _is_text),
}


def attributes(node: Node) -> Mapping[str, object]:
    """The single texts and numbers among the attributes, and pairs of numbers, such as bounds."""
    stated = {name: node.attrs.get_id(name) for name in list(node.attrs)[:MOST_OBJECTS]}
    single = [
        name
        for name, a in stated.items()
        if (a.shape in ((), (1,)) and a.dtype.itemsize <= LONGEST) or (a.shape == (2,) and a.dtype.kind in "iuf")
    ]
    found = {plain(name): node.attrs[name] for name in single}
    return {name: plain(value) if isinstance(value, str) else value for name, value in found.items()}


def _of_fixed_length(kind: np.dtype) -> bool:
    parts = [part[0] for part in (kind.fields or {}).values()]
    return all(map(_of_fixed_length, parts)) if parts else not kind.hasobject or refers(kind)


def refers(kind: np.dtype) -> bool:
    """Whether values are references to other members."""
    return h5py.check_ref_dtype(kind) is h5py.Reference
