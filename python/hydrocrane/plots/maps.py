"""Pictures of a machine over its poses: workspace, strokes, load chart, modes."""

from __future__ import annotations

import textwrap
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.ticker import MaxNLocator

from hydrocrane.analysis.capacity import Height, at_height
from hydrocrane.analysis.linear import FRICTION_WORDS
from hydrocrane.analysis.poses import pose_grid
from hydrocrane.arrays import Array
from hydrocrane.errors import HydrocraneError, InputError, unknown
from hydrocrane.machine.machine import MachineLike, as_machine
from hydrocrane.plots.style import (
    ACCENT,
    COLOURS,
    FIELD,
    GRID,
    INK,
    MUTED,
    draw_crane,
    figure,
    one_chart,
    shown,
    styled,
    title,
)

if TYPE_CHECKING:
    from hydrocrane.analysis.capacity import LoadChart
    from hydrocrane.analysis.linear import ModeMap
    from hydrocrane.linear.shapes import DampingCurves, ModeShapes
    from hydrocrane.machine.machine import Machine

_AREA = "#dfebf0"


@styled
def workspace(machine: MachineLike) -> Figure:
    """Reach of the tip inside the joint limits, its boundary, and keep-out regions, with the crane in mid-range."""
    machine = as_machine(machine)
    fig, axes = one_chart(7.5, 7.0)
    if len(machine.joint_names) > 1:
        poses = pose_grid(machine, 48)
        axes.add_collection(
            PolyCollection(list(patches(machine.tip_in_plane(poses))[0]), color=_AREA, antialiaseds=False, zorder=0.5)
        )
    draw_boundary(axes, machine)
    draw_keep_out(axes, machine)
    draw_crane(axes, machine.drawing(machine.home))
    metres(axes)
    title(fig, "Working area of the tip", machine.name)
    return fig


def draw_boundary(axes: Axes, machine: Machine, *, colour: str = COLOURS[0]) -> None:
    """Draw the boundary curves of the workspace."""
    for curve in machine.workspace():
        axes.plot(curve[:, 0], curve[:, 1], color=colour, lw=1.4, zorder=1.5)


def draw_keep_out(axes: Axes, machine: Machine) -> None:
    """Hatch the keep-out regions; they do not extend the picture."""
    for outline in machine.keep_out.values():
        axes.add_artist(Polygon(outline, facecolor=GRID, edgecolor=MUTED, hatch="///", lw=0.8, alpha=0.7, zorder=1))


def metres(axes: Axes, *, fixed: bool = False) -> None:
    """Inertial x and z in metres at equal scale; `fixed` keeps the limits and shrinks the box instead."""
    axes.set_aspect("equal", adjustable="box" if fixed else "datalim")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("z [m]")


@styled
def joint_stroke(machine: MachineLike, joint: str | None = None) -> Figure:
    """Piston position over each revolute joint (or the one named), with limits and stroke ends."""
    machine = as_machine(machine)
    if joint is not None and joint not in machine.joint_names:
        raise unknown("joint", joint, machine.joint_names)
    turning = [j for j, unit in zip(machine.joint_names, machine.joint_units, strict=True) if unit == "rad"]
    chosen = [joint] if joint else (turning or list(machine.joint_names))
    fig, axes = figure(4.8 * max(len(chosen), 1.4), 4.5, ncols=len(chosen), squeeze=False)
    for panel, name in zip(axes.flat, chosen, strict=True):
        _curve(panel, machine, machine.joint_names.index(name))
    handles, labels = axes[0, 0].get_legend_handles_labels()
    fig.legend(handles, labels, loc="outside lower center", ncols=3)
    title(fig, "Joint and piston", machine.name)
    return fig


def _curve(axes: Axes, machine: Machine, index: int) -> None:
    unit, factor = shown(machine.joint_units[index])
    low, high = machine.joint_limits[index]
    angle, stroke = _sweep(machine, index, low, high)
    inside = (angle >= low) & (angle <= high)
    axes.plot(angle * factor, stroke * 1e3, color=MUTED, lw=1.2, ls="--", label="linkage alone")
    axes.plot(angle[inside] * factor, stroke[inside] * 1e3, color=COLOURS[0], lw=2.2, label="inside the joint limits")
    ends = machine.stroke_limits[index] * 1e3
    axes.axhspan(*ends, color=COLOURS[0], alpha=0.07, lw=0, label="stroke of the cylinder")
    reasons = machine.joint_limit_reasons[index]
    for value, reason, side in ((low, reasons[0], "left"), (high, reasons[1], "right")):
        axes.axvline(value * factor, color=COLOURS[4], lw=1.0)
        # The text is placed away from the curve.
        above = np.interp(value, angle, stroke) * 1e3 < np.mean(axes.get_ylim())
        axes.annotate(
            f"{value * factor:.1f} {unit}: {reason}", (value * factor, 0.98 if above else 0.02),
            xycoords=("data", "axes fraction"), rotation=90, ha=side, va="top" if above else "bottom",
            fontsize=8, color=COLOURS[4],
            bbox={"facecolor": "white", "alpha": 0.8, "lw": 0, "pad": 1.5},
        )  # fmt: skip
    axes.set_title(f"cylinder {machine.cylinder_names[index]}")
    axes.set_xlabel(f"joint {machine.joint_names[index]} [{unit}]")
    axes.set_ylabel("piston position from mid-stroke [mm]")


def _sweep(machine: Machine, index: int, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """Joint coordinate and stroke from well below to well above the limits, where the linkage closes."""
    beyond = 0.25 * (high - low)
    grid = np.unique(np.concatenate([np.linspace(low - beyond, high + beyond, 301), [low, high]]))
    values, strokes = [], []
    for value in grid:
        q = machine.home.copy()
        q[index] = value
        try:
            stroke = machine.strokes(q)[index]
        except HydrocraneError:
            continue
        if np.isfinite(stroke):
            values.append(value)
            strokes.append(stroke)
    return np.array(values), np.array(strokes)


def patches(tip: Array) -> tuple[Array, np.ndarray]:
    """Quadrilaterals between neighbouring poses of a grid.

    Parameters
    ----------
    tip : (k_1, ..., k_n, 2) array
        Tips of a regular grid of poses; n of at least 2.

    Returns
    -------
    corners : (m, 4, 2) array
    index : (m, 4) array of int
        Flat index of each corner's pose.

    Notes
    -----
    For each pair of joints there are patches with the other joints at an end of their range; these cover the workspace
    up to its boundary. For the two joints that move the tip most there are patches at all values of the others.
    """
    shape = tip.shape[:-1]
    flat = np.arange(int(np.prod(shape))).reshape(shape)
    found = []
    for pair in combinations(range(len(shape)), 2):
        layers = np.moveaxis(flat, pair, (-2, -1)).reshape(-1, shape[pair[0]], shape[pair[1]])
        others = [shape[i] for i in range(len(shape)) if i not in pair]
        inner = np.ones(others, dtype=bool)
        for axis, count in enumerate(others):
            ends = np.isin(np.arange(count), (0, count - 1))
            inner &= ~np.expand_dims(ends, tuple(i for i in range(len(others)) if i != axis))
        if pair != (0, 1):
            layers = layers[~inner.reshape(-1)]
        corners = [layers[:, :-1, :-1], layers[:, 1:, :-1], layers[:, 1:, 1:], layers[:, :-1, 1:]]
        found.append(np.stack([c.reshape(-1) for c in corners], axis=-1))
    index = np.concatenate(found)
    return tip.reshape(-1, 2)[index], index


def paint(axes: Axes, tip: Array, value: Array, *, largest: bool, limits: tuple[float, float]) -> ScalarMappable:
    """Colour the plane by the largest (or smallest) value of all poses with the tip at that point.

    Parameters
    ----------
    tip, value : (k_1, ..., k_n, 2), (k_1, ..., k_n) arrays
        Over a regular grid of poses; patches with a NaN corner are left out.
    limits : tuple of float
        Ends of the colour scale.
    """
    flat = value.reshape(-1)
    if tip.ndim == 2:
        return axes.scatter(tip[:, 0], tip[:, 1], c=flat, cmap=FIELD, vmin=limits[0], vmax=limits[1], s=14)
    corners, index = patches(tip)
    mean = flat[index].mean(axis=1)
    good = np.flatnonzero(np.isfinite(mean))
    # Patches that are painted last are on top.
    order = good[np.argsort(mean[good] if largest else -mean[good], kind="stable")]
    sheet = PolyCollection(list(corners[order]), array=mean[order], cmap=FIELD, antialiaseds=False, zorder=1)
    sheet.set_clim(*limits)
    axes.add_collection(sheet)
    axes.autoscale_view()
    return sheet


def hatch(axes: Axes, tip: Array, forbidden: np.ndarray) -> None:
    """Hatch the plane where poses of the grid are forbidden; `tip` as in :func:`paint`."""
    if tip.ndim == 2 or not forbidden.any():
        return
    corners, index = patches(tip)
    out = forbidden.reshape(-1)[index].any(axis=1)
    axes.add_collection(
        PolyCollection(list(corners[out]), facecolor=GRID, edgecolor=MUTED, hatch="///", linewidth=0.0, zorder=1.2)
    )


# Most lines of equal payload.
_LINES = 6


@styled
def load_chart(machine: MachineLike, chart: LoadChart, *, height: Height | None = None) -> Figure:
    """Left, the largest payload at each tip position; right, against reach: at the best and the worst height.

    Lines join positions of equal payload; forbidden positions are hatched. With `height`, as in
    ``LoadChart.against_reach``, only that curve.
    """
    machine = as_machine(machine)
    fig, (area, curve) = figure(12.0, 5.4, ncols=2, width_ratios=[1.15, 1])
    # Near the pillar the payload is very large; the colours show the useful range.
    top = float(np.nanpercentile(chart.payload, 90))
    sheet = paint(area, chart.tip, chart.payload, largest=True, limits=(0.0, top))
    hatch(area, chart.tip, chart.forbidden)
    _iso_loads(area, chart, top)
    fig.colorbar(sheet, ax=area, label="payload [kg]", extend="max", shrink=0.85)
    draw_boundary(area, machine, colour=INK)
    draw_crane(area, machine.drawing(machine.home), alpha=0.9)
    metres(area)
    area.set_title("payload at the tip, in the pose with the highest payload")
    _against_reach(curve, chart, height)
    title(fig, "Static load chart", f"{machine.name} at {chart.supply_pressure * 1e-5:.0f} bar")
    return fig


def _iso_loads(axes: Axes, chart: LoadChart, top: float) -> None:
    """Lines of equal payload, at round values up to the top of the colours."""
    x, z, payload = chart.over_places()
    if x.size < 2 or not np.isfinite(top):
        return
    levels = [level for level in MaxNLocator(_LINES).tick_values(0.0, top) if 0.0 < level <= top]
    lines = axes.contour(x, z, np.minimum(payload, 2 * top), levels=levels, colors=INK, linewidths=0.8, zorder=1.3)
    axes.clabel(lines, fontsize=7, fmt=lambda level: f"{level:g} kg")


def _against_reach(axes: Axes, chart: LoadChart, height: Height | None) -> None:
    shown: tuple[Height, ...] = ("best", "worst") if height is None else (height,)
    for which, colour in zip(shown, COLOURS):
        reach, payload = chart.against_reach(which)
        axes.plot(reach, payload, color=colour, lw=2.0, marker="o" if reach.size == 1 else None, label=at_height(which))
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("reach x [m]")
    axes.set_ylabel("payload [kg]")
    axes.set_title("payload against reach")
    if reach.size > 1:
        axes.margins(x=0)
    else:
        axes.set_xlim(reach[0] - 1, reach[0] + 1)
    axes.legend()


@styled
def mode_map(machine: MachineLike, modes: ModeMap) -> Figure:
    """Slowest oscillation at each tip position (slowest over the poses that reach it), and the least damping.

    Forbidden positions are hatched.
    """
    machine = as_machine(machine)
    if not np.isfinite(modes.frequency).any():
        raise InputError("the map has no pose in which the crane holds its load and swings: carry less, or draw no map")
    fig, (left, right) = figure(12.0, 5.0, ncols=2)
    for panel, value, label in (
        (left, modes.frequency, "natural frequency [Hz]"),
        (right, 100 * modes.damping, "damping ratio [%]"),
    ):
        # The scale leaves out rare extremes near the limits.
        limits = np.nanpercentile(value, (2, 95))
        sheet = paint(panel, modes.tip, value, largest=False, limits=(float(limits[0]), float(limits[1])))
        hatch(panel, modes.tip, modes.forbidden)
        fig.colorbar(sheet, ax=panel, label=label, extend="both", shrink=0.9)
        draw_boundary(panel, machine, colour=INK)
        draw_crane(panel, machine.drawing(machine.home), alpha=0.9)
        metres(panel)
        panel.set_title(f"slowest mode: {label.split(' [')[0]}")
    title(fig, "Small motions about rest, valves closed", machine.name)
    notes = [FRICTION_WORDS[modes.friction], *(warning.text for warning in modes.warnings)]
    fig.supxlabel("\n".join(textwrap.fill(note, 170) for note in notes), fontsize=8, color=MUTED)
    return fig


# Largest motion of the tip in the picture, as a share of the crane's reach.
_SWING = 0.12


@styled
def mode_shapes(machine: MachineLike, shapes: ModeShapes) -> Figure:
    """Each mode: the crane at rest (dark) and at both ends of its oscillation (pale), much enlarged.

    The imaginary parts of a mode shape (motions with a phase lag) are not drawn.
    """
    machine = as_machine(machine)
    if not shapes.frequency.size:
        raise InputError(
            f"{machine.name} has no oscillating mode in this pose except those of the spools: nothing to draw"
        )
    count = shapes.frequency.size
    fig, panels = figure(4.2 * count, 4.4, ncols=count, squeeze=False)
    lines = machine.drawing(shapes.q)
    every = np.concatenate([points for _, _, points in lines])
    reach = np.ptp(every, axis=0).max()
    low, high = machine.joint_limits.T
    for panel, joints, frequency, damping in zip(
        panels.flat, shapes.joints.real, shapes.frequency, shapes.damping, strict=True
    ):
        # Inside the joint limits, because a drawing exists only there.
        room = np.min((high - low) / 2 / np.maximum(np.abs(joints), 1e-12))
        swing = min(_SWING * reach, 0.9 * room)
        for side in (-swing, swing):
            draw_crane(panel, machine.drawing(np.clip(shapes.q + side * joints, low, high)), alpha=0.25)
        draw_crane(panel, lines)
        metres(panel)
        panel.set_title(f"{frequency:.3g} Hz, damping {100 * damping:.2g} %")
    title(fig, "Modes of small motions, enlarged", machine.name)
    return fig


@styled
def damping_curves(curves: DampingCurves) -> Figure:
    """Frequency and damping ratio of each mode along a joint."""
    unit, factor = shown(curves.unit)
    fig, (upper, lower) = figure(7.0, 5.5, nrows=2, sharex=True)
    for k in range(curves.frequency.shape[1]):
        colour = COLOURS[k % len(COLOURS)]
        upper.plot(curves.coordinate * factor, curves.frequency[:, k], color=colour, label=f"mode {k + 1}")
        lower.plot(curves.coordinate * factor, 100 * curves.damping[:, k], color=colour)
    upper.set_ylabel("natural frequency [Hz]")
    lower.set_ylabel("damping ratio [%]")
    lower.set_xlabel(f"joint {curves.joint} [{unit}]")
    lower.axhline(0.0, color=ACCENT, lw=0.8)
    upper.legend(ncols=3)
    title(fig, "Modes along a joint", f"friction {curves.friction}")
    return fig
