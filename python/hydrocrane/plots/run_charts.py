"""The charts of a run by their names."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from hydrocrane.errors import unknown
from hydrocrane.plots.charts import cylinder_charts, overview
from hydrocrane.plots.energy import energy_chart
from hydrocrane.plots.supply import supply_charts
from hydrocrane.plots.tip_path import tip_charts

if TYPE_CHECKING:
    from hydrocrane.results.record import Record

BY_NAME: dict[str, Callable[[Record], Figure]] = {
    "cylinders": overview,
    "tip": tip_charts,
    "energy": energy_chart,
    "supply": supply_charts,
}


def of_run(run: Record, chart: str | None = None) -> Figure:
    """The chart of a run by its name, ``cylinders``, ``tip``, ``energy`` or ``supply``, or those of a cylinder by its
    name.

    Raises
    ------
    InputError
        If there is no such chart, or nothing was recorded for it.
    """
    if chart is None:
        return overview(run)
    if chart in run.cylinder_names:
        return cylinder_charts(run, chart)
    if chart not in BY_NAME:
        raise unknown("cylinder or chart", chart, [*run.cylinder_names, *BY_NAME])
    return BY_NAME[chart](run)
