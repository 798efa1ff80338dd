"""A lock for the single process that writes to a store: a lock of the operating system on a file beside it.

The system releases such a lock when its process ends in any way, so no stale lock remains. A file with a process number
could be stale.
"""

from __future__ import annotations

import os
import platform
import sys
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from hydrocrane.errors import ResultFileError
from hydrocrane.files.whole_file import cannot_write

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
