"""Logs of measured machines, judged on parts held out; writes docs/validation/measured.md.

    python docs/validation/measured.py --data FOLDER

FOLDER holds the files that the page names; none of them is part of the project. Takes about a minute.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import measured_patu as patu
import numpy as np
from matplotlib.figure import Figure

from hydrocrane.arrays import Array
from hydrocrane.identification import FrictionPoints, StaticFit, fit_static
from hydrocrane.identification.report import interval
from hydrocrane.logs import Log, read_log
from hydrocrane.plots.style import INK, MUTED, one_chart, styled, write
from hydrocrane.signals import RigParameters, derivative, steady_windows
from hydrocrane.signals.windows import SteadyWindows

PAGE = Path(__file__).with_name("measured.md")
PICTURES = Path(__file__).with_name("measured")
# Two speeds each way cannot tell an exponent: friction grows in proportion to speed.
LINEAR = {"viscous-exponent": 1.0}

# --- 1. MBARI -------------------------------------------------------------------------------------------------------

WEC = "mbari_friction_moves_50Hz.exp.gz"
INCH = 0.0254
HYDRAULIC, UPPER, LOWER = 1.375 * INCH**2, 0.0127, 0.0115
# Enters the check for vibration only; the moving mass is not stated.
WEC_MASS = 500.0
SPLIT, MOVES = 200.0, 0.01


class Judged(NamedTuple):
    """Speeds (n,) of a part held out, m/s, with the force measured, predicted, and predicted without friction, N."""

    speed: Array
    measured: Array
    predicted: Array
    frictionless: Array

    @property
    def rms(self) -> float:
        return _rms(self.predicted - self.measured)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def wec_log(folder: Path) -> tuple[Log, Array]:
    """The log as a rig's, and the pull of the test machine, N.

    Outwards is the sense in which the position grows. The hydraulic piston is pushed out by the upper pressure and in
    by the lower one, on equal areas; what the rod does to its surroundings is less than that by the friction: the
    lower gas spring, less the upper one, less the pull of the test machine.
    """
    log = read_log(folder / WEC)
    pull = log["TestMachineForce"]
    gas = log["LowerSpringPressure"] * LOWER - log["UpperSpringPressure"] * UPPER
    columns = {"time": log.time, "x": log["Pos"], "p1": log["UpperHydPress"], "p2": log["LowerHydPress"]}
    return Log.of(columns | {"force": gas - pull}, source=WEC), pull


def wec_windows(log: Log) -> SteadyWindows:
    rig = RigParameters(HYDRAULIC, HYDRAULIC, mass=WEC_MASS)
    return steady_windows(log, rig, load_cell=True)


def wec_judged(log: Log, pull: Array, fit: StaticFit) -> dict[str, Judged]:
    """The pull on the last part of the log, at held speeds and in all motion, up to the fitted speeds and beyond."""
    rate = 1.0 / float(np.median(np.diff(log.time)))
    speed = derivative(log["x"], rate).value
    known = pull + log["force"] + (log["p2"] - log["p1"]) * HYDRAULIC
    predicted = known + fit.force(speed)
    last, moving = log.time >= SPLIT, np.abs(speed) > MOVES
    held = np.zeros(log.time.size, dtype=bool)
    for window in wec_windows(log.between(SPLIT, np.inf)):
        held |= (log.time >= window.start) & (log.time <= window.end)
    within = np.abs(speed) <= 1.05 * fit.points.speed.max()
    parts = {
        "held speeds, within those of the fit": last & held & within,
        "held speeds, beyond them": last & held & ~within,
        "all motion, within the speeds of the fit": last & moving & within,
        "all motion, beyond them": last & moving & ~within,
        "all motion": last & moving,
    }
    return {name: Judged(speed[part], pull[part], predicted[part], known[part]) for name, part in parts.items()}


# --- 2. servo cylinder ----------------------------------------------------------------------------------------------

SERVO = "servo_cylinder_p{side}_{volts}V_{sample}_1kHz.csv.gz"
VOLTS = (2, 3, 4, 5)
BORE, ROD = 0.016, 0.010
# Enters the check for vibration only; the moving mass is not stated.
SERVO_MASS = 2.0
POSITION, PRESSURE = "0.02 m", "10 bar"


def servo_log(folder: Path, volts: int, sample: int) -> Log:
    """Two runs as one log: position and piston-side pressure of one, rod-side pressure of the other.

    They are put side by side by the time since the valve opened.
    """
    columns = {"command": {"column": "valve_V", "unit": "V"}}
    runs = {}
    for side, name in (("A", "p1"), ("B", "p2")):
        mapping = {
            "signal": columns
            | {"x": {"column": "position_V", "unit": POSITION}, name: {"column": "pressure_V", "unit": PRESSURE}}
        }
        path = folder / SERVO.format(side=side, volts=volts, sample=sample)
        runs[side] = read_log(path, mapping)
    start = {side: log.time[np.argmax(log["command"] > 0.5 * volts)] for side, log in runs.items()}
    first, second = runs["A"], runs["B"]
    since = first.time - start["A"]
    other = second.time - start["B"]
    p2 = np.interp(since, other, second["p2"], left=np.nan, right=np.nan)
    signals = {"time": since, "x": first["x"], "p1": first["p1"], "p2": p2, "command": first["command"]}
    return Log.of(signals, source=first.source)


def servo_points(folder: Path, sample: int) -> FrictionPoints:
    areas = np.pi / 4.0 * np.array([BORE**2, BORE**2 - ROD**2])
    rig = RigParameters(float(areas[0]), float(areas[1]), mass=SERVO_MASS)
    logs = [steady_windows(servo_log(folder, volts, sample), rig) for volts in VOLTS]
    return FrictionPoints.joined([FrictionPoints.from_windows(windows) for windows in logs if len(windows)])


# --- the page -------------------------------------------------------------------------------------------------------


def missing(folder: Path) -> list[str]:
    """Names of the files that are not in the folder."""
    names = [WEC, patu.CYCLE, *(SERVO.format(side=s, volts=v, sample=k) for s in "AB" for v in VOLTS for k in (1, 2))]
    return [name for name in names if not (folder / name).is_file()]


def said(fit: StaticFit) -> list[str]:
    """The warnings of a fit as a list."""
    return ["Warnings of the fit:", "", *(f"* {text}" for text in fit.warnings)] if fit.warnings else []


def parameter_table(fit: StaticFit) -> list[str]:
    rows = ["| parameter | value | 95 % interval | unit |", "|---|---|---|---|"]
    ranges = fit.intervals(0.95)
    for label in ("coulomb.extending", "viscous.extending", "coulomb.retracting", "viscous.retracting"):
        ends = interval(*ranges[label]).replace("..", "to")
        rows.append(f"| `{label}` | {fit.value(label):.4g} | {ends} | {fit.unit(label)} |")
    return rows


@styled
def residual_chart(
    fitted: tuple[Array, Array], held_out: tuple[Array, Array], title: str, cloud: tuple[Array, Array] | None = None
) -> Figure:
    """Prediction less measurement over velocity, N over mm/s: windows fitted and held out, and single samples."""
    figure, axes = one_chart(7.5, 3.6)
    if cloud is not None:
        axes.plot(cloud[0] * 1e3, cloud[1], ".", ms=1.5, alpha=0.25, color=MUTED, label="held out, every tenth sample")
    axes.plot(held_out[0] * 1e3, held_out[1], "s", ms=5, mfc="white", label="held out, steady windows")
    axes.plot(fitted[0] * 1e3, fitted[1], "o", ms=5, label="fitted")
    axes.axhline(0.0, color=INK, lw=0.8)
    axes.set(xlabel="velocity [mm/s]", ylabel="prediction - measurement [N]", title=title)
    axes.legend()
    return figure


def _residuals(points: FrictionPoints, fit: StaticFit) -> tuple[Array, Array]:
    return points.velocity, fit.force(points.velocity) - points.force


def wec_section(folder: Path) -> list[str]:
    log, pull = wec_log(folder)
    fitted = FrictionPoints.from_windows(wec_windows(log.between(-np.inf, SPLIT)))
    held_out = FrictionPoints.from_windows(wec_windows(log.between(SPLIT, np.inf)))
    fit = fit_static(fitted, exponents=LINEAR)
    judged = wec_judged(log, pull, fit)
    moving = judged["all motion"]
    figure = residual_chart(
        _residuals(fitted, fit),
        _residuals(held_out, fit),
        "MBARI: friction of the first 200 s, judged on the last 200 s",
        (moving.speed[::10], (moving.predicted - moving.measured)[::10]),
    )
    write(figure, PICTURES / "mbari.png")
    span = float(np.ptp(pull[log.time >= SPLIT]))
    rows = [
        "| part of the last 200 s | samples | rms [N] | share of the range | rms without friction [N] |",
        "|---|---|---|---|---|",
    ]
    for name, part in judged.items():
        if part.speed.size:
            cells = (
                part.speed.size,
                f"{part.rms:.0f}",
                f"{part.rms / span:.1%}",
                f"{_rms(part.frictionless - part.measured):.0f}",
            )
            rows.append(f"| {name} | {' | '.join(map(str, cells))} |")
    top = fitted.speed.max()
    shift = 0.5 * (fit.value("coulomb.extending") - fit.value("coulomb.retracting"))
    return [
        "## 1. Cylinder of a wave-energy converter (MBARI)",
        "",
        f"`{WEC}`: `FrictionIDMovesWithBiasCurr.exp` of <https://github.com/osrf/mbari_wec_gz> (commit 71fe25a, "
        "folder `buoy_tests/test_inputdata`), packed with gzip. Licence Apache-2.0. A test machine pulls a "
        "hydraulic piston with gas springs at held speeds; position, pressures and pull at 50 Hz for 400 s.",
        "",
        "**Balance.** Pull of the test machine = lower gas spring - upper gas spring + (lower - upper hydraulic "
        "pressure) x area + friction. Areas by the source: hydraulic piston 1.375 in^2 both ways, gas springs "
        "0.0127 m^2 (upper) and 0.0115 m^2 (lower). Velocity is positive when the position increases. Gas pressures "
        "are read as absolute and hydraulic ones as gauge, as the header says.",
        "",
        "**Assumed.** The areas hold for this machine; the pull is positive outwards (its sign follows from the "
        "gas springs: it rises by the force that they gain over the stroke); `lbs` are pounds-force; inertia is "
        f"neglected, because the moving mass is not stated ({WEC_MASS:g} kg only in the check for vibration).",
        "",
        "**Cannot be known.** Weight, the air's pressure on the rod, and zeros of pressures and load cell add up "
        "to one constant force. No data here separate it from Coulomb friction that differs between the directions. "
        f"If Coulomb friction is equal in both directions, the constant is {shift:.0f} N. Pressure is measured at the "
        "manifold or in the chamber: pressure losses between them count as friction.",
        "",
        f"Fitted to {len(fitted)} steady windows of the first 200 s, which hold speeds up to {top * 1e3:.0f} mm/s "
        "only: two levels each way. So friction is modelled as a constant plus a part proportional to speed. Nothing "
        "checks that form, and values above those speeds are extrapolated.",
        "",
        *parameter_table(fit),
        "",
        f"The last 200 s go up to {moving.speed.max() * 1e3:.0f} mm/s; the pull ranges over {span:.0f} N. *Held "
        f"speeds* are samples within steady windows, *all motion* those faster than {MOVES * 1e3:g} mm/s, with "
        "starts and stops.",
        "",
        *rows,
        "",
        "The range is mostly that of gas springs and oil pressure, which are measured; the last column says how "
        "large the error of the same balance is without friction.",
        "",
        _beyond(held_out, fit, top),
        "",
        "![residuals](measured/mbari.png)",
        "",
    ]


def _beyond(held_out: FrictionPoints, fit: StaticFit, top: float) -> str:
    """How far the map is off the steady windows beyond the speeds that it was fitted to."""
    velocity, off = _residuals(held_out, fit)
    parts = []
    for sign, word in ((1.0, "extending"), (-1.0, "retracting")):
        here = sign * off[sign * velocity > 1.05 * top]
        side = "above" if here.mean() > 0.0 else "below"
        sizes = f"{abs(here.mean()):.0f} N {side} the steady windows in the mean, {np.abs(here).max():.0f} N at most"
        parts.append(f"{word} they lie {sizes}")
    return (
        f"Beyond {top * 1e3:.0f} mm/s the straight lines of the slow part are continued: {parts[0]}; {parts[1]}. "
        "Friction of this machine is not linear in speed."
    )


def servo_section(folder: Path) -> list[str]:
    fitted, held_out = servo_points(folder, 1), servo_points(folder, 2)
    fit = fit_static(fitted, exponents=LINEAR)
    errors = _residuals(held_out, fit)
    write(
        residual_chart(
            _residuals(fitted, fit), errors, "servo cylinder 16/10 mm: fitted to sample 1, judged on sample 2"
        ),
        PICTURES / "servo.png",
    )
    span, rms = float(np.ptp(held_out.force)), _rms(errors[1])
    return [
        "## 2. Servo cylinder 16/10 mm",
        "",
        f"`{SERVO.format(side='{A,B}', volts='{2..5}', sample='{1,2}')}`: from "
        "<https://github.com/ingxfm/find-the-viscous-friction-value-from-a-bunch-of-.mat-data-files>, averaged "
        "from 10 kHz to 1 kHz. No licence is stated; nothing of it is copied here. A servo valve at a constant "
        "voltage moves a free piston out and back. Position 0.02 m/V, pressure 10 bar/V.",
        "",
        "**Pairing.** The pressures of both sides come from separate runs. A run of side A and one of side B of "
        "the same voltage and the same sample number are aligned by the time since the valve opened; "
        "position and velocity are those of the run of side A. Friction = p_A A_A - p_B A_B.",
        "",
        "**Assumed.** Equal voltages give equal motion in both runs; the cylinder is horizontal, so no weight acts; "
        "bore 16 mm and rod 10 mm are exact; the pressure sensors have no zero error. The moving mass "
        f"({SERVO_MASS:g} kg) enters only the check for vibration.",
        "",
        "The position repeatedly stays at one value at the far end of the stroke (flag `clipped`): its "
        "range ends there, and such samples are in no window.",
        "",
        "**Cannot be known.** A zero error of 0.1 bar on side A moves friction by 2.0 N, one on side B by 1.2 N, "
        "with opposite signs out and back: it is part of both Coulomb frictions, but not of the intervals.",
        "",
        f"Fitted to {len(fitted)} steady windows of sample 1. Form, chosen by likelihood with viscous exponent 1: "
        f"{fit.form_text}.",
        "",
        *parameter_table(fit),
        "",
        *said(fit),
        "",
        f"Compared with {len(held_out)} windows of sample 2: rms {rms:.2f} N, largest {np.abs(errors[1]).max():.2f} N; "
        f"{rms / float(np.mean(np.abs(held_out.force))):.1%} of the mean friction, {rms / span:.1%} of the range "
        "over both directions.",
        "",
        "![residuals](measured/servo.png)",
        "",
    ]


def page(folder: Path) -> str:
    """The page, from the files in the folder; pictures are written beside it."""
    PICTURES.mkdir(exist_ok=True)
    lines = [
        "# Measured machines",
        "",
        "<!-- generated by docs/validation/measured.py -->",
        "",
        "Logs of machines that others measured, compared on parts that were not fitted: friction identified from two "
        "cylinders, and weight, friction and payload of a crane against its pressures. A simulated motion of a "
        "crane is compared with a measured one [on another page](measured-pvg32.md). The data are not part of "
        "the project: `python "
        "docs/validation/measured.py --data FOLDER` makes this page from a folder with the files that each section "
        "names.",
        "",
        *wec_section(folder),
        *servo_section(folder),
        *patu.section(folder),
    ]
    return "\n".join(lines).rstrip() + "\n"


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, metavar="FOLDER", help="folder with the measured logs")
    folder = parser.parse_args(arguments).data
    lacking = missing(folder)
    if lacking:
        shown = ", ".join(lacking[:4]) + (f" and {len(lacking) - 4} more" if len(lacking) > 4 else "")
        parser.error(f"{folder} lacks {shown}; docs/validation/measured.md says where each file can be had")
    PAGE.write_text(page(folder), encoding="utf-8")


if __name__ == "__main__":
    main()
