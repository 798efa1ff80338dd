"""HTML views for notebooks, made of the lines of the text form, and progress bars."""

from __future__ import annotations

import html
import re
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

# Most bytes and rows of a card, about a screen; its last lines are left out.
LONGEST = 20_000
TALLEST = 60
# Interval for updates of a bar, s.
PAUSE = 0.2
DOUBT = re.compile(r"^\s*warning\b", re.IGNORECASE)
# A label at the left, separated by two or more spaces in the text form.
LABELLED = re.compile(r"^ {0,4}(?P<label>\S+(?: \S+)*) {2,}(?P<rest>\S.*)$")


def card(title: str, lines: Sequence[str], whole: str = "") -> str:
    """A heading with a row per line: label and value if a line has both. All text is escaped.

    Lines beyond 60 or 20 kB are left out, with a last row that states their number and how to print them all: `whole`.
    """
    head = f'<div class="hydrocrane"><strong>{html.escape(title)}</strong><table>'
    foot = "</table></div>"
    rows = [_row(line) for line in lines if line.strip()]
    more = "<tr><td colspan='2'>and {} more lines" + (f": {html.escape(whole)}" if whole else "") + "</td></tr>"
    room = LONGEST - len((head + foot + more).encode()) - 20
    kept = 0
    while kept < min(len(rows), TALLEST) and (room := room - len(rows[kept].encode())) >= 0:
        kept += 1
    left = more.format(len(rows) - kept) if kept < len(rows) else ""
    return head + "".join(rows[:kept]) + left + foot


def of_text(text: str, whole: str) -> str:
    """A card of a text; its first line is the heading."""
    first, *lines = text.splitlines() or [""]
    return card(first, lines, whole)


def _row(line: str) -> str:
    style = "text-align:left" + (";color:#c8553d" if DOUBT.match(line) else "")
    labelled = LABELLED.match(line)
    if labelled is None:
        return f'<tr><td colspan="2" style="{style}">{html.escape(line.strip())}</td></tr>'
    label, rest = (html.escape(labelled[name]) for name in ("label", "rest"))
    return f'<tr><th style="{style}">{label}</th><td style="{style}">{rest}</td></tr>'


def in_notebook() -> bool:
    """Whether this program runs in a notebook."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return type(shell).__name__ == "ZMQInteractiveShell"


@contextmanager
def progress_bar(title: str) -> Iterator[Callable[..., None]]:
    """A bar below the cell, of plain HTML: those of rich and tqdm would need the package ipywidgets.

    Returns a function of (done, total) and a text, if wanted; the bar disappears at the end.
    """
    from IPython.display import HTML, display

    def drawn(done: int, total: int, text: str = "") -> object:
        words = html.escape(f"{title}: {done} of {total} {text}")
        return HTML(f'<progress value="{done}" max="{max(total, 1)}" style="vertical-align:middle"></progress> {words}')

    shown = display(drawn(0, 0), display_id=True)
    last = time.monotonic() - PAUSE

    def update(done: int, total: int, text: str = "") -> None:
        nonlocal last
        if time.monotonic() - last >= PAUSE or done >= total:
            shown.update(drawn(done, total, text))
            last = time.monotonic()

    try:
        yield update
    finally:
        shown.update(HTML(""))
