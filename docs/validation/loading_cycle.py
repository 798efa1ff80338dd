"""What tip control saves a modelled operator: ``python docs/validation/loading_cycle.py`` writes page and chart.

They come from the table that ``python docs/validation/loading_cycle.py measure`` writes, in some six minutes of
processor time.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields
from itertools import product
from pathlib import Path

import numpy as np
from log_loading import (
    FAULT,
    GAINS,
    GIVEN_UP,
    MASSES,
    PASS,
    PICK,
    PLACE,
    loading_cycle,
    log_task,
    tune_operator,
)
from matplotlib.figure import Figure
from modelled_operator import CONTENT, JUDGED, STANDING, Operator
from workers import processes

from hydrocrane.plots import style

HERE = Path(__file__).resolve().parent
PAGE = HERE / "loading-cycle.md"
TABLE, PICTURE = HERE / "loading-cycle" / "cycles.csv", HERE / "loading-cycle" / "saving.png"
REACTIONS = (0.15, 0.25, 0.4)
# Levers at the same time, and the standard deviation of the error of the operator's picture, degrees.
SKILLS = ((3, 0.0), (3, 15.0), (2, 0.0), (2, 15.0), (2, 30.0))
NOMINAL = (0.25, 2, 15.0)
# Seeds of the logs: those that gains are searched with, those of every point, and those of the nominal one.
SEARCHED, SEEDS, MORE = (101,), range(1, 11), range(1, 21)
TRIALS = 10
# Of loading and unloading time, %, as a machine maker has published them for its tip control.
PUBLISHED = {"loading": 5.2, "unloading": 7.9}
TASKS = tuple(PUBLISHED)


@dataclass(frozen=True)
class Row:
    """One cycle; SI units, angles in degrees."""

    reaction: float
    interface: str
    levers: int
    picture_error: float
    task: str
    seed: int
    finished: bool
    time: float
    way: float
    energy: float
    overshoot: float
    strikes: int
    missed: int
    reversals: int
    stick_travel: float
    gain: float
    anticipation: float
    speed: float


# Reaction time, s, interface, levers at the same time, and error of the picture, degrees.
Point = tuple[float, str, int, float]


def points() -> list[Point]:
    """The tip stick first, which takes longest; skill with levers does not matter to it."""
    tips: list[Point] = [(reaction, "tip", NOMINAL[1], NOMINAL[2]) for reaction in REACTIONS]
    return tips + [(reaction, "lever", *skill) for reaction, skill in product(REACTIONS, SKILLS)]


def measured(point: Point) -> list[Row]:
    """All cycles of a point, with gains searched for it."""
    reaction, interface, levers, error = point
    able = Operator(reaction=reaction, levers=levers, picture_error=float(np.radians(error)))
    tasks = [log_task(seed, unloading=unloading) for seed in SEARCHED for unloading in (False, True)]
    operator = tune_operator(interface, able, tasks, trials=TRIALS)
    nominal = reaction == NOMINAL[0] and (interface == "tip" or (levers, error) == NOMINAL[1:])
    found = []
    for seed, task in product(MORE if nominal else SEEDS, TASKS):
        cycle = loading_cycle(log_task(seed, unloading=task == "unloading"), interface, operator)
        figures = {name: getattr(cycle, name) for name in MEASURED}
        gains = {name: getattr(operator, name) for name in GAINS}
        found.append(Row(reaction, interface, levers, error, task, seed, **figures, **gains))
    return found


MEASURED = ("finished", "time", "way", "energy", "overshoot", "strikes", "missed", "reversals", "stick_travel")


def measure() -> None:
    rows = [row for rows in processes().map(measured, points()) for row in rows]
    TABLE.parent.mkdir(exist_ok=True)
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(asdict(rows[0])), lineterminator="\n")
        writer.writeheader()
        writer.writerows({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in asdict(row).items()} for row in rows)


def stored() -> list[Row]:
    """The rows of the table."""
    kinds: dict[str, Callable[[str], object]] = {"str": str, "int": int, "float": float, "bool": "True".__eq__}
    with TABLE.open(encoding="utf-8", newline="") as file:
        return [
            Row(**{field.name: kinds[str(field.type)](row[field.name]) for field in fields(Row)})
            for row in csv.DictReader(file)
        ]


@dataclass(frozen=True)
class Pair:
    """All cycles of one task with levers, and those of the same logs with the tip stick."""

    lever: list[Row]
    tip: list[Row]

    @property
    def saving(self) -> np.ndarray:
        """Share of the lever time that the tip stick saves, % for each seed; NaN where one was given up."""
        lever, tip = (np.array([row.time for row in rows]) for rows in (self.lever, self.tip))
        return 100.0 * (1.0 - tip / lever)

    @property
    def mean(self) -> float:
        """Saving of the mean times, over the logs that both finished, %."""
        both = np.isfinite(self.saving)
        lever, tip = (np.array([row.time for row in rows])[both].mean() for rows in (self.lever, self.tip))
        return float(100.0 * (1.0 - tip / lever))

    @property
    def energy(self) -> float:
        """The same of the energy, %."""
        both = np.isfinite(self.saving)
        lever, tip = (np.array([row.energy for row in rows])[both].mean() for rows in (self.lever, self.tip))
        return float(100.0 * (1.0 - tip / lever))


def pair(rows: list[Row], reaction: float, skill: tuple[int, float], task: str) -> Pair:
    """Cycles of the same logs, in the order of their seeds."""
    own = [row for row in rows if row.reaction == reaction and row.task == task]
    lever = [row for row in own if row.interface == "lever" and (row.levers, row.picture_error) == skill]
    tip = {row.seed: row for row in own if row.interface == "tip"}
    return Pair(lever, [tip[row.seed] for row in lever])


def pairs(rows: list[Row]) -> dict[tuple[float, tuple[int, float], str], Pair]:
    """Every point of the study."""
    return {key: pair(rows, *key) for key in product(REACTIONS, SKILLS, TASKS)}


def skill_name(skill: tuple[int, float]) -> str:
    return f"{skill[0]} levers, {skill[1]:g}°"


def point_name(key: tuple[float, tuple[int, float], str]) -> str:
    return f"{key[2]} at {key[0]:g} s with {skill_name(key[1])}"


def failures(rows: list[Row]) -> str:
    """What went wrong, what was not saved, and what the model cannot say."""
    found = pairs(rows)
    lines = []
    for interface in ("lever", "tip"):
        own = [row for row in rows if row.interface == interface]
        struck = {skill_name((row.levers, row.picture_error)): None for row in own if row.strikes}
        where = f", all with {' or '.join(struck)}" if struck else ""
        lines.append(
            f"* `{interface}`: {sum(not row.finished for row in own)} of {len(own)} cycles given up, "
            f"{sum(row.missed for row in own)} logs missed, {sum(row.strikes for row in own)} strikes at the stake"
            f"{where}."
        )
    least = min(found, key=lambda key: found[key].mean)
    lines.append(f"* Least saving of time: {found[least].mean:.1f} % ({point_name(least)}).")
    single = [value for p in found.values() for value in p.saving[np.isfinite(p.saving)]]
    lines.append(
        f"* Single cycles in which tip control saved no time: {sum(v <= 0.0 for v in single)} of {len(single)}."
    )
    dear = [key for key in found if found[key].energy < 0.0]
    worst = min(found, key=lambda key: found[key].energy)
    lines.append(
        f"* Tip control takes more energy of the pump at {len(dear)} of {len(found)} points, at worst "
        f"{-found[worst].energy:.1f} % ({point_name(worst)})."
    )
    return "\n".join(lines)


# Heading, column and factor of the figures of the nominal point.
FIGURES = (
    ("time [s]", "time", 1.0, 1),
    ("way [m]", "way", 1.0, 2),
    ("energy [kJ]", "energy", 1e-3, 1),
    ("overshoot [mm]", "overshoot", 1e3, 0),
    ("stick travel [full deflections]", "stick_travel", 1.0, 1),
    ("stick reversals", "reversals", 1.0, 0),
)


def nominal_table(rows: list[Row]) -> str:
    """Percentiles of every figure, the interfaces side by side."""
    lines = [
        "| task | figure | lever 10 % | 50 % | 90 % | tip 10 % | 50 % | 90 % | saved in the mean |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for task in TASKS:
        both = pair(rows, NOMINAL[0], NOMINAL[1:], task)
        for head, name, factor, digits in FIGURES:
            lever, tip = (factor * np.array([getattr(r, name) for r in own]) for own in (both.lever, both.tip))
            cells = [f"{x:.{digits}f}" for x in np.nanpercentile(lever, (10, 50, 90))]
            cells += [f"{x:.{digits}f}" for x in np.nanpercentile(tip, (10, 50, 90))]
            mean = np.nanmean(lever)
            saved = f"{100.0 * (1.0 - np.nanmean(tip) / mean):.1f} %" if mean > 0.0 else "-"
            lines.append(f"| {task} | {head} | {' | '.join(cells)} | {saved} |")
    return "\n".join(lines)


def range_table(rows: list[Row]) -> str:
    """Savings of every point, the smallest first."""
    lines = [
        "| reaction [s] | levers | picture error | task | lever [s] | tip [s] | time saved | 10 to 90 % of the cycles "
        "| energy saved | lever given up |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    found = pairs(rows)
    for key in sorted(found, key=lambda key: found[key].mean):
        (reaction, skill, task), both = key, found[key]
        lever, tip = (np.nanmean([row.time for row in own]) for own in (both.lever, both.tip))
        low, high = np.nanpercentile(both.saving, (10, 90))
        lines.append(
            f"| {reaction:g} | {skill[0]} | {skill[1]:g}° | {task} | {lever:.1f} | {tip:.1f} | {both.mean:.1f} % "
            f"| {low:.1f} to {high:.1f} % | {both.energy:.1f} % | {sum(not row.finished for row in both.lever)} |"
        )
    return "\n".join(lines)


def gains_table(rows: list[Row]) -> str:
    """What the search found."""
    lines = [
        "| interface | reaction [s] | levers | picture error | gain [1/s] | anticipation [s] | speed [m/s] |",
        "|---|---|---|---|---|---|---|",
    ]
    seen = {(r.interface, r.reaction, r.levers, r.picture_error): (r.gain, r.anticipation, r.speed) for r in rows}
    for (interface, reaction, levers, error), gains in seen.items():
        skill = f"{levers} | {error:g}°" if interface == "lever" else "- | -"
        lines.append(f"| `{interface}` | {reaction:g} | {skill} | {' | '.join(f'{gain:.3g}' for gain in gains)} |")
    return "\n".join(lines)


def headline(rows: list[Row]) -> str:
    found = pairs(rows)
    parts = []
    for task in TASKS:
        means = [p.mean for (_, _, name), p in found.items() if name == task]
        nominal = pair(rows, NOMINAL[0], NOMINAL[1:], task).mean
        parts.append(f"{task} {nominal:.1f} % of the time ({min(means):.1f} to {max(means):.1f} % over the range)")
    return f"Saved by tip control, at the nominal operator: {', '.join(parts)}."


@style.styled
def chart(rows: list[Row]) -> Figure:
    """Saving against skill, a colour for each reaction time, a dot for each cycle."""
    figure, panels = style.figure(10.5, 4.6, ncols=len(TASKS), sharey=True)
    for axes, task in zip(panels, TASKS, strict=True):
        for number, reaction in enumerate(REACTIONS):
            colour, aside = style.COLOURS[number], 0.22 * (number - 1)
            places = np.arange(len(SKILLS)) + aside
            every = [pair(rows, reaction, skill, task) for skill in SKILLS]
            for place, both in zip(places, every, strict=True):
                axes.plot(np.full(both.saving.size, place), both.saving, ".", color=colour, alpha=0.35, ms=5)
            label = f"reaction {reaction:g} s"
            axes.plot(places, [both.mean for both in every], "_", color=colour, ms=15, mew=3, label=label)
        axes.axhline(0.0, color=style.INK, lw=0.8)
        published = f"published by a machine maker: {PUBLISHED[task]:g} %"
        axes.axhline(PUBLISHED[task], color=style.MUTED, ls="--", lw=1.2, label=published)
        names = [skill_name(skill).replace(", ", "\n") for skill in SKILLS]
        axes.set_xticks(range(len(SKILLS)), names)
        axes.set_xlabel("levers at the same time, error of the operator's picture")
        axes.set_title(task)
        axes.legend(loc="upper left", fontsize=8)
    panels[0].set_ylabel("time saved by tip control [%]")
    style.title(figure, "What tip control saves a modelled operator", "dots: cycles, bars: means")
    return figure


PROSE = """# Loading cycle: what tip control saves a modelled operator

Generated by `python docs/validation/loading_cycle.py` from the table that the same script with `measure`
writes; do not edit. The task and the operator from Python: [benchmark tip
control](../howto/benchmark-tip-control.md#logs-loaded-by-an-operator).

A simulated operator loads logs with a simulated crane. This measures a model; it is not a validation, and no
person drove. {headline}

## Failures first

{failures}
* The operator is a model with assumed abilities. The saving depends on the assumptions: the less is assumed of the
  skill with levers, the more is saved. That is why the result is a range.
* Nothing slews, and the crane is a laboratory crane with slow valves: {slow}.
* The operator neither learns during a cycle nor tires.
* The search for gains is short, {trials} sets on two tasks. The effect of a longer search was not measured.

![saving](loading-cycle/saving.png)

## The task

In the plane of `rottne-f9-lab`: from a place above the bunk over the stake to a log on the ground, pick it up,
back over the stake, lower it into the bunk, release it, return. Unloading is the reverse with the same logs.
Place and mass ({masses} kg) of each log are drawn from its seed. A place counts as reached within {pass_:g} mm
over the stake, {pick:g} mm at a log and {place:g} mm where a log is laid down; there the tip must stand below
{standing:g} mm/s, and the grapple takes {grapple:g} s. A strike is a tip inside the stake; a log is missed
if the tip is outside the tolerance when it grasps or releases. A cycle is given up after
{given_up:g} s.

## The operator

The same for both interfaces: sees tip, velocity and pose of the crane a reaction time ago; extrapolates the tip
along its velocity (*anticipation*); wants a velocity towards the place in proportion to the distance (*gain*),
no faster than *speed*; moves each stick by at most {rate:g} full deflections per second, in steps of {step:g}
of the full one; accepts an error within {content:g} of a tolerance. The structure is that of a crossover model with
delay: D. T. McRuer and H. R. Jex, *A review of quasi-linear pilot models*, IEEE Transactions on Human Factors
in Electronics, 1967. The numbers are assumptions.

* `tip`: the wanted velocity is the stick. The controller `tip` has data-sheet sensors and does not know the
  log.
* `lever`: one lever per cylinder, straight to its spool. The operator turns the wanted velocity into
  deflections with a mental model of each lever: the true direction and speed of the unloaded crane, rotated
  by a random angle with the standard deviation *picture error*, scaled by a random factor (logarithm: half that
  number), drawn again every {judged:g} s. At most two or three levers move at the same time; those that promise
  the highest speed are taken.

Three levers without an error represent an operator who inverts the crane's kinematics mentally: a bound, not a
person. *Gain*, *anticipation* and *speed* are searched for each interface and each point by the same pattern
search from the same start ({trials} sets, one log each way, other logs than those below). The cost is the time,
with {fault:g} s for each strike and each missed log.

How the sticks are found: with levers, step by step. The controller `tip` runs inside whole runs whose sticks
are stated beforehand; there the sticks are found by waveform relaxation, exactly, because the operator reacts
late (`docs/validation/operator_loop.py`).

## The nominal operator

Reaction {reaction:g} s; {levers} levers, {error:g}°; {seeds} logs each way. Percentiles over the logs;
*overshoot*: largest distance beyond a stopping point.

{nominal}

## The range

Times are means over the logs of a point, smallest saving first.

{range}

## The gains found

{gains}

## The published figures

A machine manufacturer has published that its tip control saves {loading:g} % of loading time and {unloading:g} % of
unloading time. These two figures are all that is known to us: neither the machine, nor the operators and their
practice, nor how it was measured. Our figures cannot be compared with them directly:

* a working machine's cycle has parts that no tip control shortens: slewing, gripping, sorting, driving. Here
  only {grapple:g} s for each grasp and release are such a part, so our share of the time that can be saved is
  larger;
* people learn their levers; this model draws its error again every {judged:g} s, and never better;
* here a lever opens a spool, and the speed of its piston depends on the load; many machines compensate for
  that;
* the tip of the laboratory crane moves slowly, so reaction times have little effect.
"""


def page(rows: list[Row]) -> str:
    able = Operator()
    lever, tip = (
        np.nanmean([row.way / row.time for row in rows if row.interface == interface]) for interface in ("lever", "tip")
    )
    slow = f"the tip moves at {lever:.2f} m/s in the mean with levers, {tip:.2f} m/s with the stick"
    return PROSE.format(
        headline=headline(rows), failures=failures(rows), nominal=nominal_table(rows), range=range_table(rows),
        gains=gains_table(rows), masses=f"{MASSES[0]:g} to {MASSES[1]:g}",
        pass_=1e3 * PASS, pick=1e3 * PICK, place=1e3 * PLACE,
        standing=1e3 * STANDING, grapple=able.grapple_time, given_up=GIVEN_UP, rate=able.hand_rate, step=able.hand_step,
        content=CONTENT, judged=JUDGED, trials=TRIALS, fault=FAULT, reaction=NOMINAL[0], levers=NOMINAL[1],
        error=NOMINAL[2], seeds=len(MORE), slow=slow, **PUBLISHED,
    )  # fmt: skip


if __name__ == "__main__":
    if sys.argv[1:] == ["measure"]:
        measure()
    table = stored()
    PAGE.write_text(page(table), encoding="utf-8")
    style.write(chart(table), PICTURE)
