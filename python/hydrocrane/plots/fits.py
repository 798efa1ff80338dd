"""Pictures of fits and of what is identified from logs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrocrane.errors import InputError
from hydrocrane.plots.runs import over_logs
from hydrocrane.plots.style import ACCENT, COLOURS, INK, MUTED, figure, shown, styled, title
from hydrocrane.signals.friction import steady_friction

if TYPE_CHECKING:
    from hydrocrane.identification.bristles.fit import DynamicFit
    from hydrocrane.identification.static.comparison import FrictionComparison
    from hydrocrane.identification.static.points import FrictionPoints
    from hydrocrane.identification.static.residuals import ResidualAnalysis
    from hydrocrane.identification.static.result import StaticFit
    from hydrocrane.identification.values.result import Fit
    from hydrocrane.signals.windows import SteadyWindows

SIDES = (("extending", 1.0), ("retracting", -1.0))
# Break-away readings have no speed; on a logarithmic axis they are drawn at the slowest level over this factor.
BREAKAWAY_SHARE = 0.6


@styled
def static_fit(fit: StaticFit) -> Figure:
    """Three charts: the map over velocity; its magnitude over the logarithm of speed, which shows the Stribeck effect;
    the residuals. Bands are 95 % of the map; crosses are points that were left out."""
    fig, axes = figure(12.0, 6.6, nrows=2, ncols=2, width_ratios=[1.15, 1.0], height_ratios=[1.6, 1.0])
    axes[1, 0].remove()
    whole = fig.add_subplot(axes[1, 0].get_gridspec()[:, 0])
    axes[0, 0].remove()
    for side, (name, sign) in enumerate(SIDES):
        here = fit.points.direction == side
        points = fit.points.select(here)
        if not len(points):
            continue
        used = fit.accepted[here]
        speed = _speeds(points)
        colour = COLOURS[side]
        force, band = fit.force(sign * speed), _band(fit, sign * speed)
        for axes_, v, turn in ((whole, sign * speed * 1e3, 1.0), (axes[0, 1], speed * 1e3, sign)):
            axes_.plot(v, turn * force, color=colour, label=name)
            axes_.fill_between(v, *(turn * band), color=colour, alpha=0.2, lw=0)
        shift = points.force - fit.of_sensors[here]
        _dots(whole, points.velocity * 1e3, shift, used, colour)
        _dots(axes[0, 1], _shown_speed(points) * 1e3, shift * sign, used, colour)
        left = fit.residuals[here]
        _dots(axes[1, 1], _shown_speed(points) * 1e3, left * sign, used, colour)
    _finish(fig, whole, axes[0, 1], axes[1, 1])
    how = {"least-squares": "least squares", "graphical": "read by ruler"}.get(fit.method, fit.method)
    title(fig, "Static friction", f"{int(fit.accepted.sum())} of {len(fit.points)} points, {how}")
    return fig


def _finish(fig: Figure, whole: Axes, stribeck: Axes, left: Axes) -> None:
    for axes in (whole, left):
        axes.axhline(0.0, color=MUTED, lw=0.7, zorder=1)
    whole.axvline(0.0, color=MUTED, lw=0.7, zorder=1)
    whole.set(xlabel="piston velocity [mm/s]", ylabel="friction [N]", title="map")
    whole.legend(loc="upper left")
    stribeck.set(xscale="log", ylabel="magnitude [N]", title="Stribeck effect")
    left.set(xscale="log", xlabel="speed [mm/s]", ylabel="measured - fitted [N]", title="residuals")
    left.sharex(stribeck)


def _speeds(points: FrictionPoints) -> np.ndarray:
    """Speeds for a smooth curve over the measured range, m/s."""
    moving = points.speed[points.speed > 0.0]
    return np.geomspace(0.8 * moving.min(), 1.05 * moving.max(), 400) if moving.size else np.array([1e-5, 1e-4])


def _shown_speed(points: FrictionPoints) -> np.ndarray:
    moving = points.speed[points.speed > 0.0]
    least = moving.min() if moving.size else 1e-4
    return np.where(points.speed > 0.0, points.speed, BREAKAWAY_SHARE * least)


def _band(fit: StaticFit, v: np.ndarray) -> np.ndarray:
    """Both ends (2, n) of the 95 % band of the map, N; its force where they are unknown."""
    force = fit.force(v)
    ends = np.stack([force, force]) if fit.spread is None else fit.force_interval(v).T
    return np.where(np.isfinite(ends), ends, force)


def _dots(axes: Axes, x: np.ndarray, y: np.ndarray, used: np.ndarray, colour: str) -> None:
    axes.plot(x[used], y[used], "o", color=colour, ms=3.5, alpha=0.7, mec="none")
    axes.plot(x[~used], y[~used], "x", color=ACCENT, ms=6, mew=1.4)


@styled
def friction_comparison(found: FrictionComparison) -> Figure:
    """Maps of the groups over the logarithm of speed, and each group's difference from the first, per direction."""
    fig, axes = figure(12.0, 6.8, nrows=2, ncols=2, sharex="col", height_ratios=[1.4, 1.0])
    for side, (name, sign) in enumerate(SIDES):
        curves, gaps = axes[0, side], axes[1, side]
        for (label, fit), colour in zip(found.fits.items(), _colours(found), strict=True):
            points = fit.points.select(fit.points.direction == side)
            if not len(points):
                continue
            used = fit.accepted[fit.points.direction == side]
            curves.plot(_speeds(points) * 1e3, np.abs(fit.force(sign * _speeds(points))), color=colour, label=label)
            _dots(curves, _shown_speed(points) * 1e3, points.force * sign, used, colour)
        _gaps(gaps, found, sign)
        curves.set(xscale="log", title=name, ylabel="magnitude [N]")
        gaps.set(xlabel="speed [mm/s]", ylabel="difference [%]")
    axes[0, 0].legend(loc="best")
    title(fig, "Friction of the groups", f"{found.conclusion.replace('-', ' ')}, p = {found.p_value:.2g}")
    return fig


def _colours(found: FrictionComparison) -> list[str]:
    return [COLOURS[i % len(COLOURS)] for i in range(len(found.fits))]


def _gaps(axes: Axes, found: FrictionComparison, sign: float) -> None:
    """Differences with their intervals, and the margin below which they do not matter."""
    margin = 100 * found.margin
    axes.axhspan(-margin, margin, color=COLOURS[3], alpha=0.12, lw=0)
    axes.axhline(0.0, color=MUTED, lw=0.7)
    for difference, colour in zip(found.differences, _colours(found)[1:], strict=True):
        here = np.sign(difference.velocity) == sign
        low, high = difference.interval(1.0 - found.significance)
        share = 100 / difference.reference_force[here]
        middle = difference.force[here] * share
        reach = np.abs([middle - low[here] * share, high[here] * share - middle])
        axes.errorbar(
            np.abs(difference.velocity[here]) * 1e3, middle, reach, fmt="o", color=colour, ms=4, capsize=2, lw=1.2
        )


# x, p1, p2.
UNITS = ("m", "Pa", "Pa")
NAMES = ("position", "pressure", "pressure")


@styled
def dynamic_fit(fit: DynamicFit) -> Figure:
    """A column per log: position, both pressures, and the residuals of each in standard deviations."""
    if fit.rig_residuals is None or fit.estimate is None:
        raise InputError("there is no fit to draw, only initial estimates: " + "; ".join(fit.warnings))
    models = fit.rig_residuals.models
    fig, axes = figure(5.5 * len(models) + 1.0, 7.6, nrows=3, ncols=len(models), sharex="col", squeeze=False)
    for k, model in enumerate(models):
        found = fit.predicted(k)
        for i, (name, colour) in enumerate(zip(("x", "p1", "p2"), COLOURS, strict=False)):
            row = axes[min(i, 1), k]
            unit, factor = shown(UNITS[i])
            row.plot(model.time, model.measured[:, i] * factor, ".", color=colour, ms=3, alpha=0.5, label=f"{name} log")
            row.plot(model.time, found[:, i] * factor, color=colour, lw=1.1, label=f"{name} fitted")
            row.set(ylabel=f"{NAMES[i]} [{unit}]")
            left = model.weighted(found - model.measured)[i]
            axes[2, k].plot(model.time[model.counted], left, ".", color=colour, ms=3, alpha=0.6, label=name)
        axes[0, k].set(title=model.source or f"log {k + 1}")
        axes[2, k].axhline(0.0, color=MUTED, lw=0.7)
        for edge in (-1.96, 1.96):
            axes[2, k].axhline(edge, color=ACCENT, lw=0.7, ls="--")
        axes[2, k].set(xlabel="time [s]", ylabel="residual [standard deviations]")
    for row in axes[:, 0]:
        row.legend(loc="best")
    values = ", ".join(f"{name} {value:.4g}" for name, value in fit.params.items())
    title(fig, "Bristles", f"{values}; residuals {np.sqrt(fit.estimate.variance):.2f} times the stated noise")
    return fig


# Factor and label of each axis.
AXES = {
    "velocity": (1e3, "speed [mm/s]"),
    "position": (1e3, "position [mm]"),
    "time": (1.0, "time in the log [s]"),
    "pressure": (1e-3, "force of both chambers [kN]"),
    "load": (1.0, "load [kg]"),
}


@styled
def residual_causes(analysis: ResidualAnalysis) -> Figure:
    """One chart per cause: points by direction and the fitted dependence, red if it is significant."""
    fig, axes = figure(12.0, 3.2, ncols=len(analysis.causes), sharey=True, squeeze=False)
    for chart, cause in zip(axes[0], analysis.causes, strict=True):
        factor, label = AXES[cause.name]
        for side, name in enumerate(("extending", "retracting")):
            here = analysis.direction == side
            x = cause.values[here] * factor
            chart.plot(
                x, 100 * analysis.shares[here], "o", ms=3.5, mec="none", alpha=0.7, color=COLOURS[side], label=name
            )
            order = np.argsort(x)
            colour = ACCENT if cause.shows else INK
            chart.plot(x[order], 100 * cause.fitted[here][order], color=colour, lw=1.0)
        chart.axhline(0.0, color=MUTED, lw=0.7, zorder=1)
        chart.set(xlabel=label, title=cause.name, xscale="log" if cause.name == "velocity" else "linear")
    axes[0, 0].set_ylabel("measured - fitted [%]")
    axes[0, 0].legend(loc="best")
    title(fig, "Residuals", "lines: fitted dependences, red if significant")
    return fig


@styled
def steady_windows_chart(found: SteadyWindows) -> Figure:
    """Position, pressures, friction over time with accepted (green) and rejected stretches; friction over velocity."""
    fig = plt.figure(figsize=(11.0, 6.4), layout="constrained")
    left, right = np.ravel(np.asarray(fig.subfigures(1, 2, width_ratios=(1.7, 1.0))))
    axes = left.subplots(3, 1, sharex=True)
    log, time = found.log, found.log.time
    axes[0].plot(time, log["x"] * 1e3, color=INK, lw=1.2)
    axes[0].set_ylabel("position [mm]")
    for name, colour in (("p1", COLOURS[0]), ("p2", COLOURS[1])):
        axes[1].plot(time, log[name] * 1e-5, color=colour, lw=0.9, label=name)
    axes[1].set_ylabel("pressure [bar]")
    axes[1].legend(loc="best")
    axes[2].plot(time, steady_friction(log, found.rig, load_cell=found.load_cell), color=MUTED, lw=0.6)
    axes[2].set_ylabel("friction [N]")
    axes[2].set_xlabel("time [s]")
    for panel in axes:
        _stretches(panel, found)
        panel.margins(x=0)
    for w in found:
        axes[2].plot([w.start, w.end], [w.force, w.force], color=ACCENT, lw=2.0)
    _limits(axes[2], found)
    _map(right.subplots(), found)
    title(fig, "Windows of steady motion", f"{len(found)} accepted, {len(found.rejected)} left out")
    return fig


def _stretches(panel: Axes, found: SteadyWindows) -> None:
    for w in found:
        panel.axvspan(w.start, w.end, color=COLOURS[3], alpha=0.25, lw=0)
    for r in found.rejected:
        panel.axvspan(r.start, r.end, color=MUTED, alpha=0.10, lw=0)


def _limits(panel: Axes, found: SteadyWindows) -> None:
    """Limits from the windows, because inertia forces at the starts are much larger."""
    if len(found):
        forces = np.array([w.force for w in found])
        reach = max(float(np.ptp(forces)), float(np.abs(forces).max()))
        panel.set_ylim(float(forces.min()) - 0.5 * reach, float(forces.max()) + 0.5 * reach)


def _map(panel: Axes, found: SteadyWindows) -> None:
    bars: dict[str, Any] = {"fmt": "o", "ms": 4.5, "capsize": 2.5, "lw": 1.0}
    for direction, colour, label in ((1, COLOURS[0], "extending"), (-1, COLOURS[4], "retracting")):
        chosen = [w for w in found if w.direction == direction]
        if chosen:
            panel.errorbar(
                [w.velocity * 1e3 for w in chosen], [w.force for w in chosen], yerr=[2 * w.force_error for w in chosen],
                xerr=[2 * w.velocity_error * 1e3 for w in chosen], color=colour, label=label, **bars,
            )  # fmt: skip
    panel.axhline(0.0, color=MUTED, lw=0.8)
    panel.axvline(0.0, color=MUTED, lw=0.8)
    panel.set_xlabel("velocity [mm/s]")
    panel.set_ylabel("friction [N], bars of two standard errors")
    panel.set_title("Friction over velocity")
    if len(found):
        panel.legend(loc="best")


# Most charts of one figure.
MOST = 24


@styled
def fit_charts(fit: Fit) -> Figure:
    """One chart per signal of each log: readings as dark thin lines, the model over them, held-out stretches shaded."""
    chosen = list(fit.differences.items())[:MOST]
    records = {model.record.name: model.record for model in fit.task.models}
    held_out = [records[log].time[records[log].held_out] + records[log].begin for (log, _), _ in chosen]
    return over_logs([d for _, d in chosen], "model", held_out=held_out)
