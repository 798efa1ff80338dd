"""Atomic writing of files: to a temporary file in the same folder, which is then renamed. No file is ever
incomplete."""

from __future__ import annotations

import errno
import os
import uuid
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from hydrocrane.errors import ResultFileError, nearest

# Cures for the usual failures.
_CURES = {
    errno.ENOSPC: "free some space or choose another folder",
    errno.EDQUOT: "free some of your quota or choose another folder",
    errno.EFBIG: "choose a file system that takes larger files, or write less",
    errno.EACCES: "choose a folder that you may write to",
    errno.EPERM: "choose a folder that you may write to",
    errno.EROFS: "choose a folder that you may write to",
    errno.EISDIR: "choose a name that is no folder",
    errno.ENOTDIR: "a part of this path is a file; choose another folder",
    errno.EEXIST: "a part of this path is a file; choose another folder",
    errno.ENAMETOOLONG: "choose a shorter name",
}


@contextmanager
def written_whole(path: str | os.PathLike[str]) -> Iterator[Path]:
    """The path to write to in place of `path`, in the same folder and with the same suffix; missing folders are made.

    If the block ends without an error, the file replaces `path` in one step. Otherwise the file is removed and `path`
    is unchanged. A device or a pipe is written to directly.

    Raises
    ------
    ResultFileError
        In place of an ``OSError``: with file, reason and cure.
    """
    target = Path(path)
    try:
        if target.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(target))
        target.parent.mkdir(parents=True, exist_ok=True)
        # The target of a link is written, not the link.
        place = target.resolve() if target.is_symlink() else target
        if place.exists() and not place.is_file():
            yield place
            return
        beside = place.with_name(f".{place.stem[:60]}.{uuid.uuid4().hex}.partial{place.suffix}")
        try:
            yield beside
            _settle(beside)
            if place.exists():
                # Who may read and write the file is not ours to change.
                beside.chmod(place.stat().st_mode)
            beside.replace(place)
        finally:
            beside.unlink(missing_ok=True)
    except OSError as error:
        raise cannot_write(target, error) from None


def checked_suffix(path: Path, known: Collection[str]) -> str:
    """The suffix of a file, or an error that names the `known` ones."""
    suffix = path.suffix.lower()
    if suffix not in known:
        raise ResultFileError(f"cannot write `{path.name}`: unknown suffix `{suffix}`{nearest(suffix, known)}")
    return suffix


def write_text(path: str | os.PathLike[str], text: str) -> Path:
    """Write `text` as UTF-8, line ends unchanged, atomically. Returns the path."""
    with written_whole(path) as beside:
        beside.write_text(text, encoding="utf-8", newline="")
    return Path(path)


def cannot_write(path: Path, error: OSError) -> ResultFileError:
    """The error for a file that the system refuses to write."""
    cure = _CURES.get(error.errno or 0, "")
    reason = error.strerror or str(error)
    return ResultFileError(f"cannot write `{path}`: {reason}{cure and f'; {cure}'}")


def _settle(path: Path) -> None:
    """Wait until the file is on the disk: some systems report a full disk only then."""
    with path.open("r+b") as stream:
        os.fsync(stream.fileno())
