"""Table 3: static parameters, out of the rig's logs and back."""

from __future__ import annotations

import numpy as np
from laboratory import RIGS
from static_maps import LOADS, identified, truth

NAMES = ("coulomb", "breakaway", "viscous", "stribeck-velocity")
# Shares by which a parameter may be off with noise and converters alone.
ALLOWED = {"coulomb": 0.05, "breakaway": 0.05, "viscous": 0.05, "stribeck-velocity": 0.15}
DIRECTIONS = ("extending", "retracting")


def compute() -> dict[str, float]:
    numbers, worst = {}, 0.0
    for cylinder in RIGS:
        for load in LOADS:
            row = truth(cylinder, load).pairs
            for name in NAMES:
                for side, direction in enumerate(DIRECTIONS):
                    found = identified(cylinder, load).fit.params[name][side]
                    ideal = identified(cylinder, load, ideal=True).fit.params[name][side]
                    key = f"{cylinder}.{load}.{name}.{direction}"
                    numbers[key], numbers[f"{key}.noise-only"] = found, ideal
                    worst = max(worst, abs(ideal / row[name][side] - 1) / ALLOWED[name])
    return numbers | {"largest_error_of_allowed": worst}


def repeatability(key: str) -> float:
    """Least-squares solutions repeat to their step tolerance, not to rounding."""
    return 1e-6 if "velocity" in key else 1e-2


def _cell(row: dict[str, tuple[float, float]], name: str, scale: float) -> str:
    return " / ".join(f"{scale * value:.4g}" for value in row[name])


def report(numbers: dict[str, float]) -> list[str]:
    """Table 3 as printed and as it comes back."""
    lines = [
        "Each cell is extending / retracting. *Rig*: sensors as in the data sheets after a zero calibration. *Noise*: noise "
        "and converters alone.",
        "",
        "| cylinder, load | | alpha_0 [N] | alpha_0 + alpha_1 [N] | alpha_2 | v_sigma [mm/s] |",
        "|---|---|---|---|---|---|",
    ]
    for cylinder in RIGS:
        for load in LOADS:
            rows = {"printed": truth(cylinder, load).pairs}
            for title, ending in (("rig", ""), ("noise", ".noise-only")):
                rows[title] = {
                    name: tuple(numbers[f"{cylinder}.{load}.{name}.{d}{ending}"] for d in DIRECTIONS) for name in NAMES
                }
            for title, row in rows.items():
                cells = (_cell(row, name, 1e3 if "velocity" in name else 1.0) for name in NAMES)
                lines.append(f"| {cylinder}, {load} kg | {title} | " + " | ".join(cells) + " |")
    worst = max(
        abs(numbers[f"{c}.{load}.{n}.{d}"] / np.array(truth(c, load).pairs[n])[i] - 1)
        for c in RIGS for load in LOADS for n in NAMES for i, d in enumerate(DIRECTIONS)
    )  # fmt: skip
    return [*lines, "", f"With the sensors of the data sheets the worst parameter is off by {100 * worst:.0f} %."]
