"""``hydrocrane export`` and ``schema``: machines and controllers for other programs, and what editors must know."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrocrane.app.arguments import MachineName, Output, Payload, Settings, named_machine, number
from hydrocrane.app.console import say

if TYPE_CHECKING:
    from hydrocrane.machine.machine import Machine
    from hydrocrane.scenario.scenario import Scenario

export = typer.Typer(
    name="export", help="Export machines and controllers for other tools.", invoke_without_command=True
)


@export.callback(epilog="Example:  hydrocrane export fmu rottne-f9-lab -o crane.fmu")
def exports(
    context: typer.Context,
    platforms: Annotated[
        bool, typer.Option("--platforms", help="List the platforms whose FMU library this installation holds.")
    ] = False,
) -> None:
    if platforms:
        from hydrocrane.export.platforms import PLATFORMS, installed

        there = installed()
        say(*(f"{name:15} {'yes' if name in there else 'no'}" for name in PLATFORMS))
    elif context.invoked_subcommand is None:
        say(context.get_help())


@export.command(epilog="Example:  hydrocrane export fmu rottne-f9-lab --at boom='100 deg' -o crane.fmu")
def fmu(
    target: Annotated[
        str, typer.Argument(help="Machine or scenario: file or bundled name.", metavar="MACHINE|SCENARIO")
    ],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="File to write, ending in .fmu; by default named after the target, here."),
    ] = None,
    fmi: Annotated[int, number("Version of the standard, 2 or 3; most tools take 2.", int)] = 2,
    controller: Annotated[
        str | None, typer.Option(help="Export this controller of the machine: tip, heinze-pid, lever.")
    ] = None,
    settings: Settings = [],  # noqa: B006
    at: Annotated[list[str], typer.Option(help="JOINT=VALUE of the start of a machine; else mid-range.")] = [],  # noqa: B006
    sensors: Annotated[str, typer.Option(help="What measured.… tells: ideal or data-sheet.")] = "ideal",
    parameter: Annotated[
        list[str], typer.Option(help="Key or table of the machine that becomes parameters; default supply, friction.")
    ] = [],  # noqa: B006
    platform: Annotated[list[str], typer.Option(help="Platform to put in; default all that are installed.")] = [],  # noqa: B006
    step: Annotated[str, typer.Option(help="Step that the file suggests to tools.")] = "1 ms",
) -> None:
    """Write a machine, or a controller that knows it, as a Functional Mock-up Unit (FMI 2.0 or 3.0)."""
    import hydrocrane as hc
    from hydrocrane.units import converted

    source = _source(target, settings, at)
    name = target.removesuffix(".toml") if controller is None else f"{target.removesuffix('.toml')}-{controller}"
    path = hc.export_fmu(
        source,
        output or Path(f"{Path(name).name}.fmu"),
        fmi=fmi,
        controller=controller,
        sensors=sensors,
        parameters=parameter or None,
        platforms=platform,
        step=converted("--step", step, "s"),
    )
    say(f"written: {path}")


@export.command(epilog="Example:  hydrocrane export controller rottne-f9-lab --c -o controller")
def controller(
    machine: MachineName,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder to write; by default named after MACHINE, here.")
    ] = None,
    name: Annotated[str, typer.Option("--controller", help="tip, heinze-pid or lever.")] = "tip",
    c: Annotated[bool, typer.Option("--c", help="In C, which is the only language so far.")] = True,
    monitor: Annotated[
        bool | None,
        typer.Option("--monitor/--no-monitor", help="Whether readings are checked; default yes, but for lever."),
    ] = None,
    delay: Annotated[str, typer.Option(help="Time from a sample until its command leaves the target.")] = "0 ms",
    settings: Settings = [],  # noqa: B006
) -> None:
    """Write a controller for a program in C: parameters, header, example, static library."""
    import hydrocrane as hc
    from hydrocrane.units import converted

    loaded = named_machine(machine, settings)
    folder = hc.export_controller(
        loaded,
        output or Path(f"{loaded.name}-{name}"),
        controller=name,
        monitor=monitor,
        delay=converted("--delay", delay, "s"),
    )
    say(f"written: {folder}")


@export.command(epilog="Example:  hydrocrane export urdf hiab-xs031 -o hiab.urdf")
def urdf(machine: MachineName, output: Output = None, payload: Payload = None, settings: Settings = []) -> None:  # noqa: B006
    """The open chain as URDF: links, joints, inertias, limits, tip; for Pinocchio, ROS and others."""
    from hydrocrane.export import export_urdf

    loaded = named_machine(machine, settings)
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
    from hydrocrane.export import export_mjcf

    loaded = named_machine(machine, settings)
    path = output or Path(f"{loaded.name}.xml")
    say(f"written: {export_mjcf(loaded, path, payload=payload, linkages=linkages)}")


@export.command(epilog="Example:  hydrocrane export model rottne-f9-lab --to c -o crane.c")
def model(
    machine: MachineName,
    to: Annotated[str, typer.Option(help="c, casadi, jax, numpy, matlab or cuda.")] = "c",
    output: Output = None,
    parameter: Annotated[
        list[str],
        typer.Option(help="Key or table of the machine that becomes parameters; default supply, friction, payload."),
    ] = [],  # noqa: B006
    no_parameters: Annotated[bool, typer.Option("--no-parameters", help="All numbers are constants.")] = False,
    output_name: Annotated[
        list[str], typer.Option("--output-name", help="Output of the machine; default all but energies.")
    ] = [],  # noqa: B006
    derivatives: Annotated[bool, typer.Option(help="Whether derivatives by the states are written.")] = True,
    settings: Settings = [],  # noqa: B006
) -> None:
    """The right-hand side as a function: C, CasADi, JAX, NumPy, MATLAB, CUDA C."""
    from hydrocrane.errors import InputError
    from hydrocrane.export.model import LANGUAGES, export_model

    if no_parameters and parameter:
        raise InputError("--no-parameters leaves no parameters, and --parameter names some; give one of them")
    loaded = named_machine(machine, settings)
    stem = loaded.name.replace("-", "_") if to == "matlab" else loaded.name
    path = export_model(
        loaded,
        output or Path(f"{stem}{LANGUAGES.get(to, '')}"),
        to=to,
        parameters=[] if no_parameters else parameter or None,
        outputs=output_name or None,
        derivatives=derivatives,
    )
    say(f"written: {path}")


def _source(target: str, settings: list[str], at: list[str]) -> Machine | Scenario:
    """A scenario, or a machine in a pose."""
    import hydrocrane as hc
    from hydrocrane.app.options import is_scenario, overrides, pose
    from hydrocrane.errors import InputError

    if is_scenario(target):
        if at:
            raise InputError(f"{target} states where it begins; --at is for machines")
        return hc.load_scenario(target).changed(overrides=overrides(settings))
    machine = named_machine(target, settings)
    if not at:
        return machine
    joints = dict(zip(machine.joint_names, pose(machine, at).tolist(), strict=True))
    return hc.Scenario(machine=machine, joints=joints, name=machine.name)


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
