"""How far a study is, and what its workers compute at present, in a file that outlives them.

Each worker has a row: the number of its case plus one, zero when it rests, and when it began. The file is mapped into
memory, so a case costs two stores, and the operating system keeps them when a process is killed. The next process that
opens the store reads there which cases were under way, and how often a process has ended with them.
"""

from __future__ import annotations

import mmap
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Protocol

import numpy as np

from hydrocrane.notebook import in_notebook, progress_bar
from hydrocrane.studies.case import KILLED, BlockTask, CaseResult, Watch
from hydrocrane.studies.design import Cases, Place

# Called with (cases done, all cases).
Progress = Callable[[int, int], None]


class Tell(Protocol):
    """Tells how far a study is; with `running`, only what is computed at present."""

    def __call__(self, done: int, total: int, running: str | None = None) -> None: ...


@contextmanager
def telling(progress: Progress | bool | None, title: str) -> Iterator[Tell]:
    """How a study tells how far it is: by `progress`, by a bar, or not at all.

    By default there is a bar in notebooks and if stderr is a terminal.
    """
    if callable(progress):
        yield _without_running(progress)
    elif progress is not False and in_notebook():
        with progress_bar(title) as update:
            yield _named(update)
    elif progress is False or (progress is None and not sys.stderr.isatty()):
        yield _without_running(lambda done, total: None)
    else:
        with _bar(title) as update:
            yield _named(update)


def _without_running(progress: Progress) -> Tell:
    def tell(done: int, total: int, running: str | None = None) -> None:
        if running is None:
            progress(done, total)

    return tell


def _named(update: Callable[[int, int, str], None]) -> Tell:
    def tell(done: int, total: int, running: str | None = None) -> None:
        update(done, total, running or "")

    return tell


@contextmanager
def _bar(title: str) -> Iterator[Callable[[int, int, str], None]]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("done in"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        TextColumn("{task.fields[running]}", markup=False),
    )
    with Bar(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task(title, total=None, running="")
        yield lambda done, total, running: bar.update(task, completed=done, total=total, running=running)


ROW = np.dtype([("case", "<i8"), ("since", "<f8"), ("deaths", "<i8")])
# A case is not run again after as many ends of its process.
TRIES = 2
# More of a file that was left there is not read, bytes.
LARGEST = 2**20


class Board:
    """The rows of the workers; `path` is what another process opens.

    Attributes
    ----------
    deaths : dict
        Number of a case to how often a process ended with it.
    """

    def __init__(self, path: Path, deaths: dict[int, int] | None = None) -> None:
        self.path, self.deaths = path, deaths or {}
        with path.open("r+b") as file:
            self._map = mmap.mmap(file.fileno(), 0)
        self._rows = np.frombuffer(self._map, dtype=ROW)

    def begin(self, row: int, case: int) -> None:
        self._rows[row] = (case + 1, time.time(), 0)

    def end(self, row: int) -> None:
        self._rows["case"][row] = 0

    def at(self, row: int) -> tuple[int, float] | None:
        """The case of a worker, and for how long it has computed it, s; None when it rests."""
        case, since, deaths = self._rows[row].item()
        return (case - 1, max(time.time() - since, 0.0)) if case and not deaths else None

    def longest(self) -> tuple[int, float] | None:
        """The case that is computed for the longest time, and that time, s."""
        found = [entry for row in range(len(self._rows)) if (entry := self.at(row)) is not None]
        return max(found, key=lambda entry: entry[1], default=None)

    def died(self, row: int) -> int | None:
        """Note that the process of a worker ended; the case that it ended with, None between cases."""
        entry = self.at(row)
        self.end(row)
        if entry is None:
            return None
        self.deaths[entry[0]] = self.deaths.get(entry[0], 0) + 1
        return entry[0]

    def close(self) -> None:
        del self._rows
        # A worker that is being stopped may still hold a view of it.
        with suppress(BufferError):
            self._map.close()


class OnBoard(Watch):
    """A watch that keeps a row of a board."""

    def __init__(self, board: Board, row: int, stopped: Callable[[], bool]) -> None:
        self._board, self._row, self._stopped = board, row, stopped

    def begin(self, case: int) -> None:
        self._board.begin(self._row, case)

    def end(self) -> None:
        self._board.end(self._row)

    def stopped(self) -> bool:
        return self._stopped()


def killed(times: int, how: str = "") -> CaseResult:
    """The result of a case with which a process ended too often."""
    return CaseResult(KILLED, f"the process ended {times} times while this case was computed{how}; it is left out")


def task_of(cases: Cases, place: Place, board: Board | None = None) -> BlockTask:
    """The cases of a block; those with which too many processes ended are not run."""
    numbers = cases.numbers(place)
    deaths = {} if board is None else board.deaths
    given = {case: killed(deaths[case]) for case in numbers if deaths.get(case, 0) >= TRIES}
    return BlockTask(cases.values(place), numbers, given)


@contextmanager
def board_of(store: Path | None, workers: int) -> Iterator[Board]:
    """The board of a study beside its store, removed at the end; in a temporary file without a store or where the file
    system has no mapped files.

    What the process before left there, if it was killed, is counted. Call it while the store is locked.
    """
    beside = None if store is None else Path(os.path.abspath(store)).with_name(f".{store.name}.running")
    deaths = {} if beside is None else _deaths(beside)
    rows = np.zeros(workers + len(deaths), dtype=ROW)
    for row, (case, count) in zip(rows[workers:], deaths.items(), strict=True):
        row["case"], row["deaths"] = case + 1, count
    board = _board(beside, rows.tobytes(), deaths)
    try:
        yield board
    finally:
        board.close()
        with suppress(OSError):
            board.path.unlink()


def _board(beside: Path | None, content: bytes, deaths: dict[int, int]) -> Board:
    if beside is not None:
        with suppress(OSError):
            # Processes that outlived the one before may still write into its file.
            beside.unlink(missing_ok=True)
            beside.write_bytes(content)
            return Board(beside, deaths)
    descriptor, name = tempfile.mkstemp(prefix="study-")
    with os.fdopen(descriptor, "wb") as file:
        file.write(content)
    return Board(Path(name), deaths)


def _deaths(left: Path) -> dict[int, int]:
    """How often a process ended with a case, by the board that it left."""
    try:
        with left.open("rb") as file:
            raw = file.read(LARGEST)
    except OSError:
        return {}
    found: dict[int, int] = {}
    for case, _, deaths in np.frombuffer(raw[: len(raw) // ROW.itemsize * ROW.itemsize], dtype=ROW).tolist():
        if case > 0:
            found[case - 1] = found.get(case - 1, 0) + max(deaths, 0) + (deaths == 0)
    return found
