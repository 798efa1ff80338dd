"""Files from elsewhere: only regular ones, and no more of them in memory than a log or a run has."""

from __future__ import annotations

import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hydrocrane.errors import HydrocraneError, ResultFileError

# Most numbers of one log or run, half a gigabyte of doubles: five hours of ten signals at 370 Hz.
MOST_VALUES = 2**26
# Largest file, bytes. Formats without a number of values before reading have limits of their own.
LARGEST = 2**32


def received(
    path: Path, most: int = LARGEST, kind: type[HydrocraneError] = ResultFileError, what: str = "file"
) -> Path:
    """`path`, if it is a regular file of at most `most` bytes; `what` is its kind in messages.

    A pipe may never end or never begin, and reading a device may do something.

    Raises
    ------
    HydrocraneError
        Of that `kind`: with the path, the reason and the cure.
    """
    try:
        found = path.stat()
    except FileNotFoundError:
        raise kind(f"no such {what}: {path}") from None
    except (OSError, ValueError) as error:  # A path with a zero byte, or of letters that no file system has.
        raise kind(f"cannot read {path}: {getattr(error, 'strerror', None) or error}; check the path") from None
    if stat.S_ISDIR(found.st_mode):
        raise kind(f"{path} is a folder; name a file in it")
    if not stat.S_ISREG(found.st_mode):
        raise kind(f"{path} is a pipe, a socket or a device; copy its content to a file")
    if found.st_size > most:
        raise kind(f"{path} has {found.st_size >> 20} MiB, more than {most >> 20}; is it the right file? {SHORTER}")
    return path


SHORTER = "Keep the signals that are needed, or a part of the time"


def check_values(path: Path, count: int) -> None:
    """Refuse to read more than `MOST_VALUES` numbers of a file.

    Raises
    ------
    ResultFileError
        With both numbers and the cure.
    """
    if count > MOST_VALUES:
        raise ResultFileError(f"{path} states {count:.3g} numbers, more than {MOST_VALUES:.3g} are read. {SHORTER}")


@contextmanager
def readable(path: Path, what: str) -> Iterator[None]:
    """Turns whatever a library raises for a damaged file into one error; `what` is ``a NetCDF file``, for example."""
    try:
        yield
    except HydrocraneError:
        raise
    except MemoryError:
        raise ResultFileError(f"{path} needs more memory than there is. {SHORTER}") from None
    except Exception as error:  # Many kinds, most of them built-in ones.
        reason = str(error) or type(error).__name__
        raise ResultFileError(
            f"{path} is damaged, or not {what}: {reason}; copy it again, or check its suffix"
        ) from None


def plain(text: str) -> str:
    """A text that was no UTF-8, with marks in place of what cannot be written."""
    return text.encode("utf-8", "replace").decode()
