"""A time-optimal motion of the tip, planned by CasADi and IPOPT on the exported model and replayed by `hc.simulate`.

Writes the numbers of docs/validation/time-optimal.md and its picture. Run with a Python that has hydrocrane and casadi;
takes some minutes. `--short` plans on the coarsest grid only, writes nothing, and fails where the replay misses a
demand.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import casadi as ca
import marked_page
import numpy as np

import hydrocrane as hc

PAGE, PICTURE = Path(__file__).with_name("time-optimal.md"), Path(__file__).with_name("time-optimal.png")
CRANE = hc.load_machine("rottne-f9-lab")
PAYLOAD = 50.0
START = {"boom": np.deg2rad(100.0), "jib": np.deg2rad(100.0), "extension": 0.0}
GOAL = (3.0, 0.3)
# Limits: chamber pressures, Pa, from which the plan stays a MARGIN away; flow from the supply, m^3/s; share of each
# joint's range left free at both ends; time, s, in which a spool crosses its stroke.
PRESSURES, MARGIN, FLOW, FREE, CROSSING = (5e5, 92.5e5), 2.5e5, 8e-3 / 60, 0.05, 0.2
# Stages of Radau's method in each interval: order 5.
STAGES = 3
INTERVALS, DRAWN, SHORT = (40, 60, 80, 120), 80, 60
# Worth of the squared changes of the commands, as shares of the stroke, in s: what decides where time does not.
SMOOTH = 1e-2
# Kinks of the laws keep IPOPT from going on to zero: its barrier ends at this weight.
BARRIER, TOLERANCE, MOST = 1e-5, 1e-4, 150
# IPOPT begins at the guess, not away from its bounds.
BEGIN = {"ipopt.bound_push": 1e-6, "ipopt.bound_frac": 1e-6, "ipopt.mu_init": 1e-3}
# Shares of the strokes and duration, s, of the motion at which IPOPT begins.
GUESS, LASTS = (0.6, 0.4, 0.0), 3.0
# How long the replay goes on with closed spools, s, and its tolerance.
AFTER, EXACT = 0.5, 1e-9
# What the replay must keep: distance of the tip from the goal at the end and after it, m.
NEAR = 5e-3

STATES = {name: i for i, name in enumerate(CRANE.state_names)}
CYLINDERS = CRANE.cylinder_names
RATES = [i for name, i in STATES.items() if name.endswith(".qd")]
SPOOLS = [STATES[f"cylinder.{name}.xs"] for name in CYLINDERS]
# The machine of the plan has no bristles, no Stribeck curve, and friction that passes through zero over this width. Its
# spools follow their commands at once.
SIMPLER = {"model": "static", "smoothing-velocity": "10 mm/s"}
PLANNER = CRANE.changed(
    {f"friction.{c}.{key}": value for c in CYLINDERS for key, value in SIMPLER.items()}
    | {f"friction.{c}.breakaway": list(CRANE.value(f"friction.{c}.coulomb").si) for c in CYLINDERS}
)
# States of the plan: in its model, and in STATES.
IN_MODEL = [i for i, name in enumerate(PLANNER.state_names) if not name.endswith((".xs", ".vs"))]
MOVED = [PLANNER.state_names.index(f"cylinder.{name}.xs") for name in CYLINDERS]
PLANNED = [i for name, i in STATES.items() if not name.endswith((".xs", ".vs", ".z"))]
CHAMBERS = [i for name, i in STATES.items() if name.endswith((".p1", ".p2"))]
# Sizes of the states and of the commands, for IPOPT.
SIZES = {"q": 1.0, "qd": 0.3, "p1": 1e7, "p2": 1e7}
SCALES = np.array([SIZES[CRANE.state_names[i].rpartition(".")[2]] for i in PLANNED])
STROKES = np.array(CRANE.spool_strokes)
# The side to which each spool opens: where it crosses its middle, flows have a kink. The telescope stays closed.
SIDES = np.array([1.0, -1.0, 0.0])


def joint_bounds() -> np.ndarray:
    low, high = CRANE.joint_limits.T
    return np.stack([low + FREE * (high - low), high - FREE * (high - low)], axis=1)


@dataclass(frozen=True)
class Motion:
    """Commands at `times` (k,), linear between them, and states (m, states) at `seen` (m,), s."""

    times: np.ndarray
    commands: np.ndarray
    seen: np.ndarray
    states: np.ndarray

    @cached_property
    def tip(self) -> np.ndarray:
        return CRANE.tip(np.ascontiguousarray(self.states[:, : len(CRANE.joint_names)]))

    @cached_property
    def flow(self) -> np.ndarray:
        """From the supply, m^3/s."""
        commands = np.stack([np.interp(self.seen, self.times, own) for own in self.commands.T], axis=1)
        return CRANE.outputs(self.states, commands)["supply.flow"]

    @property
    def duration(self) -> float:
        return float(self.times[-1])


def by_tip_control() -> Motion:
    """The motion of the controller `tip` until it has arrived, to compare with."""
    goal = hc.Goal(0.0, *GOAL)
    run = hc.simulate(hc.Scenario(machine=CRANE, joints=START, goals=[goal], payload=PAYLOAD, duration=12.0))
    columns = run.columns
    seen = columns["time"].values
    states = np.stack([columns[name].values for name in STATES], axis=1)
    far = np.hypot(*(columns[f"tip.{axis}"].values - at for axis, at in zip("xz", GOAL, strict=True)))
    speed = np.abs(states[:, RATES]).max(axis=1)
    last = int(np.flatnonzero((far > NEAR) | (speed > 5e-3))[-1]) + 1
    commands = np.stack([columns[f"cylinder.{c}.command"].values for c in CYLINDERS], axis=1)
    return Motion(seen[: last + 1], commands[: last + 1], seen[: last + 1], states[: last + 1])


def by_trapezoids() -> Motion:
    """The motion under spools that open, stay open, and close: where IPOPT begins."""
    times = LASTS * np.array([0.0, 0.15, 0.75, 0.9, 1.0])
    spools = np.outer([0.0, 1.0, 1.0, 0.0, 0.0], SIDES * GUESS * STROKES)
    return replayed(Motion(times, spools, times, np.zeros((5, 0))), after=0.0)


@dataclass(frozen=True)
class Plan:
    """What IPOPT found: the motion, its verdict, its iterations, and the seconds that it took."""

    motion: Motion
    verdict: str
    iterations: int
    seconds: float

    @property
    def failures(self) -> list[str]:
        return [] if self.verdict == "Solve_Succeeded" else [f"IPOPT ended with {self.verdict}"]


def whole(x: ca.SX, u: ca.SX) -> ca.SX:
    """All states of the model: with spools where their commands are."""
    found = type(x).zeros(len(PLANNER.state_names))
    found[IN_MODEL], found[MOVED] = SCALES * x, u
    return found


def interval(model: object) -> ca.Function:
    """Radau's equations of an interval, in scaled numbers: residuals, and the flow from the supply at each stage."""
    n, m = len(SCALES), len(STROKES)
    before, stages = ca.SX.sym("before", n), ca.SX.sym("stages", n, STAGES)
    first, last, step = ca.SX.sym("first", m), ca.SX.sym("last", m), ca.SX.sym("step")
    points = ca.collocation_points(STAGES, "radau")
    weights, _, _ = ca.collocation_coeff(points)
    changes = ca.horzcat(before, stages) @ weights
    residuals, flows = [], []
    for j, point in enumerate(points):
        u = STROKES * (first + point * (last - first))
        x = whole(stages[:, j], u)
        residuals.append(changes[:, j] - step * model.derivative(x, u, [PAYLOAD])[IN_MODEL] / SCALES)
        flows.append(model.outputs(x, u, [PAYLOAD])[0] / FLOW)
    found = [ca.vertcat(*residuals), ca.vertcat(*flows)]
    return ca.Function("interval", [before, stages, first, last, step], found)


def planned(count: int) -> Plan:
    """The shortest motion from rest to rest with commands that are linear over each of `count` equal intervals."""
    guess = by_trapezoids()
    model = PLANNER.casadi(parameters=["payload.mass"], outputs=["supply.flow", "tip.x", "tip.z"])
    n, m = len(SCALES), len(STROKES)
    states, commands = ca.MX.sym("states", n, count * STAGES), ca.MX.sym("commands", m, count + 1)
    duration = ca.MX.sym("duration")
    start = CRANE.equilibrium([START[joint] for joint in CRANE.joint_names], payload=PAYLOAD)
    before = ca.horzcat(start[PLANNED] / SCALES, states[:, STAGES - 1 : -1 : STAGES])
    step = duration / count
    every = interval(model).map(count)
    residuals, flows = every(before, states, commands[:, :-1], commands[:, 1:], ca.repmat(step, 1, count))
    end = whole(states[:, -1], ca.MX.zeros(m))
    tip = model.outputs(end, ca.DM.zeros(m), [PAYLOAD])[1:]
    at_rest = model.derivative(end, ca.DM.zeros(m), [PAYLOAD])[RATES]
    change = commands[:, 1:] - commands[:, :-1]
    fastest = step / CROSSING
    held = [
        (ca.vec(residuals), 0.0, 0.0),
        (tip - ca.DM(GOAL), 0.0, 0.0),
        (at_rest, -0.1, 0.1),
        (ca.vec(flows), -ca.inf, 1.0),
        (ca.vec(change) - fastest, -ca.inf, 0.0),
        (ca.vec(change) + fastest, 0.0, ca.inf),
    ]
    low, high = np.full((n, count * STAGES), -np.inf), np.full((n, count * STAGES), np.inf)
    low[: len(RATES)], high[: len(RATES)] = (bound[:, None] for bound in joint_bounds().T)
    oil = [PLANNED.index(i) for i in CHAMBERS]
    low[oil], high[oil] = ((bound + side * MARGIN) / SIZES["p1"] for side, bound in zip((1, -1), PRESSURES))
    low[RATES, -1] = high[RATES, -1] = 0.0
    edges = np.sort([0.0 * SIDES, SIDES], axis=0)[:, :, None] * np.ones(count + 1)
    edges[:, :, [0, -1]] = 0.0
    durations = (0.1, 60.0)
    lower, upper = ([*own.ravel("F"), *edge.ravel("F"), last] for own, edge, last in zip((low, high), edges, durations))
    unknown = ca.vertcat(ca.vec(states), ca.vec(commands), duration)
    problem = {
        "x": unknown,
        "f": duration + SMOOTH * ca.sumsqr(change) * count / 20,
        "g": ca.vertcat(*(value for value, _, _ in held)),
    }
    quiet = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes"}
    ends = {"ipopt.max_iter": MOST, "ipopt.tol": TOLERANCE, "ipopt.mu_target": BARRIER}
    solver = ca.nlpsol("solver", "ipopt", problem, quiet | BEGIN | ends)
    share = np.linspace(0.0, 1.0, count + 1)
    places = (share[:-1, None] + np.array(ca.collocation_points(STAGES, "radau")) / count).ravel()

    def along(values: np.ndarray, at: np.ndarray) -> np.ndarray:
        own = guess.seen / guess.duration
        return np.stack([np.interp(at, own, column) for column in values.T], axis=1)

    given = np.stack([np.interp(share * guess.duration, guess.times, own) for own in guess.commands.T], axis=1)
    first = [*(along(guess.states[:, PLANNED], places) / SCALES).ravel(), *(given / STROKES).ravel(), guess.duration]
    began = time.perf_counter()
    found = solver(
        x0=np.clip(first, lower, upper),
        lbx=lower,
        ubx=upper,
        lbg=np.concatenate([np.full(value.numel(), least) for value, least, _ in held]),
        ubg=np.concatenate([np.full(value.numel(), most) for value, _, most in held]),
    )
    took = time.perf_counter() - began
    x = np.array(found["x"]).ravel()
    lasts = float(x[-1])
    times, seen = share * lasts, np.append(0.0, places) * lasts
    spools = x[n * count * STAGES : -1].reshape(count + 1, m) * STROKES
    found = np.tile(start, (len(seen), 1))
    found[1:, PLANNED] = x[: n * count * STAGES].reshape(-1, n) * SCALES
    found[:, SPOOLS] = np.stack([np.interp(seen, times, own) for own in spools.T], axis=1)
    told = solver.stats()
    return Plan(Motion(times, spools, seen, found), told["return_status"], told["iter_count"], took)


def replayed(motion: Motion, after: float = AFTER) -> Motion:
    """What `hc.simulate` makes of a plan's commands; the spools then stay closed."""
    times, commands = motion.times, motion.commands
    if after:
        times, commands = np.append(times, motion.duration + after), np.vstack([commands, 0.0 * STROKES])
    run = hc.simulate(
        hc.Scenario(
            machine=CRANE,
            joints=START,
            payload=PAYLOAD,
            commands={c: hc.Command(times, own, "linear") for c, own in zip(CYLINDERS, commands.T, strict=True)},
            duration=float(times[-1]),
            record_interval=1e-3,
            solver=hc.Solver(method="rodas5p", rtol=EXACT),
        )
    )
    assert run.outcome.kind == "completed", run.outcome
    columns = run.columns
    return Motion(times, commands, columns["time"].values, np.stack([columns[name].values for name in STATES], axis=1))


@dataclass(frozen=True)
class Figures:
    """A plan beside its replay. Distances in m, pressures in Pa; what exceeds a limit is positive."""

    at_end: float
    after: float
    apart: float
    pressures_apart: float
    over_pressure: float
    over_flow: float
    over_joints: float

    @property
    def failures(self) -> list[str]:
        """Demands that the replay misses."""
        found = []
        if max(self.at_end, self.after) > NEAR:
            found.append(f"the tip is {1e3 * max(self.at_end, self.after):.1f} mm from the goal")
        if self.over_joints > 0:
            found.append(f"a joint leaves its range by {self.over_joints:.2g} rad or m")
        if self.over_pressure > 1e-3 * PRESSURES[1]:
            found.append(f"a pressure leaves its limits by {self.over_pressure / 1e5:.2f} bar")
        if self.over_flow > 1e-3 * FLOW:
            found.append(f"the flow exceeds its limit by {6e4 * self.over_flow:.3f} l/min")
        return found


def figures(plan: Motion, replay: Motion) -> Figures:
    there = np.stack([np.interp(plan.seen, replay.seen, own) for own in replay.states.T], axis=1)
    tip = np.stack([np.interp(plan.seen, replay.seen, own) for own in replay.tip.T], axis=1)
    far = np.hypot(*(replay.tip - GOAL).T)
    pressures, joints = replay.states[:, CHAMBERS], replay.states[:, : len(RATES)]
    bounds = joint_bounds()
    return Figures(
        at_end=float(np.interp(plan.duration, replay.seen, far)),
        after=float(far[replay.seen >= plan.duration].max()),
        apart=float(np.hypot(*(tip - plan.tip).T).max()),
        pressures_apart=float(np.abs(there - plan.states)[:, CHAMBERS].max()),
        over_pressure=float(max(PRESSURES[0] - pressures.min(), pressures.max() - PRESSURES[1])),
        over_flow=float(replay.flow.max() - FLOW),
        over_joints=float(max((bounds[:, 0] - joints).max(), (joints - bounds[:, 1]).max())),
    )


def picture(plan: Motion, replay: Motion, control: Motion) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    from hydrocrane.plots.style import MUTED, RC

    with plt.rc_context(RC):
        figure, charts = plt.subplots(2, 3, figsize=(13, 7.5), layout="constrained")
        path, spools, flow, high, low, joints = charts.ravel()
        path.plot(*control.tip.T, color=MUTED, label=f"controller tip, {control.duration:.2f} s")
        path.plot(*replay.tip.T, label=f"replay, {plan.duration:.2f} s")
        path.plot(*plan.tip.T, ".", ms=3, label="plan")
        path.plot(*GOAL, "k+", ms=12)
        path.set(title="Tip", xlabel="x, m", ylabel="z, m", aspect="equal", adjustable="datalim")
        for k, name in enumerate(CYLINDERS):
            colour = f"C{k}"
            spools.plot(plan.times, 100 * plan.commands[:, k] / STROKES[k], color=colour, label=name)
            for chart, side in ((high, "p1"), (low, "p2")):
                own = STATES[f"cylinder.{name}.{side}"]
                chart.plot(replay.seen, replay.states[:, own] / 1e5, color=colour, label=name)
                chart.plot(plan.seen, plan.states[:, own] / 1e5, ".", ms=3, color=colour)
        for k, (name, (least, most)) in enumerate(zip(CRANE.joint_names, joint_bounds(), strict=True)):
            share = [100 * (motion.states[:, k] - least) / (most - least) for motion in (replay, plan)]
            joints.plot(replay.seen, share[0], color=f"C{k}", label=name)
            joints.plot(plan.seen, share[1], ".", ms=3, color=f"C{k}")
        flow.plot(replay.seen, 6e4 * replay.flow)
        flow.plot(plan.seen, 6e4 * plan.flow, ".", ms=3, color="C0")
        flow.axhline(6e4 * FLOW, color="k", ls="--", lw=0.8)
        for chart, side in ((high, "piston"), (low, "rod")):
            for limit in PRESSURES:
                chart.axhline(limit / 1e5, color="k", ls="--", lw=0.8)
            chart.set(title=f"Pressure, {side} side", ylabel="bar")
        for limit in (0.0, 100.0):
            joints.axhline(limit, color="k", ls="--", lw=0.8)
        spools.set(title="Spool commands", ylabel="% of the stroke")
        flow.set(title="Flow from the supply", ylabel="l/min")
        joints.set(title="Joints between their limits", ylabel="%")
        for chart in (spools, flow, high, low, joints):
            chart.set_xlabel("time, s")
        for chart in (path, spools, joints):
            chart.legend(loc="center right" if chart is joints else "best")
        figure.savefig(PICTURE, dpi=100, metadata={"Software": None})
        plt.close(figure)


def numbers() -> list[str]:
    control = by_tip_control()
    rows, missed = [], []
    for count in INTERVALS:
        plan = planned(count)
        replay = replayed(plan.motion)
        found = figures(plan.motion, replay)
        missed += [f"{count} intervals: {failure}." for failure in [*plan.failures, *found.failures]]
        cells = [f"{count}", plan.verdict, f"{plan.iterations}", f"{plan.seconds:.0f}", f"{plan.motion.duration:.3f}"]
        cells += [f"{1e3 * value:.2f}" for value in (found.at_end, found.after, found.apart)]
        cells += [f"{value / 1e5:.2f}" for value in (found.pressures_apart, found.over_pressure)]
        rows.append("| " + " | ".join([*cells, f"{6e4 * found.over_flow:.3f}"]) + " |")
        print(rows[-1], flush=True)
        if count == DRAWN:
            picture(plan.motion, replay, control)
    return [
        "## Demands that a replay misses",
        "",
        *([f"* {failure}" for failure in missed] or ["None."]),
        "",
        "## Plans and their replays",
        "",
        f"The controller `tip` arrives after {control.duration:.2f} s, on a straight line and without these limits: it "
        f"needs up to {6e4 * control.flow.max():.1f} l/min and {control.states[:, CHAMBERS].max() / 1e5:.0f} bar.",
        f"The limits: {6e4 * FLOW:g} l/min, and pressures from {PRESSURES[0] / 1e5:g} to {PRESSURES[1] / 1e5:g} bar, "
        f"from which the plan stays {MARGIN / 1e5:g} bar away.",
        "",
        "| intervals | IPOPT | iterations | IPOPT's time, s | motion, s | tip off the goal at the end, mm "
        "| largest in the 0.5 s after it, mm | tip off the plan, mm | pressures off the plan, bar "
        "| beyond their limits, bar | flow over its limit, l/min |",
        "|" + "---|" * 11,
        *rows,
        "",
        f"![The plan of {DRAWN} intervals as points, its replay as lines](time-optimal.png)",
    ]


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--short", action="store_true", help="plan on the coarsest grid, write nothing")
    if not parser.parse_args(arguments).short:
        marked_page.write(PAGE, numbers())
        return
    plan = planned(SHORT)
    found = figures(plan.motion, replayed(plan.motion))
    print(plan.verdict, f"{plan.motion.duration:.3f} s", found)
    sys.exit(bool(plan.failures or found.failures))


if __name__ == "__main__":
    main(sys.argv[1:])
