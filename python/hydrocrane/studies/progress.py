"""Progress of a study and its remaining time."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from hydrocrane.notebook import in_notebook, progress_bar

# Called with (cases done, all cases).
Progress = Callable[[int, int], None]


@contextmanager
def telling(progress: Progress | bool | None, title: str) -> Iterator[Progress]:
    """A function of (done, total): `progress` itself, a bar, or no output.

    By default there is a bar in notebooks and if stderr is a terminal.
    """
    if callable(progress):
        yield progress
    elif progress is not False and in_notebook():
        with progress_bar(title) as update:
            yield update
    elif progress is False or (progress is None and not sys.stderr.isatty()):
        yield lambda done, total: None
    else:
        with _bar(title) as update:
            yield update


@contextmanager
def _bar(title: str) -> Iterator[Progress]:
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
    )
    with Bar(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task(title, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
