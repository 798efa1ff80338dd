"""``hydrocrane fit``: values of a machine file fitted to logs."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrocrane.app.arguments import Payload, Settings, choice, headless, number
from hydrocrane.app.console import reporting, say

if TYPE_CHECKING:
    from hydrocrane.fitting.parameters import Prior
    from hydrocrane.fitting.records import HoldOut


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
