"""``hydrocrane plot``, ``linearise`` and ``bode``: charts of runs and machines, linear models."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrocrane.app.arguments import (
    MachineName,
    Output,
    Payload,
    Settings,
    choice,
    headless,
    named_machine,
    named_run,
    picture_path,
    write_figure,
)
from hydrocrane.app.console import plain_table, say, warn
from hydrocrane.errors import InputError, unknown

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.table import Table

    from hydrocrane.linear import LinearModel, Loop
    from hydrocrane.machine.machine import Machine
    from hydrocrane.state_space.options import Options


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


class Side(StrEnum):
    extend = "extend"
    retract = "retract"


class Friction(StrEnum):
    smoothed = "smoothed"
    held = "held"
    released = "released"


class Mode(StrEnum):
    hold = "hold"
    steady = "steady"


At = Annotated[list[str], typer.Option(help="Joint of the pose, JOINT=VALUE with its unit; others in mid-range.")]
Inputs = Annotated[list[str], typer.Option("--from", help="Input, such as cylinder.lift.command; all commands.")]
Outputs = Annotated[list[str], typer.Option("--to", help="Output, such as tip.z; joints and tip by default.")]
SideOf = Annotated[Side, choice(Side, "Side of closed valves.")]
FrictionOf = Annotated[Friction, choice(Friction, "smoothed: as simulated; released: none, as in larger motions.")]
ModeOf = Annotated[Mode, choice(Mode, "Equilibrium: valves closed, or feeding the leakage.")]


def linearise(
    machine: MachineName,
    output: Annotated[Path, typer.Option("-o", "--output", help="File to write: .mat or .json.")],
    at: At = [],  # noqa: B006
    inputs: Inputs = [],  # noqa: B006
    outputs: Outputs = [],  # noqa: B006
    mode: ModeOf = Mode.hold,
    side: SideOf = Side.extend,
    friction: FrictionOf = Friction.smoothed,
    payload: Payload = None,
    settings: Settings = [],  # noqa: B006
) -> None:
    """Linearise a machine in a pose; write the matrices with names and units, and print the modes."""
    from hydrocrane.app.report import modes_table
    from hydrocrane.files.whole_file import checked_suffix
    from hydrocrane.state_space.exports import SUFFIXES

    checked_suffix(output, SUFFIXES)
    options = _options(inputs, outputs, mode, side, friction, payload)
    model = _linearised(machine, at, settings, options)
    say(modes_table(model.oscillations))
    _warn(model)
    say(f"written: {model.save(output)}")


def bode(
    machine: MachineName,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Picture to write.")] = None,
    at: At = [],  # noqa: B006
    inputs: Inputs = [],  # noqa: B006
    outputs: Outputs = [],  # noqa: B006
    loops: Annotated[bool, typer.Option("--loops", help="Draw the loop gains of heinze-pid; print margins.")] = False,
    mode: ModeOf = Mode.hold,
    side: SideOf = Side.extend,
    friction: FrictionOf = Friction.released,
    payload: Payload = None,
    settings: Settings = [],  # noqa: B006
) -> None:
    """Draw frequency responses of a machine in a pose, by default of the tip's height by every spool command."""
    from hydrocrane.app.options import pose
    from hydrocrane.linear import cylinder_loops
    from hydrocrane.machine.poses import in_words

    headless()
    from hydrocrane import plots
    from hydrocrane.plots.bode import OUTPUT

    path = picture_path(output, f"{Path(machine).stem}-bode.png")
    if loops:
        if inputs or outputs or mode is not Mode.hold:
            raise InputError("--loops draws every cylinder's loop at rest; leave --from, --to and --mode out")
        loaded = named_machine(machine, settings)
        q = pose(loaded, at)
        found = cylinder_loops(loaded, q, payload=payload, friction=friction.value, side=side.value)
        say(f"pose: {in_words(loaded, q)}")
        say(margins_table(found))
        if found[0].advice:
            warn(found[0].advice)
        figure = plots.loop_gains(found)
    else:
        options = _options(inputs, outputs or [OUTPUT], mode, side, friction, payload)
        model = _linearised(machine, at, settings, options)
        _warn(model)
        figure = plots.bode(model)
    write_figure(figure, path)


def _options(
    inputs: list[str], outputs: list[str], mode: Mode, side: Side, friction: Friction, payload: float | None
) -> Options:
    return {
        "inputs": inputs or None,
        "outputs": outputs or None,
        "mode": mode.value,
        "side": side.value,
        "friction": friction.value,
        "payload": payload,
    }


def _linearised(machine: str, at: list[str], settings: list[str], options: Options) -> LinearModel:
    from hydrocrane.app.options import pose
    from hydrocrane.machine.poses import in_words

    loaded = named_machine(machine, settings)
    q = pose(loaded, at)
    model = loaded.linearise(q, **options)
    say(f"pose: {in_words(loaded, q)}")
    return model


def margins_table(loops: list[Loop]) -> Table:
    """Margins of each cylinder's loop; none where the loops are not stable together."""
    import math

    headings = ("cylinder", "gain margin", "gain may fall to", "phase margin, deg", "modulus margin", "all closed")
    table = plain_table(*headings, left=("cylinder", "all closed"))
    for loop in loops:
        found = loop.margins
        if loop.stable:
            values = (found.gain, found.reduction, math.degrees(found.phase), found.modulus)
            table.add_row(loop.cylinder, *(f"{value:.3g}" for value in values), "stable")
        else:
            table.add_row(loop.cylinder, *["-"] * 4, f"unstable, grows e-fold in {1 / loop.growth:.2g} s")
    return table


def _warn(model: LinearModel) -> None:
    for warning in model.warnings:
        warn(str(warning))
