"""Layout of a regular grid of charts; each label is measured once.

Constrained layout, the default of all pictures, computes all boxes of a figure twice, which takes longer than the
drawing. If a figure has only lines, ticks, labels and headings, its margins follow in closed form.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis, XAxis
from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.spines import Spine
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array


@dataclass
class _Margins:
    """Margins beside each column and row of charts, pixels; rows count from the top."""

    left: Array
    right: Array
    bottom: Array
    top: Array

    @classmethod
    def none(cls, grid: GridSpec) -> _Margins:
        columns, rows = np.zeros(grid.ncols), np.zeros(grid.nrows)
        return cls(columns.copy(), columns, rows.copy(), rows)

    def widen(self, axes: Axes, room: dict[str, float]) -> None:
        """Make the margin beside the column or row of a chart at least this wide."""
        place = axes.get_subplotspec()
        assert place is not None
        for side, pixels in room.items():
            index = place.colspan.start if side in ("left", "right") else place.rowspan.start
            beside: Array = getattr(self, side)
            beside[index] = max(beside[index], pixels)


def arrange(fig: Figure) -> bool:
    """Place the charts of a figure. False if it is no plain grid, which is left to constrained layout."""
    engine, canvas, grid = fig.get_layout_engine(), fig.canvas, _plain_grid(fig)
    if grid is None or not isinstance(engine, ConstrainedLayoutEngine) or not isinstance(canvas, FigureCanvasAgg):
        return False
    renderer, margins = canvas.get_renderer(), _Margins.none(grid)
    pads = (float(engine.get()["w_pad"]) * fig.dpi, float(engine.get()["h_pad"]) * fig.dpi)
    head = _headline(fig, renderer, pads[1])
    # The tick labels depend on the heights, but not the heights on the labels.
    for axes in fig.axes:
        margins.widen(axes, _above_and_below(axes, renderer))
    _place(fig, grid, margins, pads, head)
    for axes in fig.axes:
        margins.widen(axes, _left_and_right(axes, renderer))
    _place(fig, grid, margins, pads, head)
    return not any(axes.yaxis.get_major_formatter().get_offset() for axes in fig.axes)


def _plain_grid(fig: Figure) -> GridSpec | None:
    """The grid of a figure that has only line charts, each in a cell, and a headline."""
    grids = {axes.get_gridspec() for axes in fig.axes}
    grid = grids.pop() if len(grids) == 1 else None
    words = [text.get_text() for text in fig.texts]
    bare = not (fig.subfigs or fig.legends or fig.images or fig.get_supxlabel() or fig.get_supylabel())
    if bare and words in ([], [fig.get_suptitle()]) and isinstance(grid, GridSpec) and all(map(_plain, fig.axes)):
        return grid
    return None


def _plain(axes: Axes) -> bool:
    place = axes.get_subplotspec()
    cell = place is not None and place.num1 == place.num2
    known = all(isinstance(part, Line2D | Spine | Axis | Text) or part is axes.patch for part in axes.get_children())
    inside = not axes.texts and all(line.get_clip_on() for line in axes.lines)
    return cell and known and inside and axes.get_visible() and axes.axison and axes.get_aspect() == "auto"


def _headline(fig: Figure, renderer: RendererAgg, pad: float) -> float:
    """Place the headline of a figure at its upper edge; returns its height with pads, pixels."""
    for text in fig.texts:
        text.set_position((text.get_position()[0], 1.0 - pad / fig.bbox.height))
        return float(text.get_window_extent(renderer).height) + 2.0 * pad
    return 0.0


def _above_and_below(axes: Axes, renderer: RendererAgg) -> dict[str, float]:
    """Headings above a chart; ticks, their numbers and the label below it; half a number of the other axis at least."""
    half = 0.5 * float(axes.yaxis.get_major_ticks(1)[0].label1.get_fontsize()) * renderer.dpi / 72.0
    titles = [part for part in axes.get_children() if isinstance(part, Text) and part.get_text()]
    above = [title.get_window_extent(renderer).y1 - axes.bbox.y1 for title in titles]
    below = axes.bbox.y0 - _numbers(axes.xaxis, renderer).y0 + _label(axes.xaxis, renderer)
    return {"top": max([half, *above]), "bottom": max(half, below)}


def _left_and_right(axes: Axes, renderer: RendererAgg) -> dict[str, float]:
    """The label, numbers and ticks left of a chart; half of the last number below it at its right."""
    x, y = _numbers(axes.xaxis, renderer), _numbers(axes.yaxis, renderer)
    left = max(axes.bbox.x0 - y.x0 + _label(axes.yaxis, renderer), axes.bbox.x0 - x.x0)
    return {"left": left, "right": x.x1 - axes.bbox.x1}


def _shown(axis: Axis, renderer: RendererAgg) -> list[Bbox]:
    """Boxes of the tick labels within the view; charts with a common axis show them once."""
    if not axis.get_tick_params().get("labelbottom" if isinstance(axis, XAxis) else "labelleft", True):
        return []
    low, high = sorted(axis.get_view_interval())
    slack = 1e-9 * (high - low)
    along = 0 if isinstance(axis, XAxis) else 1
    numbers = axis.get_majorticklabels()
    inside = [number for number in numbers if low - slack <= number.get_position()[along] <= high + slack]
    return [number.get_window_extent(renderer) for number in inside]


def _numbers(axis: Axis, renderer: RendererAgg) -> Bbox:
    """The box of a chart with the ticks of an axis and their numbers."""
    chart: Bbox = axis.axes.bbox.frozen()
    length = axis.get_major_ticks(1)[0].tick1line.get_markersize() * renderer.dpi / 72.0
    ticks = Bbox.from_extents(chart.x0 - length, chart.y0, *chart.max)
    if isinstance(axis, XAxis):
        ticks = Bbox.from_extents(chart.x0, chart.y0 - length, *chart.max)
    return Bbox.union([ticks, *_shown(axis, renderer)])


def _label(axis: Axis, renderer: RendererAgg) -> float:
    """Height of the label of an axis beside its tick labels, pixels."""
    if not axis.label.get_text():
        return 0.0
    box = axis.label.get_window_extent(renderer)
    across = box.height if isinstance(axis, XAxis) else box.width
    return float(across + axis.labelpad * renderer.dpi / 72.0)


def _place(fig: Figure, grid: GridSpec, margins: _Margins, pads: tuple[float, float], head: float) -> None:
    """Distribute the figure without the margins to columns and rows, in the ratios of their grid."""
    x, widths = _stretches(fig.bbox.width, margins.left + pads[0], margins.right + pads[0], grid.get_width_ratios())
    down, heights = _stretches(
        fig.bbox.height - head, margins.top + pads[1], margins.bottom + pads[1], grid.get_height_ratios()
    )
    for axes in fig.axes:
        place = axes.get_subplotspec()
        assert place is not None
        column, row = place.colspan.start, place.rowspan.start
        low = fig.bbox.height - head - down[row] - heights[row]
        box = Bbox.from_bounds(x[column], low, widths[column], heights[row])
        axes.set_position(box.transformed(fig.transFigure.inverted()))
        # A chart with a manual position leaves the layout; the engine of the figure must still place this one.
        axes.set_in_layout(True)


def _stretches(size: float, before: Array, after: Array, ratios: ArrayLike | None) -> tuple[Array, Array]:
    """Begins and lengths of consecutive cells between margins, with the total `size`."""
    share = np.ones(before.size) if ratios is None else np.asarray(ratios, dtype=np.float64)
    lengths = (size - (before + after).sum()) * share / share.sum()
    ends = np.cumsum(before + lengths + after)
    return ends - after - lengths, lengths
