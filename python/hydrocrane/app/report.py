"""Tables and short reports for the terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.text import Text

from hydrocrane import _core
from hydrocrane.analysis.capacity import Height, at_height, spread
from hydrocrane.app.console import plain_table, say, warn
from hydrocrane.machine.description import described
from hydrocrane.machine.poses import SHOWN, in_words
from hydrocrane.machine.stated import PROVENANCE_CLASSES
from hydrocrane.scenario.phases import ScenarioStage
from hydrocrane.scenario.solver import named

if TYPE_CHECKING:
    from rich.table import Table

    from hydrocrane._core_types import Passivity
    from hydrocrane.analysis.capacity import LoadChart
    from hydrocrane.analysis.figures import Figures
    from hydrocrane.machine.machine import Machine
    from hydrocrane.result_warning import ResultWarning
    from hydrocrane.scenario.scenario import Scenario
    from hydrocrane.state_space.oscillations import Oscillations


def machines_table(machines: list[Machine]) -> Table:
    """Bundled machines with the provenance of their values."""
    table = plain_table(title="Bundled machines")
    table.add_column("name", no_wrap=True)
    table.add_column("title", overflow="fold")
    for kind in ("states", *PROVENANCE_CLASSES):
        table.add_column(kind, justify="right")
    for machine in machines:
        tally = [str(count) for count in machine.provenance_tally.values()]
        table.add_row(machine.name, machine.title, str(len(machine.state_names)), *tally)
    return table


def machine_report(machine: Machine, figures: Figures) -> list[Text | Table]:
    """What `check` says about a machine: size, limits and their reasons, loads, speeds, friction, provenance."""
    head = Text.assemble((machine.name, "bold"), f": {machine.title}")
    about = described(machine.core)
    slope = math.degrees(about.record("environment").number("slope"))
    size = Text(
        f"{len(machine.joint_names)} degrees of freedom, {len(machine.cylinder_names)} cylinders,"
        f" {len(machine.state_names)} states, supply {machine.supply_pressure * 1e-5:.0f} bar"
        + (f", slope {slope:.3g} deg" if slope else "")
    )
    return [
        head,
        size,
        _limits(machine, [record.number("count") for record in about.records("cylinders")]),
        *_in_the_middle(machine, figures),
        *_friction(machine),
        *_cavitation(machine),
        _errata(machine),
        _tally(machine),
    ]


def _in_the_middle(machine: Machine, figures: Figures) -> list[Text | Table]:
    """Pressures, speeds and lowest mode at rest in the middle of all ranges."""
    headings = ("cylinder", "holds, kN", "at, bar", "of poses, %", "full valve, mm/s", "stroke in, s")
    table = plain_table(*headings, left=("cylinder",))
    for i, name in enumerate(machine.cylinder_names):
        down, up = 1e3 * figures.speed[i]
        table.add_row(
            name,
            f"{1e-3 * figures.force[i]:.3g}",
            f"{1e-5 * figures.pressure[i]:.3g}",
            f"{100 * figures.carried[i]:.0f}",
            f"{down:.3g} .. {up:.3g}",
            "-" if figures.time[i] is None else f"{figures.time[i]:.2g}",
        )
    mode = "none" if figures.mode is None else f"{figures.mode:.3g} Hz, by which the tip gives way {figures.sag:.2g} m"
    return [
        Text(
            f"at rest with {machine.payload_mass:g} kg at {in_words(machine, machine.home)}; "
            "supply and relief valves carry the crane in so many of all poses:"
        ),
        table,
        Text(f"lowest natural frequency of links on oil: {mode}; oil: {figures.oil}"),
    ]


def print_findings(warnings: Sequence[ResultWarning]) -> None:
    """Print each warning, and how many there are, under a file without errors."""
    for warning in warnings:
        warn(str(warning), stderr=False)
    count = f"{len(warnings)} warning{'s' if len(warnings) > 1 else ''}"
    say(f"no errors, {count}" if warnings else "no errors found")


def _limits(machine: Machine, counts: list[float]) -> Table:
    headings = ("joint", "from", "because", "to", "because", "cylinder", "stroke")
    table = plain_table(*headings, left=("joint", "because", "cylinder"))
    for i, joint in enumerate(machine.joint_names):
        unit, size = SHOWN[machine.joint_units[i]]
        low, high = machine.joint_limits[i] / size
        why_low, why_high = machine.joint_limit_reasons[i]
        cylinder, count = machine.cylinder_names[i], counts[i]
        low_x, high_x = machine.stroke_limits[i] * 1e3
        table.add_row(
            joint, f"{low:z.1f} {unit}", why_low, f"{high:z.1f} {unit}", why_high,
            f"{count:g} x {cylinder}" if count > 1.0 else cylinder, f"{low_x:z.1f} .. {high_x:z.1f} mm",
        )  # fmt: skip
    return table


def _friction(machine: Machine) -> list[Text]:
    lines = [_passivity(entry) for entry in machine.passivity()]
    return lines or [Text("friction: static maps, no bristles")]


def _passivity(entry: Passivity) -> Text:
    """One line on the passivity condition of a LuGre friction."""
    line = Text(f"LuGre friction of cylinder {entry['cylinder']}: the passivity condition holds ")
    limit = entry["velocity_limit"]
    if limit is None:
        return line.append(f"at every velocity checked, up to {entry['checked_to']:g} m/s", style="green")
    return line.append(f"only up to {limit * 1e3:.3g} mm/s", style="yellow")


def _cavitation(machine: Machine) -> list[Text]:
    """One line on the chambers that no valve of the file refills from the tank."""
    words = dict(machine.core.words)
    valves = {key.split(".")[1] for key in words if key.startswith("anti-cavitation.")}
    kept = {tuple(words.get(f"anti-cavitation.{valve}.{key}") for key in ("cylinder", "side")) for valve in valves}
    sides = [(cylinder, side) for cylinder in machine.cylinder_names for side in ("piston-side", "rod-side")]
    bare = [f"{cylinder} ({side.replace('-', ' ')})" for cylinder, side in sides if (cylinder, side) not in kept]
    if not bare:
        return []
    where = "any cylinder" if len(bare) == len(sides) else ", ".join(bare)
    return [
        Text(f"no anti-cavitation valve is stated at {where}: a chamber that the supply does not fill opens at vacuum")
    ]


def _errata(machine: Machine) -> Text:
    printed = [name for name, corrected in machine.errata.items() if not corrected]
    if not printed:
        return Text("errata: all corrected")
    return Text(f"errata run as printed: {', '.join(printed)}", style="yellow")


def _tally(machine: Machine) -> Text:
    tally = ", ".join(f"{count} {kind}" for kind, count in machine.provenance_tally.items() if count)
    return Text(f"provenance of {len(machine.provenance)} values: {tally}")


def scenario_report(plan: Scenario, machine: Machine) -> list[Text]:
    """What `check` says about a scenario."""
    solver = plan.solver
    start = in_words(machine, [plan.joints[joint] for joint in machine.joint_names])
    return [
        Text.assemble((plan.name, "bold"), f": {plan.title}"),
        Text(f"machine {machine.name}, {plan.duration:g} s recorded every {plan.record_interval * 1e3:g} ms"),
        Text(f"start at {start}; pressures {plan.pressures if isinstance(plan.pressures, str) else 'given'}"),
        Text(f"{_drive(plan, machine)}; solver {named(_core.method_for(machine.core, solver.entry), solver.method)}"),
        *_loads(plan),
        *_supply(plan),
        *(Text(f"from {begin:g} s on: {_loop(stage)}") for begin, stage in plan.stages()[1:]),
    ]


def _loads(plan: Scenario) -> list[Text]:
    """The payload against time, where it changes."""
    changes = [f"{mass:g} kg from {time:g} s" for time, mass in plan.payload_changes.items()]
    return [Text(f"payload {', '.join(changes)}")] if changes else []


def _supply(plan: Scenario) -> list[Text]:
    """The measured pressure of the supply, where there is one."""
    if plan.supply is None:
        return []
    low, high = 1e-5 * plan.supply.pressure.min(), 1e-5 * plan.supply.pressure.max()
    joined = "joined linearly" if plan.supply.interpolation == "linear" else "held"
    return [Text(f"measured supply pressure {low:.4g} to {high:.4g} bar, {plan.supply.time.size} times, {joined}")]


def _drive(plan: Scenario, machine: Machine) -> str:
    """What moves the spools."""
    if plan.closed_loop:
        return _loop(plan.stages()[0][1])
    times, _, linear = plan.command_grid(machine)
    return f"{len(times)} command times, {'joined linearly' if linear else 'held'}"


def _loop(stage: ScenarioStage) -> str:
    return f"controller {stage.driver}, {stage.sensors} sensors, {stage.stick_times} stick times"


def modes_table(found: Oscillations) -> Table:
    """Natural modes, slowest first, with the record interval that shows each well."""
    table = plain_table("frequency, Hz", "damping ratio", "mostly in", "record every", left=("mostly in",))
    rows = zip(found.frequency, found.damping, found.state, found.record_interval, strict=True)
    for frequency, damping, state, interval in rows:
        table.add_row(f"{frequency:.3g}", f"{damping:.3g}", state, f"{interval * 1e3:.2g} ms")
    return table


def load_table(chart: LoadChart, height: Height | None = None, rows: int = 10) -> Table:
    """Payload against reach, in few lines: at the best and the worst height, or at `height` alone."""
    shown: tuple[Height, ...] = ("best", "worst") if height is None else (height,)
    table = plain_table("reach, m", *(f"kg {at_height(which)}" for which in shown))
    reach = chart.against_reach(shown[0])[0]
    columns = [chart.against_reach(which)[1] for which in shown]
    for i in spread(reach.size, rows):
        table.add_row(f"{reach[i]:.2f}", *("-" if column[i] != column[i] else f"{column[i]:.0f}" for column in columns))
    return table
