"""``hydrocrane identify``: from logs of a rig to the blocks of a machine file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from hydrocrane.app.arguments import headless, number
from hydrocrane.app.console import complain, reporting, say

if TYPE_CHECKING:
    from hydrocrane.identification.form import Exponents

identify = typer.Typer(name="identify", help="Identification from measured logs.", no_args_is_help=True)


@identify.callback()
def _group() -> None:
    """Identification from measured logs."""


@identify.command(
    name="friction",
    epilog="Example:  hydrocrane identify friction levels.csv ramp.csv step.csv --rig rig-rottne --write friction.toml",
)
def identify_friction(
    logs: Annotated[
        list[Path], typer.Argument(help="Logs of constant velocities; ramps or steps if the log states it.")
    ] = [],  # noqa: B006
    rig: Annotated[str, typer.Option(help="Machine with one cylinder: bundled rig or path of a file.")] = "rig-rottne",
    mapping: Annotated[Path | None, typer.Option(help="Mapping of columns to signals, TOML.")] = None,
    ramp: Annotated[list[Path], typer.Option(help="Log of a slowly opening valve, from rest.")] = [],  # noqa: B006
    step: Annotated[list[Path], typer.Option(help="Log of small steps, from rest.")] = [],  # noqa: B006
    payload: Annotated[float | None, number("Load on the rod, kg; default: as the logs state.")] = None,
    zero: Annotated[str | None, typer.Option(help="Seconds at zero pressure, FROM:TO, e.g. 0:1.")] = None,
    window: Annotated[str | None, typer.Option(help="Seconds of every log to use, FROM:TO, e.g. 2:60.")] = None,
    load_cell: Annotated[bool, typer.Option("--load-cell", help="Take the load's weight from `force`.")] = False,
    rod_mass: Annotated[float, number("Moving mass on the cylinder's side of the load cell, kg.")] = 0.0,
    exponents: Annotated[
        str,
        typer.Option(help="chosen (by likelihood), fixed (as in the rig's file), free, or e.g. viscous-exponent=1."),
    ] = "chosen",
    cylinder: Annotated[str | None, typer.Option(help="Name of the cylinder in the machine file.")] = None,
    report: Annotated[Path | None, typer.Option(help="Page with every stage: .html.")] = None,
    write: Annotated[Path | None, typer.Option(help="Block for a machine file: .toml.")] = None,
) -> None:
    """Identify the friction of a cylinder: static map, bristles, intervals, a page, and a block for a machine file."""
    import hydrocrane as hc
    from hydrocrane.app.options import stretch, wanted_suffix

    headless()
    # A wrong name shall not cost the fit.
    wanted_suffix("--report", report, ".html", ".htm")
    wanted_suffix("--write", write, ".toml")
    with reporting() as tell:
        found = hc.identify_friction(
            logs, rig, ramps=ramp, steps=step, mapping=mapping, payload=payload, zero=stretch("--zero", zero, "0:1"),
            window=stretch("--window", window, "2:60"), load_cell=load_cell, rod_mass=rod_mass,
            exponents=_exponents(exponents), progress=tell,
        )  # fmt: skip
    say(found.summary())
    written = []
    failed = [f"{stage.name} failed: {stage.message}" for stage in found.failures]
    if write:
        try:
            written.append(found.write(write, cylinder))
        except hc.InputError as error:
            failed.append(str(error))
    if report:
        written.append(found.report().write(report))
    if written:
        say("", "written:", *(f"  {path}" for path in written))
    for message in failed:
        complain(message)
    if failed:
        raise typer.Exit(1)


def _exponents(text: str) -> Exponents:
    """``chosen``, ``fixed``, ``free``, or ``name=value`` pairs apart by commas."""
    from hydrocrane.errors import InputError
    from hydrocrane.units import plain_number

    if "=" not in text:
        return cast("Exponents", text)
    found: dict[str, float | str] = {}
    for pair in text.split(","):
        name, _, value = (part.strip() for part in pair.partition("="))
        try:
            found[name] = value if value == "free" else plain_number(value)
        except ValueError:
            raise InputError(
                f"--exponents takes chosen, fixed, free, or values as viscous-exponent=1; got `{pair.strip()}`"
            ) from None
    return found
