"""Progress of a study and its remaining time."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

from hydrocrane.notebook import in_notebook, progress_bar

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
