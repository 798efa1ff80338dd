"""Slewing gears that start and stop, under ``tip`` and under levers, and lines that are followed while they slew.

    python docs/validation/slewing_stops.py          writes the section "Slewing and stopping" of tip-machines.md

Nobody states the loads.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import NamedTuple

import marked_page
import numpy as np
from workers import processes

import hydrocrane as hc
from hydrocrane.benchmark import Condition, random_lines
from hydrocrane.benchmark.cases import scenario_of

sys.path.append(str(Path(__file__).resolve().parents[2]))

from benches.tables import table  # noqa: E402

PAGE = Path(__file__).with_name("tip-machines.md")
# Joints behind the slewing one, rad and m: near, and far out.
POSES = {
    "rottne-f9-forwarder": {"near": (2.09, 1.75, 0.0), "far": (1.57, 2.79, 0.3)},
    "sany-sy19e": {"near": (0.7, 1.05, 0.7), "far": (-0.26, 0.0, -0.35)},
}
LOADS = {"rottne-f9-forwarder": (0.0, 120.0), "sany-sy19e": (0.0, 60.0, 120.0)}
DEFLECTIONS = (1.0, 0.3)
# From which angle, rad; when the stick is moved, for how long, with which ramp, and how long it is watched, s.
FROM, BEGINS, HELD, RAMP, WATCHED = -0.8, 0.5, 2.0, 0.3, 8.0
# Lines of a seed on which nothing was chosen, the angle that they begin at, rad, the speeds across that are asked for
# on the way, and the full speed of the stick, m/s.
SEED, LINES, ANGLE, ACROSS, FULL_SPEED = 3900, 20, -0.5, (0.0, 0.5, 1.3), 1.5
# Speed below which the tip is settled, m/s, as on the rest of the page.
SETTLES = 5e-3


class Stop(NamedTuple):
    """How a tip came to rest across the plane of its boom, SI."""

    radius: float
    fastest: float
    way: float
    back: float
    settled: float
    deviation: float
    crossed: float


class Task(NamedTuple):
    machine: str
    pose: str
    payload: float
    deflection: float
    mode: str


def plan(task: Task) -> hc.Scenario:
    machine = hc.load_machine(task.machine)
    time = [BEGINS, BEGINS + HELD]
    if task.mode == "tip":
        stick = hc.Joystick(time, {"slew": [task.deflection, 0.0]}, ramp=RAMP)
    else:
        axes = {name: [0.0, 0.0] for name in machine.cylinder_names}
        axes[machine.cylinder_names[0]] = [task.deflection, 0.0]
        stick = hc.Joystick(time, axes, mode="lever", ramp=RAMP)
    joints = dict(zip(machine.joint_names, (FROM, *POSES[task.machine][task.pose]), strict=True))
    duration = BEGINS + HELD + WATCHED
    return hc.Scenario(task.machine, joints=joints, joystick=stick, payload=task.payload, duration=duration)


def stop(task: Task) -> Stop:
    run = hc.simulate(plan(task), ledger=False)
    columns, slew = run.columns, run.machine.cylinder_names[0]
    since = columns.time - BEGINS - HELD
    angle, rate = (columns[f"joint.{run.machine.joint_names[0]}.{kind}"].values for kind in ("q", "qd"))
    radius = float(np.hypot(columns["tip.x"].values[-1], columns["tip.y"].values[-1]))
    released, speed = since >= 0.0, radius * np.abs(rate)
    deviation = columns["tip.deviation"].values if task.mode == "tip" else np.array([np.nan])
    crossed = f"cylinder.{slew}.crossed"
    return Stop(
        radius=radius,
        fastest=float(speed.max()),
        way=radius * float(angle[-1] - angle[released][0]),
        # From the farthest place after the stick was released.
        back=radius * float(angle[released].max() - angle[-1]),
        settled=float(since[speed > SETTLES].max(initial=0.0)),
        deviation=float(np.max(deviation, initial=0.0, where=~np.isnan(deviation))) if task.mode == "tip" else np.nan,
        crossed=float(np.abs(columns[crossed].values).max()) if crossed in columns else 0.0,
    )


def rows() -> Iterator[list[str]]:
    tasks = [
        Task(machine, pose, payload, deflection, mode)
        for machine, poses in POSES.items()
        for payload, pose, deflection, mode in product(LOADS[machine], poses, DEFLECTIONS, ("tip", "lever"))
    ]
    for task, found in zip(tasks, processes().map(stop, tasks), strict=True):
        yield [
            f"`{task.machine}`", f"{task.payload:g}", f"{found.radius:.2f}", f"{100.0 * task.deflection:.0f}",
            f"`{task.mode}`", f"{found.fastest:.2f}", f"{1e3 * found.way:.0f}", f"{1e3 * found.back:.1f}",
            f"{found.settled:.2f}", "" if np.isnan(found.deviation) else f"{1e3 * found.deviation:.1f}",
            f"{6e4 * found.crossed:.2f}",
        ]  # fmt: skip


class Lines(NamedTuple):
    """Random lines in the plane of the boom, with this speed across it, m/s."""

    machine: str
    payload: float
    across: float


def lines(task: Lines) -> tuple[float, list[float]]:
    """Fastest slewing, rad/s, and how far the tip was off each line in the plane, m."""
    machine, fastest, off = hc.load_machine(task.machine), 0.0, []
    for case in random_lines(machine, LINES, seed=SEED, condition=Condition(payload=task.payload)):
        plan = scenario_of(machine, "tip", replace(case, start=(ANGLE, *case.start[1:])))
        share = plan.joystick.table(())
        axes = dict(zip(("x", "z"), share.T * case.task.speed / FULL_SPEED, strict=True))
        axes["slew"] = task.across / FULL_SPEED * np.minimum(np.hypot(*share.T), 1.0)
        stick = replace(plan.joystick, axes=axes, full_speed=FULL_SPEED)
        columns = hc.simulate(replace(plan, joystick=stick, duration=case.task.moving_time + 4.0), ledger=False).columns
        fastest = max(fastest, float(np.abs(columns[f"joint.{machine.joint_names[0]}.qd"].values).max()))
        places = np.column_stack([columns[f"tip.{axis}"].values for axis in "xyz"])
        seen = np.column_stack([np.hypot(places[:, 0], places[:, 1]), places[:, 2]])
        way = case.task.displacement[-1] / np.linalg.norm(case.task.displacement[-1])
        off.append(float(np.abs((seen - seen[0]) @ (-way[1], way[0])).max()))
    return fastest, off


LINES_HEADS: Sequence[str] = (
    "machine", "load, kg", "asked across, m/s", "fastest slewing, rad/s", "off the line in the plane, mm: worst",
    "median",
)  # fmt: skip


def line_rows() -> Iterator[list[str]]:
    cases = [(name, load, across) for name in POSES for load in (0.0, LOADS[name][1]) for across in ACROSS]
    tasks = [Lines(*case) for case in cases]
    for task, (fastest, off) in zip(tasks, processes().map(lines, tasks), strict=True):
        yield [
            f"`{task.machine}`", f"{task.payload:g}", f"{task.across:g}", f"{fastest:.2f}", f"{1e3 * max(off):.2f}",
            f"{1e3 * np.median(off):.2f}",
        ]  # fmt: skip


HEADS: Sequence[str] = (
    "machine", "load, kg", "radius, m", "deflection, %", "controller", "fastest, m/s", "way after release, mm",
    "back from the farthest place, mm", "settled after, s", "off the circle, mm", "through relief valves, l/min",
)  # fmt: skip


if __name__ == "__main__":
    tables = [table(list(LINES_HEADS), list(line_rows())), "", table(list(HEADS), list(rows()))]
    marked_page.write(PAGE, tables, "slewing")
