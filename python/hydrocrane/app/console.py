"""Where the command line writes: results to stdout, errors to stderr, a bar for long work."""

from __future__ import annotations

import os
import re
import sys
import textwrap
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from hydrocrane.errors import printable

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.table import Table


def _console(*, stderr: bool = False, width: int | None = None) -> Console:
    """A console for texts from files: square brackets are no markup, and nothing in them controls the terminal."""
    from rich.console import Console

    plain = Console(stderr=stderr, width=width, highlight=False, markup=False, emoji=False)
    taken = plain.render_str
    plain.render_str = lambda text, **how: taken(printable(text), **how)  # type: ignore[method-assign]
    return plain


def say(*parts: RenderableType) -> None:
    """Print strings and rich objects, one per line."""
    from rich.table import Table

    # A pipe has no width of its own; tables need room for their columns.
    console = _console(width=None if _has_width() else 150)
    for part in parts:
        if isinstance(part, str):
            console.print(_wrapped(part, console), soft_wrap=True)
        else:
            console.print(_fitted(part, console) if isinstance(part, Table) else part)


def _has_width(*, stderr: bool = False) -> bool:
    return "COLUMNS" in os.environ or (sys.stderr if stderr else sys.stdout).isatty()


def _wrapped(text: str, console: Console, *, stderr: bool = False) -> str:
    """A text within the width, where there is one; words, so paths, and lines quoted from files stay whole."""
    if not _has_width(stderr=stderr):
        return text
    return "\n".join(line if _QUOTED.match(line) else _line(line, console.width) for line in text.split("\n"))


# A line of a file: as errors show it, with carets under it, or to be copied.
_QUOTED = re.compile(r" *\d* \| |[\w.-]+ = ")
# What stands before the text of a line: a word in a column of its own, or spaces.
_LABEL = re.compile(r" *\S+  +| *")


def _line(line: str, width: int) -> str:
    """One line; what follows stands under its text, if that leaves half the width."""
    if len(line) <= width:
        return line
    column = len(line) - len(_LABEL.sub("", line, count=1))
    column = column if column <= width // 2 else 0
    indent = " " * (column or 2)
    parts = textwrap.wrap(line[column:], width - len(indent), break_long_words=False, break_on_hyphens=False)
    return line[:column] + f"\n{indent}".join(parts)


def plain_table(
    *headings: str, left: Sequence[str] = (), title: str | None = None, collapse_padding: bool = False
) -> Table:
    """A table without lines; the columns `left` are texts, the others numbers."""
    from rich.table import Table

    table = Table(
        title=title,
        title_justify="left",
        box=None,
        pad_edge=False,
        header_style="bold",
        collapse_padding=collapse_padding,
    )
    for heading in headings:
        table.add_column(heading, justify="left" if heading in left else "right")
    return table


def _fitted(table: Table, console: Console) -> Table:
    """The table, or where its columns would break words, each of its rows as a block of headings and values."""
    from rich.table import Table
    from rich.text import Text

    # A measure is cut to the width that it is given: only a very wide one tells what the words need.
    needed = console.measure(table, options=console.options.update(width=10_000))
    if needed.maximum <= console.width:
        return table
    if needed.minimum <= console.width:
        # What is too little is taken from the column with the most room, and from none below its longest word.
        texts = [[str(cell) for cell in (column.header, *column.cells)] for column in table.columns]
        least = [max(len(word) for text in of for word in text.split() or [""]) for of in texts]
        widths = [max(len(line) for text in of for line in text.splitlines() or [""]) for of in texts]
        for _ in range(needed.maximum - console.width):
            roomiest = max(range(len(widths)), key=lambda at: widths[at] - least[at])
            widths[roomiest] -= 1
        for column, width in zip(table.columns, widths, strict=True):
            column.min_width = column.max_width = width
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
    _printed("error: ", "bold red", message)


def warn(message: str, *, stderr: bool = True) -> None:
    """Print one warning, to stderr unless it is what was asked for."""
    _printed("warning: ", "bold yellow", message, stderr=stderr)


def _printed(kind: str, style: str, message: str, *, stderr: bool = True) -> None:
    from rich.text import Text

    console = _console(stderr=stderr)
    text = Text(_wrapped(kind + printable(message), console, stderr=stderr))
    text.stylize(style, 0, len(kind))
    console.print(text, soft_wrap=True)


@contextmanager
def waiting(what: str) -> Iterator[None]:
    """A spinner on a terminal, nothing in a pipe."""
    from rich.text import Text

    with _console(stderr=True).status(Text(what)):
        yield


@contextmanager
def reporting() -> Iterator[Callable[[str], None]]:
    """A spinner on a terminal; nothing in a pipe; gives a function to be called with what is being done."""
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn())
    console = _console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task("", total=None)
        yield lambda text: progress.update(task, description=printable(text))


@contextmanager
def bar(what: str) -> Iterator[Callable[[int, int], None]]:
    """A progress bar; gives a function to be called with (done, in all)."""
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=_console(stderr=True), transient=True) as progress:
        task = progress.add_task(printable(what), total=None)
        yield lambda done, total: progress.update(task, completed=done + 1, total=total)
