"""Pictures of sweeps and of sensitivities."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure

from hydrocrane.errors import InputError, check_known, unknown
from hydrocrane.plots.style import ACCENT, COLOURS, FIELD, MUTED, figure, one_chart, shown, styled, title

if TYPE_CHECKING:
    import xarray as xr

    from hydrocrane.analysis.sensitivity import Sensitivities

# Most keys of a picture.
MOST_KEYS = 6


@styled
def sweep(data: xr.Dataset, measure: str) -> Figure:
    """Draw a figure of a study: a line over one key, a field over two, points over each key of drawn cases.

    Parameters
    ----------
    data : xarray.Dataset
        Result of :func:`hydrocrane.sweep`; for a grid with more than two keys, a part of it: ``data.sel(...)``.
    measure : str
        One of its figures. Cases that ended early have none and are marked.
    """
    values = _checked(data, measure)
    if values.dims == ("case",):
        fig = _points(data, values)
    elif values.ndim == 1:
        fig = _line(data, values)
    else:
        fig = _field(data, values)
    failed = int(np.isnan(values.values).sum())
    title(fig, str(data.attrs.get("title", "Study")), f"{failed} of {values.size} without a figure" if failed else "")
    return fig


def _checked(data: xr.Dataset, measure: str) -> xr.DataArray:
    known = [str(name) for name, entry in data.items() if entry.dtype.kind == "f" and "time" not in entry.dims]
    check_known("figure of the study", measure, known)
    values = data[measure].squeeze(drop=True)
    if values.ndim == 0:
        raise InputError("a study of one case has nothing to draw")
    if values.ndim > 2:
        extra = ", ".join(str(dim) for dim in values.dims[2:])
        raise InputError(f"a picture has room for two keys; choose values of {extra} with data.sel(...)")
    return values


def _line(data: xr.Dataset, values: xr.DataArray) -> Figure:
    key = str(values.dims[0])
    places, labels, heading = _axis(data[key])
    unit, factor = shown(str(values.attrs.get("units", "")))
    fig, axes = one_chart(8.0, 4.5)
    order = np.argsort(places)
    axes.plot(places[order], values.values[order] * factor, "o-" if labels is None else "o", ms=4)
    _mark_failed(axes, places[np.isnan(values.values)])
    _label(axes.xaxis, places, labels, heading)
    axes.set_ylabel(_named(str(values.name), unit))
    return fig


def _field(data: xr.Dataset, values: xr.DataArray) -> Figure:
    down, across = (str(dim) for dim in values.dims)
    (y, y_labels, y_heading), (x, x_labels, x_heading) = _axis(data[down]), _axis(data[across])
    unit, factor = shown(str(values.attrs.get("units", "")))
    fig, axes = one_chart(8.0, 5.5)
    order = np.ix_(np.argsort(y), np.argsort(x))
    table = values.values[order] * factor
    mesh = axes.pcolormesh(np.sort(x), np.sort(y), table, cmap=FIELD, shading="nearest")
    fig.colorbar(mesh, label=_named(str(values.name), unit))
    rows, columns = np.nonzero(np.isnan(table))
    axes.plot(np.sort(x)[columns], np.sort(y)[rows], "x", color=ACCENT, ms=6)
    axes.grid(visible=False)
    _label(axes.xaxis, x, x_labels, x_heading)
    _label(axes.yaxis, y, y_labels, y_heading)
    return fig


def _points(data: xr.Dataset, values: xr.DataArray) -> Figure:
    # In the order of the study.
    keys = list(json.loads(data.attrs["study"])["keys"])[:MOST_KEYS]
    unit, factor = shown(str(values.attrs.get("units", "")))
    fig, panels = figure(3.6 * len(keys) + 1.0, 4.0, ncols=len(keys), sharey=True, squeeze=False)
    for axes, key in zip(panels[0], keys, strict=True):
        places, labels, heading = _axis(data[key])
        axes.plot(places, values.values * factor, "o", ms=3, alpha=0.6, color=COLOURS[0])
        _mark_failed(axes, places[np.isnan(values.values)])
        _label(axes.xaxis, places, labels, heading)
    panels[0][0].set_ylabel(_named(str(values.name), unit))
    return fig


def _axis(key: xr.DataArray) -> tuple[np.ndarray, list[str] | None, str]:
    """Positions along an axis, labels if they are words, and the heading."""
    if key.dtype.kind == "f":
        unit, factor = shown(str(key.attrs.get("units", "")))
        return key.values * factor, None, _named(str(key.name), unit)
    words, places = np.unique(key.values.astype(str), return_inverse=True)
    return places.astype(float), [str(word) for word in words], str(key.name)


def _label(axis: Axis, places: np.ndarray, labels: list[str] | None, heading: str) -> None:
    if labels is not None:
        axis.set_ticks(range(len(labels)), labels)
    elif places.size <= 8:
        axis.set_ticks(np.unique(places))
    axis.set_label_text(heading)


def _named(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit not in ("", "1") else name


def _mark_failed(axes: Axes, places: np.ndarray) -> None:
    """Crosses on the lower edge for cases without a figure."""
    if places.size:
        low = axes.get_xaxis_transform()
        axes.plot(places, np.zeros(places.size), "x", color=ACCENT, transform=low, clip_on=False, label="no figure")
        axes.legend()


@styled
def ranking(slopes: Sensitivities, signals: str | Sequence[str], *, most: int = 12) -> Figure:
    """Parameters in the order of their effect on a signal: root mean square over the run, and the largest value.

    Parameters
    ----------
    slopes : Sensitivities
        Relative ones, ``sensitivities(..., relative=True)``, because only these are comparable.
    signals : str or sequence of str
        One signal, or the components of one vector, such as ``tip.x`` and ``tip.z``; its length then counts.
    most : int
        Number of parameters to show.
    """
    names = [signals] if isinstance(signals, str) else list(signals)
    _check(slopes, names, most)
    size = np.sqrt(sum(slopes.data[name].values ** 2 for name in names))
    mean, largest = np.sqrt((size**2).mean(axis=0)), size.max(axis=0)
    order = np.argsort(-mean)[:most]
    unit, factor = shown(str(slopes.data[names[0]].attrs["units"]))
    fig, axes = one_chart(9.5, 0.32 * order.size + 1.4)
    axes.barh(np.arange(order.size), mean[order] * factor, color=COLOURS[0], label="root mean square over the run")
    axes.plot(largest[order] * factor, np.arange(order.size), "|", color=MUTED, ms=11, mew=2, label="largest")
    axes.set_yticks(np.arange(order.size), [str(slopes.data.parameter.values[i]) for i in order])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set_xlabel(f"change for 100 % of the parameter [{unit}]")
    axes.legend(loc="lower right")
    title(fig, "What matters", f"{' and '.join(names)}, {order.size} of {mean.size} parameters")
    return fig


def _check(slopes: Sensitivities, names: Sequence[str], most: int) -> None:
    if not slopes.relative:
        raise InputError("a ranking needs relative sensitivities: sensitivities(..., relative=True)")
    if not names or most < 1:
        raise InputError("a ranking needs at least one signal, and `most` at least 1")
    for name in names:
        if name not in slopes.data.data_vars:
            raise unknown("signal", name, [str(known) for known in slopes.data.data_vars])
    if len({slopes.data[name].attrs["units"] for name in names}) > 1:
        raise InputError(f"{', '.join(names)} have different units; rank them one by one")
    if not slopes.data.sizes["time"]:
        raise InputError(f"this run recorded nothing to rank: {slopes.outcome.kind}, {slopes.outcome.message}")
