"""``hydrocrane``: simulate, look, check, from the command line.

Heavy imports happen inside the commands, so that ``--help`` answers at once.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn, cast

import typer

from hydrocrane.app.arguments import (
    MachineName,
    Output,
    Payload,
    RunName,
    Settings,
    headless,
    named_machine,
    named_run,
    number,
    picture_path,
    write_figure,
)
from hydrocrane.app.console import bar, complain, say, waiting, warn
from hydrocrane.app.control import control
from hydrocrane.app.export import export, schema
from hydrocrane.app.identify import fit, identify, rig
from hydrocrane.app.live import live, view
from hydrocrane.app.plot import bode, linearise, plot
from hydrocrane.app.sweep import sweep

if TYPE_CHECKING:
    from hydrocrane.results.run import Run
    from hydrocrane.scenario.changes import RunChanges

app = typer.Typer(
    name="hydrocrane",
    help="Model, simulate and look at hydraulically driven cranes.",
    epilog="Example:  hydrocrane simulate vertical-lift-open-loop -o results",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
app.add_typer(control)
app.add_typer(export)
app.add_typer(identify)
app.add_typer(rig)
app.command(epilog="Example:  hydrocrane fit my-scenario.toml drive.csv -p payload.mass -p friction.lift.coulomb[0]")(
    fit
)
app.command(epilog="Example:  hydrocrane bode rottne-f9-lab --at boom='100 deg' --to tip.z -o bode.png")(bode)
app.command(epilog="Example:  hydrocrane linearise rottne-f9-lab --at boom='100 deg' -o crane.mat")(linearise)
app.command(epilog="Example:  hydrocrane live rottne-f9-lab")(live)
app.command(epilog="Example:  hydrocrane plot before.nc after.nc --signal tip.z --signal cylinder.lift.p1")(plot)
app.command(epilog="Example:  hydrocrane view results/vertical-lift-open-loop.nc")(view)
app.command(epilog="Example:  hydrocrane schema machine -o machine.schema.json")(schema)
app.command(epilog="Example:  hydrocrane sweep study.toml --store results/study.zarr --picture study.png")(sweep)


@app.command(epilog="Example:  hydrocrane simulate vertical-lift-open-loop --set supply.pressure='100 bar' -o results")
def simulate(
    scenario: Annotated[str, typer.Argument(help="Bundled scenario or path of a scenario file.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for data, charts, film.")] = Path("results"),
    settings: Settings = [],  # noqa: B006
    machine: Annotated[str | None, typer.Option(help="Use this machine in place of the scenario's.")] = None,
    command_log: Annotated[
        Path | None, typer.Option(help="CSV file with spool commands in place of the scenario's; columns as cylinders.")
    ] = None,
    supply_log: Annotated[
        Path | None, typer.Option(help="CSV file with a measured supply pressure; its column is `supply.pressure`.")
    ] = None,
    payload: Payload = None,
    duration: Annotated[float | None, number("s.")] = None,
    method: Annotated[
        str | None,
        typer.Option(help="auto; rodas5p, hc-exponential-4, hc-rosenbrock-3 (stiff); tsit5 (explicit)."),
    ] = None,
    rtol: Annotated[float | None, number("Relative tolerance.")] = None,
    step: Annotated[float | None, number("Fixed steps of this size, s.")] = None,
    record_limit: Annotated[str | None, typer.Option(help="Most memory of the record; default is 2 GB.")] = None,
    verify: Annotated[bool, typer.Option("--verify", help="Run again, tighter, and report the difference.")] = False,
    also: Annotated[list[str], typer.Option(help="Also write mat, csv, parquet, xlsx, mf4 or mcap.")] = [],  # noqa: B006
    film: Annotated[str, typer.Option(help="Animation: gif, mp4 or none.")] = "gif",
) -> None:
    """Run a scenario; write its data, charts and animation, and print a summary."""
    import hydrocrane as hc
    from hydrocrane.app.options import checked_scenario, overrides
    from hydrocrane.errors import InputError
    from hydrocrane.files.excel import check_sheet

    wanted = {"payload": payload, "duration": duration, "method": method, "rtol": rtol, "step": step}
    wanted["record_limit"] = record_limit
    changes = cast("RunChanges", {name: value for name, value in wanted.items() if value is not None})
    changes["overrides"] = overrides(settings)
    plan = hc.load_scenario(checked_scenario(scenario))
    if command_log is not None:
        changes["commands"] = hc.read_commands(command_log, machine or plan.load_machine())
        plan = plan.changed(controller=None, joystick=None, goals=(), phases=())
    if supply_log is not None:
        changes["supply"] = hc.read_supply(supply_log)
    if plan.recorded_by not in ("", hc.__version__):
        warn(f"{scenario} was recorded with version {plan.recorded_by}, this is {hc.__version__}: the drive may differ")
    suffixes = _data_suffixes(plan.name, also, film)
    if ".xlsx" in suffixes:
        check_sheet(plan.changed(**changes).record_times().size)
    if output.exists() and not output.is_dir():
        raise InputError(f"--output is a folder, and `{output}` is a file; choose another name")
    with waiting("simulating"):
        run = _run_or_part(lambda: hc.simulate(plan, machine=machine, verify=verify, **changes))
    paths: list[Path] = []
    try:
        # Data first: a picture that fails must not cost the run.
        for path in _write_run(run, output, suffixes, film):
            paths.append(path)
    except (KeyboardInterrupt, OSError):
        _say_written(run, paths)
        warn("not everything was written")
        raise
    _say_written(run, paths)
    if run.warnings:
        warn(f"the run may be wrong: {len(run.warnings)} warning{'s' * (len(run.warnings) > 1)}, see above")
    if not run.outcome.completed:
        raise typer.Exit(1)


def _run_or_part(simulate: Callable[[], Run]) -> Run:
    """The run; after Ctrl-C the one until then."""
    try:
        return simulate()
    except KeyboardInterrupt as stopped:
        part: Run | None = getattr(stopped, "run", None)
        if part is None:
            raise
        return part


def _data_suffixes(name: str, also: list[str], film: str) -> list[str]:
    """Suffixes of the data files of the run `name`; what cannot be written here is an error before anything runs."""
    from hydrocrane.errors import InputError
    from hydrocrane.files.datasets import writable

    found = [".nc"]
    for suffix in also:
        # Several at once, as in `--also csv,mat`.
        found += [f".{part.strip().lstrip('.').lower()}" for part in suffix.split(",")]
    for suffix in found:
        writable(Path(f"{name}{suffix}"))
    if film not in ("gif", "mp4", "none"):
        raise InputError(f"--film is gif, mp4 or none, got `{film}`")
    if film != "none":
        from hydrocrane.plots.animation import checked_suffix as checked_film

        checked_film(Path(f"{name}.{film}"))
    return list(dict.fromkeys(found))


def _say_written(run: Run, paths: list[Path]) -> None:
    say(run.summary(), "", "written:" if paths else "nothing was written", *(f"  {path}" for path in paths))


def _write_run(run: Run, folder: Path, suffixes: list[str], film: str) -> Iterator[Path]:
    """Write data, charts and film; tells each file once it is there."""
    name = run.columns.attrs["scenario"]
    for suffix in suffixes:
        yield run.save(folder / f"{name}{suffix}")
    if not run.columns.rows:
        return
    headless()
    with waiting("drawing charts"):
        for cylinder in run.cylinder_names:
            path = folder / f"{name}-{cylinder}.png"
            run.plot(cylinder, path=path)
            yield path
    if film != "none":
        with bar("drawing the animation") as progress:
            path = folder / f"{name}.{film}"
            run.animate(path, progress=progress)
            yield path


@app.command(epilog="Example:  hydrocrane animate results/vertical-lift-open-loop.nc -o lift.gif --speed 2")
def animate(
    run: RunName,
    output: Output = None,
    fps: Annotated[int, number("Pictures per second.", int, least=1)] = 20,
    speed: Annotated[float, number("1 is real time.", least=1e-6)] = 1.0,
    settings: Settings = [],  # noqa: B006
) -> None:
    """Write a film of the moving crane: .gif, or .mp4 where ffmpeg is found."""
    from hydrocrane.plots.animation import checked_suffix

    headless()
    path = output or Path(f"{Path(run).stem}.gif")
    checked_suffix(path)
    record = named_run(run, settings)
    with bar("drawing the animation") as progress:
        record.animate(path, fps=fps, speed=speed, progress=progress)
    say(f"written: {path}")


@app.command(epilog="Example:  hydrocrane workspace rottne-f9-lab -o workspace.png")
def workspace(
    machine: MachineName,
    output: Output = None,
    settings: Settings = [],  # noqa: B006
) -> None:
    """Draw the working area of the crane tip."""
    from hydrocrane import plots

    headless()
    loaded = named_machine(machine, settings)
    path = picture_path(output, f"{loaded.name}-workspace.png")
    write_figure(plots.workspace(loaded), path)


@app.command(epilog="Example:  hydrocrane circuit rottne-f9-mobile -o circuit.svg")
def circuit(
    machine: MachineName,
    output: Output = None,
    settings: Settings = [],  # noqa: B006
) -> None:
    """Draw the hydraulic circuit of a machine: pump, valves and cylinders with their values."""
    from hydrocrane import plots

    headless()
    loaded = named_machine(machine, settings)
    path = picture_path(output, f"{loaded.name}-circuit.svg")
    write_figure(plots.circuit(loaded), path)


@app.command(epilog="Example:  hydrocrane loadchart rottne-f9-lab --height '1.5 m' --set supply.pressure='180 bar'")
def loadchart(
    machine: MachineName,
    output: Output = None,
    height: Annotated[
        str | None,
        typer.Option(help="Height of the tip: best, worst, or such as '1.5 m'; default: both."),
    ] = None,
    samples: Annotated[int, number("Poses per turning joint of the map, not of the curves.", int, least=2)] = 50,
    settings: Settings = [],  # noqa: B006
) -> None:
    """Payload against reach: what the cylinders hold at supply pressure."""
    from hydrocrane import plots
    from hydrocrane.analysis import capacity
    from hydrocrane.app.options import tip_height
    from hydrocrane.app.report import load_table

    headless()
    wanted = tip_height(height)
    loaded = named_machine(machine, settings)
    path = picture_path(output, f"{loaded.name}-loadchart.png")
    with waiting("computing the workspace"):
        chart = capacity.load_chart(loaded, samples=samples)
        table, figure = load_table(chart, wanted), plots.load_chart(loaded, chart, height=wanted)
    say(table)
    write_figure(figure, path)


@app.command(epilog="Example:  hydrocrane modes rottne-f9-lab --at boom='100 deg' --at jib='100 deg'")
def modes(
    machine: MachineName,
    at: Annotated[
        list[str], typer.Option(help="Joint of the pose, JOINT=VALUE with its unit; others in mid-range.")
    ] = [],  # noqa: B006
    payload: Payload = None,
    output: Output = None,
    samples: Annotated[
        int | None,
        number(
            "Poses per turning joint of the map; 0 draws none. Default: 16; tilted slewing gears: none.", int, least=0
        ),
    ] = None,
    settings: Settings = [],  # noqa: B006
) -> None:
    """Natural frequencies and damping in a pose, with and without friction, and their map over the workspace."""
    from hydrocrane import plots
    from hydrocrane.analysis import linear
    from hydrocrane.analysis.poses import pose_grid
    from hydrocrane.app.options import pose
    from hydrocrane.app.report import modes_table
    from hydrocrane.errors import InputError
    from hydrocrane.machine.poses import in_words

    headless()
    loaded = named_machine(machine, settings)
    path = picture_path(output, f"{loaded.name}-modes.png")
    if samples is None:
        samples = 0 if "y" in loaded.tip_axes and not loaded.first_in_plane else 16
    if samples:
        # A grid that is none is told before anything is printed.
        pose_grid(loaded, samples)
    q = pose(loaded, at)
    say(f"pose: {in_words(loaded, q)}")
    for found in linear.modes_to_show(loaded, q, payload=payload):
        say(linear.FRICTION_WORDS[found.friction], modes_table(found), "")
        for warning in found.warnings:
            warn(str(warning))
    if samples:
        with waiting("computing the workspace"):
            drawn = linear.mode_map(loaded, samples=samples, payload=payload)
        try:
            figure = plots.mode_map(loaded, drawn)
        except InputError as nothing:
            warn(str(nothing))
        else:
            write_figure(figure, path)


@app.command(epilog="Example:  hydrocrane machines")
def machines() -> None:
    """List the bundled machines with the provenance of their values, and the bundled scenarios."""
    import hydrocrane as hc
    from hydrocrane.app.report import machines_table

    say(machines_table([hc.load_machine(name) for name in hc.bundled_machines()]))
    say("", f"scenarios: {', '.join(hc.bundled_scenarios())}")


@app.command(epilog="Example:  hydrocrane check my-crane/machine.toml")
def check(
    file: Annotated[str, typer.Argument(help="Machine or scenario: file or bundled name.")],
    settings: Settings = [],  # noqa: B006
) -> None:
    """Check a machine or scenario file and say what it describes."""
    import hydrocrane as hc
    from hydrocrane.app.options import is_scenario, overrides
    from hydrocrane.app.report import machine_report, print_findings, scenario_report

    if is_scenario(file):
        plan = hc.load_scenario(file).changed(overrides=overrides(settings))
        machine = plan.load_machine()
        _, doubts_of_start = plan.start(machine)
        say(*scenario_report(plan, machine))
        unusual = (*machine.warnings, *plan.warnings, *doubts_of_start)
    else:
        from hydrocrane.analysis.figures import doubts, figures

        machine = named_machine(file, settings)
        found = figures(machine)
        say(*machine_report(machine, found))
        unusual = (*machine.warnings, *doubts(machine, found))
    print_findings(unusual)


@app.command(epilog="Example:  hydrocrane new my-crane --pump ls")
def new(
    folder: Annotated[Path, typer.Argument(help="Folder to create.")],
    machine: Annotated[
        str | None, typer.Option(help="Copy this bundled machine in place of an example without a maker.")
    ] = None,
    pump: Annotated[
        str | None, typer.Option(help="Add a pump: fixed, pressure-compensated or ls (load-sensing).")
    ] = None,
) -> None:
    """Write a machine file and a scenario to start one's own crane from."""
    from hydrocrane.app.starter import write_starter

    files = write_starter(folder, machine, pump)
    say("written:", *(f"  {path}" for path in files), f"next: hydrocrane simulate {files[1]}")


@app.command(epilog="Example:  hydrocrane cite rottne-f9-lab > sources.bib")
def cite(target: Annotated[str, typer.Argument(help="Machine or saved run.")]) -> None:
    """Print BibTeX for the laws, methods and parameters that a machine or a run uses."""
    import hydrocrane as hc
    from hydrocrane.app.options import checked_machine

    print(hc.cite(hc.load_run(target) if target.endswith(".nc") else checked_machine(target)))


def _show_version(asked: bool) -> None:
    if asked:
        from hydrocrane import __version__

        print(f"hydrocrane {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


def main(arguments: list[str] | None = None) -> NoReturn:
    """Entry point: a wrong input is one message on stderr and exit status 2."""
    import os
    import warnings

    from hydrocrane.errors import HydrocraneError

    warnings.showwarning = lambda message, *_, **__: warn(str(message))
    try:
        try:
            app(arguments)
        finally:
            sys.stdout.flush()
    except HydrocraneError as error:
        complain(str(error))
    except OSError as error:
        complain(f"{error.strerror}: {error.filename or 'what is printed cannot be written'}")
        if error.filename is None:
            # Python would try to write it again at the end.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    sys.exit(2)
