"""``hydrocrane sweep``: run a study from a file."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from hydrocrane.app.arguments import headless, number
from hydrocrane.app.console import complain, plain_table, say
from hydrocrane.result_warning import DoubtfulResult

if TYPE_CHECKING:
    import xarray as xr
    from rich.table import Table

    from hydrocrane.scenario.changes import RunChanges
    from hydrocrane.studies import Study

# Messages of failed cases that are printed.
SHOWN_FAILURES = 5


def sweep(
    study: Annotated[str, typer.Argument(help="Study file.", metavar="STUDY")],
    store: Annotated[
        Path | None, typer.Option(help="Folder for the results; by default the study's own, or named after it.")
    ] = None,
    workers: Annotated[int | None, number("Cases at a time; by default one per core.", int)] = None,
    scheduler: Annotated[
        str | None, typer.Option(help="`threads`, `processes`, or a Dask scheduler, e.g. tcp://host:8786.")
    ] = None,
    time_limit: Annotated[
        str | None, typer.Option(help="Longest time of a case by the clock, e.g. `5 min`.", metavar="TIME")
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Start again; the contents of the store are lost.")
    ] = False,
    resume: Annotated[
        str, typer.Option(help="`trust`: also if nobody can tell that your own code is the same as before.")
    ] = "same",
    record_limit: Annotated[str | None, typer.Option(help="Most memory of a record; default is 2 GB.")] = None,
    picture: Annotated[Path | None, typer.Option(help="Also draw a figure against the keys, into this file.")] = None,
    measure: Annotated[str | None, typer.Option(help="Which figure to draw; by default the first.")] = None,
) -> None:
    """Run a scenario for many values of some keys; a study that was stopped goes on where it was."""
    from hydrocrane.studies import StudyInterrupted, load_study

    file = load_study(study)
    if record_limit is not None:
        changes = {**file.study.changes, "record_limit": record_limit}
        file = replace(file, study=replace(file.study, changes=cast("RunChanges", changes)))
    folder = store or file.store
    # A picture that cannot be drawn shall not cost the runs.
    drawn = _pictured(file.study, measure, picture) if picture is not None else None
    try:
        with warnings.catch_warnings():
            # The table of outcomes says it.
            warnings.filterwarnings("ignore", ".*cases have no results", DoubtfulResult)
            data = file.study.run(
                folder, overwrite=overwrite, resume=resume, workers=workers, scheduler=scheduler, time_limit=time_limit
            )
    except StudyInterrupted as stopped:
        complain(str(stopped))
        raise typer.Exit(1) from None
    say(outcome_table(data), *failures(data))
    written = [folder]
    if picture is not None and drawn is not None:
        written.append(_draw(data, drawn, picture))
    say("written:", *(f"  {path}" for path in written))


def _pictured(study: Study, measure: str | None, picture: Path) -> str:
    """The figure to draw, once it is known that its picture can be written."""
    from hydrocrane.plots.style import checked_suffix

    checked_suffix(picture)
    return study.pictured(measure)


def outcome_table(data: xr.Dataset) -> Table:
    """How many cases ended how."""
    import numpy as np

    outcomes, counts = np.unique(data["outcome"].values.astype(str), return_counts=True)
    table = plain_table("outcome", "cases", "share", left=("outcome",))
    for i in np.argsort(-counts, kind="stable"):
        table.add_row(str(outcomes[i]), str(counts[i]), f"{counts[i] / counts.sum():.1%}")
    return table


def failures(data: xr.Dataset) -> list[str]:
    """What went wrong, each message once, with how often it came."""
    import numpy as np

    texts, counts = np.unique(data["message"].values.astype(str), return_counts=True)
    found = [(int(count), str(text)) for count, text in zip(counts, texts, strict=True) if text]
    found.sort(key=lambda entry: -entry[0])
    lines = [f"{count} x {text}" for count, text in found[:SHOWN_FAILURES]]
    more = len(found) - SHOWN_FAILURES
    return [*lines, *([f"and {more} more messages; `message` in the store has them all"] if more > 0 else [])]


def _draw(data: xr.Dataset, measure: str, path: Path) -> Path:
    headless()
    from hydrocrane import plots
    from hydrocrane.plots.style import write

    return write(plots.sweep(data, measure), path)
