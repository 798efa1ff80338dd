"""Identified friction: points and map, residuals, comparisons of groups; as Figures 66-69, 74 and 75."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrocrane.plots.style import ACCENT, COLOURS, MUTED, figure, styled, title

if TYPE_CHECKING:
    from hydrocrane.identification.comparison import FrictionComparison
    from hydrocrane.identification.points import FrictionPoints
    from hydrocrane.identification.result import StaticFit

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
