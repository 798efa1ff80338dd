"""Random lines and random stops under ``tip``: ``python docs/validation/tip_motion.py`` writes both tables.

Figures in SI. The page is written by ``tip_control.py``.
"""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import hydrocrane as hc
from hydrocrane.benchmark import Condition, random_lines, run_case
from hydrocrane.benchmark.stops import random_stop

FOLDER = Path(__file__).resolve().parent / "tip-control"
LINES, STOPS = FOLDER / "random-lines.csv", FOLDER / "random-stops.csv"
MACHINES = ("rottne-f9-lab", "hiab-xs031")
SEEDS, PER_SEED, TRIED = range(6), 30, 24
# Controllers that random lines are driven with.
CONTROLLERS = ("tip", "pi")


def conditions(machine: hc.Machine) -> Iterator[Condition]:
    yield Condition()
    if machine.sensors:
        yield Condition(sensors="data-sheet")
    yield Condition(payload=100.0 if machine.name == MACHINES[0] else 40.0)


def lines() -> Iterator[dict[str, object]]:
    """A row per machine, condition and controller."""
    for machine in map(hc.load_machine, MACHINES):
        for condition in conditions(machine):
            cases = [c for s in SEEDS for c in random_lines(machine, PER_SEED, seed=s, condition=condition)]
            for controller in CONTROLLERS:
                runs = [run_case(machine, controller, case) for case in cases]
                found = [run.metrics for run in runs if run.metrics is not None]
                away = np.array([figures.path_max for figures in found])
                # A tip that does not settle within the run counts as one that takes for ever.
                settling = np.array([math.inf if math.isnan(f.settling) else f.settling for f in found])
                yield {
                    "machine": machine.name, "condition": str(condition), "controller": controller, "lines": len(away),
                    "median": np.median(away), "p90": np.percentile(away, 90), "p99": np.percentile(away, 99),
                    "worst": away.max(), "beyond_10_mm": int((away > 0.01).sum()),
                    "reached": np.mean([figures.reached for figures in found]), "settling": np.median(settling),
                }  # fmt: skip


def stops() -> Iterator[dict[str, object]]:
    """A row per machine, sensors and payload."""
    for machine in map(hc.load_machine, MACHINES):
        for sensors in ("ideal", "data-sheet") if machine.sensors else ("ideal",):
            for payload in (0.0, 80.0, 200.0, 300.0):
                tried = [random_stop(machine, seed, payload=payload, sensors=sensors) for seed in range(TRIED)]
                found = [stop for stop in tried if stop is not None]
                settling = np.array([stop.settling for stop in found])
                yield {
                    "machine": machine.name, "sensors": sensors, "payload": payload,
                    "tried": TRIED, "stops": len(found), "median": np.median(settling),
                    "p90": np.percentile(settling, 90), "longest": settling.max(),
                    "quiet": max(stop.quiet for stop in found), "drift": max(stop.drift for stop in found),
                }  # fmt: skip


def write(path: Path, rows: Iterator[dict[str, object]]) -> None:
    table = list(rows)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(table[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)


if __name__ == "__main__":
    chosen = sys.argv[1:] or ["lines", "stops"]
    if "lines" in chosen:
        write(LINES, lines())
    if "stops" in chosen:
        write(STOPS, stops())
