"""What a fit says as text: pieces of a machine file, rows of tables, and a report in one HTML file."""

from __future__ import annotations

import base64
import datetime
import html
import io
import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from hydrocrane.arrays import checked_name
from hydrocrane.errors import ResultFileError, printable
from hydrocrane.files.toml_file import toml_key
from hydrocrane.files.whole_file import write_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def comment(text: str) -> str:
    """A line of comment, whatever the names in it hold."""
    return f"# {printable(' '.join(text.splitlines()))}"


def fitted_key(name: str, value: str, source: str, ends: str) -> str:
    """A key with its value in the notation of machine files, where it comes from, and its interval as a comment."""
    stated = json.dumps(source, ensure_ascii=False)
    return f'{name} = {{ value = {value}, class = "fitted", source = {stated} }}  # 95 %: {ends}'


def write_part(path: str | PathLike[str], text: Callable[[str], str]) -> Path:
    """Write a part of a machine file; `text` makes it for the name of the file."""
    target = Path(path)
    if target.suffix != ".toml":
        raise ResultFileError(f"a part of a machine file ends in .toml, unlike `{target.name}`")
    return write_text(target, text(target.name))


def head(name: str, cylinder: str, source: str, model: str) -> list[str]:
    """The first lines of the block of a fit."""
    return [
        f"[friction.{toml_key(checked_name('the name of a friction table', name))}]",
        'class = "fitted"',
        f"source = {json.dumps(source, ensure_ascii=False)}",
        f"cylinder = {json.dumps(cylinder, ensure_ascii=False)}",
        f"model = {json.dumps(model)}",
    ]


def signature(date: str = "") -> str:
    """Program, version and day of the fit; today by default."""
    from hydrocrane import __version__

    return f"hydrocrane {__version__}, {date or datetime.date.today().isoformat()}"


def interval(low: float, high: float) -> str:
    """An interval as a block's comments show it: from zero, the bound of a positive quantity, by its upper end only."""
    if not np.isfinite([low, high]).all():
        return "not identifiable"
    return f"not determined, at most {high:.4g}" if low == 0.0 else f"{low:.4g} .. {high:.4g}"


def shown(value: float, low: float, high: float) -> str:
    """A value beside its interval. Rounding errors of zero, where only a prior or a bound determines a value, are shown
    as zero."""
    return "0" if abs(value) < 1e-6 * max(abs(low), abs(high)) else f"{value:.4g}"


def parameter_row(label: str, unit: str, value: float, low: float, high: float) -> tuple[str, str, str, str, str]:
    """A row of a table: parameter, unit, value, both ends of its interval."""
    if not (np.isfinite(low) and np.isfinite(high)):
        return (label, unit, "-", "not identifiable", "")
    if low == 0.0:
        return (label, unit, "not determined", "0", f"{high:.4g}")
    return (label, unit, shown(value, low, high), f"{low:.4g}", f"{high:.4g}")


# A drawing with more points, such as the curves of a whole log, is embedded as pixels, this many per inch.
MOST_POINTS, RESOLUTION = 3000, 110

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #22313f; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.2rem; margin-top: 2.2rem; border-bottom: 1px solid #e4e7eb; }
nav ul { columns: 2; padding-left: 1.2rem; } nav .failed { color: #c8553d; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: .2rem .7rem; border-bottom: 1px solid #e4e7eb; }
th:first-child, td:first-child { text-align: left; }
/* A table wider than the page scrolls by itself. */
.table { overflow-x: auto; }
img { max-width: 100%; } pre { background: #f5f7f9; padding: .8rem; overflow-x: auto; }
.warnings { border-left: 4px solid #e08e2b; padding: .1rem 1rem; background: #fdf6ec; }
.failure { border-left: 4px solid #c8553d; padding: .1rem 1rem; background: #fbeeea; }
"""


@dataclass(frozen=True)
class Table:
    """Headings and rows of text; the first column names the row."""

    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Section:
    """One part of a report; empty fields are left out.

    Attributes
    ----------
    text : str
        Plain text, an empty line between paragraphs.
    warnings : tuple of str
        Limits of the results of this section.
    code : str
        A block to be copied, as for a machine file.
    failure : str
        Why the stage failed.
    """

    title: str
    text: str = ""
    table: Table | None = None
    figure: Figure | None = None
    warnings: tuple[str, ...] = ()
    code: str = ""
    failure: str = ""

    def html(self, anchor: str) -> str:
        """The section as HTML; all text is escaped."""
        parts = [f'<section id="{anchor}"><h2>{html.escape(self.title)}</h2>']
        if self.failure:
            parts.append(f'<div class="failure"><p>Not finished: {html.escape(self.failure)}</p></div>')
        parts += [f"<p>{html.escape(p)}</p>" for p in self.text.split("\n\n") if p.strip()]
        if self.warnings:
            items = "".join(f"<li>{html.escape(w)}</li>" for w in self.warnings)
            parts.append(f'<div class="warnings"><ul>{items}</ul></div>')
        if self.table is not None:
            parts.append(_table(self.table))
        if self.figure is not None:
            parts.append(f'<img alt="{html.escape(self.title, quote=True)}" src="{_picture(self.figure)}">')
        if self.code:
            parts.append(f"<pre>{html.escape(self.code)}</pre>")
        return "\n".join([*parts, "</section>"])


# A title, and the function that makes its section.
Stage: TypeAlias = tuple[str, Callable[[], Section]]


@dataclass
class Report:
    """A report that grows with each stage.

    A failed stage appears with its message, and the report continues.
    """

    title: str
    introduction: str = ""
    sections: list[Section] = field(default_factory=list)

    def add(self, *sections: Section) -> None:
        """Append finished sections."""
        self.sections += sections

    def stage(self, title: str, make: Callable[[], Section | Iterable[Section]]) -> bool:
        """Append the section that `make` returns, or its error under `title`; true if it succeeded."""
        try:
            made = make()
            self.add(*([made] if isinstance(made, Section) else made))
        except (ValueError, ArithmeticError) as error:
            self.add(Section(title, failure=str(error) or type(error).__name__))
            return False
        return True

    @property
    def failures(self) -> list[str]:
        """Titles of the failed stages."""
        return [s.title for s in self.sections if s.failure]

    def html(self) -> str:
        """The whole page."""
        title = html.escape(self.title)
        entries = "".join(_entry(i, section) for i, section in enumerate(self.sections, 1))
        body = "\n".join(section.html(f"s{i}") for i, section in enumerate(self.sections, 1))
        introduction = f"<p>{html.escape(self.introduction)}</p>" if self.introduction else ""
        return (
            f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
            f"<style>{STYLE}</style></head>\n<body><h1>{title}</h1>{introduction}\n<nav><ul>{entries}</ul></nav>\n"
            f"{body}\n</body></html>\n"
        )

    def write(self, path: str | Path) -> Path:
        """Write the page as one self-contained file."""
        target = Path(path)
        if target.suffix.lower() not in (".html", ".htm"):
            raise ResultFileError(f"a report is written as HTML: `{target.name}` should end in .html")
        return write_text(target, self.html())


def _entry(number: int, section: Section) -> str:
    mark = ' class="failed"' if section.failure else ""
    note = " (not finished)" if section.failure else ""
    return f'<li{mark}><a href="#s{number}">{html.escape(section.title)}</a>{note}</li>'


def _table(table: Table) -> str:
    head = "".join(f"<th>{html.escape(h)}</th>" for h in table.headings)
    rows = "".join(f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>" for row in table.rows)
    return f'<div class="table"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'


def _picture(figure: Figure) -> str:
    """A picture as a data URL, so that its names do not collide with those of the page: vectors, or pixels if these are
    far smaller."""
    from matplotlib.lines import Line2D

    dense = sum(np.size(line.get_xdata()) for line in figure.findobj(Line2D)) > MOST_POINTS
    drawn, kind = io.BytesIO(), "png" if dense else "svg"
    figure.savefig(drawn, format=kind, dpi=RESOLUTION, metadata={} if dense else {"Date": None})
    mime = "image/png" if dense else "image/svg+xml"
    return f"data:{mime};base64,{base64.b64encode(drawn.getvalue()).decode('ascii')}"
