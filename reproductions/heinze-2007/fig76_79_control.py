"""Figures 76 to 79: what the sketches of the sticks say, the sequence of set-points, and the PID listing.

The sticks drive the corrected machine; set-points and PID are those of the controller `heinze-pid` on the printed one.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from common import completed, figure, printed_controller, save

import hydrocrane as hc

START = {"boom": np.deg2rad(100.0), "jib": np.deg2rad(100.0), "extension": 0.0}
LEVER, HOLD = 0.3, 1.0
DIRECTIONS = np.deg2rad(np.arange(0.0, 360.0, 45.0))
SPEED, STROKE_TIME = 0.08, 2.0
PERIOD = 1e-3
# Deflections of one stick against time, held between.
SEQUENCE = {"x": [0.0, 0.5, 1.0, 0.3, 0.0], "z": [0.0, 1.0, 0.4, -0.6, 0.0]}
SEQUENCE_TIMES = np.array([0.0, 0.1, 0.3, 0.5, 0.7])
# The printed laws jump, which takes fixed steps.
SOLVERS = {"heinze-2007": hc.Solver(method="tsit5", step=2e-5), "rottne-f9-lab": hc.Solver(method="rodas5p")}


def drive(machine: str, duration: float, stick: hc.Joystick, **options):
    """A run from the thesis's start under a stick."""
    plan = hc.Scenario(
        machine=machine, joints=START, duration=duration, joystick=stick, solver=SOLVERS[machine], **options
    )
    return completed(hc.simulate(plan, ledger=False))


@cache
def lever_runs() -> dict[tuple[str, float], np.ndarray]:
    """Displacement of every piston (3,), m, after each lever was held to each side."""
    names = hc.load_machine("rottne-f9-lab").cylinder_names
    runs = {}
    for name in names:
        for side in (LEVER, -LEVER):
            stick = hc.Joystick([0.1, HOLD], {name: [side, 0.0]}, mode="lever")
            data = drive("rottne-f9-lab", HOLD + 0.3, stick, controller="lever")
            moved = [data[f"cylinder.{c}.x"].values for c in names]
            runs[name, side] = np.array([x[-1] - x[0] for x in moved])
    return runs


@cache
def stick_runs() -> list[np.ndarray]:
    """Way of the tip (m, 2) from its start for the stick in each direction, m."""
    ways = []
    for angle in DIRECTIONS:
        axes = {"x": [np.cos(angle), 0.0], "z": [np.sin(angle), 0.0]}
        stick = hc.Joystick([0.1, 0.1 + STROKE_TIME], axes, full_speed=SPEED)
        data = drive("rottne-f9-lab", STROKE_TIME + 1.0, stick, controller="tip")
        tip = np.column_stack([data["tip.x"].values, data["tip.z"].values])
        ways.append(tip - tip[0])
    return ways


@cache
def sequence():
    """A run of `heinze-pid` under the sequence of deflections, one record per sample."""
    stick = hc.Joystick(SEQUENCE_TIMES, SEQUENCE, full_speed=SPEED)
    return drive(
        "heinze-2007", 0.9, stick, controller="heinze-pid", period=PERIOD, record_interval=PERIOD, sensors="ideal"
    )


def samples():
    """The records at which the controller acted: all but the last, where the run ends."""
    return sequence().isel(time=slice(None, -1))


def columns(data, names: list[str]) -> np.ndarray:
    return np.column_stack([data[name].values for name in names])


def printed_commands() -> np.ndarray:
    """Spool commands (m, 3) of the printed listing, given the joint angles and set-points of the run, m."""
    data = samples()
    q = columns(data, [f"measured.joint.{joint}.q" for joint in START])
    pid = printed_controller.IncrementalPid()
    targets = [printed_controller.ik(point) for point in columns(data, ["set_point.x", "set_point.z"])]
    return np.array([pid.step(target - now) for target, now in zip(targets, q, strict=True)])


def repeatability(key: str) -> float:
    """Angles of a run repeat to a part of the solver's tolerance."""
    return 1e-5 if key == "stick_angle_deg" else 1e-9


def compute() -> dict[str, float]:
    moved = lever_runs()
    wrong = 0
    for (name, side), way in moved.items():
        own = [c == name for c in dict.fromkeys(lever for lever, _ in moved)].index(True)
        others = np.delete(np.abs(way), own)
        wrong += bool(way[own] * side <= 0 or others.max() > 0.1 * abs(way[own]))
    angles = [np.arctan2(*way[-1][::-1]) for way in stick_runs()]
    aside = np.angle(np.exp(1j * (np.array(angles) - DIRECTIONS)))
    data = samples()
    points = columns(data, ["set_point.x", "set_point.z"])
    sticks = columns(data, ["stick.x", "stick.z"])
    sums = points[0] + np.cumsum(sticks, axis=0) * SPEED * PERIOD
    own_commands = columns(data, [f"controller.{c}" for c in ("lift", "jib", "extension")])
    return {
        "levers_missed": float(wrong),
        "stick_angle_deg": float(np.degrees(np.abs(aside).max())),
        "set_point_gap_m": float(np.abs(points - sums).max()),
        "pid_command_gap_m": float(np.abs(own_commands - printed_commands()).max()),
    }


def draw() -> None:
    fig, axes = figure(2, 2, (10.0, 7.5))
    (levers, stick), (points, pid) = axes
    for i, way in enumerate(lever_runs().values()):
        for j in range(3):
            levers.bar(i + 0.25 * (j - 1), way[j] * 1e3, 0.25, color=f"C{j}")
    labels = [f"{name}\n{'push' if side > 0 else 'pull'}" for name, side in lever_runs()]
    levers.set_xticks(range(len(labels)), labels, fontsize=8)
    levers.set(title="Figure 76: one lever per cylinder", ylabel="pistons moved [mm]")
    for way in stick_runs():
        stick.plot(*(way * 1e3).T, color="tab:blue")
    stick.set(title="Figure 77: one stick, eight directions", xlabel="x [mm]", ylabel="z [mm]", aspect="equal")
    data = samples()
    time = data.time.values
    for axis in "xz":
        way = data[f"set_point.{axis}"].values
        points.plot(time, (way - way[0]) * 1e3, label=f"set-point {axis} [mm]")
        points.step(time, data[f"stick.{axis}"].values * SPEED * 1e3, "--", where="post", label=f"asked {axis} [mm/s]")
    points.set(title="Figure 78: set-points of the stick", xlabel="time [s]")
    points.legend(frameon=False, fontsize=8)
    printed = printed_commands()
    for j, cylinder in enumerate(("lift", "jib", "extension")):
        pid.plot(time, data[f"controller.{cylinder}"].values * 1e3, color=f"C{j}", label=cylinder)
        pid.plot(time[::40], printed[::40, j] * 1e3, "k.", ms=4, label="printed listing" if j == 2 else None)
    pid.set(title="Figure 79: the PID beside the listing", xlabel="time [s]", ylabel="spool command [mm]")
    pid.legend(frameon=False, fontsize=8)
    save(fig, "fig76_79_control")
