"""Where the command line writes: results to stdout, errors to stderr, a bar for long work."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.table import Table


def say(*parts: RenderableType) -> None:
    """Print strings and rich objects, one per line."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    # A pipe has no width of its own; tables need room for their columns.
    wide = None if sys.stdout.isatty() or "COLUMNS" in os.environ else 150
    console = Console(highlight=False, width=wide)
    for part in parts:
        # Plain strings may hold square brackets, which must not be read as markup.
        shown = _fitted(part, console) if isinstance(part, Table) else part
        console.print(Text(shown) if isinstance(shown, str) else shown, soft_wrap=isinstance(shown, str))


def _fitted(table: Table, console: Console) -> Table:
    """The table, or where its columns would break words, each of its rows as a block of headings and values."""
    from rich.table import Table
    from rich.text import Text

    # A measure is cut to the width that it is given: only a very wide one tells what the words need.
    if console.measure(table, options=console.options.update(width=10_000)).minimum <= console.width:
        # Columns share what is too little by their widths; none may fall below its longest word.
        for column in table.columns:
            words = " ".join(str(cell) for cell in (column.header, *column.cells)).split()
            column.min_width = max(map(len, words), default=0)
        return table
    blocks = Table(title=table.title, title_justify="left", box=None, pad_edge=False, show_header=False)
    blocks.add_column(style="bold", no_wrap=True)
    blocks.add_column(overflow="fold")
    rows = list(zip(*(list(column.cells) for column in table.columns), strict=True))
    for at, row in enumerate(rows):
        if at:
            blocks.add_row("", "")
        for column, cell in zip(table.columns, row, strict=True):
            blocks.add_row(Text(str(column.header)), cell)
    return blocks


def complain(message: str) -> None:
    """Print one error to stderr, its lines and carets kept as they are."""
    from rich.console import Console
    from rich.text import Text

    Console(stderr=True, highlight=False).print(Text.assemble(("error: ", "bold red"), message), soft_wrap=True)


def warn(message: str) -> None:
    """Print one warning to stderr."""
    from rich.console import Console
    from rich.text import Text

    Console(stderr=True, highlight=False).print(Text.assemble(("warning: ", "bold yellow"), message), soft_wrap=True)


@contextmanager
def waiting(what: str) -> Iterator[None]:
    """A spinner on a terminal, nothing in a pipe."""
    from rich.console import Console

    with Console(stderr=True).status(what):
        yield


@contextmanager
def reporting() -> Iterator[Callable[[str], None]]:
    """A spinner on a terminal; nothing in a pipe; gives a function to be called with what is being done."""
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn())
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task("", total=None)
        yield lambda text: progress.update(task, description=text)


@contextmanager
def bar(what: str) -> Iterator[Callable[[int, int], None]]:
    """A progress bar; gives a function to be called with (done, in all)."""
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(what, total=None)
        yield lambda done, total: progress.update(task, completed=done + 1, total=total)
