"""Figures 65 to 69: from logs at constant velocity to friction maps, and how a plain least-squares fit goes wrong."""

from __future__ import annotations

from functools import cache

import numpy as np
from common import figure, save
from laboratory import RIGS, calibrated, parameters, violations, windows
from scipy.optimize import curve_fit
from static_maps import LOADS, identified, log_of, truth
from table3_static_parameters import ALLOWED

from hydrocrane.identification import StaticMap
from hydrocrane.signals import low_pass, steady_friction

CYLINDER, LOAD = "Rottne", 0
# Edge of the filter for the slow level that is drawn, Hz.
SLOW_LEVEL, EDGE = 5e-4, 0.5
# Plain fits, all by every sample: Stribeck velocity at the start (m/s) and viscous exponent. 1.5 is that of the rig's
# friction, 1 that of (115).
PLAIN = {"from 0.1 m/s": (0.1, 1.5), "linear viscous": (1e-3, 1.0), "from 1 mm/s": (1e-3, 1.5)}


@cache
def slow_velocity() -> dict[str, np.ndarray]:
    """Velocity of one slow level: difference of the unfiltered position, and of the filtered one, m/s."""
    log = log_of(CYLINDER, LOAD)
    piece = next(s for s in log.segments if np.isclose(s.velocity, SLOW_LEVEL))
    readings = calibrated(log)
    time, step = readings.time, float(np.diff(readings.time[:2])[0])
    filtered = low_pass(readings["x"], 1 / step, EDGE)
    here = (time > piece.start + 4.0) & (time < piece.end - 1.0)
    return {
        "time": time[here] - piece.start,
        "raw": np.gradient(readings["x"], time)[here],
        "filtered": np.gradient(filtered, time)[here],
    }


@cache
def samples() -> tuple[np.ndarray, np.ndarray]:
    """Velocity (m/s) and friction (N) of every sample of the extending windows: most of them are slow."""
    log = log_of(CYLINDER, LOAD)
    readings = calibrated(log)
    friction = steady_friction(readings, parameters(log))
    velocities, forces = [], []
    for window in windows(log):
        if window.velocity > 0:
            inside = friction[(readings.time >= window.start) & (readings.time <= window.end)]
            velocities.append(np.full(inside.size, window.velocity))
            forces.append(inside)
    return np.concatenate(velocities), np.concatenate(forces)


@cache
def plain_fit(name: str) -> StaticMap:
    """(122) by SciPy's curve fit to all samples, from the start of that name."""
    velocity, force = samples()
    stribeck, exponent = PLAIN[name]
    start = (200.0, 300.0, stribeck, 1e4)

    def law(v, coulomb, breakaway, stribeck, viscous):
        return _map(coulomb, breakaway, abs(stribeck), viscous, exponent).force(v)

    found = curve_fit(law, velocity, force, p0=start, method="lm")[0]
    return _map(*found[:2], abs(found[2]), found[3], exponent)


def _map(coulomb: float, breakaway: float, stribeck: float, viscous: float, exponent: float) -> StaticMap:
    values = {"coulomb": coulomb, "breakaway": breakaway, "stribeck-velocity": stribeck, "viscous": viscous}
    return StaticMap.of({**values, "viscous-exponent": exponent})


def worst_level(law: StaticMap, offset: float = 0.0) -> float:
    """Largest distance of a map from the mean of a level, N."""
    velocity, force = samples()
    levels = np.unique(velocity)
    means = np.array([force[velocity == level].mean() for level in levels])
    return float(np.abs(law.force(levels) + offset - means).max())


def reading_off_table(ideal: bool) -> float:
    """Largest error of the reading by ruler, as a share of what is allowed, over all rows of Table 3."""
    return max(
        abs(identified(cylinder, load, ideal).reading.params[name][side] / pair[side] - 1) / ALLOWED[name]
        for cylinder in RIGS
        for load in LOADS
        for name, pair in truth(cylinder, load).pairs.items()
        if name in ALLOWED
        for side in (0, 1)
    )


def maps_differ() -> list[bool]:
    """The text on Figure 69: Rottne rises more; Kalmar has the higher Stribeck velocity and its minimum later."""
    held = []
    v = np.geomspace(1e-4, 0.1, 500)
    for load in LOADS:
        for sign in (1.0, -1.0):
            rottne, kalmar = (np.abs(identified(c, load).fit.force(sign * v)) for c in ("Rottne", "Kalmar"))
            held.append(bool(rottne[-1] - rottne.min() > kalmar[-1] - kalmar.min()))
            held.append(bool(kalmar.argmin() > rottne.argmin()))
        velocities = [identified(c, load).fit.params["stribeck-velocity"] for c in ("Rottne", "Kalmar")]
        held.append(max(velocities[0]) < min(velocities[1]))
    return held


def compute() -> dict[str, float]:
    slow, found = slow_velocity(), identified(CYLINDER, LOAD)
    velocity, _ = samples()
    worst = {name: worst_level(plain_fit(name)) for name in PLAIN}
    ours = worst_level(found.fit.law, found.fit.offset)
    share = float(np.mean(velocity < 1e-3))
    numbers = {
        "raw_scatter_m_s": float(slow["raw"].std()),
        "filtered_scatter_m_s": float(slow["filtered"].std()),
        "filter_violations": violations([slow["raw"].std() > SLOW_LEVEL, slow["filtered"].std() < 0.1 * SLOW_LEVEL]),
        "levels_missed": float(abs(20 - found.points.levels.count.size)),
        "reading_error_of_allowed": reading_off_table(ideal=True),
        "reading_error_of_allowed_data_sheet": reading_off_table(ideal=False),
        "share_of_slow_samples": share,
        "trap_violations": violations([share > 0.5, worst["from 0.1 m/s"] > 50.0, ours < 5.0]),
        "fit_of_levels_worst_N": ours,
        "maps_violations": violations(maps_differ()),
    }
    return numbers | {f"plain_fit_{name}_worst_N": value for name, value in worst.items()}


def repeatability(key: str) -> float:
    """Least-squares solutions repeat to their step tolerance, not to rounding."""
    return 0.1 if key.endswith("_N") else 1e-6 if key.endswith("m_s") else 1e-4


def draw() -> None:
    draw_velocity()
    draw_points()
    draw_trap()
    draw_maps()


def draw_velocity() -> None:
    slow = slow_velocity()
    fig, axes = figure(1, 2, (9.5, 3.4))
    for axis, name in zip(axes.flat, ("raw", "filtered")):
        axis.plot(slow["time"], 1e3 * slow[name], lw=0.6, color="0.4")
        axis.set(title=f"Figure 65, {name}", xlabel="time [s]", ylabel="velocity [mm/s]")
    axes[0, 1].set_ylim(0, 1e3 * 2 * SLOW_LEVEL)
    save(fig, "fig65_69_static_maps_65")


def draw_points() -> None:
    """Figures 66 and 67: points, and the reading by ruler with its construction lines."""
    found = identified(CYLINDER, LOAD)
    points, read = found.points, found.reading.params
    fig, axes = figure(1, 2, (10.0, 4.0))
    axes[0, 0].errorbar(1e3 * points.velocity, points.force, 2 * points.force_error, fmt="o", ms=4, capsize=2)
    axes[0, 0].set(title="Figure 66", xlabel="piston velocity [mm/s]", ylabel="friction [N]")
    axis, extending = axes[0, 1], points.direction == 0
    coulomb, breakaway, stribeck = (read[name][0] for name in ("coulomb", "breakaway", "stribeck-velocity"))
    axis.plot(1e3 * points.velocity[extending], points.force[extending], "o-", ms=4)
    speeds = np.geomspace(8e-5, 0.11, 200)
    line = coulomb + read["viscous"][0] * speeds ** read["viscous-exponent"][0]
    axis.plot(1e3 * speeds, line, "k--", lw=0.9)
    level = coulomb + (breakaway - coulomb) / np.e
    axis.plot([0.08, 1e3 * stribeck, 1e3 * stribeck], [level, level, 0.0], "k:", lw=0.9)
    for text, height in (("alpha_0 + alpha_1", breakaway), ("alpha_0 + alpha_1/e", level), ("alpha_0", coulomb)):
        axis.annotate(text, (0.085, height), (0, 4), textcoords="offset points", fontsize=8)
    axis.annotate("v_sigma", (1e3 * stribeck, 8.0), (4, 0), textcoords="offset points", fontsize=8)
    axis.set(title="Figure 67, extending", xlabel="piston velocity [mm/s]", ylabel="friction [N]", xscale="log")
    axis.set_ylim(0, 450)
    save(fig, "fig65_69_static_maps_66")


def draw_trap() -> None:
    velocity, force = samples()
    found = identified(CYLINDER, LOAD)
    speeds = np.geomspace(8e-5, 0.11, 300)
    fig, axes = figure(1, 2, (10.0, 4.0))
    for axis, scale in zip(axes.flat, ("log", "linear")):
        axis.plot(1e3 * velocity[::200], force[::200], ".", color="0.75", ms=3, label="every 200th sample")
        for (name, _), style in zip(PLAIN.items(), ("-", "-.", ":")):
            axis.plot(1e3 * speeds, plain_fit(name).force(speeds), style, label=f"all samples, {name}")
        fitted = found.fit.force(speeds) + found.fit.offset
        axis.plot(1e3 * speeds, fitted, "k--", lw=1.0, label="by levels, hydrocrane")
        axis.set(xlabel="piston velocity [mm/s]", ylabel="friction [N]", xscale=scale, ylim=(0, 450))
    axes[0, 0].set_title("Figure 68")
    axes[0, 0].legend(frameon=False, fontsize=8, loc="lower left")
    save(fig, "fig65_69_static_maps_68")


def draw_maps() -> None:
    fig, axes = figure(2, 2, (10.0, 7.0))
    speeds = np.geomspace(5e-5, 0.105, 300)
    for row, cylinder in zip(axes, RIGS):
        for axis, sign, side in zip(row, (1.0, -1.0), (0, 1)):
            for load, colour in zip(LOADS, ("C0", "C1")):
                found = identified(cylinder, load)
                here = found.points.direction == side
                axis.plot(1e3 * speeds, sign * found.fit.force(sign * speeds), color=colour, label=f"{load} kg, fitted")
                axis.plot(1e3 * speeds, sign * truth(cylinder, load).force(sign * speeds), "k:", lw=0.9)
                axis.plot(1e3 * found.points.speed[here], sign * found.points.force[here], "o", ms=3.5, color=colour)
            axis.set(xscale="log", ylim=(0, None), ylabel="friction, magnitude [N]")
            axis.set_title(f"Figure 69, {cylinder}, {'extending' if side == 0 else 'retracting'}", fontsize=10)
    axes[0, 0].plot([], [], "k:", lw=0.9, label="Table 3")
    axes[0, 0].legend(frameon=False, fontsize=8)
    for axis in axes[1]:
        axis.set_xlabel("speed [mm/s]")
    save(fig, "fig65_69_static_maps_69")
