"""Loading and unloading of logs by a model of an operator, with one lever per cylinder or with tip control.

The task lies in the plane of the laboratory crane: a bunk beside the crane, a stake at its edge, logs on the ground
beyond. Nothing slews. The figures are those of a simulation of crane and operator; see
`modelled_operator.py` for the operator.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from modelled_operator import INTERFACES, PERIOD, Driver, Operator, Waypoint
from operator_loop import Drive, drive

from hydrocrane.arrays import Array, seed_number, whole_number
from hydrocrane.benchmark.cases import START
from hydrocrane.benchmark.suite import MACHINE
from hydrocrane.benchmark.tuning import pattern_search
from hydrocrane.errors import InputError, check_known
from hydrocrane.machine.machine import Machine, MachineLike, as_machine
from hydrocrane.results.run import Run
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.simulation.running import simulate

# Position above the bunk, where a cycle begins and ends, and the way-points over the stake, m.
HOME, OUTSIDE, INSIDE = (1.5, 0.5), (2.15, 0.25), (1.65, 0.25)
# Ranges (lowest, highest) of x and z of the logs, m: on the ground, with the grapple 0.25 m above it, and in the bunk.
GROUND = ((2.35, 2.9), (-0.96, -0.96))
BUNK = ((1.35, 1.6), (-0.6, -0.3))
# kg.
MASSES = (60.0, 150.0)
# Tolerances of a way-point, m: over the stake, at a log, at the place of release, at home.
PASS, PICK, PLACE, REST = 0.15, 0.05, 0.08, 0.15
# The stake: x of its sides and z of its top, m.
STAKE = ((1.87, 1.93), 0.0)
# Telescope positions at which the reach of a place is checked, m.
TELESCOPE = (0.0, -0.2, 0.2)
# Time limit of a cycle, s per log.
GIVEN_UP = 90.0
# Recording interval of a run, s.
RECORDED = 0.01
# Cost of a strike at the stake or of a missed log in a search, s.
FAULT = 10.0
# Gains that a search changes, and its first and last factors.
GAINS, SEARCH = ("gain", "anticipation", "speed"), (1.5, 1.15)

# Found from the defaults of Operator by `python docs/validation/loading_cycle.py measure`.
TUNED: dict[str, dict[str, float]] = {
    "lever": {"gain": 1.5, "anticipation": 0.25, "speed": 0.3},
    "tip": {"gain": 1.5, "anticipation": 0.25, "speed": 0.675},
}


@dataclass(frozen=True)
class LogTask:
    """Logs to be moved between ground and bunk.

    Attributes
    ----------
    name : str
    waypoints : tuple of Waypoint
    unloading : bool
        From the bunk to the ground; otherwise the other way.
    logs : int
    seed : int
        Seed of the places and masses.
    """

    name: str
    waypoints: tuple[Waypoint, ...]
    unloading: bool
    logs: int
    seed: int


@dataclass(frozen=True)
class Cycle:
    """Result of a task.

    Attributes
    ----------
    interface : {"lever", "tip"}
    task : LogTask
    operator : Operator
    finished : bool
        Whether the operator completed the task in time.
    time : float
        Until the tip is at rest at home again, s; NaN if the task was not completed, as for all further figures.
    way : float
        Path length of the tip, m.
    energy : float
        Delivered by the pump, J.
    overshoot : float
        Largest overshoot of the tip beyond a way-point with a stop, along the path to it, m.
    strikes : int
        Number of collisions of the tip with the stake.
    missed : int
        Number of logs grasped or released outside the tolerance.
    reversals : int
        Number of sign changes of the sticks.
    stick_travel : float
        Sum of the movements of all sticks, in full deflections.
    run : Run
        The whole run. Its scenario has the sticks as a table and can be run again without an operator.
    """

    interface: str
    task: LogTask
    operator: Operator
    finished: bool
    time: float
    way: float
    energy: float
    overshoot: float
    strikes: int
    missed: int
    reversals: int
    stick_travel: float
    run: Run

    @property
    def faults(self) -> int:
        """Strikes and missed logs together."""
        return self.strikes + self.missed

    @property
    def cost(self) -> float:
        """Time of the task, or up to the time limit, with ``FAULT`` for each fault, s."""
        return float(self.run.columns["time"].values[-1]) + FAULT * self.faults


def log_task(seed: int, *, unloading: bool = False, logs: int = 1) -> LogTask:
    """Random logs to be moved.

    Places and masses are uniform between the bounds of this module: logs lie on the ground between x = 2.35 and 2.9 m
    and weigh 60 to 150 kg.

    Parameters
    ----------
    seed : int
        Zero or greater. The same seed gives the same logs for loading and for unloading.
    unloading : bool
        From the bunk to the ground in place of the other way.
    logs : int
        Number of logs, moved one after the other; at least one.
    """
    whole_number("logs", logs)
    random = np.random.default_rng(seed_number(seed))
    over = [Waypoint(INSIDE, PASS), Waypoint(OUTSIDE, PASS)]
    points: list[Waypoint] = []
    for _ in range(logs):
        ground, bunk = ((float(random.uniform(*x)), float(random.uniform(*z))) for x, z in (GROUND, BUNK))
        mass = float(random.uniform(*MASSES))
        if unloading:
            points += [Waypoint(bunk, PICK, mass), *over, Waypoint(ground, PLACE, 0.0), *over[::-1]]
        else:
            points += [*over, Waypoint(ground, PICK, mass), *over[::-1], Waypoint(bunk, PLACE, 0.0)]
    points.append(Waypoint(HOME, REST, stop=True))
    name = f"{'unloading' if unloading else 'loading'}, {logs} log{'s' if logs > 1 else ''}, seed {seed}"
    return LogTask(name, tuple(points), unloading, logs, seed)


def loading_cycle(
    task: LogTask, interface: str, operator: Operator | None = None, *, machine: MachineLike = MACHINE, seed: int = 0
) -> Cycle:
    """Let an operator do a task, and compute the figures.

    Parameters
    ----------
    task : LogTask
    interface : {"lever", "tip"}
        One lever per cylinder, straight to its spool; or one stick for the velocity of the tip under the controller
        ``tip`` with data-sheet sensors, without knowledge of the logs.
    operator : Operator, optional
        Default: :func:`tuned_operator` for the interface.
    machine : Machine, str or path
        With the joints of the laboratory crane; the places of the task must be within its reach.
    seed : int
        Seed of the errors of the sensors and, together with the task's seed, of the operator's picture.

    Examples
    --------
    >>> from log_loading import loading_cycle, log_task
    >>> loading_cycle(log_task(1), "tip").finished
    True
    """
    machine = as_machine(machine)
    check_known("interface of an operator", interface, INTERFACES)
    operator = tuned_operator(interface) if operator is None else operator
    if set(machine.joint_names) != set(START):
        fit = f"the places of the logs fit a crane with the joints {', '.join(START)}"
        raise InputError(f"{fit}; {machine.name} has {', '.join(machine.joint_names)}")
    for place in (HOME, *(point.place for point in task.waypoints)):
        if not _poses(machine, place):
            raise InputError(
                f"{machine.name} cannot hold its tip with {MASSES[1]:g} kg at {place} m; give a place within its reach"
            )
    start = _poses(machine, HOME)[0].tolist()
    plan = Scenario(
        machine=machine.source,
        overrides=machine.overrides,
        joints=dict(zip(machine.joint_names, start, strict=True)),
        payload=0.0,
        sensors="data-sheet" if interface == "tip" else "ideal",
        seed=seed,
        name="log-loading",
        title=task.name,
    )
    driver = Driver(machine, interface, operator, task.waypoints, seed_number(seed) + task.seed)
    found = drive(plan, driver, GIVEN_UP * task.logs)
    run = simulate(found.scenario.changed(record_interval=RECORDED), machine=machine, ledger=False)
    return _measured(task, interface, operator, found, run)


def tuned_operator(interface: str, **abilities: float) -> Operator:
    """An operator with the gains that :func:`tune_operator` found for an interface, and other `abilities`."""
    check_known("interface of an operator", interface, INTERFACES)
    return Operator().changed(**(TUNED[interface] | abilities))


def tune_operator(
    interface: str,
    operator: Operator,
    tasks: Sequence[LogTask],
    *,
    machine: MachineLike = MACHINE,
    trials: int = 20,
    progress: Callable[[int, int], None] | None = None,
) -> Operator:
    """Search an operator's gains for an interface: the same search, the same start and the same cost for either.

    The cost is the mean time of a task, with ``FAULT`` s for each strike at the stake and each log missed; a task that
    is not completed costs the time limit.

    Parameters
    ----------
    interface : {"lever", "tip"}
    operator : Operator
        Abilities, and the gains to start from.
    tasks : sequence of LogTask
        Tasks other than those of the evaluation.
    machine : Machine, str or path
    trials : int
        Most sets of gains to try.
    progress : callable, optional
        Called with the trials done and their largest number.
    """
    machine, count = as_machine(machine), 0
    if not tasks or trials < 1:
        raise InputError(f"a search needs one task and one trial or more; got {len(tasks)} and {trials}")

    def cost(gains: dict[str, float]) -> float:
        nonlocal count
        if progress is not None:
            progress(count, trials)
        count += 1
        trial = operator.changed(**gains)
        return float(np.mean([loading_cycle(task, interface, trial, machine=machine).cost for task in tasks]))

    start = {name: getattr(operator, name) for name in GAINS}
    return operator.changed(**pattern_search(cost, start, trials=trials, factors=SEARCH)[0])


def _poses(machine: Machine, place: tuple[float, float]) -> list[Array]:
    """Poses (n,) with the tip at `place` in which the supply can move every piston in both directions with the heaviest
    log."""
    poses = [np.ravel(q) for x3 in TELESCOPE for q in machine.inverse_kinematics(place, x3=x3)]
    return [q for q in poses if machine.piston_speeds(q, payload=MASSES[1]).all()]


def _measured(task: LogTask, interface: str, operator: Operator, found: Drive, run: Run) -> Cycle:
    time = run.columns["time"].values
    tip = np.column_stack([run.columns[name].values for name in ("tip.x", "tip.z")])
    power = run.columns["supply.power"].values
    (left, right), top = STAKE
    struck = (tip[:, 0] > left) & (tip[:, 0] < right) & (tip[:, 1] < top)
    return Cycle(
        interface=interface,
        task=task,
        operator=operator,
        finished=found.finished,
        time=found.scenario.duration if found.finished else float("nan"),
        way=float(np.hypot(*np.diff(tip, axis=0).T).sum()),
        energy=float(0.5 * (power[1:] + power[:-1]) @ np.diff(time)),
        overshoot=_overshoot(task, found, time, tip),
        strikes=int(np.count_nonzero(np.diff(struck.astype(int)) == 1)),
        missed=_missed(task, found, time, tip),
        reversals=sum(_reversals(axis) for axis in found.sticks.T),
        stick_travel=float(np.abs(np.diff(found.sticks, axis=0)).sum()),
        run=run,
    )


def _overshoot(task: LogTask, found: Drive, time: Array, tip: Array) -> float:
    """Largest overshoot beyond a way-point with a stop, along the line from the previous way-point, m."""
    aims = found.aims[np.minimum((time / PERIOD).astype(int), found.aims.size - 1)]
    farthest, before = 0.0, np.asarray(HOME)
    for index, point in enumerate(task.waypoints):
        place = np.asarray(point.place)
        if point.stops and (aims == index).any():
            along = (place - before) / np.hypot(*(place - before))
            farthest = max(farthest, float(((tip[aims == index] - place) @ along).max()))
        before = place
    return farthest


def _missed(task: LogTask, found: Drive, time: Array, tip: Array) -> int:
    """Number of logs grasped or released farther from their place than the tolerance."""
    changed = [point for point in task.waypoints if point.payload is not None]
    moments = found.scenario.payload_changes
    places = [tip[np.searchsorted(time, moment - 1e-9)] for moment in moments]
    return sum(
        float(np.hypot(*(place - np.asarray(point.place)))) > point.tolerance
        for point, place in zip(changed, places, strict=False)
    )


def _reversals(axis: Array) -> int:
    """Number of sign changes of a stick, with or without a rest at its centre."""
    moved = np.sign(axis[axis != 0.0])
    return int(np.count_nonzero(np.diff(moved)))
