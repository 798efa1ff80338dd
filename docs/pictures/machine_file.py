"""Pictures of how a machine file states frames, pins, angles, sides, flows; the crane is that of `hydrocrane new`."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc

import hydrocrane as hc
from hydrocrane.app.starter import TEMPLATE
from hydrocrane.plots.style import (
    ACCENT,
    COLOURS,
    CRANE_LINES,
    GRID,
    INK,
    MUTED,
    draw_crane,
    figure,
    one_chart,
    styled,
    write,
)

FILE = TEMPLATE / "machine.toml"
POSE = {"boom": np.radians(28.0), "jib": np.radians(-55.0), "telescope": 0.3}
# Where the name of a pin stands, from the pin, in points.
NAMES = {
    "post.boom-joint": (-12, -4, "right"),
    "post.lift-barrel": (8, -14, "left"),
    "boom.lift-rod": (8, -14, "left"),
    "boom.jib-barrel": (-8, 8, "right"),
    "boom.jib-joint": (-4, -20, "center"),
    "jib.jib-rod": (-8, 6, "right"),
    "jib.telescope-barrel": (9, 3, "left"),
    "jib.telescope-origin": (-12, -16, "right"),
    "telescope.rod": (10, 8, "left"),
    "telescope.tip": (-10, -4, "right"),
}
# The same for the names of frames.
FRAMES = {
    "post": (10, -14, "left"),
    "boom": (-12, -16, "right"),
    "jib": (34, 44, "left"),
    "telescope": (-4, -24, "right"),
}


def along(angle: float) -> np.ndarray:
    return np.array([np.cos(angle), np.sin(angle)])


def turned(angle: float, point: np.ndarray) -> np.ndarray:
    return point[0] * along(angle) + point[1] * along(angle + np.pi / 2)


def frames() -> dict[str, tuple[np.ndarray, float]]:
    """Origin and angle of every link's frame, as the law places them (docs/theory/geometry/frames.md)."""
    post, boom, jib = (0.0, POSE["boom"], POSE["boom"] + POSE["jib"])
    elbow = np.array([0.0, 1.0]) + turned(boom, np.array([2.0, 0.0]))
    return {
        "post": (np.zeros(2), post),
        "boom": (np.array([0.0, 1.0]), boom),
        "jib": (elbow, jib),
        "telescope": (elbow + turned(jib, np.array([0.4 + POSE["telescope"], 0.0])), jib),
    }


def pins() -> dict[str, np.ndarray]:
    """Places of all named points."""
    links = tomllib.loads(FILE.read_text(encoding="utf-8"))["link"]
    found = {}
    for link, (origin, angle) in frames().items():
        for name, text in links[link]["point"].items():
            point = np.array([float(part) for part in text.removesuffix("m").strip(" ()").split(",")])
            found[f"{link}.{name}"] = origin + turned(angle, point)
    return found


def arrow(axes: Axes, start: np.ndarray, end: np.ndarray, colour: str, style: str = "-|>") -> None:
    props = {"arrowstyle": style, "color": colour, "lw": 1.4, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, start, arrowprops=props)


def name_at(axes: Axes, text: str, at: np.ndarray, right: float, up: float, ha: str = "center", **style: Any) -> None:
    """A text so many points right and up of a place."""
    axes.annotate(text, at, (right, up), textcoords="offset points", ha=ha, **style)


def arc(axes: Axes, centre: np.ndarray, radius: float, first: float, last: float, text: str, colour: str) -> None:
    """An angle from `first` to `last`, rad, with an arrow at its end and a text beyond its middle."""
    low, high = np.degrees(sorted((first, last)))
    axes.add_patch(Arc(centre, 2 * radius, 2 * radius, theta1=low, theta2=high, color=colour, lw=1.6))
    end, sense = centre + radius * along(last), np.sign(last - first)
    arrow(axes, end - 0.03 * sense * along(last + np.pi / 2), end, colour)
    axes.annotate(text, centre + 1.12 * radius * along((first + last) / 2), color=colour, va="center")


def bare(axes: Axes, heading: str) -> None:
    axes.set_aspect("equal")
    axes.axis("off")
    axes.set_title(heading)


@styled
def frames_and_pins() -> Figure:
    """The template's frames and pins."""
    fig, axes = one_chart(8.6, 4.9)
    axes.set(xlim=(-0.8, 4.2), ylim=(-0.2, 2.5))
    draw_crane(axes, hc.load_machine(FILE).drawing(np.array(list(POSE.values()))), alpha=0.35)
    for link, (origin, angle) in frames().items():
        for turn, letter in ((0.0, "x"), (np.pi / 2, "z")):
            arrow(axes, origin, origin + 0.42 * along(angle + turn), ACCENT)
            axes.annotate(letter, origin + 0.48 * along(angle + turn), color=ACCENT, ha="center", va="center")
        name_at(axes, f"frame of {link}", origin, *FRAMES[link], color=ACCENT)
    for name, beside in NAMES.items():
        place = pins()[name]
        axes.plot(*place, marker="o", ms=5, color=INK, zorder=7)
        name_at(axes, name, place, *beside, fontsize=8.5)
    bare(axes, "Each link has a frame. Pins are points of a link, in its own frame.")
    return fig


@styled
def angles_and_sides() -> Figure:
    """Both conventions of a revolute joint at the same pose, and both sides of a linkage."""
    fig, charts = figure(9.6, 3.0, ncols=3)
    for axes, convention in zip(charts, ("relative", "included"), strict=False):
        joint, parent, child = np.array([1.0, 0.5]), np.radians(25.0), np.radians(-35.0)
        axes.set(xlim=(-0.1, 2.2), ylim=(-0.45, 1.35))
        for start, end, name in ((joint - along(parent), joint, "parent"), (joint, joint + along(child), "child")):
            axes.plot(*zip(start, end, strict=True), **CRANE_LINES["link"])
            name_at(axes, name, (start + end) / 2, 0, 10)
        axes.plot(*joint, **CRANE_LINES["joint"])
        axes.plot(*zip(joint, joint + 0.9 * along(parent), strict=True), color=MUTED, ls=":", lw=1.4)
        if convention == "relative":
            arc(axes, joint, 0.55, parent, child, "-60 deg", ACCENT)
            bare(axes, '"relative"')
            says = "from the parent's x axis to the child's,\ncounter-clockwise; stretched is 0"
        else:
            arc(axes, joint, 0.4, parent - np.pi, child, "120 deg", ACCENT)
            bare(axes, '"included"')
            says = "counter-clockwise from parent to child\nas enclosed by them; stretched is 180 deg"
        axes.annotate(says, (0.5, 0.0), xycoords="axes fraction", ha="center", va="top", fontsize=8.5)
    linkage(charts[2])
    return fig


def linkage(axes: Axes) -> None:
    """Rocker and coupler on both sides of the line between their pivots."""
    rocker, coupler, lengths = np.array([0.55, 0.3]), np.array([1.35, 0.2]), (0.6, 0.55)
    axes.set(xlim=(-0.2, 2.1), ylim=(-0.5, 1.3))
    line = coupler - rocker
    square = line @ line
    share = (lengths[0] ** 2 - lengths[1] ** 2 + square) / (2 * square)
    across = np.sqrt(lengths[0] ** 2 / square - share**2) * np.array([-line[1], line[0]])
    for side, sense, alpha in (("left", 1.0, 1.0), ("right", -1.0, 0.35)):
        pin = rocker + share * line + sense * across
        for pivot, name, where in ((rocker, "rocker", "right"), (coupler, "coupler", "left")):
            axes.plot(*zip(pivot, pin, strict=True), alpha=alpha, **CRANE_LINES["torque-link"])
            if sense > 0:
                name_at(axes, name, (pivot + pin) / 2, -8 if where == "right" else 8, 0, where)
        axes.plot(*pin, alpha=alpha, **CRANE_LINES["joint"])
        name_at(axes, f'side = "{side}"', pin, 0, 9 if sense > 0 else -17, color=ACCENT)
    arrow(axes, rocker, coupler, MUTED)
    for pivot, name, where in ((rocker, "rocker-pivot", "right"), (coupler, "coupler-pivot", "left")):
        axes.plot(*pivot, **CRANE_LINES["joint"])
        name_at(axes, name, pivot, -8 if where == "right" else 8, -4, where)
    bare(axes, "side of a linkage")
    says = "left or right, looking from\nthe rocker's pivot to the coupler's"
    axes.annotate(says, (0.5, 0.0), xycoords="axes fraction", ha="center", va="top", fontsize=8.5)


@styled
def nominal_flow() -> Figure:
    """Pressure along the way through a valve at its nominal flow, as data sheets measure it."""
    fig, axes = one_chart(8.6, 3.5)
    ends = [0.0, 1.0, 1.5, 3.0, 3.5, 4.5]
    axes.plot(ends, [2.0, 2.0, 1.0, 1.0, 0.0, 0.0], color=COLOURS[0], lw=2.4)
    parts = ("pump", "edge P-A", "port A = port B", "edge B-T", "tank")
    for name, start, end in zip(parts, ends, ends[1:], strict=False):
        if name.startswith("edge"):
            axes.axvspan(start, end, color=GRID, lw=0)
        axes.annotate(name, ((start + end) / 2, -0.35), ha="center", annotation_clip=False)
    for x, top, bottom, text in (
        (1.75, 2.0, 1.0, "nominal-edge-pressure-drop\nsheet: per edge, per notch, per land"),
        (3.75, 2.0, 0.0, "nominal-pressure-drop\nsheet: in all, P-A and B-T"),
    ):
        for height in (top, bottom):
            axes.plot([x - 0.12, x + 0.06], [height, height], color=MUTED, lw=0.8)
        arrow(axes, np.array([x, top]), np.array([x, bottom]), ACCENT, "<|-|>")
        axes.annotate(text, (x + 0.1, (top + bottom) / 2), va="center", color=ACCENT)
    axes.set(xlim=(-0.05, 5.3), ylim=(-0.1, 2.2), xticks=[], yticks=[], ylabel="pressure at nominal-flow")
    axes.grid(visible=False)
    axes.set_title("A flow belongs to a drop: over one edge or over both")
    return fig


def draw_all(folder: Path) -> None:
    write(frames_and_pins(), folder / "machine-file-frames.png")
    write(angles_and_sides(), folder / "machine-file-angles.png")
    write(nominal_flow(), folder / "machine-file-nominal-flow.png")
