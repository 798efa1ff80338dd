"""Table 3: static parameters, out of the rig's logs and back."""

from __future__ import annotations

from laboratory import RIGS
from static_maps import LOADS, identified, truth

# Shares by which a parameter may be off with noise and converters alone.
ALLOWED = {"coulomb": 0.05, "breakaway": 0.05, "viscous": 0.05, "stribeck-velocity": 0.15}
DIRECTIONS = ("extending", "retracting")
ROWS = tuple((cylinder, load) for cylinder in RIGS for load in LOADS)


def printed() -> dict[str, float]:
    """Table 3 by cylinder, load, parameter and direction."""
    return {
        f"{cylinder}.{load}.{name}.{direction}": value
        for cylinder, load in ROWS
        for name in ALLOWED
        for direction, value in zip(DIRECTIONS, truth(cylinder, load).pairs[name])
    }


def compute() -> dict[str, float]:
    numbers, worst = {}, 0.0
    for key, value in printed().items():
        cylinder, load, name, direction = key.split(".")
        fits = (identified(cylinder, int(load), ideal).fit for ideal in (False, True))
        numbers[key], clean = (fit.params[name][DIRECTIONS.index(direction)] for fit in fits)
        numbers[f"{key}.noise-only"] = clean
        worst = max(worst, abs(clean / value - 1) / ALLOWED[name])
    return numbers | {"largest_error_of_allowed": worst}


def repeatability(key: str) -> float:
    """Least-squares solutions repeat to their step tolerance, not to rounding."""
    return 1e-5 if "velocity" in key else 2e-2


def report(numbers: dict[str, float]) -> list[str]:
    """Table 3 as printed and as it comes back."""
    lines = [
        "Each cell is extending / retracting. *Rig*: sensors as in the data sheets after a zero calibration. *Noise*: "
        "noise and converters alone.",
        "",
        "| cylinder, load | | alpha_0 [N] | alpha_0 + alpha_1 [N] | alpha_2 | v_sigma [mm/s] |",
        "|---|---|---|---|---|---|",
    ]
    table = printed()
    for cylinder, load in ROWS:
        for title, values, ending in (("printed", table, ""), ("rig", numbers, ""), ("noise", numbers, ".noise-only")):
            cells = []
            for name in ALLOWED:
                scale = 1e3 if "velocity" in name else 1.0
                pair = (scale * values[f"{cylinder}.{load}.{name}.{d}{ending}"] for d in DIRECTIONS)
                cells.append(" / ".join(f"{value:.5g}" if value > 1e3 else f"{value:.3g}" for value in pair))
            lines.append(f"| {cylinder}, {load} kg | {title} | " + " | ".join(cells) + " |")
    worst = max(abs(numbers[key] / value - 1) for key, value in table.items())
    return [*lines, "", f"With the sensors of the data sheets the worst parameter is off by {100 * worst:.0f} %."]
