"""Lines, stops and drives of seeds on which nothing was chosen: ``python docs/validation/tip_further.py [TABLE ...]``.

Figures in SI. The page is written by ``tip_control.py``.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import partial

import numpy as np
from tip_motion import FOLDER, MACHINES, write
from tip_rest import LASTS, in_processes
from tip_soak import soak
from tip_stops import Stop, random_stop

import hydrocrane as hc
from hydrocrane.benchmark import Condition, random_lines, run_case

PATHS = {name: FOLDER / f"further-{name}.csv" for name in ("lines", "stops", "drives")}
SEEDS, LINE_SEEDS, LINES_PER_SEED = range(600, 700), range(600, 630), 30
LAB, LOADER = MACHINES
# Time within which a stop shall settle, s.
WITHIN = {LAB: 0.6, LOADER: 2.0}
SPEED, PAYLOAD, SENSORS = "control.tip.full-speed", (0.0, 80.0, 200.0), ("ideal", "data-sheet")
PERIODS = ("", ""), ("control.period", "5 ms")
CHANGED = (PERIODS[1], ("control.tip.damping-ratio", 0.25), ("control.tip.damping-ratio", 0.6))


@dataclass(frozen=True)
class Row:
    """A row of stops or drives: what differs from the file, the sensors, and the load, kg."""

    machine: str
    changed: str = ""
    value: str | float = ""
    sensors: str = "ideal"
    payload: float = 0.0

    def load(self) -> hc.Machine:
        return hc.load_machine(self.machine, {self.changed: self.value} if self.changed else {})


STOPPED = [
    *(Row(LAB, *period, sensors, load) for period in PERIODS for sensors in SENSORS for load in PAYLOAD),
    *(Row(LOADER, payload=load) for load in (*PAYLOAD, 300.0)),
    *(Row(LOADER, *changed, payload=80.0) for changed in CHANGED),
]
DRIVEN = [Row(LOADER, SPEED, "0.3 m/s", payload=load) for load in (0.0, 150.0)] + [Row(LOADER)]


def lines_of(payload: float, seed: int) -> list[float]:
    """Largest deviations of the lines of a seed, m; the controller is not told of the load."""
    machine, condition = hc.load_machine(LOADER), Condition(payload=payload)
    cases = random_lines(machine, LINES_PER_SEED, seed=seed, condition=condition)
    found = [run_case(machine, "tip", case).metrics for case in cases]
    return [figures.path_max for figures in found if figures is not None]


def lines() -> Iterator[dict[str, object]]:
    """A row for each load."""
    for payload in (0.0, 40.0):
        away = np.concatenate(in_processes(partial(lines_of, payload), LINE_SEEDS))
        yield {
            "machine": LOADER, "payload": payload, "lines": len(away), "median": np.median(away),
            "p90": np.percentile(away, 90), "p99": np.percentile(away, 99), "worst": away.max(),
            "beyond_10_mm": int((away > 0.01).sum()),
        }  # fmt: skip


def stop_of(row: Row, seed: int) -> Stop | None:
    return random_stop(row.load(), seed, payload=row.payload, sensors=row.sensors)


def stops() -> Iterator[dict[str, object]]:
    """A row for each of ``STOPPED``."""
    for row in STOPPED:
        found = [stop for stop in in_processes(partial(stop_of, row), SEEDS) if stop is not None]
        settling, quiet, drift = np.array([(stop.settling, stop.quiet, stop.drift) for stop in found]).T
        yield {
            **asdict(row), "stops": len(found), "mean": settling.mean(), "longest": settling.max(),
            "within": int((settling <= WITHIN[row.machine]).sum()), "quiet": quiet.max(),
            "quiet_enough": int((quiet <= 1e-3).sum()), "drift": drift.max(),
            "still_enough": int((drift <= 1e-3).sum()),
        }  # fmt: skip


def drive_of(row: Row, seed: int) -> tuple[float, float, float, float]:
    """Distance from the set-point, m; share beyond limits; depth in a margin, m; pressure over supply pressure."""
    machine = row.load()
    found = soak(machine, seed, LASTS, payload=row.payload, sensors=row.sensors)
    return found.lag, found.beyond_limits, machine.tip_gains["keep-out-margin"] - found.clearance, found.pressure


def drives() -> Iterator[dict[str, object]]:
    """A row for each of ``DRIVEN``."""
    for row in DRIVEN:
        lag, beyond, depth, pressure = np.array(in_processes(partial(drive_of, row), SEEDS)).T
        yield {
            **asdict(row), "drives": len(lag),
            "median": np.median(lag), "p90": np.percentile(lag, 90), "worst": lag.max(),
            "beyond_200_mm": int((lag > 0.2).sum()), "beyond_limits": int((beyond > 0.0).sum()),
            "in_margin": int((depth > 5e-3).sum()), "depth": depth.max(), "pressure": pressure.max(),
        }  # fmt: skip


if __name__ == "__main__":
    tables = {"lines": lines, "stops": stops, "drives": drives}
    for name in sys.argv[1:] or tables:
        write(PATHS[name], tables[name]())
