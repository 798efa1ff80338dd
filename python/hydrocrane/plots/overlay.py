"""Several runs in one picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, TypedDict

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrocrane.errors import InputError, unknown
from hydrocrane.plots.style import COLOURS, figure, shown, styled

if TYPE_CHECKING:
    import xarray as xr

    from hydrocrane.results.record import Record

# Colours repeat after six runs; dashes then distinguish them.
DASHES = ("-", "--", ":")


@styled
def overlay(
    runs: Mapping[str, Record],
    signals: str | Sequence[str],
    *,
    against: str = "time",
    relative_to: str | None = None,
    span: tuple[float, float] | None = None,
) -> Figure:
    """One panel per signal, with one line per run.

    Parameters
    ----------
    runs : mapping
        Label to run.
    signals : str or sequence of str
        Variables of ``run.data``, such as ``cylinder.lift.friction``.
    against : str
        Abscissa: ``time``, or a signal, such as the piston position for a friction loop.
    relative_to : str, optional
        Label of the run that is subtracted from the others at equal times.
    span : (float, float), optional
        Only this stretch of time, s.
    """
    names = [signals] if isinstance(signals, str) else list(signals)
    _check(runs, names, against, relative_to)
    records = {label: _stretch(label, run, span) for label, run in runs.items()}
    base = None if relative_to is None else records.pop(relative_to)
    looks = {label: _look(i) for i, label in enumerate(runs)}
    first = next(iter(records.values()))
    fig, axes = figure(9.5, 2.3 * len(names) + 0.7, nrows=len(names), sharex=True, squeeze=False)
    for panel, name in zip(axes[:, 0], names, strict=True):
        for label, data in records.items():
            _line(panel, data, base, name, against, {"label": label, **looks[label]})
        meaning = str(first[name].attrs.get("long_name", ""))
        heading = f"{name}: {meaning}" if meaning else name
        panel.set(
            title=heading if relative_to is None else f"{heading}, less that of {relative_to}",
            ylabel=f"[{_scale(first, name)[0]}]",
        )
        panel.margins(x=0.01)
    fig.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=min(len(records), 5))
    axes[-1, 0].set_xlabel(f"{against} [{_scale(first, against)[0]}]")
    return fig


class Look(TypedDict, total=False):
    """Colour and dashes of a line."""

    color: str
    ls: str | tuple[int, tuple[int, ...]]
    lw: float
    label: str


def _look(number: int) -> Look:
    """Colour and dashes of the run with this number."""
    return {"color": COLOURS[number % len(COLOURS)], "ls": DASHES[number // len(COLOURS) % len(DASHES)], "lw": 1.2}


def _check(runs: Mapping[str, Record], names: Sequence[str], against: str, relative_to: str | None) -> None:
    if not isinstance(runs, Mapping):
        raise InputError(f'runs must be a mapping from label to run, {{"label": run}}; got {type(runs).__name__}')
    if relative_to is not None and relative_to not in runs:
        raise unknown("run", relative_to, list(runs))
    if len(runs) < (1 if relative_to is None else 2):
        raise InputError("there is no run to draw: give a mapping from label to run")
    if not names:
        raise InputError("there is nothing to draw: name a signal, such as tip.z")
    for label, run in runs.items():
        for name in [*names, against]:
            if name not in run.data.variables:
                raise unknown(f"signal of run `{label}`", name, [str(known) for known in run.data.variables])


def _stretch(label: str, run: Record, span: tuple[float, float] | None) -> xr.Dataset:
    """The record of a run within `span`."""
    if not run.data.sizes["time"]:
        raise InputError(f"run `{label}` recorded nothing to draw: {run.outcome.kind}, {run.outcome.message}")
    data = run.data if span is None else run.data.sel(time=slice(*span))
    if span is not None and not data.sizes["time"]:
        raise InputError(f"run `{label}` recorded nothing between {span[0]:g} and {span[1]:g} s")
    return data


def _line(panel: Axes, data: xr.Dataset, base: xr.Dataset | None, name: str, against: str, look: Look) -> None:
    values = data[name].values
    if base is not None:
        values = values - np.interp(data.time.values, base.time.values, base[name].values)
    panel.plot(data[against].values * _scale(data, against)[1], values * _scale(data, name)[1], **look)


def _scale(data: xr.Dataset, name: str) -> tuple[str, float]:
    """Unit of a signal on pictures, and the factor to it."""
    return shown(str(data[name].attrs.get("units", "")))
