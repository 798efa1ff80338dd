"""A sheet of lines, areas and texts in millimetres; a circuit diagram is composed of sheets."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, Literal

import numpy as np
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath

from hydrocrane.plots.style import ACCENT, COLOURS, INK, MUTED

Point = tuple[float, float]
Side = Literal["left", "center", "right"]

POINTS_PER_MM = 72 / 25.4
FONT = "DejaVu Sans"
SIZE, LEADING = 3.1, 4.2

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
        """Lines of text from `y` downwards; with `head` the first one is bold."""
        shown = [line for line in lines if line]
        for i, line in enumerate(shown):
            self.labels.append(Label(x, y - i * LEADING, line, side, bold=head and i == 0))

    def add(self, other: Sheet, dx: float = 0.0, dy: float = 0.0) -> None:
        """Add another sheet to this one, without its ports."""
        for stroke in other.strokes:
            self.strokes.append(replace(stroke, points=tuple((x + dx, y + dy) for x, y in stroke.points)))
        self.labels += [replace(label, x=label.x + dx, y=label.y + dy) for label in other.labels]

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, bottom, right and top of everything on it."""
        points = [point for stroke in self.strokes for point in stroke.points]
        boxes = [label.box for label in self.labels]
        xs = [x for x, _ in points] + [x for box in boxes for x in (box[0], box[2])]
        ys = [y for _, y in points] + [y for box in boxes for y in (box[1], box[3])]
        return min(xs), min(ys), max(xs), max(ys)


def side_by_side(sheets: Iterable[Sheet], gap: float, start: float = 0.0) -> list[tuple[Sheet, float]]:
    """Each sheet with its shift to the right, for which it lies `gap` beside the previous one."""
    placed, right = [], start - gap
    for sheet in sheets:
        left, _, end, _ = sheet.extent
        shift = right + gap - left
        placed.append((sheet, shift))
        right = end + shift
    return placed
