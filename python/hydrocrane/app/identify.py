"""``hydrocrane rig``, ``identify`` and ``fit``: the friction rig, and values of a machine file from logs."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from hydrocrane.app.arguments import Payload, Settings, choice, headless, number
from hydrocrane.app.console import complain, plain_table, reporting, say, waiting

if TYPE_CHECKING:
    from rich.table import Table

    from hydrocrane.identification.records import HoldOut
    from hydrocrane.identification.static.maps import Exponents
    from hydrocrane.identification.values.parameters import Prior
    from hydrocrane.rig import RigLog
    from hydrocrane.rig.running import RunSettings

rig = typer.Typer(name="rig", help="The virtual friction rig.", no_args_is_help=True)


@rig.callback()
def _rig_group() -> None:
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
    from hydrocrane.logs.formats.writers import checked_suffix
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


identify = typer.Typer(name="identify", help="Identification from measured logs.", no_args_is_help=True)


@identify.callback()
def _identify_group() -> None:
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


class MotionChoice(StrEnum):
    simulated = "simulated"
    measured = "measured"


class InterpolationChoice(StrEnum):
    linear = "linear"
    hold = "hold"


def fit(
    scenario: Annotated[str, typer.Argument(help="Bundled scenario or path of a scenario file.")],
    logs: Annotated[list[Path], typer.Argument(help="Measured logs.")],
    parameter: Annotated[list[str], typer.Option("-p", "--parameter", help="Key to fit; repeat for more.")],
    mapping: Annotated[Path | None, typer.Option(help="Mapping of columns to signals, TOML.")] = None,
    signal: Annotated[list[str], typer.Option(help="Compare only this signal; repeat for more.")] = [],  # noqa: B006
    motion: Annotated[
        MotionChoice, choice(MotionChoice, "Simulate the motion, or take it as measured and compare forces.")
    ] = MotionChoice.simulated,
    interpolation: Annotated[
        InterpolationChoice, choice(InterpolationChoice, "Interpolation of a logged command between samples.")
    ] = InterpolationChoice.linear,
    bandwidth: Annotated[float, number("Bandwidth of a measured motion, Hz.")] = 2.0,
    window: Annotated[str | None, typer.Option(help="Part of the logs, FROM:TO, s.")] = None,
    hold_out: Annotated[str | None, typer.Option(help="Compared, not fitted: last share, 0.3, or FROM:TO, s.")] = None,
    prior: Annotated[
        list[str], typer.Option(help="Standard deviation, SI: KEY=VALUE, or KEY=none; repeat for more.")
    ] = [],  # noqa: B006
    tie: Annotated[
        list[str], typer.Option(help="Key in proportion to a parameter: KEY=PARAMETER; repeat for more.")
    ] = [],  # noqa: B006
    settings: Settings = [],  # noqa: B006
    payload: Payload = None,
    starts: Annotated[int, number("Number of searches; all but the first start from drawn values.", int)] = 1,
    seed: Annotated[int, number("Draws the starts.", int)] = 0,
    report: Annotated[Path | None, typer.Option(help="Page with values, quality, pictures: .html.")] = None,
    write: Annotated[Path | None, typer.Option(help="Part of a machine file: .toml.")] = None,
) -> None:
    """Fit values of a machine file, and errors of sensors, to measured logs; tell intervals and doubts."""
    import hydrocrane as hc
    from hydrocrane.app.options import overrides, stretch, wanted_suffix
    from hydrocrane.scenario.changes import Changes

    headless()
    wanted_suffix("--report", report, ".html", ".htm")
    wanted_suffix("--write", write, ".toml")
    changes: Changes = {"overrides": overrides(settings)}
    if payload is not None:
        changes["payload"] = payload
    with reporting() as tell:
        found = hc.fit(
            scenario, logs, parameter, mapping=mapping, signals=signal or None, motion=motion.value,
            interpolation=interpolation.value, bandwidth=bandwidth,
            window=stretch("--window", window, "0:20"), hold_out=_hold_out(hold_out),
            priors=dict(map(_prior, prior)), ties=dict(map(_tie, tie)), starts=starts, starts_seed=seed, progress=tell,
            **changes,
        )  # fmt: skip
    say(found.summary())
    written = [] if write is None else [found.write(write)]
    if report is not None:
        written.append(found.report().write(report))
    if written:
        say("", "written:", *(f"  {path}" for path in written))


def _hold_out(text: str | None) -> HoldOut:
    from hydrocrane.app.options import stretch
    from hydrocrane.errors import InputError
    from hydrocrane.units import plain_number

    if text is None or ":" in text:
        return stretch("--hold-out", text, "10:20")
    try:
        return plain_number(text)
    except ValueError:
        raise InputError(f"--hold-out takes a share such as 0.3, or FROM:TO in s; got `{text}`") from None


def _tie(text: str) -> tuple[str, str]:
    from hydrocrane.errors import InputError

    key, _, leader = text.partition("=")
    if not (key.strip() and leader.strip()):
        raise InputError(
            f"--tie takes KEY=PARAMETER, for example friction.lift.breakaway=friction.lift.coulomb; got `{text}`"
        )
    return key.strip(), leader.strip()


def _prior(text: str) -> tuple[str, Prior]:
    from hydrocrane.errors import InputError
    from hydrocrane.units import plain_number

    key, _, value = text.partition("=")
    try:
        return key.strip(), None if value.strip() == "none" else plain_number(value)
    except ValueError:
        raise InputError(
            f"--prior takes KEY=VALUE in SI, for example payload.mass=20, or KEY=none; got `{text}`"
        ) from None
