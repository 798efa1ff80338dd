"""``hydrocrane control``: benchmark of crane-tip control."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from hydrocrane.app.arguments import Settings, headless, named_machine, number
from hydrocrane.app.console import bar, plain_table, say

if TYPE_CHECKING:
    from rich.table import Table

    from hydrocrane.benchmark.suite import Benchmark

control = typer.Typer(name="control", help="Crane-tip control.", no_args_is_help=True)

# Column heading, figure, factor; the files hold all figures.
COLUMNS = (
    ("score\n%", "score", 1e2),
    ("path\n%", "reached", 1e2),
    ("max\nmm", "path_max", 1e3),
    ("RMS\nmm", "path_rms", 1e3),
    ("end\nmm", "end_error", 1e3),
    ("settle\ns", "settling", 1.0),
    ("shake\nmm/s", "vibration", 1e3),
    ("pump\nkJ", "energy", 1e-3),
    ("stops\nhit", "end_stop_hits", 1),
    ("own\nms", "rho_set_point", 1e3),
)


@control.callback()
def _group() -> None:
    """Crane-tip control."""


@control.command(name="benchmark", epilog="Example:  hydrocrane control benchmark --quick -o results")
def run_benchmark(
    controllers: Annotated[list[str], typer.Argument(help="Names; tip, pi and heinze-pid by default.")] = [],  # noqa: B006
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for table and picture.")] = Path("results"),
    machine: Annotated[str, typer.Option(help="Bundled machine or path of a machine file.")] = "rottne-f9-lab",
    settings: Settings = [],  # noqa: B006
    seed: Annotated[int, number("Seed of the sensors' errors.", int)] = 0,
    quick: Annotated[bool, typer.Option("--quick", help="A few cases in place of all.")] = False,
) -> None:
    """Run the tasks of the tip-control benchmark; print a table, write it as CSV and JSON, and draw a page."""
    from hydrocrane import benchmark
    from hydrocrane.benchmark import fitted_tasks

    loaded = named_machine(machine, settings)
    # A folder that cannot be made shall not cost the runs.
    output.mkdir(parents=True, exist_ok=True)
    if not quick and fitted_tasks.fits_the_benchmark(loaded):
        cases = benchmark.all_cases(loaded)
    else:
        cases = fitted_tasks.tuning_cases(loaded) + ([] if quick else benchmark.drawn_cases(loaded))
    with bar("running the benchmark") as progress:
        found = benchmark.benchmark(
            controllers or benchmark.CONTROLLERS, cases, machine=loaded, seed=seed, progress=progress
        )
    paths = found.save(output)
    headless()
    paths += _picture(found, output / "control-benchmark.png")
    remarks = _remarks(found)
    say(benchmark_table(found), _standings(found), *remarks, "written:", *(f"  {path}" for path in paths))
    if remarks:
        raise typer.Exit(1)


@control.command(name="tune", epilog="Example:  hydrocrane control tune rottne-f9-lab --trials 20 -o gains.toml")
def run_tune(
    machine: Annotated[str, typer.Argument(help="Bundled machine or path of a machine file.")] = "rottne-f9-lab",
    output: Annotated[Path | None, typer.Option("-o", "--output", help="File for the block of gains.")] = None,
    controller: Annotated[str, typer.Option(help="tip, or pi, which the benchmark compares with.")] = "tip",
    settings: Settings = [],  # noqa: B006
    trials: Annotated[int, number("Largest number of sets of gains to simulate.", int)] = 60,
    seed: Annotated[int, number("Seed of the sensors' errors.", int)] = 0,
) -> None:
    """Search the gains of a controller by simulation, and report them before and after."""
    from hydrocrane.benchmark import tuning
    from hydrocrane.files.whole_file import write_text
    from hydrocrane.linear.period_advice import period_advice

    loaded = named_machine(machine, settings)
    with bar("tuning") as progress:
        found = tuning.tune(loaded, controller=controller, trials=trials, seed=seed, progress=progress)
    lines = [f"{key:20} {found.before[key]:8.4g} -> {found.after[key]:8.4g} {found.units[key]}" for key in found.after]
    say(
        *lines,
        f"cost {found.cost_before * 1e3:.3f} mm -> {found.cost_after * 1e3:.3f} mm, {found.trials} sets simulated",
        "(worst case: RMS deviation, and priced spool travel, settling and speed at rest)",
        f"speed at rest, worst case: {found.rest_before * 1e3:.2f} mm/s -> {found.rest_after * 1e3:.2f} mm/s",
        found.toml(),
    )
    if controller == "tip":
        say(str(period_advice(loaded)))
    if output is not None:
        write_text(output, found.toml())
        say(f"written: {output}")


def _picture(found: Benchmark, path: Path) -> list[Path]:
    from hydrocrane.plots.benchmark import control_benchmark
    from hydrocrane.plots.style import write

    if not any(len(result.tip) for result in found.results):
        return []
    return [write(control_benchmark(found), path)]


def benchmark_table(found: Benchmark) -> Table:
    """One row per run, those of the controller with the best mean score first."""
    table = plain_table(collapse_padding=True)
    for heading in ("controller", "task", "condition"):
        table.add_column(heading, no_wrap=True)
    for heading, *_ in COLUMNS:
        # Where a terminal is narrow, names are cut, never figures.
        table.add_column(heading, justify="right", no_wrap=True, min_width=5)
    table.add_column("remark", no_wrap=True)
    order = list(found.standings)
    for result in sorted(found.results, key=lambda result: order.index(result.controller)):
        head = (result.controller, result.case.task.name, str(result.case.condition))
        row = result.row
        table.add_row(
            *head,
            *(_cell(cast("float | None", row[key]), factor) for _, key, factor in COLUMNS),
            result.remark.split(":")[0],
        )
    return table


def _standings(found: Benchmark) -> str:
    """Mean scores, and who never moved the tip."""
    from hydrocrane.benchmark.cases import STANDING

    shown = []
    for controller, score in found.standings.items():
        reached = [r.metrics.reached for r in found.results if r.controller == controller and r.metrics is not None]
        still = " (never moves the tip)" if all(share < STANDING for share in reached) else ""
        shown.append(f"{controller} {score:.0%}{still}")
    return f"mean score: {', '.join(shown)}"


def _cell(value: float | None, factor: float) -> str:
    from hydrocrane.benchmark.metrics import significant

    if value is None:
        return "-"
    return str(value) if isinstance(value, int) else significant(value * factor)


def _remarks(found: Benchmark) -> list[str]:
    """What the table cannot say: runs that did not come to their end, and why."""
    return [
        f"{result.controller}, {result.case.task.name}, {result.case.condition}: "
        f"{result.outcome.kind}; {result.message}"
        for result in found.results
        if not result.outcome.completed
    ]
