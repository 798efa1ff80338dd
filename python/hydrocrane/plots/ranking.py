"""Ranking of parameters by their effect on a signal of a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from hydrocrane.errors import InputError, unknown
from hydrocrane.plots.style import COLOURS, MUTED, one_chart, shown, styled, title

if TYPE_CHECKING:
    from hydrocrane.analysis.sensitivity import Sensitivities


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
