"""The whole benchmark of crane-tip control: all its cases, run with every controller, and its tables."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hydrocrane.arrays import seed_number
from hydrocrane.benchmark import tasks
from hydrocrane.benchmark.cases import OWN, START, Case, Result, made, run_case
from hydrocrane.benchmark.conditions import VARIANTS, Condition
from hydrocrane.benchmark.random_tasks import random_lines
from hydrocrane.control.controllers import NAMES, AnyController, check_controller
from hydrocrane.errors import InputError, unknown
from hydrocrane.files.whole_file import write_text
from hydrocrane.machine.machine import Machine, MachineLike, as_machine

MACHINE = "rottne-f9-lab"
# Version of tasks, conditions and figures; it increases with every change that moves a result.
VERSION = 4
CONTROLLERS = ("tip", "pi", "heinze-pid")
LOGS = (100.0, 200.0)
# Number of random lines of the whole benchmark, and their seed.
RANDOM_LINES, RANDOM_SEED = 20, 1


@dataclass(frozen=True)
class Benchmark:
    """All results of a benchmark."""

    machine: str
    seed: int
    results: tuple[Result, ...]

    @property
    def standings(self) -> dict[str, float]:
        """Mean score of each controller over its cases, the best first."""
        scores: dict[str, list[float]] = {}
        for result in self.results:
            scores.setdefault(result.controller, []).append(result.score)
        means = {controller: float(np.mean(values)) for controller, values in scores.items()}
        return dict(sorted(means.items(), key=lambda item: -item[1]))

    def save(self, folder: Path) -> list[Path]:
        """Write ``control-benchmark.csv`` and ``control-benchmark.json`` (SI units); returns their paths."""
        from hydrocrane import __version__

        rows = [result.row for result in self.results]
        table = io.StringIO(newline="")
        writer = csv.DictWriter(table, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
        head = {"benchmark": VERSION, "hydrocrane": __version__, "machine": self.machine, "seed": self.seed}
        content = head | {"results": rows}
        return [
            write_text(folder / "control-benchmark.csv", table.getvalue()),
            write_text(folder / "control-benchmark.json", json.dumps(content, indent=1, allow_nan=False) + "\n"),
        ]


def all_cases(machine: Machine) -> list[Case]:
    """Every task under the reference, two lines and the circle under the others, logs, and random lines.

    Log handling is no case of the reference: without a load it would be a path like others.
    """
    every = [*tasks.lines(), tasks.square(), tasks.circle(), tasks.reach()]
    chosen = [task for task in every if task.name in ("up 0.1 m/s", "out 0.1 m/s", "circle")]
    logs = [Case(tasks.pick_and_place(), Condition(payload=mass)) for mass in LOGS]
    fixed = [Case(task) for task in every] + [Case(task, c) for c in _conditions() for task in chosen] + logs
    return fixed + drawn_cases(machine)


def drawn_cases(machine: Machine) -> list[Case]:
    """Random lines with ideal sensors, with data-sheet sensors, and without pressure sensors."""
    conditions = [Condition(), Condition(sensors="data-sheet")] if machine.sensors else [Condition()]
    conditions.append(Condition(variant="joint sensors only"))
    return [case for c in conditions for case in random_lines(machine, RANDOM_LINES, seed=RANDOM_SEED, condition=c)]


def _conditions() -> list[Condition]:
    return [
        Condition(payload=100.0),
        Condition(payload=200.0),
        Condition(sensors="data-sheet"),
        Condition(period=0.01),
        Condition(period=0.02),
        Condition(friction=0.5),
        Condition(friction=2.0),
        Condition(payload=200.0, sensors="data-sheet", friction=2.0),
        Condition(period=0.05),
        Condition(period=0.1),
        Condition(drop_out=0.05),
        *(Condition(variant=name) for name in VARIANTS),
        Condition(payload=200.0, sensors="data-sheet", variant="joint sensors only"),
    ]


def benchmark(
    controllers: Iterable[AnyController] = CONTROLLERS,
    cases: Sequence[Case] | None = None,
    *,
    machine: MachineLike = MACHINE,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> Benchmark:
    """Run every case with every controller.

    Parameters
    ----------
    controllers : iterable
        Names, including ``pi``, or your own controllers as in :class:`hydrocrane.Scenario`.
    cases : sequence of Case, optional
        Default is :func:`all_cases`.
    machine : Machine, str or path
        With the joints of the laboratory crane, boom, jib and extension, unless every case has a start pose.
    seed : int
        Seed of the errors of the sensors; zero or greater.
    progress : callable, optional
        Called with (runs done, all runs) before each run.
    """
    machine = as_machine(machine)
    machine.require_plane("the benchmark of tip control")
    cases = all_cases(machine) if cases is None else list(cases)
    drivers = list(controllers)
    for controller in drivers:
        if isinstance(controller, str) and controller not in (*NAMES, *OWN):
            raise unknown("controller", controller, (*NAMES, *OWN))
        check_controller(made(controller))
    if not drivers or not cases:
        raise InputError("a benchmark needs one controller and one case or more")
    seed = seed_number(seed)
    if set(machine.joint_names) != set(START) and any(case.start is None for case in cases):
        fit = f"the benchmark's tasks fit a crane with the joints {', '.join(START)}"
        raise InputError(f"{fit}; {machine.name} has {', '.join(machine.joint_names)}")
    plan = [(driver, case) for driver in drivers for case in cases]
    results = []
    for done, (driver, case) in enumerate(plan):
        if progress is not None:
            progress(done, len(plan))
        results.append(run_case(machine, driver, case, seed=seed))
    return Benchmark(machine.name, seed, tuple(results))
