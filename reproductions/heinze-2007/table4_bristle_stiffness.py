"""Table 4: bristle stiffness from ramps, by (123) to (126) as printed, as corrected (E18), and by fit."""

from __future__ import annotations

import numpy as np
from bristle_fits import fit
from laboratory import RIGS, experiment, motion
from scipy.integrate import cumulative_trapezoid
from static_maps import truth

# Averages of the table, "x 10e5" read as x 10^5 (E20), N/m.
PRINTED = {"Rottne": 1.1e5, "Kalmar": 1.1e6}
RAMP = {"speed": 0.25, "last": 1.0}
# The ramp is read up to this share of the break-away force: (124) takes the seal's force at rest for all of it.
READ = 0.9
WAYS = ("printed", "corrected", "measured force")
DIRECTIONS = ("extending", "retracting")


def deflection(way: str, time: np.ndarray, x: np.ndarray, force: np.ndarray, limit: float) -> np.ndarray:
    """Bristle deflection (n,), m, from the piston's way x (m) since the bristles were straight.

    (125) as printed and as corrected take the force as c t; (124) itself can take it as measured.
    """
    if way == "measured force":
        return cumulative_trapezoid(1 - force / limit, x, initial=0.0)
    rate = float(time @ force / (time @ time))
    under = cumulative_trapezoid(x, time, initial=0.0)
    if way == "printed":
        return x - rate / (2 * limit) * (x * time + under)
    return x - rate / limit * (x * time - under)


def stretch(cylinder: str, side: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time (s), way (m) and friction (N) from straight bristles to just before the break-away, positive.

    The retracting ramp begins with bristles bent by the extending one: they are straight where friction is zero.
    """
    duration = motion("ramp", cylinder, side, 0.0, **RAMP)["time"][-1]
    found = motion("ramp", cylinder, side, duration / 200, **RAMP)
    sign = 1.0 if side == 0 else -1.0
    force = sign * found["friction"]
    begin = 0 if side == 0 else int(np.argmax(force > 0))
    force = force - (force[0] if side == 0 else 0.0)
    end = int(np.argmax(force > READ * force.max()))
    here = slice(begin, end)
    return (
        found["time"][here] - found["time"][begin],
        sign * (found["x"][here] - found["x"][begin]),
        force[here],
    )


def stiffness(cylinder: str, side: int, way: str) -> float:
    """sigma_0 = Z^T U / Z^T Z   (126), N/m."""
    time, x, force = stretch(cylinder, side)
    z = deflection(way, time, x, force, truth(cylinder, 0).pairs["breakaway"][side])
    return float(z @ force / (z @ z))


def compute() -> dict[str, float]:
    numbers = {}
    for cylinder in RIGS:
        crane = experiment("ramp", cylinder, **RAMP).run.machine
        true = float(crane.value("friction.test.bristle-stiffness").si)
        for way in WAYS:
            for side, direction in enumerate(DIRECTIONS):
                numbers[f"{cylinder}.{way}.{direction}"] = stiffness(cylinder, side, way) / true
        fitted, (low, high) = fit(cylinder).params, fit(cylinder).intervals()["bristle-stiffness"]
        numbers[f"{cylinder}.fit"] = fitted["bristle-stiffness"] / true
        numbers[f"{cylinder}.fit.low"], numbers[f"{cylinder}.fit.high"] = low / true, high / true
        numbers[f"{cylinder}.off_the_table"] = abs(fitted["bristle-stiffness"] / PRINTED[cylinder] - 1)
    return numbers | {"largest_distance": max(numbers[f"{cylinder}.off_the_table"] for cylinder in RIGS)}


def repeatability(key: str) -> float:
    """The fit stops somewhere in a flat valley, within a part of its standard deviation."""
    return 1e-2 if ".fit" in key or "distance" in key or "table" in key else 1e-6


def report(numbers: dict[str, float]) -> list[str]:
    """What each way gives, as a share of the stiffness that the rig has."""
    lines = ["| sigma_0 over that of the rig | extending | retracting |", "|---|---|---|"]
    titles = dict(zip(WAYS, ("(125) as printed", "(125) corrected", "(124) with the measured force")))
    for cylinder in RIGS:
        for way, title in titles.items():
            cells = " | ".join(f"{numbers[f'{cylinder}.{way}.{d}']:.2f}" for d in DIRECTIONS)
            lines.append(f"| {cylinder}, {title} | {cells} |")
        fitted, low, high = (numbers[f"{cylinder}.fit{end}"] for end in ("", ".low", ".high"))
        lines.append(f"| {cylinder}, fit, 95 % interval | {fitted:.4f}, {low:.4f} to {high:.4f} | both at once |")
    return lines
