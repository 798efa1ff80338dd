"""``hydrocrane export``: machines as files of other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrocrane.app.console import say

export = typer.Typer(name="export", help="Write a machine for other programs.", no_args_is_help=True)

MachineName = Annotated[str, typer.Argument(help="Bundled machine or path of a machine file.", metavar="MACHINE")]
Settings = Annotated[list[str], typer.Option("--set", help="Override a machine key: KEY=VALUE.")]
Payload = Annotated[float | None, typer.Option(help="Mass at the tip, kg.")]
Output = Annotated[Path | None, typer.Option("-o", "--output", help="File to write; by default named after MACHINE.")]


@export.callback()
def _group() -> None:
    """Write a machine for other programs."""


@export.command(epilog="Example:  hydrocrane export urdf hiab-xs031 -o hiab.urdf")
def urdf(machine: MachineName, output: Output = None, payload: Payload = None, settings: Settings = []) -> None:  # noqa: B006
    """The open chain as URDF: links, joints, inertias, limits, tip; for Pinocchio, ROS and others."""
    from hydrocrane.app.options import checked_machine, overrides
    from hydrocrane.export import export_urdf
    from hydrocrane.machine.machine import load_machine

    loaded = load_machine(checked_machine(machine), overrides(settings))
    say(f"written: {export_urdf(loaded, output or Path(f'{loaded.name}.urdf'), payload=payload)}")


@export.command(epilog="Example:  hydrocrane export mjcf rottne-f9-lab --linkages -o crane.xml")
def mjcf(
    machine: MachineName,
    output: Output = None,
    payload: Payload = None,
    linkages: Annotated[bool, typer.Option("--linkages", help="Close torque linkages by constraints.")] = False,
    settings: Settings = [],  # noqa: B006
) -> None:
    """The chain as MJCF for MuJoCo, with each cylinder as an actuator between its pins."""
    from hydrocrane.app.options import checked_machine, overrides
    from hydrocrane.export import export_mjcf
    from hydrocrane.machine.machine import load_machine

    loaded = load_machine(checked_machine(machine), overrides(settings))
    path = output or Path(f"{loaded.name}.xml")
    say(f"written: {export_mjcf(loaded, path, payload=payload, linkages=linkages)}")
