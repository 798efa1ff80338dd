"""Tip control by design: lines on every bundled crane, with a load that the controller is not told.

    python docs/validation/tip_machines.py                                  writes docs/validation/tip-machines.md
    python docs/validation/tip_machines.py --machines crane.toml=300        prints the tables of other machine files
    python docs/validation/tip_machines.py --short                          few lines; says what is newly missed

A machine file is given with its rated load in kg. The variable ``WORKERS`` states the number of processes.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import marked_page
import numpy as np
from tip_soak import alarms
from workers import processes

import hydrocrane as hc
from hydrocrane.benchmark import Case, Condition, random_lines
from hydrocrane.benchmark.cases import motion_of, scenario_of
from hydrocrane.benchmark.metrics import LAST, TipMotion, metrics

sys.path.append(str(Path(__file__).resolve().parents[2]))

from benches.tables import table  # noqa: E402

PAGE = Path(__file__).with_name("tip-machines.md")
# Rated loads, kg.
RATED = {"rottne-f9": 120.0, "hiab-xs031": 150.0, "sany-sy19e": 60.0}
# The printed machine is left out: behind closed valves its tip sinks by decimetres.
LEFT_OUT = ("heinze-2007",)
SHARES, SENSORS = (0.0, 0.5, 1.0), ("ideal", "data-sheet")
# No constant was chosen on lines of this seed. Every so many of them is held for a minute.
SEED, LINES, EACH_HELD = 3900, 40, 4
SHORT_LINES = 2
# After the stick is centred: when the tip shall rest, and from when on and for how long it is held, s.
RESTS, HELD_FROM, HELD = 4.0, 6.0, 60.0
# The set-point is behind the stick, the piston behind it by the valve: three times what all lags and the slowest mode
# take.
TIMES = 3.0
# m, m/s, share of the lines
OFF, QUIET, DRIFT, SETTLED = 10e-3, 1e-3, 1e-3, 0.9
# Speed below which a tip is settled, m/s, as in the benchmark.
SETTLES = 5e-3
# Kinds of warnings that a controller gives; others are about the run.
TOLD = ("controller-oscillates", "tip-off-path", "sensor-stop")
# What is missed, and why: machine, sensors, demand.
FAST = "modes faster than the valves: [(a)](#causes)"
NOISE = "a low gain within the noise of the pressures: [(b)](#causes)"
CENTRE = "near the dead centre of the lift: [(c)](#causes)"
SLEW = "coarse counts of the slewing gear: [(e)](#causes)"
STICK = "seals that stick: [(f)](#causes)"
EMPTIES = "a motor that empties: [(f)](#causes)"
MISSED = {
    **{
        (machine, sensors, demand): FAST if sensors == "ideal" else f"{FAST}, or {NOISE}"
        for machine, sensors in (
            ("rottne-f9-mobile", "ideal"),
            ("rottne-f9-mobile", "data-sheet"),
            ("rottne-f9-ls", "data-sheet"),
        )
        for demand in ("speed at rest", "not settled in time")
    },
    ("rottne-f9-lab", "data-sheet", "speed at rest"): f"{FAST}, or {NOISE}",
    ("rottne-f9-pump", "data-sheet", "speed at rest"): f"{FAST}, or {NOISE}",
    ("rottne-f9-forwarder", "data-sheet", "speed at rest"): SLEW,
    ("sany-sy19e", "ideal", "speed at rest"): STICK,
    ("sany-sy19e", "ideal", "not settled in time"): STICK,
    ("sany-sy19e", "ideal", "drift in a minute"): EMPTIES,
    ("hiab-xs031", "ideal", "worst deviation"): CENTRE,
    ("hiab-xs031", "ideal", "speed at rest"): f"likely {CENTRE}",
    ("hiab-xs031", "ideal", "drift in a minute"): f"likely {CENTRE}",
}


class Line(NamedTuple):
    """What a line came to, SI; no drift where it was not held."""

    off: float
    settled: float
    given: float
    rest: float
    drift: float
    count: float
    told: tuple[str, ...]


class Crane(NamedTuple):
    """A machine and the load that it is rated for, kg."""

    machine: str
    rated: float


class Task(NamedTuple):
    """Lines of a row: which, and which of them are held."""

    crane: Crane
    payload: float
    sensors: str
    lines: int
    held: int


def followed(machine: hc.Machine, case: Case, duration: float, sensors: str = "ideal") -> tuple[hc.Run, TipMotion]:
    """A line under ``tip``, followed until `duration`, s."""
    plan = replace(scenario_of(machine, "tip", case), duration=duration, sensors=sensors)
    run = hc.simulate(plan, ledger=False, on_error="stop")
    return run, motion_of(run, case.task)


def until(motion: TipMotion, end: float) -> TipMotion:
    """Its part up to `end`, s."""
    count = int(np.searchsorted(motion.time, end, side="right"))
    return TipMotion(**{key: None if value is None else value[:count] for key, value in vars(motion).items()})


def valve_lag(machine: hc.Machine) -> float:
    """Mean time from a command to the flow of the slowest valve, s."""

    def of(valve: str, key: str) -> float:
        name = f"{valve}.{key}"
        return float(machine.value(name).si) if name in machine.keys else 0.0

    valves = [
        key.removesuffix(".stroke") for key in machine.keys if key.startswith("valve.") and key.endswith(".stroke")
    ]
    swings = [(of(v, "delay"), of(v, "damping-ratio"), of(v, "natural-frequency")) for v in valves]
    return max(delay + (2.0 * ratio / omega if omega else 0.0) for delay, ratio, omega in swings)


def time_given(machine: hc.Machine, q: np.ndarray, payload: float) -> float:
    """3/omega_1 + 3 lag, s, in the pose q (n,)."""
    found = hc.modes(machine, q, payload=payload, friction="released")
    # What takes longer than the crane is held for is no swing: near a dead centre nothing holds a joint.
    own = [
        f
        for f, state in zip(found.frequency, found.state, strict=True)
        if state.startswith("joint.") and f * HELD > 1.0
    ]
    omega = 2.0 * math.pi * min(own)
    lag = 2.0 / min(machine.tip_gains["stick-bandwidth"], omega) + valve_lag(machine)
    return TIMES * (1.0 / omega + lag)


def count_at_tip(run: hc.Run, q: np.ndarray) -> float:
    """How far a count of every joint sensor moves the tip, m: the smallest changes of the readings."""
    counts = []
    for joint in run.machine.joint_names:
        steps = np.abs(np.diff(run.data[f"measured.joint.{joint}.q"].values))
        counts.append(steps[steps > 0.0].min(initial=math.inf))
    return float(np.linalg.norm(run.machine.tip_jacobian(q), axis=0) @ np.where(np.isfinite(counts), counts, 0.0))


def line(machine: hc.Machine, case: Case, sensors: str, held: bool) -> Line:
    centred = case.task.moving_time
    run, motion = followed(machine, case, centred + (HELD_FROM + HELD if held else RESTS + LAST), sensors)
    found = metrics(until(motion, centred + RESTS + LAST))
    settled = math.inf if math.isnan(found.settling) else found.settling
    return judged(run, case, sensors, held, found.path_max, settled, found.vibration)


def slewing_line(machine: hc.Machine, case: Case, sensors: str, held: bool) -> Line:
    """A line under ``tip`` while the crane slews from a random angle by a random share of the stick."""
    random = np.random.default_rng([SEED, round(1e6 * case.task.speed)])
    share, angle = random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)
    plan, centred = scenario_of(machine, "tip", replace(case, start=(angle, *case.start[1:]))), case.task.moving_time
    slew = share * np.hypot(*plan.joystick.table(()).T)
    stick = replace(plan.joystick, axes={**plan.joystick.axes, "slew": slew})
    duration = centred + (HELD_FROM + HELD if held else RESTS + LAST)
    run = hc.simulate(replace(plan, joystick=stick, duration=duration, sensors=sensors), ledger=False, on_error="stop")
    q, qd = (
        np.column_stack([run.data[f"joint.{joint}.{kind}"].values for joint in machine.joint_names])
        for kind in ("q", "qd")
    )
    since = run.data.time.values - centred
    speed = np.linalg.norm(np.einsum("tij,tj->ti", machine.tip_jacobian(q), qd), axis=1)
    at_rest = (since >= RESTS) & (since <= RESTS + LAST)
    moving = since[(speed > SETTLES) & (since <= RESTS + LAST)]
    settled = math.inf if moving.size and moving[-1] >= RESTS else max(0.0, float(moving.max(initial=0.0)))
    off = float(np.nanmax(run.data["tip.deviation"].values))
    return judged(run, case, sensors, held, off, settled, float(np.sqrt(np.mean(speed[at_rest] ** 2))))


def judged(run: hc.Run, case: Case, sensors: str, held: bool, off: float, settled: float, rest: float) -> Line:
    """What a run came to that was `off` its line and took so long to be `settled`."""
    machine, data = run.machine, run.data
    q = np.array([data[f"joint.{joint}.q"].values[-1] for joint in machine.joint_names])
    tip = np.column_stack([data[f"tip.{axis}"].values for axis in machine.tip_axes])
    still = tip[data.time.values - case.task.moving_time >= HELD_FROM]
    warnings = [warning.kind for warning in run.warnings if warning.kind in TOLD]
    return Line(
        off=off if run.outcome.completed else math.inf,
        settled=settled,
        given=time_given(machine, q, case.condition.payload),
        rest=rest,
        drift=float(np.linalg.norm(still - still[0], axis=1).max()) if held and still.size else math.nan,
        count=count_at_tip(run, q) if sensors == "data-sheet" else 0.0,
        told=tuple(dict.fromkeys([*warnings, *alarms(run)])),
    )


def lines(task: Task) -> list[Line]:
    machine = hc.load_machine(task.crane.machine)
    follow = slewing_line if machine.first_in_plane else line
    cases = random_lines(machine, task.lines, seed=SEED, condition=Condition(payload=task.payload))
    return [follow(machine, case, task.sensors, k < task.held) for k, case in enumerate(cases)]


@dataclass(frozen=True)
class Row:
    """A machine with a load and sensors, and what its lines came to."""

    task: Task
    lines: list[Line]

    @cached_property
    def machine(self) -> str:
        return Path(self.task.crane.machine).stem

    def of(self, key: str) -> np.ndarray:
        return np.array([getattr(line, key) for line in self.lines])

    @cached_property
    def settled(self) -> float:
        return float(np.mean(self.of("settled") <= self.of("given")))

    @cached_property
    def drift(self) -> float:
        return float(np.nanmax(self.of("drift")))

    @cached_property
    def drift_asked(self) -> float:
        """A millimetre, or the least count of the held lines where counts are coarser."""
        return max(DRIFT, float(self.of("count")[~np.isnan(self.of("drift"))].min()))

    @property
    def told(self) -> int:
        return sum(bool(line.told) for line in self.lines)

    @property
    def demands(self) -> Iterator[tuple[str, float, float, float, str]]:
        """Each with what was found and what is asked at most, the factor to its unit, and the unit."""
        yield "worst deviation", float(self.of("off").max()), OFF, 1e3, "mm"
        yield "speed at rest", float(self.of("rest").max()), QUIET, 1e3, "mm/s"
        yield "drift in a minute", self.drift, self.drift_asked, 1e3, "mm"
        yield "not settled in time", 1.0 - self.settled, 1.0 - SETTLED, 1e2, "%"
        yield "lines with an alarm", float(self.told), 0.0, 1.0, ""

    def missed(self) -> list[tuple[str, float, float, float, str]]:
        return [demand for demand in self.demands if not demand[1] <= demand[2] * (1.0 + 1e-9)]

    def cells(self) -> list[str]:
        off, given = 1e3 * self.of("off"), self.of("given")
        return [
            f"`{self.machine}`", self.task.sensors, f"{self.task.payload:g}", f"{off.max():.1f}",
            f"{np.median(off):.2f}", f"{np.median(given):.2f} ({given.min():.2f} to {given.max():.2f})",
            f"{100.0 * self.settled:.0f}", f"{1e3 * self.of('rest').max():.2f}", f"{1e3 * self.drift:.2f}",
            f"{1e3 * self.drift_asked:.2f}", str(self.told),
        ]  # fmt: skip


HEADS = (
    "machine", "sensors", "load, kg", "off the line, mm: worst", "median", "time given, s: median (range)",
    "settled in it, %", "at rest, mm/s: worst", "drift in a minute, mm: worst", "asked", "lines with an alarm",
)  # fmt: skip


def bundled() -> list[Crane]:
    """Cranes whose tip moves in a plane, which may slew."""
    names = [name for name in hc.bundled_machines() if len(hc.load_machine(name).joint_names) > 1]
    names = [name for name in names if name not in LEFT_OUT]
    return [Crane(name, next(kg for start, kg in RATED.items() if name.startswith(start))) for name in names]


def driven(cranes: Sequence[Crane], lines_of_row: int, held: int, shares: Sequence[float] = SHARES) -> list[Row]:
    """A row for each crane, its sensors and its loads."""
    tasks = [
        Task(crane, share * crane.rated, sensors, lines_of_row, held)
        for crane in cranes
        for sensors in (SENSORS if hc.load_machine(crane.machine).sensors else SENSORS[:1])
        for share in shares
    ]
    return [Row(task, found) for task, found in zip(tasks, processes().map(lines, tasks), strict=True)]


def failures(rows: Sequence[Row]) -> list[str]:
    """A line of the table for every demand that is missed, the farthest first."""
    found = [(row, *demand) for row in rows for demand in row.missed()]
    found.sort(key=lambda one: -one[2] / max(one[3], 1e-9))
    text = [
        [
            f"`{row.machine}`", row.task.sensors, f"{row.task.payload:g}", what, f"{factor * limit:.3g} {unit}",
            f"{factor * value:.3g} {unit}", MISSED.get((row.machine, row.task.sensors, what), "not known"),
        ]
        for row, what, value, limit, factor, unit in found
    ]  # fmt: skip
    heads = ["machine", "sensors", "load, kg", "demand", "asked at most", "found", "why"]
    return [table(heads, text)] if text else ["None."]


def verdict(rows: Sequence[Row]) -> list[str]:
    """How many rows meet each demand, and which machines miss it."""
    text = []
    for what in [demand[0] for demand in next(iter(rows)).demands]:
        missing = [row for row in rows if what in [demand[0] for demand in row.missed()]]
        names = ", ".join(dict.fromkeys(f"`{row.machine}` with {row.task.sensors} sensors" for row in missing))
        text.append(
            f"* **{what}**: met in {len(rows) - len(missing)} of {len(rows)} rows"
            + (f"; missed by {names}." if names else ".")
        )
    said = sorted({text for row in rows for line in row.lines for text in line.told})
    return [*text, *(["", "Alarms told: " + "; ".join(said) + "."] if said else [])]


def numbers(rows: Sequence[Row]) -> list[str]:
    worst_first = sorted(rows, key=lambda row: -max(row.of("rest")))
    return [
        "## Failures", "", *failures(rows), "", "## Verdict", "", *verdict(rows), "", "## All rows", "",
        table(list(HEADS), [row.cells() for row in worst_first]),
    ]  # fmt: skip


def short() -> list[str]:
    """Demands that a few lines with the rated load miss, though the page does not say so."""
    found = driven(bundled(), SHORT_LINES, 1, SHARES[-1:])
    return [
        f"{row.machine}, {row.task.sensors} sensors: {demand}"
        for row in found
        for demand in row.missed()
        if (row.machine, row.task.sensors, demand[0]) not in MISSED
    ]


def crane_of(text: str) -> Crane:
    file, _, rated = text.rpartition("=")
    if not file:
        raise argparse.ArgumentTypeError(f"state the rated load as well, {text}=300 for 300 kg")
    return Crane(file, float(rated))


def main(arguments: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--machines", nargs="+", type=crane_of, metavar="FILE=KG", help="print these in their place")
    parser.add_argument("--lines", type=int, default=LINES, help="lines of a row")
    parser.add_argument("--short", action="store_true", help="few lines; fails where a demand is newly missed")
    given = parser.parse_args(arguments)
    if given.short:
        missed = short()
        print(*missed, sep="\n")
        return bool(missed)
    found = numbers(driven(given.machines or bundled(), given.lines, max(1, given.lines // EACH_HELD)))
    if given.machines:
        print(*found, sep="\n")
    else:
        marked_page.write(PAGE, found)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
