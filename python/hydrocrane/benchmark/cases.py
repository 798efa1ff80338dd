"""Benchmark of crane-tip control: the same tasks for every controller, under the same conditions.

Each case is one run of :func:`hydrocrane.simulate`: a task of :mod:`hydrocrane.benchmark.tasks` or a random line of
:mod:`hydrocrane.benchmark.random_tasks` under a :class:`Condition`. Payload, changed friction and most variants of the
machine are unknown to the controller, whose controller model is the machine of the file. The errors of the sensors
depend on the seed, everything else is the same in every run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field, fields

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.benchmark import tasks
from hydrocrane.benchmark.conditions import Condition
from hydrocrane.benchmark.metrics import Metrics, TipMotion, metrics
from hydrocrane.benchmark.piston_pi import PistonPi
from hydrocrane.benchmark.tasks import Task
from hydrocrane.control.controllers import AnyController, OwnController
from hydrocrane.control.joystick import Joystick
from hydrocrane.errors import HydrocraneError
from hydrocrane.machine.machine import Machine
from hydrocrane.results.outcome import Outcome
from hydrocrane.results.run import Run
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.simulation.running import simulate

START = {"boom": np.radians(100.0), "jib": np.radians(100.0), "extension": 0.0}
# Controllers that only the benchmark has; each run has a new one.
OWN: dict[str, Callable[[], OwnController]] = {"pi": PistonPi}
# Shares of the path below which a tip counts as not moving, and as stopping before the end.
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
    """Result of a case.

    Attributes
    ----------
    controller : str
    case : Case
    outcome : Outcome
        Outcome of the run; of kind ``refused`` if the controller cannot run under the condition.
    metrics : Metrics or None
        ``None`` without a recorded motion.
    tip, asked : (m, 2) arrays
        Paths of the true tip and of the stick, m; empty without a recorded motion.
    """

    controller: str
    case: Case
    outcome: Outcome
    metrics: Metrics | None = None
    tip: Array = field(default_factory=lambda: np.empty((0, 2)))
    asked: Array = field(default_factory=lambda: np.empty((0, 2)))

    @property
    def message(self) -> str:
        """Reason for a refusal or an early end; empty if the case is complete."""
        return "" if self.outcome.completed else self.outcome.message

    @property
    def score(self) -> float:
        """As in :class:`hydrocrane.benchmark.metrics.Metrics`; 0 without a motion."""
        return 0.0 if self.metrics is None else self.metrics.score

    @property
    def remark(self) -> str:
        """Remark on the deviation: a tip that hardly moves has none."""
        if self.metrics is None:
            return "no motion"
        share = f"{self.metrics.reached:.0%} of the path"
        if self.metrics.reached < STANDING:
            return f"stands still: {share}"
        return f"stops short: {share}" if self.metrics.reached < SHORT else ""

    @property
    def row(self) -> dict[str, str | float | None]:
        """Plain values for a table; missing figures are ``None``."""
        nothing: dict[str, str | float | None] = {f.name: None for f in fields(Metrics)}
        figures = nothing if self.metrics is None else {k: _plain(v) for k, v in asdict(self.metrics).items()}
        head: dict[str, str | float | None] = {
            "controller": self.controller,
            "task": self.case.task.name,
            "speed": self.case.task.speed,
        }
        end = {"remark": self.remark, "outcome": self.outcome.kind, "message": self.message}
        return head | asdict(self.case.condition) | figures | end


def quick_cases() -> list[Case]:
    """One slow and one fast line, and the slow one with payload and data-sheet sensors together."""
    slow, fast = [task for task in tasks.lines() if task.name in ("up 0.1 m/s", "out 0.2 m/s")]
    return [Case(slow), Case(fast), Case(slow, Condition(payload=100.0, sensors="data-sheet"))]


def run_case(machine: Machine, controller: AnyController, case: Case, *, seed: int = 0) -> Result:
    """Run one case; a refusal or failure of the controller is part of the result."""
    name = controller if isinstance(controller, str) else getattr(controller, "__name__", type(controller).__name__)
    try:
        run = simulate(scenario_of(machine, made(controller), case, seed=seed), ledger=False, on_error="stop")
    except HydrocraneError as error:
        return Result(name, case, Outcome("refused", 0.0, str(error)))
    if run.data.sizes["time"] < 2:
        return Result(name, case, run.outcome)
    motion = motion_of(run, case.task)
    return Result(name, case, run.outcome, metrics(motion), motion.tip, motion.asked)


def made(controller: AnyController) -> AnyController:
    """The controller behind a name of the benchmark; other controllers unchanged."""
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
        name="tip-control",
        title=task.name,
        seed=seed,
        controller=controller,
        joystick=stick,
        period=condition.period,
        sensors=condition.sensors,
        sensor_faults=condition.sensor_faults(machine, 0.5 * task.moving_time, by_name=isinstance(controller, str)),
        controller_model=known,
    )


def motion_of(run: Run, task: Task) -> TipMotion:
    """The data of a run that the metrics need."""
    machine, data = run.machine, run.data
    time = data.time.values

    def columns(names: Iterable[str]) -> Array:
        return np.column_stack([data[name].values for name in names])

    q, qd = (columns(f"joint.{joint}.{kind}" for joint in machine.joint_names) for kind in ("q", "qd"))
    tip = columns(("tip.x", "tip.z"))
    displacement, velocity = task.displacement, task.velocity
    return TipMotion(
        time=time,
        tip=tip,
        tip_velocity=np.einsum("tij,tj->ti", machine.tip_jacobian(q)[:, [0, -1]], qd),
        asked=tip[0] + np.column_stack([np.interp(time, task.time, displacement[:, i]) for i in (0, 1)]),
        asked_velocity=np.column_stack([np.interp(time, task.time, velocity[:, i]) for i in (0, 1)]),
        set_point=columns(("set_point.x", "set_point.z")) if "set_point.x" in data else None,
        command=columns(f"cylinder.{c}.command" for c in machine.cylinder_names) / machine.spool_strokes,
        power=data["supply.power"].values,
        end_stops=data["energy.end_stops"].values,
    )


def _plain(value: float) -> float | None:
    return value if np.isfinite(value) else None
