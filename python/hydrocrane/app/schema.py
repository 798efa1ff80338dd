"""``hydrocrane schema``: what editors must know of machine and scenario files."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from hydrocrane.app.console import say


class FileKind(StrEnum):
    machine = "machine"
    scenario = "scenario"


def schema(
    kind: Annotated[FileKind, typer.Argument(help="Kind of file.")] = FileKind.machine,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="File to write; by default it is printed.")
    ] = None,
) -> None:
    """Print or write the JSON Schema of machine or scenario files, for completion and hover in editors."""
    from hydrocrane import _core
    from hydrocrane.files.whole_file import write_text

    text = _core.json_schema(kind.value)
    if output is None:
        print(text, end="")
    else:
        say(f"written: {write_text(output, text)}")
