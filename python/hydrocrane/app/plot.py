"""``hydrocrane plot``: charts of runs and machines, and any signals of one run or of several over each other."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrocrane.app.arguments import (
    Output,
    Settings,
    choice,
    headless,
    named_machine,
    named_run,
    picture_path,
    write_figure,
)
from hydrocrane.errors import InputError, unknown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from hydrocrane.machine.machine import Machine


class Chart(StrEnum):
    cylinders = "cylinders"
    tip = "tip"
    energy = "energy"
    supply = "supply"
    joint_stroke = "joint-stroke"
    flow_law = "flow-law"
    friction = "friction"


OF_RUNS = (Chart.cylinders, Chart.tip, Chart.energy, Chart.supply)


def plot(
    targets: Annotated[
        list[str],
        typer.Argument(
            help="Saved run, scenario, or (last three charts) machine; several runs with --signal.", metavar="TARGET"
        ),
    ],
    chart: Annotated[Chart, choice(Chart, "What to draw; the last three take a machine.")] = Chart.cylinders,
    signal: Annotated[
        list[str],
        typer.Option(help="Draw this signal instead of a chart, as tip.z or cylinder.lift.p1; again for each."),
    ] = [],  # noqa: B006
    cylinder: Annotated[str | None, typer.Option(help="Only this cylinder.")] = None,
    output: Output = None,
    settings: Settings = [],  # noqa: B006
) -> None:
    """Draw charts of a run, or of a machine's linkage, valve or friction; or signals of runs over each other."""
    headless()
    name = "-".join(dict.fromkeys(Path(target).stem for target in targets))
    if signal:
        path = picture_path(output, f"{name}-signals.png")
        write_figure(_signals(targets, signal, chart, cylinder, settings), path)
        return
    if len(targets) > 1:
        raise InputError("several runs are drawn over each other by signals: name one, such as --signal tip.z")
    path = picture_path(output, f"{name}-{chart.value}.png")
    if chart is Chart.cylinders:
        figure = named_run(targets[0], settings).plot(cylinder)
    elif chart in OF_RUNS:
        if cylinder is not None:
            raise InputError(
                f"--cylinder goes with charts of cylinders, and --chart {chart.value} is of the whole machine"
            )
        figure = named_run(targets[0], settings).plot(chart.value)
    else:
        figure = _machine_chart(named_machine(targets[0], settings), chart, cylinder)
    write_figure(figure, path)


def _signals(targets: list[str], signals: list[str], chart: Chart, cylinder: str | None, settings: list[str]) -> Figure:
    """Each signal of each run; runs are named as their files, as far as that tells them apart."""
    from hydrocrane import plots

    if chart is not Chart.cylinders or cylinder is not None:
        raise InputError("--signal draws signals alone: leave --chart and --cylinder out")
    stems = [Path(target).stem for target in targets]
    labels = targets if len(set(stems)) < len(stems) else stems
    if len(set(labels)) < len(labels):
        raise InputError("the same run is named twice: name each run once")
    runs = {label: named_run(target, settings) for label, target in zip(labels, targets)}
    return plots.overlay(runs, list(dict.fromkeys(signals)))


def _machine_chart(machine: Machine, chart: Chart, cylinder: str | None) -> Figure:
    from hydrocrane import plots

    if cylinder is not None and cylinder not in machine.cylinder_names:
        raise unknown("cylinder", cylinder, machine.cylinder_names)
    if chart is Chart.flow_law:
        return plots.flow_law(machine, cylinder)
    if chart is Chart.friction:
        return plots.friction_maps(machine, cylinder)
    return plots.joint_stroke(machine, cylinder and machine.joint_names[machine.cylinder_names.index(cylinder)])
