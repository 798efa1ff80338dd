"""Charts of runs: cylinders, tip, energy, supply, several runs over each other, and a run beside a log."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple, TypedDict

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, check_known, unknown
from hydrocrane.plots.style import ACCENT, COLOURS, INK, MUTED, RC, figure, one_chart, shown, styled, title, write
from hydrocrane.results.energy import EnergyEntry, EnergyFlow, energy_flow

if TYPE_CHECKING:
    import xarray as xr

    from hydrocrane.files.columns import Columns
    from hydrocrane.results.comparison import Difference
    from hydrocrane.results.record import Record

# Values from which matplotlib writes a power of ten above an axis.
LARGE = 1e6

__all__ = ["cylinder_charts", "overview", "write"]


class Quantity(NamedTuple):
    """A chart of a cylinder: a signal, and optionally a second one as a dark thin line."""

    name: str
    heading: str
    axis: str
    thin: str = ""


def _quantities(run: Record, cylinder: str) -> list[Quantity]:
    """The charts of a cylinder."""
    number = run.cylinder_names.index(cylinder)
    joint, name = run.joint_names[number], f"cylinder.{cylinder}"
    turns = run.columns[f"joint.{joint}.q"].attrs.get("units") == "rad"
    of_joint = ("angle", "angular velocity") if turns else ("position", "velocity")
    return [
        Quantity(f"joint.{joint}.q", f"joint {joint}", of_joint[0]),
        Quantity(f"joint.{joint}.qd", f"rate of joint {joint}", of_joint[1]),
        Quantity(f"{name}.p1", "pressure p1, piston side", "pressure"),
        Quantity(f"{name}.p2", "pressure p2, rod side", "pressure"),
        Quantity(f"{name}.x", "piston position", "position"),
        Quantity(f"{name}.v", "piston velocity", "velocity"),
        Quantity(f"{name}.xs", "spool; command thin", "position", f"{name}.command"),
        Quantity(f"{name}.force", "net force on the rod; friction thin", "force", f"{name}.friction"),
    ]


@styled
def cylinder_charts(run: Record, cylinder: str) -> Figure:
    """Joint, pressures, piston, spool with its command, force with friction of one cylinder against time."""
    check_known("cylinder", cylinder, run.cylinder_names)
    check_recorded(run)
    fig, axes = figure(9.5, 9.6, nrows=4, ncols=2, sharex=True)
    colour = COLOURS[run.cylinder_names.index(cylinder) % len(COLOURS)]
    for panel, quantity in zip(axes.flat, _quantities(run, cylinder), strict=True):
        _curve(panel, run, quantity, colour, quantity.heading)
    for panel in axes[-1]:
        panel.set_xlabel("time [s]")
    title(fig, f"Cylinder {cylinder}", subject(run))
    return fig


@styled
def overview(run: Record) -> Figure:
    """The charts of all cylinders, one column each."""
    check_recorded(run)
    cylinders = run.cylinder_names
    fig, axes = figure(4.2 * max(len(cylinders), 1.6), 15.0, nrows=8, ncols=len(cylinders), sharex=True, squeeze=False)
    for column, cylinder in enumerate(cylinders):
        for row, quantity in enumerate(_quantities(run, cylinder)):
            heading = f"{cylinder}: {quantity.heading}" if row > 1 else quantity.heading
            _curve(axes[row, column], run, quantity, COLOURS[column % len(COLOURS)], heading, size=9.5)
        axes[-1, column].set_xlabel("time [s]")
    title(fig, "Cylinders", subject(run))
    return fig


def check_recorded(run: Record) -> None:
    if not run.columns.rows:
        raise InputError(f"this run recorded nothing to draw: {run.outcome.kind}, {run.outcome.message}")


def _curve(
    axes: Axes, run: Record, quantity: Quantity, colour: str, heading: str, size: float = RC["axes.titlesize"]
) -> None:
    variable = run.columns[quantity.name]
    unit, factor = shown(str(variable.attrs.get("units", "")))
    values = variable.values * factor
    axes.plot(run.columns.time, values, color=colour)
    if quantity.thin:
        thin = run.columns[quantity.thin].values * factor
        axes.plot(run.columns.time, thin, color=INK, lw=0.8)
        values = np.concatenate([values, thin])
    # A heading must move above a power of ten; to detect this costs a fifth of the drawing time.
    axes.set_title(heading, fontsize=size, y=1.0 if np.abs(values).max() < LARGE else None)
    axes.set_ylabel(f"{quantity.axis} [{unit}]")
    axes.margins(x=0)
    mark_payload_changes(axes, run)
    _keep_flat(axes, values)
    if values.min() < 0 < values.max():
        axes.axhline(0.0, color=MUTED, lw=0.7, zorder=1)


def _keep_flat(axes: Axes, values: Array) -> None:
    """Prevents that the rounding errors of a constant fill the height of the chart."""
    middle, spread = 0.5 * (values.max() + values.min()), values.max() - values.min()
    least = 1e-2 * max(abs(middle), 1.0)
    if spread < least:
        axes.set_ylim(middle - least, middle + least)


def subject(run: Record) -> str:
    about = run.columns.attrs
    return f"{about['scenario']} on {about['machine']}"


@styled
def comparison_charts(differences: Sequence[Difference]) -> Figure:
    """One chart per quantity: the log as a dark thin line, the run over it, and the size of the difference."""
    return over_logs(differences, "run", largest=True, sharex=True)


def over_logs(
    differences: Sequence[Difference],
    label: str,
    *,
    largest: bool = False,
    sharex: bool = False,
    held_out: Sequence[Array] = (),
) -> Figure:
    """One chart per quantity, a run called `label` over its log; the times `held_out` of each are shaded."""
    columns = 1 if len(differences) == 1 else 2
    rows = -(-len(differences) // columns)
    fig, axes = figure(5.0 * columns, 2.4 * rows + 0.7, nrows=rows, ncols=columns, sharex=sharex, squeeze=False)
    for i, (panel, d) in enumerate(zip(axes.flat, differences, strict=False)):
        unit, factor = shown(d.unit)
        panel.plot(d.time, d.log * factor, color=INK, lw=1.0, label="log")
        panel.plot(d.time, d.run * factor, color=COLOURS[1], lw=1.6, alpha=0.9, label=label)
        if held_out and held_out[i].size:
            panel.axvspan(held_out[i][0], held_out[i][-1], color=INK, alpha=0.08, lw=0, label="held out")
        size = f", largest {d.maximum * factor:.3g}" if largest else ""
        panel.set_title(f"{d.name}   rms {d.rms * factor:.3g}{size} {unit}", fontsize=9)
        panel.set_ylabel(f"[{unit}]")
        panel.margins(x=0)
    for panel in axes.flat[len(differences) :]:
        panel.set_visible(False)
    for panel in axes[-1]:
        panel.set_xlabel("time [s]")
    axes.flat[0].legend(loc="best")
    title(fig, f"{label.capitalize()} and log")
    return fig


# Smaller shares of the total are left out, because they would be printed as zero.
LEAST = 1e-6


@styled
def energy_chart(run: Record) -> Figure:
    """Bars of all energy sources and below them of all sinks, in kJ and as shares of the total input.

    Losses are those of the ledger, each with its name and in the colour of its cylinder. Elastic energy in the oil,
    transported and stored, is one bar. A crane that moves down is a source.

    Raises
    ------
    InputError
        If the run recorded no ledger.
    """
    flow = energy_flow(run)
    owners = {name: COLOURS[i % len(COLOURS)] for i, name in enumerate(run.cylinder_names)} | {"": MUTED}
    given, taken = (
        [entry for entry in entries if entry.total >= LEAST * flow.total] for entries in (flow.given, flow.taken)
    )
    fig, axes = one_chart(9.5, 1.6 + 0.32 * (len(given) + len(taken) + 1))
    places = _bars(axes, given, 0.0, owners, flow)
    places |= _bars(axes, taken, max(places) + 1.8, owners, flow)
    axes.set(yticks=list(places), yticklabels=list(places.values()), xlabel="energy [kJ]")
    axes.set_xlim(0.0, 1.22 * 1e-3 * flow.total)
    axes.set_ylim(max(places) + 0.7, -0.9)
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)
    named = [Patch(color=colour, label=name or "whole machine") for name, colour in owners.items()]
    axes.legend(handles=named, loc="lower right")
    title(fig, "Energy", subject(run))
    sums = f"given {_energy(flow.total)}, taken {_energy(flow.total - flow.gap)}"
    axes.set_title(f"{sums}; the ledger closes to {flow.residual:.1e} J", fontsize=9, fontweight="normal")
    return fig


def _bars(
    axes: Axes, entries: list[EnergyEntry], start: float, owners: dict[str, str], flow: EnergyFlow
) -> dict[float, str]:
    """Draw the entries from `start` downwards; their heights and names."""
    for i, entry in enumerate(entries):
        # A part of opposite sign begins left of zero, so that the bar ends at the total.
        end = 1e-3 * sum(part for part in entry.parts.values() if part < 0.0)
        for owner, colour in owners.items():
            part = 1e-3 * max(entry.parts.get(owner, 0.0), 0.0)
            axes.barh(start + i, part, left=end, height=0.72, color=colour)
            end += part
        words = f" {_energy(entry.total)}   {100 * entry.total / flow.total:.3g} %"
        axes.text(end, start + i, words, va="center", fontsize=8.5, color=INK)
    return {start + i: entry.name for i, entry in enumerate(entries)}


def _energy(joule: float) -> str:
    return f"{1e-3 * joule:.4g} kJ" if abs(joule) >= 100.0 else f"{joule:.3g} J"


# Charts below the path, each against time if the run has it: variable, heading.
PANELS = (
    ("tip.deviation", "distance from the path of the set-point"),
    ("payload", "payload"),
    ("supply.power", "power drawn from the pump"),
)


@styled
def tip_charts(run: Record) -> Figure:
    """Path of the tip, in space also from above, and of its set-point; deviation, payload, pump power against time."""
    data = run.columns
    if data.rows < 2:
        raise InputError(f"this run recorded no motion to draw: {run.outcome.kind}, {run.outcome.message}")
    rows = [(name, heading) for name, heading in PANELS if name in data]
    # From the side, and of a machine in space from above.
    views = [("x", "z"), ("x", "y")] if "tip.y" in data else [("x", "z")]
    heights = [2.4] * len(views) + [1.0] * len(rows)
    fig, axes = figure(7.5, 4.0 * len(views) + 1.7 * len(rows), nrows=len(heights), height_ratios=heights)
    for panel, view in zip(axes, views, strict=False):
        _path(panel, run, view)
    for panel, (name, heading) in zip(axes[len(views) :], rows, strict=True):
        unit, factor = shown(str(data[name].attrs["units"]))
        drawstyle = "steps-pre" if name == "payload" else "default"
        panel.plot(data.time, data[name].values * factor, color=COLOURS[0], drawstyle=drawstyle)
        panel.set_title(heading, fontsize=9.5)
        panel.set_ylabel(f"[{unit}]")
        panel.margins(x=0)
        panel.sharex(axes[len(views)])
        mark_payload_changes(panel, run)
    axes[-1].set_xlabel("time [s]")
    title(fig, "Crane tip", f"{data.attrs['scenario']} on {data.attrs['machine']}")
    return fig


def mark_payload_changes(axes: Axes, run: Record) -> None:
    """A line at each time at which a load is picked up or released."""
    for change in run.payload_changes:
        axes.axvline(change.time, color=ACCENT if change.after > change.before else MUTED, lw=0.9, ls=":", zorder=1.5)


def _path(axes: Axes, run: Record, view: tuple[str, str]) -> None:
    data = run.columns
    time, x, z = (data[name].values for name in ("time", *(f"tip.{axis}" for axis in view)))
    wanted = [f"set_point.{axis}" for axis in view]
    if wanted[0] in data:
        axes.plot(*(data[name].values for name in wanted), color=INK, lw=0.8, label="set-point")
    axes.plot(x, z, color=COLOURS[0], lw=1.2, label="tip")
    axes.plot(x[0], z[0], marker="o", ms=4, color=INK, ls="none", label="start")
    for change in run.payload_changes:
        load = change.after - change.before
        word, colour = ("picks up", ACCENT) if load > 0 else ("releases", MUTED)
        place = [np.interp(change.time, time, column) for column in (x, z)]
        axes.plot(*place, marker="v", ms=7, color=colour, ls="none", label=f"{word} {abs(load):g} kg")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"{view[0]} [m]")
    axes.set_ylabel(f"{view[1]} [m]")
    axes.legend(loc="best")


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
