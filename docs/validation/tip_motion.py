"""Random motions under ``tip``: ``python docs/validation/tip_motion.py``.

Lines, stops, lines after some driving, and all of them without pressure sensors.

Names of tables, ``lines``, ``stops``, ``after-driving``, ``pressures``, take a part of them.
Figures in SI. The page is written by ``tip_control.py``.
"""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from tip_after_driving import lines_after_driving
from tip_stops import random_stop

import hydrocrane as hc
from hydrocrane.benchmark import START, VARIANTS, Condition, random_lines, run_case
from hydrocrane.benchmark.conditions import at_valves
from hydrocrane.machine.overrides import Override

FOLDER = Path(__file__).resolve().parent / "tip-control"
NAMES = ("random-lines", "random-stops", "after-driving", "pressures")
LINES, STOPS, DRIVEN, PRESSURES = (FOLDER / f"{name}.csv" for name in NAMES)
MACHINES = ("rottne-f9-lab", "hiab-xs031")
SEEDS, PER_SEED, TRIED = range(6), 30, 24
# What the controller is not told of the crane that it drives, and the drives that teach it.
UNSTATED = ("dead band 5 %", "offset 2 %", "gain 0.8", "supply - 30 %", "leakage x 10")
OVERLAP, DRIVES = 0.05, range(10)
# Random lines, stops and drives of a row with or without pressure sensors, and where the drives begin.
FEW_LINES, FEW_STOPS, FEW_DRIVES = 30, 12, 3
STARTS = {MACHINES[0]: START, MACHINES[1]: {"lift": 0.939, "tilt": -1.279, "extension": 0.55}}
# Periods of stops besides the controller's own.
PERIODS = {MACHINES[0]: ("5 ms",)}
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


def stopped() -> Iterator[tuple[hc.Machine, str, float]]:
    """Machine, sensors and payload (kg) of each row of stops."""
    for machine in map(hc.load_machine, MACHINES):
        for sensors in ("ideal", "data-sheet") if machine.sensors else ("ideal",):
            yield from ((machine, sensors, payload) for payload in (0.0, 80.0, 200.0, 300.0))


def stopped_at_periods() -> Iterator[tuple[hc.Machine, str, float, str]]:
    """The same with each period: the controller's own, and those of ``PERIODS``."""
    rows = list(stopped())
    yield from ((*row, "") for row in rows)
    for machine, sensors, payload in rows:
        for period in PERIODS.get(machine.name, ()):
            yield machine.changed({"control.period": period}), sensors, payload, period


def stops() -> Iterator[dict[str, object]]:
    """A row per machine, sensors, payload and period."""
    for machine, sensors, payload, period in stopped_at_periods():
        tried = [random_stop(machine, seed, payload=payload, sensors=sensors) for seed in range(TRIED)]
        found = [stop for stop in tried if stop is not None]
        settling = np.array([stop.settling for stop in found])
        yield {
            "machine": machine.name, "sensors": sensors, "payload": payload, "period": period,
            "tried": TRIED, "stops": len(found), "median": np.median(settling),
            "p90": np.percentile(settling, 90), "longest": settling.max(),
            "quiet": max(stop.quiet for stop in found), "drift": max(stop.drift for stop in found),
        }  # fmt: skip


def unstated(machine: hc.Machine) -> dict[str, dict[str, Override]]:
    """Overrides by name, and some of them at once."""
    overlap = at_valves("overlap", lambda stroke: OVERLAP * stroke)(machine)
    single = {"overlap 5 %": overlap} | {name: VARIANTS[name].overrides(machine) for name in UNSTATED}
    together = ("overlap 5 %", "offset 2 %", "supply - 30 %", "leakage x 10")
    return {"nothing": {}} | single | {", ".join(together): {k: v for n in together for k, v in single[n].items()}}


def after_driving() -> Iterator[dict[str, object]]:
    """A row for each thing that the controller is not told."""
    machine = hc.load_machine(MACHINES[0])
    for name, changes in unstated(machine).items():
        learnt, kept = (
            np.array([lines_after_driving(machine, changes, seed, learning_time=time).deviation for seed in DRIVES])
            for time in (None, 0.0)
        )
        yield {
            "unstated": name, "drives": len(learnt), "median": np.median(learnt), "worst": learnt.max(),
            "median_not_learnt": np.median(kept), "worst_not_learnt": kept.max(),
        }  # fmt: skip


def told_of() -> Iterator[tuple[str, dict[str, Override], bool]]:
    """Where the pressures come from in words, the overrides that say so, and whether the file states the load."""
    estimated: dict[str, Override] = {"control.tip.pressures": "estimated"}
    yield from (("measured", {}, False), ("estimated", estimated, False), ("estimated, load stated", estimated, True))


def pressures() -> Iterator[dict[str, object]]:
    """A row per machine, sensors, payload and source of the pressures."""
    for name, (source, told, stated) in ((name, told) for name in MACHINES for told in told_of()):
        crane = hc.load_machine(name).changed(told)
        for sensors in ("ideal", "data-sheet") if crane.sensors else ("ideal",):
            for payload in (0.0, 80.0, 200.0):
                machine = crane.changed({"payload.mass": payload}) if stated else crane
                condition = Condition(payload=payload, sensors=sensors)
                cases = random_lines(machine, FEW_LINES, seed=2, condition=condition)
                runs = [run_case(machine, "tip", case) for case in cases]
                away = np.array([run.metrics.path_max for run in runs if run.metrics is not None])
                tried = [random_stop(machine, s, payload=payload, sensors=sensors) for s in range(FEW_STOPS)]
                found = [stop for stop in tried if stop is not None]
                laden = {"payload.mass": payload}
                drives = [
                    lines_after_driving(machine, laden, seed, start=STARTS[name]).deviation
                    for seed in range(FEW_DRIVES if sensors == "ideal" else 0)
                ]
                yield {
                    "machine": name, "sensors": sensors, "payload": payload, "pressures": source,
                    "lines": len(away), "median": np.median(away), "p90": np.percentile(away, 90),
                    "worst": away.max(), "driven": max(drives) if drives else "", "stops": len(found),
                    "settling": np.median([stop.settling for stop in found]),
                    "quiet": np.median([stop.quiet for stop in found]), "loudest": max(stop.quiet for stop in found),
                    "drift": max(stop.drift for stop in found), "drives": FEW_DRIVES, "tried": FEW_STOPS,
                }  # fmt: skip


def write(path: Path, rows: Iterator[dict[str, object]]) -> None:
    table = list(rows)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(table[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)


if __name__ == "__main__":
    tables = {
        "lines": (LINES, lines),
        "stops": (STOPS, stops),
        "after-driving": (DRIVEN, after_driving),
        "pressures": (PRESSURES, pressures),
    }
    for name in sys.argv[1:] or tables:
        path, rows = tables[name]
        write(path, rows())
