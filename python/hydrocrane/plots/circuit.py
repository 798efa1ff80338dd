"""Circuit diagram of a machine, drawn from its file, so that mistakes in the file are visible."""

from __future__ import annotations

from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from hydrocrane.machine import circuit as circuits
from hydrocrane.machine.circuit import Circuit, CircuitSection
from hydrocrane.machine.machine import Machine
from hydrocrane.plots import circuit_symbols as symbols
from hydrocrane.plots.circuit_parts import (
    LINE_SLOT,
    LOAD_LINE,
    ON_LINE,
    PRESSURE_LINE,
    SLOT,
    SUPPLY,
    TANK_LINE,
    TIME,
    VOLUME,
    before_spool,
    cylinder_labels,
    pumps,
    shown,
    stated,
    valve_labels,
)
from hydrocrane.plots.circuit_symbols import LEADING, LINES, POINTS_PER_MM, Label, Sheet, font, side_by_side
from hydrocrane.plots.style import MUTED, styled

MARGIN, GAP = 6.0, 8.0
# Distances of both lines of a section from its middle, and of the line from the pump.
ASIDE = 24.0


@styled
def circuit(machine: Machine) -> Figure:
    """Hydraulic circuit of a machine: supply, valves, compensators, load-holding valves and cylinders, with their
    values.

    Symbols are those of ISO 1219-1, simplified. Save it as ``.svg``, ``.pdf`` or ``.png``.

    Examples
    --------
    >>> hc.plots.circuit(hc.load_machine("rottne-f9-mobile")).savefig("circuit.svg")
    """
    return render(diagram(machine))


def diagram(machine: Machine) -> Sheet:
    """The whole diagram as lines and texts, mm."""
    found = circuits.read(machine)
    sheet = Sheet()
    levels = _levels(found)
    sections = [
        _section(section, found, levels, last=i == len(found.sections) - 1) for i, section in enumerate(found.sections)
    ]
    hung = [*pumps(found), *(part for make in SUPPLY if (part := make(found)) is not None)]
    placed = _placed(hung, sections)
    _common_lines(sheet, placed, found)
    for part, shift in placed:
        sheet.add(part, shift)
    left, _, _, top = sheet.extent
    sheet.labels.append(Label(left, top + 12.0, machine.title or machine.name, bold=True, size=4.6))
    note = f"{machine.name}  ·  hydraulic circuit, symbols after ISO 1219-1, simplified"
    if found.left_out:
        note += f"  ·  not drawn: {', '.join(found.left_out)}"
    sheet.labels.append(Label(left, top + 6.0, note, colour=MUTED))
    return sheet


def _placed(hung: list[Sheet], sections: list[Sheet]) -> list[tuple[Sheet, float]]:
    """Places the sections above the parts below the common lines; the load-sensing line goes down before the first
    part."""
    below = side_by_side(hung, GAP)
    down = [part.ports["LS"][0] + shift for part, shift in below if "LS" in part.ports]
    left = sections[0].ports["P"][0] - sections[0].extent[0]
    start = max(down) + GAP - left if down else 0.0
    return [*below, *side_by_side(sections, GAP, max(0.0, start))]


def _levels(found: Circuit) -> tuple[float, float]:
    """Heights of the lower edge of the valves and of the middle of the cylinders."""
    slots = max(len(before_spool(section)) for section in found.sections)
    labels = LEADING * max(len([line for line in valve_labels(section) if line]) for section in found.sections)
    base = (LOAD_LINE if found.senses_load else PRESSURE_LINE) + 6.0
    valve = base + max(SLOT * slots + 2.0, labels + 3.0)
    stacked = max(
        (sum(1 for side, _ in section.on_lines if side == wanted) for section in found.sections for wanted in (0, 1)),
        default=0,
    )
    return valve, valve + symbols.CELL + 5.0 + LINE_SLOT * stacked + 14.0


def _section(section: CircuitSection, found: Circuit, levels: tuple[float, float], *, last: bool) -> Sheet:
    """A cylinder above its valve, about x = 0."""
    low, middle = levels
    sheet = Sheet()
    _from_pump(sheet, section, low)
    sheet.line((symbols.PORT, low), (symbols.PORT, TANK_LINE), kind="tank")
    sheet.ports["T"] = (symbols.PORT, TANK_LINE)
    if found.senses_load and found.shares_flow:
        _to_shared_load_line(sheet, low)
    elif found.senses_load:
        _to_load_line(sheet, low, last=last)
    _to_cylinder(sheet, section, low + symbols.CELL, middle)
    symbols.spool_valve(sheet, 0.0, low + 0.5 * symbols.CELL, section.valve.word("type") == "regenerative")
    sheet.text(symbols.PORT + 4.0, low - 8.5, valve_labels(section), head=True)
    if section.motor.is_stated:
        symbols.motor(sheet, 0.0, middle - 6.5, ASIDE)
    else:
        symbols.cylinder(sheet, 0.0, middle)
    for i, line in enumerate(reversed(cylinder_labels(section))):
        sheet.labels.append(
            Label(0.0, middle + 10.5 + i * (LEADING + 0.6), line, "center", bold=i == 1, size=3.1 + i * 0.9)
        )
    return sheet


def _from_pump(sheet: Sheet, section: CircuitSection, low: float) -> None:
    """From the line of the pump to the spool."""
    stack = before_spool(section)
    x = -ASIDE if stack else -symbols.PORT
    sheet.line((-symbols.PORT, low), (-symbols.PORT, low - 4.0), (x, low - 4.0), (x, PRESSURE_LINE), kind="pressure")
    sheet.ports["P"] = (x, PRESSURE_LINE)
    for i, part in enumerate(reversed(stack)):
        part(sheet, x, low - 4.0 - (i + 0.5) * SLOT, 0.0, section)


def _to_load_line(sheet: Sheet, low: float, *, last: bool) -> None:
    """From the spool to the load-sensing line of the pump; a shuttle valve selects the higher pressure."""
    end = LOAD_LINE if last else LOAD_LINE + 4.0
    sheet.line((0.0, low), (0.0, end), kind="load")
    sheet.ports["LS"] = (0.0, LOAD_LINE) if last else (-2.2, LOAD_LINE)
    if not last:
        below = LOAD_LINE - 7.0
        sheet.line((9.0, LOAD_LINE), (9.0, below), (0.0, below), (0.0, LOAD_LINE - 4.0), kind="load")
        symbols.shuttle_valve(sheet, 0.0, LOAD_LINE)
        sheet.ports["LS from the right"] = (9.0, LOAD_LINE)


def _to_shared_load_line(sheet: Sheet, low: float) -> None:
    """The same if all compensators have the highest load pressure: a check valve passes only that."""
    sheet.line((0.0, low), (0.0, LOAD_LINE), kind="load")
    symbols.check_valve(sheet, 0.0, low - 9.0, up=False)
    sheet.ports["LS"] = sheet.ports["LS from the right"] = (0.0, LOAD_LINE)


def _to_cylinder(sheet: Sheet, section: CircuitSection, high: float, middle: float) -> None:
    """Both lines from the spool to the cylinder, with their parts."""
    for side, out, port in ((0, -1.0, "A"), (1, 1.0, "B")):
        x = out * ASIDE
        sheet.line((out * symbols.PORT, high), (out * symbols.PORT, high + 5.0), (x, high + 5.0), (x, middle - 6.5))
        sheet.labels.append(
            Label(x + out * 1.6, high + 7.5, port, "left" if out > 0 else "right", size=2.6, colour=MUTED)
        )
        parts = [table for there, table in section.on_lines if there == side]
        for i, table in enumerate(parts):
            ON_LINE[table.kind](sheet, x, high + 7.0 + (i + 0.5) * LINE_SLOT, out, table)


def _common_lines(sheet: Sheet, placed: list[tuple[Sheet, float]], found: Circuit) -> None:
    """The common lines, with dots at connections and their names at the left."""
    mains = shown(found.mains.number("volume"), VOLUME)
    delay = None if found.pump is None else shown(found.pump.number("ls-time-constant"), TIME)
    names = {
        "P": ("pressure", PRESSURE_LINE, stated("mains, {}", mains) or "pressure"),
        "T": ("tank", TANK_LINE, "return"),
        "LS": ("load", LOAD_LINE, stated("load sensing, {}", delay or "") or "load sensing"),
    }
    start = min(part.ports[name][0] + shift for part, shift in placed for name in part.ports)
    for name, (kind, level, text) in names.items():
        places = sorted(part.ports[name][0] + shift for part, shift in placed if name in part.ports)
        if not places:
            continue
        if name == "LS":
            _load_line(sheet, placed, found)
        else:
            sheet.line((places[0], level), (places[-1], level), kind=kind)
            for x in places[1:-1]:
                sheet.dot(x, level)
        letters = Label(start - 4.0, level, name, "right", bold=True)
        sheet.labels += [letters, Label(letters.box[0] - 2.0, level, text, "right", colour=MUTED)]


def _load_line(sheet: Sheet, placed: list[tuple[Sheet, float]], found: Circuit) -> None:
    """From the last section to the first and on to the pumps."""
    own = [(part, shift) for part, shift in placed if "LS" in part.ports]
    places = sorted(part.ports["LS"][0] + shift for part, shift in own)
    back = sorted(
        part.ports["LS from the right"][0] + shift for part, shift in own if "LS from the right" in part.ports
    )
    # The first ports are those of the pumps; of fixed ones the relief valve has the only one.
    fixed = found.pump is not None and found.pump.word("type") == "fixed"
    first = 1 if fixed else 1 + len(found.further)
    starts = [*places[:first], *back]
    for x in places[1:first]:
        sheet.dot(x, LOAD_LINE)
    for start, end in zip(starts, places[1:], strict=False):
        sheet.line((start, LOAD_LINE), (end, LOAD_LINE), kind="load")
    for joined in set(back[:-1]) & set(places):
        sheet.dot(joined, LOAD_LINE)


def render(sheet: Sheet) -> Figure:
    """A figure of the sheet's size at scale 1:1."""
    left, bottom, right, top = sheet.extent
    width, height = right - left + 2 * MARGIN, top - bottom + 2 * MARGIN
    fig = plt.figure(figsize=(width / 25.4, height / 25.4))
    axes = fig.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(left - MARGIN, right + MARGIN), ylim=(bottom - MARGIN, top + MARGIN))
    axes.set_axis_off()
    for order, stroke in enumerate(sheet.strokes):
        xs, ys = [x for x, _ in stroke.points], [y for _, y in stroke.points]
        look = LINES[stroke.kind]
        if stroke.fill:
            axes.fill(xs, ys, facecolor=stroke.fill, edgecolor=look["color"], lw=look["lw"], zorder=2 + 1e-4 * order)
        else:
            axes.plot(xs, ys, zorder=2 + 1e-4 * order, solid_capstyle="butt", **look)
    for label in sheet.labels:
        axes.text(
            label.x, label.y, label.text, size=label.size * POINTS_PER_MM, fontproperties=font(label.bold),
            ha=label.side, va="center_baseline", color=label.colour, zorder=5,
        ).set_fontsize(label.size * POINTS_PER_MM)  # fmt: skip
    return fig
