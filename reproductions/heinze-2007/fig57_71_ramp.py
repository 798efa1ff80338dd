"""Figures 57, 58 and 71: the piston leaves its rest on a ramp of the spool: sticking, shearing, slipping."""

from __future__ import annotations

from functools import cache

import numpy as np
from common import figure, save
from laboratory import RIGS, experiment, motion, violations

from hydrocrane import rig

# Figure 57 goes on well into slipping; Figure 71 is the slow ramp from which sigma_0 is read.
THREE_PHASES = {"speed": 1.0, "last": 6.0}
SLOW = {"speed": 0.25, "last": 1.0}
# Figures 57 and 58 are drawn up to so many times the time of break-away.
SHOWN = 2.5
# The text: a maximum bristle deflection of approximately 4 mm, without load and direction.
STATED_DEFLECTION = 4e-3
LOADS = (0, 115)
DIRECTIONS = ("extending", "retracting")


@cache
def response(cylinder: str, slow: bool) -> dict[str, np.ndarray]:
    """Signals of the extending ramp, averaged over 1/200 of it."""
    ramp = SLOW if slow else THREE_PHASES
    duration = motion("ramp", cylinder, 0, 0.0, **ramp)["time"][-1]
    return motion("ramp", cylinder, 0, duration / 200, **ramp)


def phases(found: dict[str, np.ndarray]) -> tuple[int, int]:
    """Last samples of sticking and of shearing: friction has reached a tenth of the break-away force, and all of it."""
    peak = int(found["friction"].argmax())
    return reached(found, 0.1), peak


def reached(found: dict[str, np.ndarray], share: float) -> int:
    """First sample at which friction has grown by this share of its rise."""
    rise = found["friction"] - found["friction"][0]
    return int(np.argmax(rise > share * rise.max()))


def three_phases() -> list[bool]:
    """What the text says of Figures 57 and 58: friction rises slowly while the piston hardly moves; then the piston
    moves by what the bristles bend; last it slips with Coulomb and viscous friction and the bristles relax."""
    found = response("Rottne", False)
    stuck, broken = phases(found)
    half = reached(found, 0.5)
    time, way, bent, friction = found["time"], found["x"] - found["x"][0], found["z"], found["friction"]
    slopes = [(friction[b] - friction[a]) / (time[b] - time[a]) for a, b in ((0, stuck), (stuck, broken))]
    crane = experiment("ramp", "Rottne", **THREE_PHASES).run.machine
    slipping = crane.friction_map(found["velocity"][-1])
    return [
        slopes[0] < slopes[1],
        way[stuck] < 0.05 * way[broken],
        found["velocity"][stuck] < 0.2 * found["velocity"][broken],
        bent[half] - bent[stuck] > 2 / 3 * (way[half] - way[stuck]),
        abs(friction[-1] - slipping) < 0.1 * slipping,
        bent[-1] < 0.9 * bent.max(),
    ]


def deflections(cylinder: str, load: int) -> list[float]:
    """Largest bristle deflection (m) on the slow ramp, extending and retracting, with the row of Table 3 of a load."""
    overrides = rig.loaded_friction(RIGS[cylinder], load)
    log = experiment("ramp", cylinder, payload=load, overrides=overrides, **SLOW)
    return [float(np.abs(log.part(segment, truth=True).z).max()) for segment in log.segments]


def compute() -> dict[str, float]:
    numbers = {"statements_violated": violations(three_phases())}
    for cylinder in RIGS:
        found = response(cylinder, True)
        peak = phases(found)[1]
        numbers[f"{cylinder}_break_away_N"] = float(found["friction"][peak])
        for load in LOADS:
            for direction, z in zip(DIRECTIONS, deflections(cylinder, load), strict=True):
                numbers[f"{cylinder}_{load}kg_{direction}_deflection_m"] = z
        numbers[f"{cylinder}_way_to_break_away_m"] = float(found["x"][peak] - found["x"][0])
    found = [numbers[f"Rottne_{load}kg_{direction}_deflection_m"] for load in LOADS for direction in DIRECTIONS]
    off = max(min(found) - STATED_DEFLECTION, STATED_DEFLECTION - max(found), 0.0)
    return numbers | {"deflection_outside_of_the_range_m": off}


def report(numbers: dict[str, float]) -> list[str]:
    """Largest bristle deflections on the slow ramp."""
    lines = ["| largest bristle deflection [mm], row of Table 3 | extending | retracting |", "|---|---|---|"]
    for cylinder in RIGS:
        for load in LOADS:
            cells = " | ".join(f"{1e3 * numbers[f'{cylinder}_{load}kg_{d}_deflection_m']:.2f}" for d in DIRECTIONS)
            lines.append(f"| {cylinder}, {load} kg | {cells} |")
    return lines


def draw() -> None:
    draw_phases()
    fig, axes = figure(3, 2, (9.5, 7.5))
    for column, cylinder in zip(axes.T, RIGS):
        found = response(cylinder, True)
        until = int(1.5 * phases(found)[1])
        time = found["time"][:until]
        for axis, name, scale in ((column[0], "friction", 1.0), (column[1], "x", 1e3)):
            datum = found["x"][0] if name == "x" else 0.0
            axis.plot(time, scale * (found[f"raw_{name}"][:until] - datum), lw=0.5, color="0.7", label="as read")
            axis.plot(time, scale * (found[name][:until] - datum), label="averaged")
        column[0].legend(frameon=False, loc="lower right")
        column[2].plot(time, 1e3 * found["z"][:until])
        column[0].set(title=f"Figure 71, {cylinder}", ylabel="friction [N]")
        column[1].set(ylabel="position [mm]")
        column[2].set(xlabel="time [s]", ylabel="bristle deflection [mm]")
    save(fig, "fig57_71_ramp_71")


def draw_phases() -> None:
    found = response("Rottne", False)
    ends = [found["time"][k] for k in phases(found)]
    fig, axes = figure(3, 1, (7.0, 6.5))
    drawn = (
        ("Figure 57", "friction [N]", found["friction"]),
        ("", "velocity [mm/s]", 1e3 * found["velocity"]),
        ("Figure 58", "bristle deflection [mm]", 1e3 * found["z"]),
    )
    for axis, (title, label, values) in zip(axes[:, 0], drawn):
        axis.plot(found["time"], values)
        axis.set(title=title, ylabel=label, xlim=(0, SHOWN * ends[1]))
        for end in ends:
            axis.axvline(end, color="0.5", lw=0.8, ls="--")
    inside = found["time"] < SHOWN * ends[1]
    axes[1, 0].set_ylim(top=1.1e3 * found["velocity"][inside].max())
    for name, start, end in zip(("sticking", "shearing", "slipping"), (0.0, *ends), (*ends, SHOWN * ends[1])):
        axes[0, 0].text((start + end) / 2, 1.15 * found["friction"].max(), name, ha="center", fontsize=8)
    axes[0, 0].set_ylim(top=1.3 * found["friction"].max())
    axes[2, 0].set_xlabel("time [s]")
    save(fig, "fig57_71_ramp_57")
