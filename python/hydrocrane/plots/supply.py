"""Supply and demand of flow: pump and valves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrocrane.plots.charts import check_recorded, subject
from hydrocrane.plots.style import ACCENT, COLOURS, MUTED, figure, shown, styled, title

if TYPE_CHECKING:
    from hydrocrane.files.columns import Columns
    from hydrocrane.results.record import Record

PRESSURES = {
    "mains.setting": "what the pump is set to",
    "mains.p": "mains",
    "mains.load": "load-sensing line",
}
RETURN = {"tank_line.p": "tank line", "tank_line.filter_drop": "of it over the filter"}
FLOWS = {
    "mains.pump_flow": "pump",
    "supply.flow": "valves",
    "mains.relief_flow": "relief valve",
    "tank_line.flow": "tank line",
}
POWERS = {"mains.shaft_power": "shaft of the pump", "supply.power": "valves"}


@styled
def supply_charts(run: Record) -> Figure:
    """Pressures, return pressure, flows, power, displacement and compensators against time, if the machine has them.

    The chart of the pressures is shaded while the pump cannot deliver the demand.
    """
    check_recorded(run)
    columns = run.columns
    panels = [panel for panel in _panels(run) if any(name in columns for name in panel[2])]
    fig, axes = figure(9.5, 1.9 * len(panels) + 1.0, nrows=len(panels), sharex=True, squeeze=False)
    for panel, (heading, quantity, names) in zip(axes[:, 0], panels, strict=True):
        _draw(panel, columns, names)
        panel.set_title(heading)
        panel.set_ylabel(f"{quantity} [{_unit(columns, names)}]")
        panel.margins(x=0)
        if len(panel.lines) > 1:
            panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    _shade(axes[0, 0], columns)
    axes[-1, 0].set_xlabel("time [s]")
    title(fig, "Supply", subject(run))
    return fig


def _panels(run: Record) -> list[tuple[str, str, dict[str, str]]]:
    """Heading, quantity, and signals with their names."""
    names = _swivels(run.columns)
    swivels = {name: name.split(".")[1] if len(names) > 1 else "" for name in names}
    drops = {f"cylinder.{c}.compensator_drop": c for c in run.cylinder_names}
    return [
        ("Pressures", "pressure", PRESSURES),
        ("Return pressure", "pressure", RETURN),
        ("Flows", "flow", FLOWS),
        ("Power", "power", POWERS),
        ("Displacement of the pump in use", "share", swivels),
        ("Shortfall: above zero the pump cannot deliver the demand", "pressure", {"mains.shortfall": ""}),
        ("What the compensators take", "pressure", drops),
    ]


def _swivels(columns: Columns) -> list[str]:
    """The shares of the displacements of all pumps."""
    return [name for name in columns if name.startswith("pump.") and name.endswith(".displacement")]


def _draw(panel: Axes, columns: Columns, names: dict[str, str]) -> None:
    for i, (name, label) in enumerate(names.items()):
        if name in columns:
            colour = MUTED if name == "mains.setting" else COLOURS[i % len(COLOURS)]
            _, factor = shown(str(columns[name].attrs["units"]))
            panel.plot(columns.time, columns[name].values * factor, color=colour, label=label)


def _unit(columns: Columns, names: dict[str, str]) -> str:
    return next(shown(str(columns[name].attrs["units"]))[0] for name in names if name in columns)


def _shade(panel: Axes, columns: Columns) -> None:
    """Shade the times at which the pump cannot deliver the demand: the pressure is a fifth too low, or too low at full
    displacement."""
    if "mains.shortfall" not in columns:
        return
    lack, setting = columns["mains.shortfall"].values, columns["mains.setting"].values
    swivels = [columns[name].values for name in _swivels(columns)]
    full = np.all([share >= 0.99 for share in swivels], axis=0)
    lacks = (lack > 0.2 * setting) | (full & (lack > 0.01 * setting))
    low, high = panel.get_ylim()
    panel.fill_between(columns.time, low, high, where=np.asarray(lacks), color=ACCENT, alpha=0.12, lw=0)
    panel.set_ylim(low, high)
