"""The benchmark of tip control on one page: paths with their deviation enlarged, and bars of the largest deviation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrocrane.benchmark.metrics import nearest_on_path, significant
from hydrocrane.errors import InputError
from hydrocrane.plots.style import COLOURS, INK, MUTED, styled, title

if TYPE_CHECKING:
    from hydrocrane.benchmark.cases import Result
    from hydrocrane.benchmark.suite import Benchmark

# Shapes of paths in the order of priority, because there is room for only PANELS of them.
SHAPES = ("up", "out", "square", "circle", "reach", "log", "down", "in")
PANELS = 6
# Share of the path's size that the enlarged deviation may take.
SHOWN_DEVIATION = 0.2
# Left end of the bars, m.
LEAST = 1e-5


@styled
def control_benchmark(found: Benchmark) -> Figure:
    """A row of paths for each controller, and one bar per controller and case."""
    moved = [result for result in found.results if len(result.tip)]
    if not moved:
        raise InputError("no case of this benchmark recorded a motion; there is nothing to draw")
    controllers = list(dict.fromkeys(result.controller for result in moved))
    cases = list(dict.fromkeys(_label(result) for result in moved))
    paths = _chosen_paths(moved)
    heights = [2.9 * len(controllers), 0.7 + 0.2 * len(cases) * max(1, len(controllers) - 0.5)]
    fig = plt.figure(figsize=(max(8.0, 2.7 * len(paths)), sum(heights) + 0.4), layout="constrained")
    upper, lower = np.ravel(np.asarray(fig.subfigures(2, 1, height_ratios=heights)))
    panels = upper.subplots(len(controllers), len(paths), squeeze=False)
    by_key = {(result.controller, _label(result)): result for result in moved}
    for row, controller in enumerate(controllers):
        for column, label in enumerate(paths):
            _path(panels[row, column], by_key.get((controller, label)), controller, COLOURS[row % len(COLOURS)])
    _bars(lower.subplots(), by_key, controllers, cases)
    title(fig, "Crane-tip control", f"{found.machine}, seed {found.seed}")
    return fig


def _label(result: Result) -> str:
    return f"{result.case.task.name} · {result.case.condition}"


def _chosen_paths(moved: Sequence[Result]) -> list[str]:
    """Labels of the cases whose paths are drawn: one of each shape, under the reference condition if possible."""
    shapes: dict[str, str] = {}
    for result in sorted(moved, key=lambda r: str(r.case.condition) == "reference"):
        shapes[result.case.task.name.split()[0]] = _label(result)
    known = [shape for shape in SHAPES if shape in shapes]
    return [shapes[shape] for shape in [*known, *(s for s in shapes if s not in SHAPES)][:PANELS]]


def _path(axes: Axes, result: Result | None, controller: str, colour: str) -> None:
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("z [m]")
    if result is None:
        axes.set_title(f"{controller}: no motion", fontsize=9)
        return
    nearest = nearest_on_path(result.tip, result.asked)
    aside = result.tip - nearest
    factor = _enlargement(aside, float(np.ptp(result.asked, axis=0).max()))
    drawn = nearest + factor * aside
    axes.plot(*result.asked.T, color=INK, lw=0.9)
    axes.plot(*drawn.T, color=colour, lw=1.4)
    axes.plot(*result.asked[0], marker="o", ms=4, color=INK)
    largest = significant(float(np.hypot(*aside.T).max()) * 1e3)
    axes.set_title(f"{controller}\n{result.case.task.name}\n{largest} mm, drawn x {factor:g}", fontsize=9)


def _enlargement(aside: np.ndarray, size: float) -> float:
    """Factor of 1 or more: 1, 2 or 5 times a power of ten, for which the largest deviation is near its share of the
    path's size."""
    largest = max(float(np.hypot(*aside.T).max()), 1e-9)
    wanted = SHOWN_DEVIATION * size / largest
    decade = 10.0 ** np.floor(np.log10(wanted))
    return max(1.0, float(max(step for step in (1, 2, 5) if step * decade <= wanted * (1 + 1e-9)) * decade))


def _bars(axes: Axes, by_key: dict[tuple[str, str], Result], controllers: list[str], cases: list[str]) -> None:
    places = np.arange(len(cases), dtype=float)
    thickness = 0.8 / len(controllers)
    for i, controller in enumerate(controllers):
        results = [by_key.get((controller, case)) for case in cases]
        values = np.array([_largest(result) for result in results])
        style: dict[str, Any] = {"color": COLOURS[i % len(COLOURS)], "height": thickness, "label": controller}
        axes.barh(places + i * thickness, np.maximum(values - LEAST, 0.0) * 1e3, left=LEAST * 1e3, **style)
        for place, result, value in zip(places, results, values, strict=True):
            note = "did not run" if result is None else _note(result, value)
            axes.text(value * 1e3, place + i * thickness, f" {note}", va="center", fontsize=7, color=MUTED)
    axes.set_xscale("log")
    axes.set_yticks(places + 0.5 * (len(controllers) - 1) * thickness, cases, fontsize=8)
    axes.invert_yaxis()
    axes.margins(x=0.08, y=0.01)
    axes.grid(visible=False, axis="y")
    axes.set_xlabel("largest distance of the tip from its path [mm]")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=len(controllers))


def _note(result: Result, value: float) -> str:
    """Text beside the bar of a deviation `value`, m."""
    early = "ended early" if not result.outcome.completed else ""
    return ", ".join(part for part in (significant(value * 1e3), early, result.remark) if part)


def _largest(result: Result | None) -> float:
    """Largest deviation, m, not below the left end of the axis."""
    return LEAST if result is None or result.metrics is None else max(result.metrics.path_max, LEAST)
