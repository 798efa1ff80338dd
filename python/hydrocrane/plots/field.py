"""A quantity over the workspace, as coloured cells."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh

from hydrocrane.arrays import Array
from hydrocrane.plots.style import FIELD


def cells(axes: Axes, tip: Array, value: Array, *, largest: bool, size: int) -> QuadMesh:
    """Colour square cells of the plane by the largest (or smallest) value of the poses whose tip lies in each.

    Parameters
    ----------
    tip, value : (m, 2), (m,) arrays
        NaN values are left out.
    size : int
        Number of cells along the longer side.
    """
    good = np.isfinite(value)
    tip, value = tip[good], value[good]
    low, high = tip.min(axis=0), tip.max(axis=0)
    step = max((high - low).max() / size, 1e-6)
    count = np.maximum(np.ceil((high - low) / step).astype(int), 1)
    place = np.minimum(((tip - low) / step).astype(int), count - 1)
    table = np.full(count, -np.inf if largest else np.inf)
    (np.maximum if largest else np.minimum).at(table, (place[:, 0], place[:, 1]), value)
    table = _close_gaps(np.where(np.isfinite(table), table, np.nan))
    edges = [low[i] + step * np.arange(count[i] + 1) for i in (0, 1)]
    return axes.pcolormesh(*edges, np.ma.masked_invalid(table.T), cmap=FIELD, zorder=1)


def _close_gaps(table: Array, rounds: int = 3) -> Array:
    """Give cells between sampled ones, which no pose happened to hit, the mean of their neighbours.

    Only cells with at least five of eight neighbours known are filled, so that the outline does not grow.
    """
    for _ in range(rounds):
        padded = np.pad(table, 1, constant_values=np.nan)
        rows, columns = table.shape
        around = np.stack(
            [padded[i : i + rows, j : j + columns] for i in range(3) for j in range(3) if (i, j) != (1, 1)]
        )
        known = np.isfinite(around).sum(axis=0)
        mean = np.nansum(around, axis=0) / np.maximum(known, 1)
        table = np.where(np.isnan(table) & (known >= 5), mean, table)
    return table
