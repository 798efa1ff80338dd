"""The PATU 655 log crane: weight, friction and payload against its measured pressures; a section of measured.md."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import hydrocrane as hc
from hydrocrane.logs import read_log
from hydrocrane.plots.style import COLOURS, INK, one_chart, styled, write

MACHINE = Path(__file__).with_name("measured") / "patu655.toml"
CYCLE = "patu_pvg32_cycle.csv"
# Distance of the pins at mid-stroke, mm; the log has distances of pins.
MIDDLE = {"lift": 820.0 + 535.0 / 2, "tilt": 1050.0 + 780.0 / 2}
LENGTHS = {"lift": "s1_position_meas_mm", "tilt": "s2_position_meas_mm"}
PRESSURES = {"lift": ("p1", "p2"), "tilt": ("p3", "p4")}
# The crane lifts until then, s; what follows is judged.
LIFTED = 20.3
# The motion is slow, and the noise of the strokes makes accelerations of its own above, Hz.
BANDWIDTH = 0.5
# The measured force jumps by 3.7 to 4.9 kN between holding and lifting: half to a whole of it is friction.
FRICTION = (2150.0, 500.0)


def mapping() -> dict[str, object]:
    """Which column of the cycle is which signal."""
    signals: dict[str, object] = {}
    for cylinder in ("lift", "tilt"):
        offset = f"-{MIDDLE[cylinder]:g} mm"
        signals[f"cylinder.{cylinder}.x"] = {"column": LENGTHS[cylinder], "unit": "mm", "offset": offset}
        for side, name in zip(("p1", "p2"), PRESSURES[cylinder], strict=True):
            signals[f"cylinder.{cylinder}.{side}"] = {"column": f"{name}_pressure_meas_Pa", "unit": "Pa"}
    return {"time": {"column": "t_s", "unit": "s"}, "signal": signals}


def plan() -> hc.Scenario:
    return hc.Scenario(machine=str(MACHINE), payload=150.0, joints={"lift": 0.0, "tilt": -0.8})


def fits(folder: Path) -> dict[str, hc.Fit]:
    """Payload and friction by the first 13 s, by the whole lift, and with pistons at rest and the tilt's angle."""
    log = folder / CYCLE
    free: dict[str, tuple[float, float] | None] = {"payload.mass": None, "friction.lift.coulomb": None}
    known: dict[str, tuple[float, float] | None] = {"payload.mass": None, "friction.lift.coulomb": FRICTION}
    names = ["payload.mass", "friction.lift.coulomb"]
    offset = angle_offset(folder)
    tilted = {**known, "joint.tilt.q.zero": (offset, 0.03)}
    half, rest = (13.0, 27.1), (LIFTED, 27.1)

    def made(parameters: list[str], priors: dict, hold_out: tuple[float, float], at_rest: bool = False) -> hc.Fit:
        return hc.fit(
            plan(), log, parameters, mapping=mapping(), motion="measured", bandwidth=BANDWIDTH, at_rest=at_rest,
            hold_out=hold_out, priors=priors,
        )  # fmt: skip

    return {
        "alone": made(names, free, half),
        "jump": made(names, known, half),
        "all": made([*names, "joint.tilt.q.zero"], tilted, rest, at_rest=True),
    }


def angle_offset(folder: Path) -> float:
    """By how much the tilt angle from the measured length is above that of the angle sensors, rad, in the median."""
    log = read_log(folder / CYCLE, {"time": mapping()["time"]})
    machine = hc.load_machine(MACHINE)
    strokes = np.stack([log[LENGTHS[c]] - MIDDLE[c] for c in MIDDLE], axis=1) * 1e-3
    tilt = machine.joints_from_strokes(strokes)[:, 1]
    sensed = np.radians(log["z2_angle_meas_deg"] - log["z1_angle_meas_deg"])
    return float(np.median(tilt - sensed))


@styled
def residual_chart(found: hc.Fit) -> Figure:
    """Modelled less measured force of both cylinders over time; what was judged is shaded."""
    fig, axes = one_chart(7.5, 3.2)
    for colour, ((_, signal), d) in zip(COLOURS, found.differences.items(), strict=False):
        axes.plot(d.time, (d.run - d.log) * 1e-3, lw=1.2, color=colour, label=signal.split(".")[1])
    axes.axhline(0.0, color=INK, lw=0.8)
    axes.axvspan(LIFTED, float(found.task.models[0].record.time[-1]), color=INK, alpha=0.08, lw=0, label="judged")
    axes.set(xlabel="time [s]", ylabel="model - measurement [kN]", title="PATU 655: force of the cylinders")
    axes.legend(ncols=3)
    return fig


def _value(found: hc.Fit, name: str, factor: float, digits: str) -> str:
    low, high = found.interval(name)
    return f"{found.value(name) * factor:{digits}} [{low * factor:{digits}}, {high * factor:{digits}}]"


def _row(title: str, found: hc.Fit, largest: dict[str, float]) -> str:
    cells = [title, _value(found, "payload.mass", 1.0, ".0f"), _value(found, "friction.lift.coulomb", 1e-3, ".1f")]
    of = {q.signal.split(".")[1]: q for q in found.quality}
    for cylinder in ("lift", "tilt"):
        q = of.get(cylinder)
        rms = (q.rms, q.held_out) if q is not None else (np.nan, np.nan)
        cells += [f"{r * 1e-3:.2f} ({r / largest[cylinder]:.1%})" if np.isfinite(r) else "-" for r in rms]
    return f"| {' | '.join(cells)} |"


def section(folder: Path) -> list[str]:
    """The section of the page; its picture is written beside the page."""
    found = fits(folder)
    whole = found["all"]
    write(residual_chart(whole), MACHINE.with_name("patu.png"))
    largest = {signal.split(".")[1]: float(np.abs(d.log).max()) for (_, signal), d in whole.differences.items()}
    headings = "| fit | payload [kg] | Coulomb, lift [kN] | lift, rms [kN] | judged | tilt, rms [kN] | judged |"
    angle = np.degrees([angle_offset(folder), whole.value("joint.tilt.q.zero")])
    return [
        "## 3. PATU 655 log crane",
        "",
        f"`{CYCLE}`: the measured curves of public figures of <https://github.com/qkhadim22/DeepMechDyn> (commit "
        "be07e41), read at 100 Hz; the repository states no licence, and nothing of it is copied here. One cycle "
        f"of 27 s: the crane lifts its boom from 0.6 to {LIFTED:g} s and holds; the tilt cylinder stands still. "
        "Only the measured curves are used, none of the authors' models. Machine file: "
        "[patu655.toml](measured/patu655.toml), after the authors' publications.",
        "",
        "**Compared**: pressures times areas of both cylinders against weight, inertia and friction along the "
        f"measured strokes (`hc.fit`, measured motion, below {BANDWIDTH:g} Hz). Shares are of the largest force of a "
        f"cylinder, {largest['lift'] * 1e-3:.0f} kN and {largest['tilt'] * 1e-3:.0f} kN. Intervals are of 95 %.",
        "",
        headings,
        "|" + "---|" * 7,
        _row("0 to 13 s, moving, nothing known of friction", found["alone"], largest),
        _row("0 to 13 s, moving, friction by the jump", found["jump"], largest),
        _row(f"0 to {LIFTED:g} s, both cylinders, at rest too", whole, largest),
        "",
        "*Friction by the jump*: the measured force jumps by 3.7 to 4.9 kN between holding and lifting, half to all "
        f"of which is friction; taken as {FRICTION[0] * 1e-3:g} kN, standard deviation {FRICTION[1] * 1e-3:g} kN.",
        "",
        "Warnings of the first fit:",
        "",
        *(f"* {text.replace(f'{folder / CYCLE}: ', '')}" for text in found["alone"].warnings),
        "",
        "The payload is not stated with the data. The angle sensors and the length of the tilt cylinder disagree by "
        f"{angle[0]:.1f} deg in the median; the last fit leaves that angle free about this value and finds "
        f"{angle[1]:.1f} deg. A piston at rest has some friction between minus and plus break-away; the tilt cylinder "
        "rests throughout, so its residual only shows that it stays within this range.",
        "",
        "**Driven by its logged commands** the crane is simulated in [a page of its own](measured-pvg32.md), with the "
        "pressure-compensated sections of its PVG 32.",
        "",
        "![residuals](measured/patu.png)",
        "",
    ]
