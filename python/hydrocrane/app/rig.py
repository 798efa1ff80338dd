"""``hydrocrane rig``: the virtual friction rig."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrocrane.app.arguments import Settings, number
from hydrocrane.app.console import plain_table, say, waiting

if TYPE_CHECKING:
    from rich.table import Table

    from hydrocrane.rig import RigLog
    from hydrocrane.rig.running import RunSettings

rig = typer.Typer(name="rig", help="The virtual friction rig.", no_args_is_help=True)


@rig.callback()
def _group() -> None:
    """The virtual friction rig."""


@rig.command(name="list", epilog="Example:  hydrocrane rig list")
def list_experiments() -> None:
    """List the experiments and the rigs."""
    from hydrocrane.machine.machine import bundled_machines
    from hydrocrane.rig.experiments import EXPERIMENTS

    width = max(len(name) for name in EXPERIMENTS)
    say(*(f"{name:{width}}  {about.title}" for name, about in EXPERIMENTS.items()))
    say("", f"rigs: {', '.join(name for name in bundled_machines() if name.startswith('rig-'))}")


@rig.command(name="run", epilog="Example:  hydrocrane rig run constant-velocity --payload 20 --seed 3 -o log.csv")
def run_experiment(
    experiment: Annotated[str, typer.Argument(help="Name of the experiment; `hydrocrane rig list` shows them.")],
    machine: Annotated[str, typer.Option("--rig", help="Bundled rig or path of a machine file.")] = "rig-rottne",
    output: Annotated[Path, typer.Option("-o", "--output", help="Log: .csv, .mat, .nc, .h5 or .mf4.")] = Path(
        "log.csv"
    ),
    payload: Annotated[float | None, number("Load on the rod, kg.")] = None,
    supply: Annotated[str | None, typer.Option(help='Supply pressure with its unit, e.g. "100 bar".')] = None,
    seed: Annotated[int, number("Seed of the sensors' errors.", int)] = 0,
    sensors: Annotated[str, typer.Option(help="data-sheet or ideal.")] = "data-sheet",
    bits: Annotated[int | None, number("Resolution of the converters.", int)] = None,
    load_cell: Annotated[bool, typer.Option("--load-cell/--no-load-cell", help="Log the force on the rod.")] = True,
    calibration: Annotated[float, number("Seconds at zero pressure before the run.")] = 0.0,
    slips: Annotated[
        float | None, number("Length of each level, in slips of the bristles; of constant-velocity.")
    ] = None,
    settings: Settings = [],  # noqa: B006
) -> None:
    """Run an experiment and write what the sensors read; one file per load or pressure where these are varied."""
    from hydrocrane import rig as rigs
    from hydrocrane.app.options import overrides
    from hydrocrane.logs.writers import checked_suffix
    from hydrocrane.rig.experiments import experiment as known

    # Neither a wrong name nor a wrong suffix shall cost the run.
    known(experiment)
    checked_suffix(output)
    how: RunSettings = {"seed": seed, "sensors": sensors, "bits": bits, "load_cell": load_cell}
    how |= {"payload": payload, "supply": supply, "calibration": calibration, "overrides": overrides(settings)}
    if slips is not None:
        how["slips"] = slips
    varied = {key for member in known(experiment).series for key in member if how.get(key) is None}
    with waiting("running the experiment"):
        logs = rigs.series(experiment, machine, **how) if varied else [rigs.run(experiment, machine, **how)]
    paths = [log.save(output if len(logs) == 1 else _beside(output, log, varied)) for log in logs]
    say(*(segment_table(log) for log in logs), "written:", *(f"  {path}" for path in paths))
    unfinished = [log.data.attrs["outcome_message"] for log in logs if not log.run.outcome.completed]
    if unfinished:
        say(*unfinished)
        raise typer.Exit(1)


def _beside(path: Path, log: RigLog, varied: set[str]) -> Path:
    """The path of one log among several: ``log-20kg.csv``, ``log-100bar.csv``."""
    about = log.data.attrs
    what = f"{about['payload']:g}kg" if "payload" in varied else f"{about['supply'] / 1e5:.0f}bar"
    return path.with_name(f"{path.stem}-{what}{path.suffix}")


def segment_table(log: RigLog) -> Table:
    """One row per piece of the experiment."""
    about = log.data.attrs
    title = f"{about['experiment']} on {about['machine']}, {about['payload']:g} kg, {about['supply'] / 1e5:g} bar"
    table = plain_table(title=title)
    table.add_column("piece", no_wrap=True)
    for heading in ("from s", "to s", "mean velocity mm/s"):
        table.add_column(heading, justify="right")
    for segment in log.segments:
        table.add_row(segment.name, f"{segment.start:.2f}", f"{segment.end:.2f}", f"{segment.velocity * 1e3:.4g}")
    return table
