"""Rest, soak and regions under ``tip``: ``python docs/validation/tip_rest.py`` writes a table of each.

Figures in SI. The page is written by ``tip_control.py``. The printed machine is left out: behind closed valves its tip
sinks by decimetres.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict
from functools import partial
from typing import TypeVar

from tip_motion import FOLDER, MACHINES, stopped, write
from tip_soak import Soak, soak, worst_of
from tip_stops import REST, random_stop
from workers import processes

import hydrocrane as hc

T = TypeVar("T")
RESTS, SOAKS, KEPT_OUT = FOLDER / "rest.csv", FOLDER / "soak.csv", FOLDER / "keep-out.csv"
STOPS, AT_REST = 6, 600.0
# Seeds of the drives of a row, and how long each goes on, s.
SOAKS_OF_ROW, KEPT_OUT_OF_ROW, LASTS = range(6), range(2), 360.0
LAB, LOADER = MACHINES
# Machine, sensors, payload (kg) and speed at full deflection (m/s; None: the machine's own).
DRIVEN = [
    (LAB, "ideal", 0.0, None),
    (LAB, "data-sheet", 200.0, None),
    (LOADER, "ideal", 0.0, 0.3),
    (LOADER, "ideal", 0.0, None),
]
# The ground of the file with a wall on it, in the middle of what the tip reaches: corners, m.
GROUNDS = {
    LAB: [(-4.5, -1.21), (1.0, -1.21), (1.0, 0.0), (1.4, 0.0), (1.4, -1.21), (4.5, -1.21), (4.5, -3.5), (-4.5, -3.5)],
    LOADER: [(-4.5, -0.3), (2.0, -0.3), (2.0, 0.8), (2.4, 0.8), (2.4, -0.3), (5.0, -0.3), (5.0, -3.0), (-4.5, -3.0)],
}


def rests() -> Iterator[dict[str, object]]:
    """A row per machine, sensors and payload: the worst of the stops."""
    for machine, sensors, payload in stopped():
        end = REST + AT_REST
        tried = [random_stop(machine, seed, payload=payload, sensors=sensors, end=end) for seed in range(STOPS)]
        found = [stop for stop in tried if stop is not None]
        yield {
            "machine": machine.name, "sensors": sensors, "payload": payload, "tried": STOPS,
            "stops": len(found), "seconds": AT_REST,
            "quiet": max(stop.quiet for stop in found), "drift": max(stop.drift for stop in found),
        }  # fmt: skip


def drive(case: tuple[str, str, float, float | None], pushed: bool, seed: int) -> Soak:
    """A drive of a case of ``DRIVEN``; `pushed`: with a wall on the ground, and sticks that point down and inwards."""
    name, sensors, payload, speed = case
    ground = {"keep-out.ground.outline": [f"({x}, {z}) m" for x, z in GROUNDS[name]]}
    return soak(
        hc.load_machine(name),
        seed,
        LASTS,
        payload=payload,
        sensors=sensors,
        full_speed=speed,
        towards=(-1.0, -1.0) if pushed else (0.0, 0.0),
        overrides=ground if pushed else None,
    )


def in_processes(work: Callable[[int], T], seeds: Iterable[int]) -> list[T]:
    """What `work` finds for each seed."""
    return list(processes().map(work, seeds))


def drives(pushed: bool, seeds: range) -> Iterator[dict[str, object]]:
    """A row per case of ``DRIVEN``: the worst of its drives."""
    for case in DRIVEN:
        name, sensors, payload, speed = case
        found = worst_of(in_processes(partial(drive, case, pushed), seeds))
        margin = hc.load_machine(name).tip_gains["keep-out-margin"]
        head = {"machine": name, "sensors": sensors, "payload": payload, "full_speed": speed}
        told = {"warnings": len(found.warnings), "alarms": len(found.alarms)}
        entered = {"margin": margin, "penetration": max(0.0, margin - found.clearance)}
        yield head | {"seconds": LASTS * len(seeds)} | asdict(found) | told | entered


PARTS = {
    "rest": (RESTS, rests),
    "soak": (SOAKS, partial(drives, False, SOAKS_OF_ROW)),
    "keep-out": (KEPT_OUT, partial(drives, True, KEPT_OUT_OF_ROW)),
}

if __name__ == "__main__":
    for part in sys.argv[1:] or PARTS:
        path, rows = PARTS[part]
        write(path, rows())
