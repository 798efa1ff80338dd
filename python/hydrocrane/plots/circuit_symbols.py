"""Symbols of circuit diagrams after ISO 1219, and the sheet that they are drawn on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from math import cos, sin
from typing import Any, Literal

import numpy as np
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath

from hydrocrane.arrays import Array
from hydrocrane.plots.style import ACCENT, COLOURS, INK, MUTED

Point = tuple[float, float]
Side = Literal["left", "center", "right"]

POINTS_PER_MM = 72 / 25.4
FONT = "DejaVu Sans"
SIZE, LEADING = 3.1, 4.2
# Widest head of a text, mm: a symbol with what belongs to it.
WIDEST = 36.0

# Style of each kind of line: lines with flow, pilot lines, outlines of parts.
LINES: dict[str, dict[str, Any]] = {
    "line": {"color": INK, "lw": 1.1},
    "pressure": {"color": ACCENT, "lw": 1.8},
    "tank": {"color": COLOURS[0], "lw": 1.8},
    "pilot": {"color": INK, "lw": 0.8, "ls": (0, (4, 2))},
    "load": {"color": COLOURS[3], "lw": 1.1, "ls": (0, (4, 2))},
    "symbol": {"color": INK, "lw": 1.1},
    "thin": {"color": INK, "lw": 0.8},
    "blank": {"color": "none", "lw": 0.0},
    "envelope": {"color": MUTED, "lw": 0.8, "ls": (0, (8, 2, 1, 2))},
}


@dataclass(frozen=True)
class Stroke:
    """A polyline; `fill` closes and fills it."""

    points: tuple[Point, ...]
    kind: str = "line"
    fill: str = ""


@dataclass(frozen=True)
class Label:
    """One line of text, its middle height at `y`."""

    x: float
    y: float
    text: str
    side: Side = "left"
    bold: bool = False
    size: float = SIZE
    colour: str = INK

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Left, bottom, right and top."""
        width = text_width(self.text, self.size, self.bold)
        left = self.x - {"left": 0.0, "center": 0.5, "right": 1.0}[self.side] * width
        return left, self.y - 0.5 * self.size, left + width, self.y + 0.5 * self.size


@cache
def text_width(text: str, size: float, bold: bool) -> float:
    """Width of a text, mm, by the metrics of its font: the same on every machine."""
    if not text.strip():
        return 0.0
    path = TextPath((0, 0), text, size=size * POINTS_PER_MM, prop=font(bold), usetex=False)
    return float(path.get_extents().x1) / POINTS_PER_MM


def font(bold: bool) -> FontProperties:
    return FontProperties(family=FONT, weight="bold" if bold else "normal")


@dataclass
class Sheet:
    """Part of a drawing; `ports` are its connection points."""

    strokes: list[Stroke] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)
    ports: dict[str, Point] = field(default_factory=dict)

    def line(self, *points: Point, kind: str = "line") -> None:
        self.strokes.append(Stroke(points, kind))

    def area(self, *points: Point, kind: str = "symbol", fill: str = "white") -> None:
        self.strokes.append(Stroke(points, kind, fill))

    def box(self, x: float, y: float, width: float, height: float, kind: str = "symbol") -> None:
        """A rectangle about (x, y)."""
        w, h = 0.5 * width, 0.5 * height
        self.area((x - w, y - h), (x + w, y - h), (x + w, y + h), (x - w, y + h), kind=kind)

    def circle(self, x: float, y: float, radius: float, kind: str = "symbol", fill: str = "white") -> None:
        turn = np.linspace(0.0, 2 * np.pi, 61)[:-1]
        self.area(*zip(x + radius * np.cos(turn), y + radius * np.sin(turn)), kind=kind, fill=fill)

    def arrow(self, start: Point, end: Point, kind: str = "thin", length: float = 2.2) -> None:
        """A line with a filled head at its end."""
        (x0, y0), (x1, y1) = start, end
        far = float(np.hypot(x1 - x0, y1 - y0))
        u, v = (x1 - x0) / far, (y1 - y0) / far
        foot = (x1 - length * u, y1 - length * v)
        half = 0.36 * length
        self.line(start, foot, kind=kind)
        corners = ((foot[0] - half * v, foot[1] + half * u), end, (foot[0] + half * v, foot[1] - half * u))
        self.area(*corners, kind="thin", fill=INK)

    def dot(self, x: float, y: float) -> None:
        """Marks a connection of lines."""
        self.circle(x, y, 0.8, kind="thin", fill=INK)

    def text(self, x: float, y: float, lines: Sequence[str], side: Side = "left", head: bool = False) -> None:
        """Lines of text from `y` downwards; with `head` the first one is bold, and in two lines where it is wide."""
        shown = [line for line in lines if line]
        bold = int(head)
        if head and text_width(shown[0], SIZE, True) > WIDEST:
            shown[:1], bold = shown[0].rsplit(" ", 1), 2
        for i, line in enumerate(shown):
            self.labels.append(Label(x, y - i * LEADING, line, side, bold=i < bold))

    def add(self, other: Sheet, dx: float = 0.0, dy: float = 0.0) -> None:
        """Add another sheet to this one, without its ports."""
        for stroke in other.strokes:
            self.strokes.append(replace(stroke, points=tuple((x + dx, y + dy) for x, y in stroke.points)))
        self.labels += [replace(label, x=label.x + dx, y=label.y + dy) for label in other.labels]

    @property
    def boxes(self) -> Array:
        """(k, 4) left, bottom, right and top of each stroke and label."""
        strokes = [np.array(stroke.points) for stroke in self.strokes]
        around = [[*points.min(axis=0), *points.max(axis=0)] for points in strokes]
        return np.array([*around, *(label.box for label in self.labels)])

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, bottom, right and top of everything on it."""
        boxes = self.boxes
        low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def side_by_side(sheets: Iterable[Sheet], gap: float, start: float = 0.0) -> list[tuple[Sheet, float]]:
    """Each sheet with its shift to the right, for which whatever is on it lies `gap` beside what is left of it."""
    placed: list[tuple[Sheet, float]] = []
    there = np.array([[start - gap, -np.inf, start - gap, np.inf]])
    for sheet in sheets:
        boxes = sheet.boxes
        left, bottom, _, top = boxes.T
        beside = (there[:, 1, None] < top + 0.5 * gap) & (there[:, 3, None] > bottom - 0.5 * gap)
        shift = float(np.max(np.where(beside, there[:, 2, None] + gap - left, -np.inf)))
        placed.append((sheet, shift))
        there = np.concatenate([there, boxes + [shift, 0.0, shift, 0.0]])
    return placed


# Size of a valve's square, and of a position of a spool valve.
BOX, CELL = 9.0, 13.0
# Distance of the ports of a position from its middle.
PORT = 3.8


def spring(sheet: Sheet, x: float, y: float, towards: float, length: float = 5.0, adjustable: bool = False) -> None:
    """A spring that begins at (x, y) and points to the left (-1) or right (1); an adjustable one has an arrow."""
    turns = 6
    points = [(x, y)]
    for i in range(1, turns):
        points.append((x + towards * length * i / turns, y + (1.3 if i % 2 else -1.3)))
    sheet.line(*points, (x + towards * length, y), kind="thin")
    if adjustable:
        middle = x + towards * 0.5 * length
        sheet.arrow((middle - 2.4, y - 2.6), (middle + 2.4, y + 2.6), length=1.6)


def throttle(sheet: Sheet, x: float, y: float, variable: bool = False) -> None:
    """A throttle in a vertical line."""
    for side in (-1.0, 1.0):
        bow = [(x + side * (2.6 - 1.5 * (1 - (h / 3.0) ** 2)), y + h) for h in (-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0)]
        sheet.line(*bow, kind="symbol")
    if variable:
        sheet.arrow((x - 4.5, y - 4.0), (x + 4.5, y + 4.0), length=1.8)


def check_valve(sheet: Sheet, x: float, y: float, up: bool = True) -> None:
    """A check valve in a vertical line: oil flows up, or down."""
    sense = 1.0 if up else -1.0
    sheet.area((x - 1.6, y - 1.2), (x + 1.6, y - 1.2), (x + 1.6, y + 1.2), (x - 1.6, y + 1.2), kind="blank")
    sheet.circle(x, y + 0.5 * sense, 1.5)
    sheet.line((x - 2.6, y + 0.4 * sense), (x, y - 1.8 * sense), (x + 2.6, y + 0.4 * sense), kind="symbol")


def shuttle_valve(sheet: Sheet, x: float, y: float) -> None:
    """Inputs above and below, output at the left, with the higher pressure."""
    sheet.box(x, y, 4.4, 8.0)
    sheet.circle(x, y + 2.2, 1.2)
    sheet.line((x - 1.5, y + 4.0), (x, y + 1.6), (x + 1.5, y + 4.0), kind="thin")
    sheet.line((x - 1.5, y - 4.0), (x, y - 1.6), (x + 1.5, y - 4.0), kind="thin")


def pressure_valve(sheet: Sheet, x: float, y: float, up: bool = True, open_at_rest: bool = False) -> None:
    """The square of a pilot-operated valve, with the arrow of its flow."""
    sheet.box(x, y, BOX, BOX)
    aside = 0.0 if open_at_rest else 1.9
    half = 0.5 * BOX * (1.0 if up else -1.0)
    sheet.arrow((x + aside, y - half), (x + aside, y + half))


def relief_valve(sheet: Sheet, x: float, y: float) -> None:
    """From the pressure line above to the tank below, closed at rest, spring at the right."""
    pressure_valve(sheet, x, y, up=False)
    spring(sheet, x + 0.5 * BOX, y, 1.0, adjustable=True)
    sheet.line((x, y + 0.5 * BOX + 2.0), (x - 0.5 * BOX - 2.0, y + 0.5 * BOX + 2.0), kind="pilot")
    sheet.line((x - 0.5 * BOX - 2.0, y + 0.5 * BOX + 2.0), (x - 0.5 * BOX - 2.0, y), (x - 0.5 * BOX, y), kind="pilot")


def compensator(sheet: Sheet, x: float, y: float, behind: bool) -> None:
    """In a vertical line that flows up; the load comes from the right.

    Before the spool, spring and load pressure open it and the pressure downstream closes it. Behind the metering edge
    the load pressure closes it and the pressure upstream opens it.
    """
    pressure_valve(sheet, x, y, open_at_rest=not behind)
    left, right, reach = x - 0.5 * BOX, x + 0.5 * BOX, 0.5 * BOX + 1.8
    level = y - reach if behind else y + reach
    sheet.line((x, level), (left - 2.2, level), (left - 2.2, y), (left, y), kind="pilot")
    spring(sheet, right, y + 1.8, 1.0, length=4.5)


def priority_element(sheet: Sheet, x: float, y: float) -> None:
    """In a vertical line that flows up: the pressure upstream opens it, spring and load at the right close it."""
    pressure_valve(sheet, x, y, open_at_rest=True)
    left, right, level = x - 0.5 * BOX, x + 0.5 * BOX, y - 0.5 * BOX - 1.8
    sheet.line((x, level), (left - 2.2, level), (left - 2.2, y), (left, y), kind="pilot")
    spring(sheet, right, y + 1.8, 1.0, length=4.5)


def counterbalance_valve(sheet: Sheet, x: float, y: float, out: float) -> None:
    """In a vertical line from the cylinder above: a check valve lets oil up, the square down; spring towards `out`."""
    inside, reach = x - out * 10.0, 0.5 * BOX + 3.0
    sheet.line((x, y + reach), (inside, y + reach), (inside, y - reach), (x, y - reach))
    check_valve(sheet, inside, y)
    pressure_valve(sheet, x, y, up=False)
    spring(sheet, x + out * 0.5 * BOX, y, out, adjustable=True)
    # The pressure of the chamber.
    near = x - out * (0.5 * BOX + 1.6)
    sheet.line(
        (x, y + 0.5 * BOX + 1.4),
        (near, y + 0.5 * BOX + 1.4),
        (near, y + 2.0),
        (near + out * 1.6, y + 2.0),
        kind="pilot",
    )
    sheet.dot(x, y + reach)
    sheet.dot(x, y - reach)


def pilot_check_valve(sheet: Sheet, x: float, y: float, out: float) -> None:
    """In a vertical line from the cylinder above: oil flows up, and down while the pilot from inside lifts the ball."""
    sheet.box(x, y, BOX, BOX, kind="envelope")
    sheet.line((x, y - 0.5 * BOX), (x, y + 0.5 * BOX))
    check_valve(sheet, x, y + 0.8)
    sheet.line((x - out * 0.5 * BOX, y - 2.6), (x - out * 1.0, y - 2.6), (x - out * 1.0, y - 1.2), kind="pilot")


def hose_burst_valve(sheet: Sheet, x: float, y: float, out: float, bleeds: bool) -> None:
    """In a vertical line from the cylinder above: a spring keeps the ball off its seat until too much flows down."""
    if bleeds:
        aside, reach = x - out * 6.0, 0.5 * BOX + 1.0
        sheet.line((x, y + reach), (aside, y + reach), (aside, y - reach), (x, y - reach), kind="thin")
        throttle(sheet, aside, y)
        sheet.dot(x, y + reach)
        sheet.dot(x, y - reach)
    check_valve(sheet, x, y)
    spring(sheet, x + out * 2.6, y - 2.2, out, length=4.0)


def hose(sheet: Sheet, x: float, y: float, out: float, narrow: bool, height: float = 14.0) -> None:
    """A flexible line in a vertical one: a bow between two dots; `narrow`: with the sign of its resistance."""
    half = 0.5 * height
    sheet.area((x - 0.9, y - half), (x + 0.9, y - half), (x + 0.9, y + half), (x - 0.9, y + half), kind="blank")
    turn = [i / 12 for i in range(13)]
    sheet.line(*((x - out * 16.0 * t * (1.0 - t), y - half + height * t) for t in turn))
    sheet.dot(x, y - half)
    sheet.dot(x, y + half)
    if narrow:
        throttle(sheet, x - out * 4.0, y)


def leak(sheet: Sheet, x: float, y: float, out: float) -> None:
    """From a vertical line at (x, y) aside to the outside."""
    end = x + out * 7.0
    sheet.line((x, y), (end, y), kind="symbol")
    sheet.line((end - out * 2.2, y + 1.3), (end, y), (end - out * 2.2, y - 1.3), kind="symbol")
    sheet.dot(x, y)


def to_tank(sheet: Sheet, x: float, y: float, aside: float) -> None:
    """From a vertical line at (x, y) aside and down to a tank of its own."""
    sheet.line((x, y), (aside, y), (aside, y - 16.0))
    tank(sheet, aside, y - 18.0)
    sheet.dot(x, y)


def accumulator(sheet: Sheet, x: float, y: float, width: float = 9.0, height: float = 18.0) -> None:
    """Gas above, oil below; the line comes from below."""
    radius, turn = 0.5 * width, [i * 3.141592653589793 / 12 for i in range(13)]
    straight = 0.5 * height - radius
    upper = [(x + radius * cos(t), y + straight + radius * sin(t)) for t in turn]
    lower = [(x - radius * cos(t), y - straight - radius * sin(t)) for t in turn]
    sheet.area(*upper, *lower)
    sheet.line((x - radius, y), (x + radius, y), kind="symbol")
    sheet.area((x - 1.9, y + 5.4), (x, y + 2.2), (x + 1.9, y + 5.4), kind="thin")


def pump(sheet: Sheet, x: float, y: float, variable: bool, radius: float = 8.0) -> None:
    """Outlet above, inlet below."""
    sheet.circle(x, y, radius)
    sheet.area((x - 2.6, y + radius - 4.4), (x, y + radius), (x + 2.6, y + radius - 4.4), fill=INK)
    if variable:
        sheet.arrow((x - radius - 2.0, y - radius - 1.0), (x + radius + 2.0, y + radius + 1.0), length=2.8)


def prime_mover(sheet: Sheet, x: float, y: float, radius: float = 6.0) -> None:
    sheet.circle(x, y, radius)
    sheet.labels.append(Label(x, y, "M", "center", size=4.4))


def shaft(sheet: Sheet, start: float, end: float, y: float) -> None:
    """A turning shaft: a double line."""
    for aside in (-0.7, 0.7):
        sheet.line((start, y + aside), (end, y + aside), kind="thin")


def pressure_source(sheet: Sheet, x: float, y: float) -> None:
    """A pressure source without a pump."""
    sheet.area((x - 4.0, y), (x, y + 7.0), (x + 4.0, y), fill=INK)


def pump_control(sheet: Sheet, x: float, y: float) -> None:
    """The valve that swivels a pump: pressure of the mains at the left, spring at the right."""
    sheet.box(x, y, BOX, BOX)
    sheet.arrow((x - 1.9, y - 0.5 * BOX), (x - 1.9, y + 0.5 * BOX))
    spring(sheet, x + 0.5 * BOX, y, 1.0, adjustable=True)


def return_filter(sheet: Sheet, x: float, y: float, bypassed: bool) -> None:
    """In a vertical line that flows down; a bypass valve stands beside it."""
    if bypassed:
        aside, reach = x - 9.0, 7.5
        sheet.line((x, y + reach), (aside, y + reach), (aside, y - reach), (x, y - reach))
        check_valve(sheet, aside, y, up=False)
        spring(sheet, aside - 2.6, y + 2.2, -1.0, length=4.0)
        sheet.dot(x, y + reach)
        sheet.dot(x, y - reach)
    sheet.area((x, y + 5.0), (x + 5.0, y), (x, y - 5.0), (x - 5.0, y), kind="blank")
    sheet.line((x, y + 5.0), (x + 5.0, y), (x, y - 5.0), (x - 5.0, y), (x, y + 5.0), kind="symbol")
    sheet.line((x - 5.0, y), (x + 5.0, y), kind="pilot")


def tank(sheet: Sheet, x: float, y: float) -> None:
    """An open tank; the line ends in it."""
    sheet.line((x - 4.0, y + 2.6), (x - 4.0, y - 2.0), (x + 4.0, y - 2.0), (x + 4.0, y + 2.6), kind="symbol")
    sheet.line((x, y + 4.0), (x, y - 0.4))


def cylinder(sheet: Sheet, x: float, y: float, width: float = 50.0, height: float = 13.0) -> None:
    """Double-acting with one rod, which points to the right; piston side at the left."""
    rod = 0.3 * height
    sheet.box(x, y, width, height)
    piston = x - 0.18 * width
    sheet.box(piston, y, 5.0, height)
    right = x + 0.5 * width + 12.0
    sheet.area(
        (piston + 2.5, y - 0.5 * rod), (right, y - 0.5 * rod), (right, y + 0.5 * rod), (piston + 2.5, y + 0.5 * rod)
    )
    sheet.circle(right + 1.8, y, 1.8)


def motor(sheet: Sheet, x: float, y: float, ports: float) -> None:
    """Turns both ways; its ports lie at `ports` to either side, its shaft to the right."""
    radius = 8.0
    shaft(sheet, x + radius, x + radius + 12.0, y)
    sheet.circle(x, y, radius)
    for side in (-1.0, 1.0):
        tip = x + side * (radius - 4.4)
        sheet.area((x + side * radius, y - 2.6), (tip, y), (x + side * radius, y + 2.6), fill=INK)
        sheet.line((x + side * radius, y), (x + side * ports, y), kind="line")


def closed_port(sheet: Sheet, x: float, y: float, up: bool) -> None:
    """A port that ends within a position of a spool valve; it stands at the lower edge, or at the upper one."""
    end = y + (3.4 if up else -3.4)
    sheet.line((x, y), (x, end), kind="thin")
    sheet.line((x - 1.4, end), (x + 1.4, end), kind="thin")


def spool_valve(sheet: Sheet, x: float, y: float, regenerative: bool) -> None:
    """Three positions between A and B above, P and T below; the left one extends the cylinder; two solenoids."""
    half = 0.5 * CELL
    for cell in (-1, 0, 1):
        sheet.box(x + cell * CELL, y, CELL, CELL)
    for bar in (-1.0, 1.0):
        # Two bars mark a proportional valve, with all intermediate positions.
        level = y + bar * (half + 1.2)
        for left, right in ((-1.5, -0.45), (0.45, 1.5)):
            sheet.line((x + left * CELL, level), (x + right * CELL, level), kind="thin")
    low, high = y - half, y + half
    for port in (-PORT, PORT):
        closed_port(sheet, x + port, low, up=True)
        closed_port(sheet, x + port, high, up=False)
    extend, retract = x - CELL, x + CELL
    if regenerative:
        sheet.arrow((extend - PORT, low), (extend - PORT, high))
        sheet.line((extend + PORT, high), (extend + PORT, y), (extend - PORT, y), kind="thin")
        sheet.dot(extend - PORT, y)
        closed_port(sheet, extend + PORT, low, up=True)
    else:
        sheet.arrow((extend - PORT, low), (extend - PORT, high))
        sheet.arrow((extend + PORT, high), (extend + PORT, low))
    sheet.arrow((retract - PORT, low), (retract + PORT, high))
    sheet.arrow((retract - PORT, high), (retract + PORT, low))
    for sense in (-1.0, 1.0):
        edge = x + sense * 1.5 * CELL
        sheet.box(edge + sense * 3.0, y - 2.0, 6.0, 5.0)
        sheet.line((edge + sense * 0.8, y - 4.0), (edge + sense * 5.2, y), kind="thin")
        sheet.arrow((edge + sense * 3.0 - 2.2, y - 5.6), (edge + sense * 3.0 + 2.2, y + 1.6), length=1.6)
        spring(sheet, edge, y + 3.2, sense)
