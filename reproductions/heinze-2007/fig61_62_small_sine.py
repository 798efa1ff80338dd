"""Figures 61 and 62: a small sinusoid of the spool that just breaks the piston away, again and again."""

from __future__ import annotations

from functools import cache

import numpy as np
from common import figure, save
from laboratory import experiment, motion, violations

CYLINDER = "Rottne"
# Travel there and back, in slips of the bristles.
SINE = {"frequency": 0.2, "travel": 3.0, "cycles": 4}
AVERAGED = 0.1


@cache
def response() -> dict[str, np.ndarray]:
    return motion("small-sine", CYLINDER, 0, AVERAGED, **SINE)


def half_periods() -> list[dict[str, np.ndarray]]:
    """The signals between two turns, positive while extending; the first period, from rest, is left out."""
    found, half = response(), 0.5 / SINE["frequency"]
    pieces = []
    for k in range(2, 2 * SINE["cycles"]):
        here = (found["time"] >= k * half) & (found["time"] < (k + 1) * half)
        sign = 1.0 if k % 2 == 0 else -1.0
        pieces.append({name: sign * found[name][here] for name in ("x", "velocity", "friction", "z")})
    return pieces


def kink(piece: dict[str, np.ndarray]) -> float:
    """Slope of friction over position after the break-away as a share of that before it.

    Break-away is where friction has come through nine tenths of its swing.
    """
    rise, way = piece["friction"] - piece["friction"][0], piece["x"] - piece["x"][0]
    broken = int(np.argmax(rise > 0.9 * rise.max()))
    before, after = rise[broken] / way[broken], (rise.max() - rise[broken]) / (way[-1] - way[broken])
    return float(after / before)


def compute() -> dict[str, float]:
    pieces = half_periods()
    slips = [np.ptp(piece["x"]) - np.ptp(piece["z"]) for piece in pieces]
    kinks = [kink(piece) for piece in pieces]
    return {
        "halves_without_break_away": violations([one < 0.2 for one in kinks]),
        "halves_without_slip": violations([slip > 0.1 * np.ptp(p["x"]) for slip, p in zip(slips, pieces)]),
        "largest_slope_left_after_break_away": max(kinks),
        "smallest_slip_m": float(min(slips)),
        "largest_travel_m": float(max(np.ptp(piece["x"]) for piece in pieces)),
    }


def draw() -> None:
    found = response()
    log = experiment("small-sine", CYLINDER, **SINE)
    spool = log.part(log.segments[0]).command
    fig, axes = figure(4, 1, (8.0, 8.0))
    axes[0, 0].plot(spool.time - spool.time[0], 1e3 * spool)
    for axis, name, scale in ((axes[1, 0], "friction", 1.0), (axes[2, 0], "x", 1e3)):
        datum = found["x"][0] if name == "x" else 0.0
        axis.plot(found["time"], scale * (found[f"raw_{name}"] - datum), color="0.7", lw=0.4, label="as read")
        axis.plot(found["time"], scale * (found[name] - datum), label="averaged over 0.1 s")
    axes[3, 0].plot(found["time"], 1e3 * found["velocity"])
    axes[0, 0].set(ylabel="spool [mm]")
    axes[1, 0].set(title="Figure 61", ylabel="friction [N]", ylim=(None, 320))
    axes[1, 0].legend(frameon=False, loc="upper right", ncols=2)
    axes[2, 0].set(title="Figure 62", ylabel="position [mm]")
    axes[3, 0].set(xlabel="time [s]", ylabel="velocity [mm/s]")
    save(fig, "fig61_62_small_sine")
