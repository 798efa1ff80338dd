"""``hydrocrane linearise`` and ``hydrocrane bode``: linear models to files and to pictures."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrocrane.app.arguments import (
    MachineName,
    Payload,
    Settings,
    choice,
    headless,
    named_machine,
    picture_path,
    write_figure,
)
from hydrocrane.app.console import plain_table, say, warn

if TYPE_CHECKING:
    from rich.table import Table

    from hydrocrane.linear import LinearModel, Loop
    from hydrocrane.state_space.options import Options


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
    from hydrocrane.errors import InputError
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
