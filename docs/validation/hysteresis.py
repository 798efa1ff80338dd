"""What the hysteresis of the pilot stages costs tip control, which does not know it: accuracy along lines, and rest.

Writes the numbers of docs/validation/mobile-hydraulics.md. Run with a Python that has hydrocrane; takes half a minute.
"""

from __future__ import annotations

from pathlib import Path

import marked_page
import numpy as np

import hydrocrane as hc
from hydrocrane.benchmark import tasks
from hydrocrane.benchmark.cases import Case, run_case

PAGE = Path(__file__).with_name("mobile-hydraulics.md")
MACHINE = "rottne-f9-lab"
CYLINDERS = ("lift", "jib", "extension")
SHARES = (0.0, 0.01, 0.02, 0.04, 0.06)
LINES = ("up 0.1 m/s", "down 0.1 m/s")
# Sensors, load in kg, and overlap of the spools in mm.
RESTS = (("ideal", 0.0, 0.0), ("data-sheet", 200.0, 0.0), ("ideal", 0.0, 2.5))


def of_every_valve(share: float, overlap: float = 0.0) -> dict[str, float]:
    values = {"command.hysteresis": share, "overlap": 1e-3 * overlap}
    return {f"valve.{name}.{key}": value for name in CYLINDERS for key, value in values.items()}


def off_the_line(line: str, share: float) -> float:
    """Largest distance of the tip from a line of the benchmark, m."""
    (task,) = [task for task in tasks.lines() if task.name == line]
    result = run_case(hc.load_machine(MACHINE, of_every_valve(share)), "tip", Case(task))
    assert result.metrics is not None
    return result.metrics.path_max


def at_rest(share: float, sensors: str, payload: float, overlap: float) -> tuple[float, float]:
    """Of the tip from 3 s to 9 s after a move: root mean square of its speed (m/s), distance from where it was (m)."""
    run = hc.simulate(
        hc.Scenario(
            machine=MACHINE,
            joints={"boom": np.radians(100.0), "jib": np.radians(100.0), "extension": 0.0},
            payload=payload,
            duration=10.0,
            record_interval=5e-3,
            joystick=hc.Joystick([0.0, 1.0], {"z": [1.0, 0.0]}, full_speed=0.2),
            sensors=sensors,
            overrides=of_every_valve(share, overlap),
            seed=1,
        ),
        ledger=False,
    )
    tip = np.stack([run.data["tip.x"].values, run.data["tip.z"].values], axis=1)
    time = run.data["time"].values
    rest, speed = time > 4.0, np.hypot(*np.gradient(tip, time, axis=0).T)
    return float(np.sqrt((speed[rest] ** 2).mean())), float(np.linalg.norm(tip[rest] - tip[rest][0], axis=1).max())


def row(share: float) -> str:
    cells = [f"{100 * share:g}", *(f"{1e3 * off_the_line(line, share):.2f}" for line in LINES)]
    for case in RESTS:
        cells += [f"{1e3 * number:.2f}" for number in at_rest(share, *case)]
    return "| " + " | ".join(cells) + " |"


def numbers() -> list[str]:
    rest = [
        f"at rest, {sensors} sensors, {payload:.0f} kg, overlap {overlap:g} mm: {what}"
        for sensors, payload, overlap in RESTS
        for what in ("speed, mm/s", "drift, mm")
    ]
    heading = ["hysteresis, % of the stroke", *(f"off the line {line}, mm" for line in LINES), *rest]
    return ["| " + " | ".join(heading) + " |", "|" + "---|" * len(heading), *map(row, SHARES)]


if __name__ == "__main__":
    marked_page.write(PAGE, numbers(), "hysteresis")
