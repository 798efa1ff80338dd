"""A quantity over the workspace, as patches of a grid of poses in the plane of the tip."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection

from hydrocrane.arrays import Array
from hydrocrane.plots.style import FIELD, GRID, MUTED


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
