"""Figures 91 and 92: linearity and hysteresis of the two load cells from the readings of their own certificates.

Arithmetic on the certificates alone; hydrocrane is not involved. Its load cells have the certified linearity and no
hysteresis (docs/theory/sensor/load_cell.md).
"""

from __future__ import annotations

import numpy as np

# Readings at 0, 50, 100, 50 and 0 % of the nominal force, mV/V, without their sign; linearity and hysteresis, %.
CELLS = {
    "50 kN": ((0.0, 0.4990, 0.9994, 0.4993, 0.0001), 0.049, 0.072),
    "10 kN": ((0.0, 0.5011, 1.0026, 0.5013, 0.0001), 0.012, 0.047),
}
READING_ROUNDING, PRINT_ROUNDING = 0.5e-4, 0.5e-3
LOADS = np.array([0.5, 1.0])


def linearity(up: np.ndarray) -> float:
    """Largest departure of the rising readings (2,) from the best line through zero, % of the last reading.

    The best line has departures of equal size and opposite sign at half and full force.
    """
    slope = up.sum() / LOADS.sum()
    return float(100 * np.abs(up - slope * LOADS).max() / up[-1])


def hysteresis(up: float, down: float) -> float:
    """Difference at half force, % of the rising reading."""
    return 100 * (down - up) / up


def compute() -> dict[str, float]:
    numbers = {}
    for cell, (readings, printed_linearity, printed_hysteresis) in CELLS.items():
        _, half, full, half_down, _ = readings
        found = {"linearity": linearity(np.array([half, full])), "hysteresis": hysteresis(half, half_down)}
        # Rounded readings: (2 half - full)/3 for the linearity, a difference of two for the hysteresis.
        allowed = {
            "linearity": 100 * READING_ROUNDING / full + PRINT_ROUNDING,
            "hysteresis": 100 * 2 * READING_ROUNDING / half + PRINT_ROUNDING,
        }
        printed = {"linearity": printed_linearity, "hysteresis": printed_hysteresis}
        for key, value in found.items():
            numbers[f"{cell}.{key}_percent"] = value
            numbers[f"{cell}.{key}_share_of_the_rounding"] = abs(value - printed[key]) / allowed[key]
        shares = [numbers[f"{cell}.{key}_share_of_the_rounding"] for key in found]
        numbers[f"{cell}.largest_share_of_the_rounding"] = max(shares)
    return numbers


def report(numbers: dict[str, float]) -> list[str]:
    """Printed and computed properties."""
    lines = ["| load cell | linearity, printed | from the readings | hysteresis, printed | from the readings |"]
    lines.append("|---|---|---|---|---|")
    for cell, (_, line, loop) in CELLS.items():
        found = (numbers[f"{cell}.{key}_percent"] for key in ("linearity", "hysteresis"))
        lines.append(f"| {cell} | {line} % | {next(found):.3f} % | {loop} % | {next(found):.3f} % |")
    return lines
