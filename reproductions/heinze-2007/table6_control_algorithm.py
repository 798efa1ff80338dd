"""Table 6, step by step: what `heinze-pid` does in a run, and what the printed listing contains.

A step counts as done if the run shows it. Where it only shows in the spool command, the command is computed anew with
all steps, which has to agree, and with this step left out, which must not.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from common import completed, printed_controller, printed_program
from fig76_79_control import SEQUENCE, SEQUENCE_TIMES, START, columns, drive

import hydrocrane as hc

PERIOD, SET_POINT_EVERY, RECORDS = 1e-3, 4, 4
CYLINDERS = ("lift", "jib", "extension")
AGREES = 1e-9  # m of spool, m, rad
# Fast enough for the spools to reach their limits, m/s.
SPEED = 1.0
# Outward for as long as it takes to leave the working area.
OUT = {"speed": 0.5, "duration": 4.0, "period": 5e-3}
# For the penalty the telescope starts out of the middle of its range.
TELESCOPE = 0.1
# Own candidates of the telescope, and how far above the best of them the chosen posture's penalty may lie, as a share:
# the search ends at a thousandth of the distance of its own candidates.
GRID, MORE = 4001, 1e-3

STEPS = {
    1: ("time below the sampling interval: leave", "set-points only; the PID runs at every evaluation (E22)"),
    2: ("measure the joints", "yes"),
    3: ("read the stick", "yes, from constants"),
    4: ("stick to tip velocity", "yes"),
    5: ("new tip coordinates", "yes, from the measured tip"),
    6: ("limit to the working area", "**no**"),
    7: ("loop over the telescope", "one candidate, x3 = 0"),
    8: ("penalty function", "**no**"),
    9: ("inverse kinematics", "yes"),
    10: ("better than the previous ones", "nothing to compare"),
    11: ("end of the loop", "one candidate"),
    12: ("shift the error before last", "yes"),
    13: ("shift the last error", "yes"),
    14: ("new errors", "yes"),
    15: ("save the errors", "yes"),
    16: ("(129)", "yes, as the listing has it (E21)"),
    17: ("(130)", "yes"),
    18: ("to the valves", "yes"),
    19: ("repeat", "yes"),
}


@cache
def followed():
    """A run on the printed machine, four records per sample and four samples per set-point."""
    stick = hc.Joystick(SEQUENCE_TIMES, SEQUENCE, full_speed=SPEED)
    interval = SET_POINT_EVERY * PERIOD
    keys = {"control.heinze-pid.set-point-interval": interval, "control.heinze-pid.working-area": "none"}
    return drive(
        "heinze-2007",
        0.9,
        stick,
        controller="heinze-pid",
        period=PERIOD,
        record_interval=PERIOD / RECORDS,
        sensors="ideal",
        overrides=keys,
    ).isel(time=slice(None, -1))


def commands(q: np.ndarray, targets: np.ndarray, left_out: int = 0) -> np.ndarray:
    """Spool commands (m, 3) of steps 12 to 17 for joints and targets (m, 3), one step left out."""
    kp, ki, kd = np.array(printed_controller.GAINS).T
    newest, before, earlier, output = np.zeros((4, 3))
    found = []
    for now in targets - q:
        if left_out != 12:
            earlier = before
        if left_out != 13:
            before = newest
        error = newest if left_out == 14 else now
        if left_out != 15:
            newest = error
        if left_out != 16:
            output = output + kp * (error - before) + ki * error + kd * (error - 2 * before + earlier)
        if left_out != 17:
            output = np.clip(output, -printed_program.SPOOL_STROKE, printed_program.SPOOL_STROKE)
        found.append(np.array(printed_controller.SPOOL_SIGNS) * output)
    return np.array(found)


def close(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(np.abs(a - b).max() < AGREES)


def constant_between(values: np.ndarray, every: int) -> bool:
    """Whether rows change at multiples of `every` only, and do change."""
    blocks = values[: len(values) // every * every].reshape(-1, every, values.shape[1])
    return bool((blocks == blocks[:, :1]).all() and len(np.unique(blocks[:, 0], axis=0)) > 1)


def observed_steps() -> dict[int, bool]:
    """Steps 1 to 5, 9 and 12 to 19 in the run on the printed machine."""
    data = followed()
    sent, points = columns(data, [f"controller.{c}" for c in CYLINDERS]), columns(data, ["set_point.x", "set_point.z"])
    arrived = columns(data, [f"cylinder.{c}.command" for c in CYLINDERS])
    sampled = data.isel(time=slice(None, None, RECORDS))
    q = columns(sampled, [f"measured.joint.{joint}.q" for joint in START])
    stick = columns(sampled, ["stick.x", "stick.z"])
    held = np.searchsorted(SEQUENCE_TIMES, sampled.time.values + 1e-9, side="right") - 1
    asked = np.column_stack([SEQUENCE[axis] for axis in "xz"])[held]
    due = slice(None, None, SET_POINT_EVERY)
    moved = np.diff(points[::RECORDS][due], axis=0)
    targets = np.array([printed_controller.ik(point) for point in points[::RECORDS]])
    own, spools = sent[::RECORDS], commands(q, targets)
    # A record at a sample shows the command before it.
    between = np.arange(len(sent)) % RECORDS > 0
    still = np.tile(printed_controller.ik(points[0]), (len(q), 1))
    return {
        1: constant_between(sent, RECORDS) and constant_between(points, RECORDS * SET_POINT_EVERY),
        2: close(q, columns(sampled, [f"joint.{joint}.q" for joint in START])),
        3: close(stick, asked),
        4: close(np.sign(moved), np.sign(asked[due][1:])),
        5: close(moved, SPEED * PERIOD * SET_POINT_EVERY * asked[due][1:]),
        9: close(own, spools) and not close(own, commands(q, still)),
        **{k: close(own, spools) and not close(own, commands(q, targets, k)) for k in range(12, 18)},
        18: close(arrived[between], sent[between]),
        19: bool((np.diff(own, axis=0) != 0).any(axis=1)[len(own) // 4 :].all()),
    }


def within(working_area: str) -> bool:
    """Whether every set-point of a run outward can be reached within the joint limits, on the corrected machine."""
    stick = hc.Joystick([0.0], {"x": [1.0], "z": [0.0]}, full_speed=OUT["speed"])
    keys = {"control.heinze-pid.working-area": working_area}
    data = drive("rottne-f9-lab", OUT["duration"], stick, controller="heinze-pid", period=OUT["period"], overrides=keys)
    crane = hc.load_machine("rottne-f9-lab")
    points = columns(data, ["set_point.x", "set_point.z"])[::20]
    return all(len(crane.inverse_kinematics(point)) > 0 for point in points)


def penalty_steps() -> dict[int, bool]:
    """Steps 7, 8, 10 and 11: the posture chosen at the first set-point has the lowest penalty of all."""
    start = np.array([*list(START.values())[:2], TELESCOPE])
    stick = hc.Joystick([0.0], {"x": [1.0], "z": [0.0]}, full_speed=SPEED)
    plan = hc.Scenario(
        machine="rottne-f9-lab",
        joints=dict(zip(START, start)),
        duration=3 * PERIOD,
        joystick=stick,
        controller="heinze-pid",
        period=PERIOD,
        record_interval=PERIOD,
        overrides={"control.heinze-pid.extension": "penalty", "control.heinze-pid.working-area": "none"},
    )
    first = completed(hc.simulate(plan, ledger=False)).isel(time=slice(0, 1))
    crane = hc.load_machine("rottne-f9-lab")
    spool = columns(first, [f"controller.{c}" for c in CYLINDERS])[0]
    # The first increment is the error times the sum of the gains.
    chosen = start + spool * printed_controller.SPOOL_SIGNS / np.sum(printed_controller.GAINS, axis=1)
    point = columns(first, ["set_point.x", "set_point.z"])[0]
    low, high = crane.joint_limits.T

    def penalty(posture: np.ndarray) -> float:
        motion, middle = (posture - start) / (high - low), (posture - (low + high) / 2) / (high - low)
        return float(motion @ motion + 0.1 * middle @ middle)

    postures = [q for x3 in np.linspace(low[2], high[2], GRID) for q in crane.inverse_kinematics(point, x3=x3)]
    best, kept = min(map(penalty, postures)), min(map(penalty, crane.inverse_kinematics(point, x3=TELESCOPE)))
    lowest = close(crane.tip(chosen), point) and penalty(chosen) < best * (1 + MORE) < kept
    varied = abs(chosen[2] - TELESCOPE) > 1e-3
    return {7: varied, 8: lowest, 10: lowest, 11: lowest}


def compute() -> dict[str, float]:
    done = observed_steps() | {6: within("limited") and not within("none")} | penalty_steps()
    numbers = {f"step_{k}": float(done[k]) for k in STEPS}
    return numbers | {"steps_missed": float(sum(not done[k] for k in STEPS))}


def report(numbers: dict[str, float]) -> list[str]:
    """Step by step."""
    lines = ["| step of Table 6 | `heinze-pid` | the printed listing, as read |", "|---|---|---|"]
    for k, (what, printed) in STEPS.items():
        own = "done" if numbers[f"step_{k}"] else "**not done**"
        key = {6: ", key `working-area`", 7: ", key `extension`", 8: ", key `extension`"}.get(k, "")
        lines.append(f"| {k}, {what} | {own}{key} | {printed} |")
    return lines
