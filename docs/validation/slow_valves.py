"""Tip control with valves that answer late: as stated, and 20 ms later than the controller knows.

Writes the numbers of docs/validation/slow-valves.md. Run with a Python that has hydrocrane; takes some minutes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import marked_page
from tip_machines import followed

import hydrocrane as hc
from hydrocrane.benchmark import Condition, random_lines
from hydrocrane.benchmark.conditions import at_valves
from hydrocrane.benchmark.metrics import metrics

PAGE = Path(__file__).with_name("slow-valves.md")
# Machines with a load that the controller is not told, kg.
LOADS = {"rottne-f9-lab": 120.0, "rottne-f9-mobile": 120.0, "rottne-f9-ls": 120.0, "hiab-xs031": 80.0}
# Natural frequency of the spools, Hz, and dead time, ms; none: as the file states them.
VALVES = ((None, None), (12.0, 10.0), (8.0, 25.0), (5.0, 50.0), (None, 200.0))
LATE = {"": 0, "valves 20 ms later": 20}
# How long each line is followed after its end, s.
REST = 8.0
SEED, LINES = 1200, 20


def with_valves(machine: hc.Machine, frequency: float | None, delay: float) -> hc.Machine:
    stated = at_valves("delay", lambda stroke: 1e-3 * delay)(machine)
    if frequency is not None:
        stated |= at_valves("natural-frequency", lambda stroke: 2.0 * math.pi * frequency)(machine)
    return machine.changed(stated)


def rows() -> Iterator[tuple[float, str]]:
    """Speed of the tip at the end, by which they are sorted, and a row of the table."""
    for name, load in LOADS.items():
        for frequency, delay in VALVES:
            file = hc.load_machine(name)
            known = with_valves(file, frequency, delay) if delay is not None else file
            for payload in (0.0, load):
                for variant in LATE:
                    condition = Condition(payload=payload, variant=variant)
                    yield row(name, known, condition, (frequency, delay))


def row(name: str, known: hc.Machine, condition: Condition, valve) -> tuple[float, str]:
    frequency, delay = valve
    found, told = [], 0
    for case in random_lines(known, LINES, seed=SEED, condition=condition):
        run, motion = followed(known, case, case.task.duration + REST)
        told += any(warning.kind == "controller-oscillates" for warning in run.warnings)
        found.append(metrics(motion))
    away = sorted(1e3 * m.path_max for m in found)
    settling = sorted(math.inf if math.isnan(m.settling) else m.settling for m in found)
    quiet = max(1e3 * m.vibration for m in found)
    spool = "" if frequency is None else f"{frequency:g} Hz, "
    stated = "as stated" if delay is None else f"{spool}{delay:g} ms"
    p90 = math.ceil(0.9 * len(found)) - 1
    times = ["never" if math.isinf(t) else f"{t:.2f}" for t in (settling[p90], settling[-1])]
    late = LATE[condition.variant]
    cells = [f"`{name}`", f"{condition.payload:g}", stated, str(late), f"{away[p90]:.1f}", f"{away[-1]:.1f}", *times]
    return quiet, "| " + " | ".join([*cells, f"{quiet:.2f}", str(told)]) + " |"


def numbers() -> list[str]:
    lines = [
        "| machine | load, kg | valves | later than known, ms | off the line, mm: 90 % | worst "
        "| settled, s: 90 % | longest | speed of the tip in the last half second, mm/s, worst | told |",
        "|" + "---|" * 10,
    ]
    ordered = sorted(rows(), key=lambda found: -found[0])
    return [*lines, *(text for _, text in ordered)]


if __name__ == "__main__":
    marked_page.write(PAGE, numbers())
