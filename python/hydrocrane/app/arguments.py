"""What commands share: arguments, what these name, and the pictures that are written."""

from __future__ import annotations

import math
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrocrane.app.console import say, waiting

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from typer.models import OptionInfo

    from hydrocrane.machine.machine import Machine
    from hydrocrane.results.run import Run


def number(help: str, kind: type = float, least: float = -math.inf, most: float = math.inf) -> OptionInfo:
    """An option that is a number as in a file: an underscore, which Python would take, is a misprint."""

    def read(text: str) -> float:
        from hydrocrane.units import plain_number

        try:
            plain_number(str(text))
            value: float = kind(text)
        except ValueError:
            value = math.nan
        if least <= value <= most:
            return value
        ends = f"{least:g} to {most:g}" if most < math.inf else f"{least:g} or more"
        of = "" if least == -math.inf else f", {ends}"
        raise typer.BadParameter(f"`{text}` is not {'a whole' if kind is int else 'a'} number{of}")

    option: OptionInfo = typer.Option(help=help, parser=read, metavar=f"<{kind.__name__}>")
    return option


def choice(kind: type[StrEnum], help: str) -> OptionInfo:
    """An option that is one of a few words; a misspelt one is told the nearest."""

    def read(text: str) -> StrEnum:
        from hydrocrane.errors import nearest

        try:
            return kind(str(text))
        except ValueError:
            raise typer.BadParameter(f"`{text}` is none of its choices{nearest(text, kind)}") from None

    metavar = f"<{'|'.join(kind)}>"
    option: OptionInfo = typer.Option(help=help, parser=read, metavar=metavar, autocompletion=lambda: list(kind))
    return option


MachineName = Annotated[str, typer.Argument(help="Bundled machine or path of a machine file.", metavar="MACHINE")]
RunName = Annotated[str, typer.Argument(help="Saved run (.nc), bundled scenario or scenario file.", metavar="RUN")]
Settings = Annotated[
    list[str], typer.Option("--set", help='Override a machine key: KEY=VALUE, e.g. supply.pressure="100 bar".')
]
Payload = Annotated[float | None, number("Mass at the tip, kg.")]
Output = Annotated[
    Path | None, typer.Option("-o", "--output", help="File to write; by default named after the target, here.")
]


def named_machine(source: str, settings: list[str]) -> Machine:
    from hydrocrane.app.options import checked_machine, overrides
    from hydrocrane.machine.machine import load_machine

    return load_machine(checked_machine(source), overrides(settings))


def named_run(source: str, settings: list[str]) -> Run:
    """A saved run, or a scenario run now."""
    import hydrocrane as hc
    from hydrocrane.app.options import checked_scenario, overrides
    from hydrocrane.errors import InputError

    if source.endswith(".nc"):
        if settings:
            raise InputError("--set changes a simulation; a saved run stays as it is")
        return hc.load_run(source)
    with waiting("simulating"):
        return hc.simulate(checked_scenario(source), overrides=overrides(settings))


def headless() -> None:
    """Pictures go to files: ask matplotlib for no windows."""
    import matplotlib as mpl

    mpl.use("Agg")


def picture_path(output: Path | None, default: str) -> Path:
    """Where a picture goes; a suffix that cannot be written is an error before anything is computed."""
    from hydrocrane.plots.style import checked_suffix

    return checked_suffix(output or Path(default))


def write_figure(figure: Figure, path: Path) -> None:
    from hydrocrane.plots.style import write

    write(figure, path)
    say(f"written: {path}")
