"""Benchmark of crane-tip control: the same tasks for every controller, under the same conditions.

Each case is one run of :func:`hydrocrane.simulate`: a task of :mod:`hydrocrane.benchmark.tasks` or a random line of
:mod:`hydrocrane.benchmark.random_tasks` under a :class:`Condition`. Payload, changed friction and most variants of the
machine are unknown to the controller, whose controller model is the machine of the file. The errors of the sensors
depend on the seed, everything else is the same in every run.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path

import numpy as np

from hydrocrane.arrays import Array, seed_number
from hydrocrane.benchmark import tasks
from hydrocrane.benchmark.conditions import VARIANTS, Condition
from hydrocrane.benchmark.metrics import Metrics, Motion, metrics
from hydrocrane.benchmark.piston_pi import PistonPi
from hydrocrane.benchmark.tasks import Task
from hydrocrane.control.controllers import NAMES, AnyController, OwnController, check_controller
from hydrocrane.control.joystick import Joystick
from hydrocrane.errors import HydrocraneError, InputError, unknown
from hydrocrane.files.whole_file import write_text
from hydrocrane.machine.machine import Machine, MachineLike, as_machine
from hydrocrane.results.outcome import Outcome
from hydrocrane.results.run import Run
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.simulation.running import simulate

MACHINE = "rottne-f9-lab"
START = {"boom": np.radians(100.0), "jib": np.radians(100.0), "extension": 0.0}
# Changes with every change of tasks, conditions or figures that moves a result.
VERSION = 2
CONTROLLERS = ("tip", "pi", "heinze-pid")
# Controllers of the benchmark's own, made anew for each run.
OWN: dict[str, Callable[[], OwnController]] = {"pi": PistonPi}
# Random lines of the whole benchmark, and the seed that draws them.
RANDOM_LINES, RANDOM_SEED = 20, 1
LOGS = (100.0, 200.0)
# Shares of the path below which a tip counts as standing still, and as stopping short of the end.
STANDING, SHORT = 0.05, 0.9


@dataclass(frozen=True)
class Case:
    """One run of the benchmark.

    Attributes
    ----------
    task : Task
    condition : Condition
    start : tuple of float, or None
        Joint coordinates in the machine's order, rad or m; ``None``: ``START``.
    """

    task: Task
    condition: Condition = Condition()
    start: tuple[float, ...] | None = None


@dataclass(frozen=True)
class Result:
    """What came of a case.

    Attributes
    ----------
    controller : str
    case : Case
    outcome : Outcome
        That of the run; of kind ``refused`` where the controller cannot run under the condition.
    metrics : Metrics or None
        ``None`` without a recorded motion.
    tip, asked : (m, 2) arrays
        Way of the true tip and of the stick, m; empty without a recorded motion.
    """

    controller: str
    case: Case
    outcome: Outcome
    metrics: Metrics | None = None
    tip: Array = field(default_factory=lambda: np.empty((0, 2)))
    asked: Array = field(default_factory=lambda: np.empty((0, 2)))

    @property
    def message(self) -> str:
        """Why it was refused or ended early; empty where it came to its end."""
        return "" if self.outcome.completed else self.outcome.message

    @property
    def score(self) -> float:
        """As of :class:`hydrocrane.benchmark.metrics.Metrics`; 0 without a motion."""
        return 0.0 if self.metrics is None else self.metrics.score

    @property
    def remark(self) -> str:
        """What one must know beside the deviation: a tip that hardly moves cannot deviate."""
        if self.metrics is None:
            return "no motion"
        share = f"{self.metrics.reached:.0%} of the path"
        if self.metrics.reached < STANDING:
            return f"stands still: {share}"
        return f"stops short: {share}" if self.metrics.reached < SHORT else ""

    @property
    def row(self) -> dict[str, str | float | None]:
        """Plain values for a table; figures that are not there are ``None``."""
        nothing: dict[str, str | float | None] = {f.name: None for f in fields(Metrics)}
        figures = nothing if self.metrics is None else {k: _plain(v) for k, v in asdict(self.metrics).items()}
        head: dict[str, str | float | None] = {
            "controller": self.controller,
            "task": self.case.task.name,
            "speed": self.case.task.speed,
        }
        end = {"remark": self.remark, "outcome": self.outcome.kind, "message": self.message}
        return head | asdict(self.case.condition) | figures | end


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

    A log makes no case of the reference: without a load to take up it would be a path like others.
    """
    every = [*tasks.lines(), tasks.square(), tasks.circle(), tasks.reach()]
    chosen = [task for task in every if task.name in ("up 0.1 m/s", "out 0.1 m/s", "circle")]
    logs = [Case(tasks.pick_and_place(), Condition(payload=mass)) for mass in LOGS]
    fixed = [Case(task) for task in every] + [Case(task, c) for c in _conditions() for task in chosen] + logs
    return fixed + drawn_cases(machine)


def drawn_cases(machine: Machine) -> list[Case]:
    """Random lines with ideal and with data-sheet sensors."""
    from hydrocrane.benchmark.random_tasks import random_lines

    conditions = [Condition(), Condition(sensors="data-sheet")] if machine.sensors else [Condition()]
    return [case for c in conditions for case in random_lines(machine, RANDOM_LINES, seed=RANDOM_SEED, condition=c)]


def quick_cases() -> list[Case]:
    """One slow and one fast line, and the slow one with payload and data-sheet sensors together."""
    slow, fast = [task for task in tasks.lines() if task.name in ("up 0.1 m/s", "out 0.2 m/s")]
    return [Case(slow), Case(fast), Case(slow, Condition(payload=100.0, sensors="data-sheet"))]


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
        Names, ``pi`` among them, or controllers of one's own as in :class:`hydrocrane.Scenario`.
    cases : sequence of Case, optional
        Default is :func:`all_cases`.
    machine : Machine, str or path
        With the joints of the laboratory crane, boom, jib and extension, unless every case has its own start.
    seed : int
        Draws the errors of the sensors; zero or greater.
    progress : callable, optional
        Called with (runs done, runs in all) before each run.
    """
    machine = as_machine(machine)
    cases = all_cases(machine) if cases is None else list(cases)
    drivers = list(controllers)
    for controller in drivers:
        if isinstance(controller, str) and controller not in (*NAMES, *OWN):
            raise unknown("controller", controller, (*NAMES, *OWN))
        check_controller(_made(controller))
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


def run_case(machine: Machine, controller: AnyController, case: Case, *, seed: int = 0) -> Result:
    """Run one case; what the controller refuses or fails at is part of the result."""
    name = controller if isinstance(controller, str) else getattr(controller, "__name__", type(controller).__name__)
    try:
        run = simulate(scenario_of(machine, _made(controller), case, seed=seed), ledger=False, on_error="stop")
    except HydrocraneError as error:
        return Result(name, case, Outcome("refused", 0.0, str(error)))
    if run.data.sizes["time"] < 2:
        return Result(name, case, run.outcome)
    motion = motion_of(run, case.task)
    return Result(name, case, run.outcome, metrics(motion), motion.tip, motion.asked)


def _made(controller: AnyController) -> AnyController:
    """The controller behind a name of the benchmark's own; others as they are."""
    return OWN[controller]() if isinstance(controller, str) and controller in OWN else controller


def scenario_of(machine: Machine, controller: AnyController, case: Case, *, seed: int = 0) -> Scenario:
    """The scenario of a case."""
    task, condition = case.task, case.condition
    known = condition.known(machine)
    stick = Joystick(task.time, task.deflections, interpolation="linear", full_speed=task.speed)
    return Scenario(
        machine=machine.source,
        joints=START if case.start is None else dict(zip(machine.joint_names, case.start, strict=True)),
        duration=task.duration,
        payload=0.0 if task.carries else condition.payload,
        payload_changes=dict(zip(task.carries, (condition.payload, 0.0), strict=True)) if task.carries else {},
        overrides={**machine.overrides, **condition.overrides(machine)},
        name=task.name,
        seed=seed,
        controller=controller,
        joystick=stick,
        period=condition.period,
        sensors=condition.sensors,
        sensor_faults=condition.sensor_faults(machine, 0.5 * task.moving_time),
        believed=known,
    )


def motion_of(run: Run, task: Task) -> Motion:
    """What the metrics need of a run of a task."""
    machine, data = run.machine, run.data
    time = data.time.values

    def columns(names: Iterable[str]) -> Array:
        return np.column_stack([data[name].values for name in names])

    q, qd = (columns(f"joint.{joint}.{kind}" for joint in machine.joint_names) for kind in ("q", "qd"))
    tip = columns(("tip.x", "tip.z"))
    way, velocity = task.displacement, task.velocity
    return Motion(
        time=time,
        tip=tip,
        tip_velocity=np.einsum("tij,tj->ti", machine.tip_jacobian(q), qd),
        asked=tip[0] + np.column_stack([np.interp(time, task.time, way[:, i]) for i in (0, 1)]),
        asked_velocity=np.column_stack([np.interp(time, task.time, velocity[:, i]) for i in (0, 1)]),
        set_point=columns(("set_point.x", "set_point.z")) if "set_point.x" in data else None,
        command=columns(f"cylinder.{c}.command" for c in machine.cylinder_names) / machine.spool_strokes,
        power=data["supply.power"].values,
        end_stops=data["energy.end_stops"].values,
    )


def _plain(value: float) -> float | None:
    return value if np.isfinite(value) else None
