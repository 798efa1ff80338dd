"""Figure 73 and Table 5: steps within the bristles' reach, and the damping that (127) reads from them.

With the velocity and acceleration taken as differences of the unfiltered position, noise decides alone: the noise n
gives the velocity (n_k - n_k-1)/h and the acceleration (n_k - 2 n_k-1 + n_k-2)/h^2, whose regression is 3/(2 h), so
that (127) gives sigma_1 = -(3 m/(2 h) + alpha_2) whatever the seal is.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from bristle_fits import fit
from common import figure, save
from laboratory import RIGS, calibrated, experiment, motion, parameters, violations
from static_maps import truth

import hydrocrane as hc
from hydrocrane.signals import steady_friction

# Table 5, extending and retracting, N s/m, and the loads (kg) and sampling time (s) with which noise alone gives its
# extending column; the thesis states neither.
DIRECTIONS = ("extending", "retracting")
PRINTED = {"Rottne": (-1.53e4, -1.55e4), "Kalmar": (-1.74e5, -1.73e5)}
LOAD = {"Rottne": 0.0, "Kalmar": 115.0}
INTERVAL = 1e-3
STEP = {"shares": (0.3, 0.5), "seconds": 0.2}
AVERAGED = 0.02
# The piston rests for this long before a step at the least, s.
REST = 1.0


@cache
def printed_way(cylinder: str, side: int = 0, damping: float | None = None) -> float:
    """sigma_1 by (127) from the first step of a direction, N s/m; `damping` replaces that of the rig.

    Velocity and acceleration are backward differences, alpha_2 is that of the direction.
    """
    overrides = None if damping is None else {"friction.test.bristle-damping": damping}
    log = experiment("step", cylinder, payload=LOAD[cylinder], interval=INTERVAL, overrides=overrides, **STEP)
    readings, rig = calibrated(log), parameters(log)
    step = log.segments[side]
    resting = (readings.time > step.start - REST) & (readings.time < step.start)
    x, force = readings["x"], steady_friction(readings, rig)
    x, force = x - x[resting].mean(), force - force[resting].mean()
    stiffness = float(log.run.machine.value("friction.test.bristle-stiffness").si)
    # The differences reach two samples back.
    first = int(np.argmax(readings.time >= step.start))
    here = slice(first - 2, int(np.argmax(readings.time >= step.end)))
    slope = damped_slope(x[here], force[here], rig.mass, stiffness, INTERVAL)
    return slope - truth(cylinder, 0).pairs["viscous"][side]


def damped_slope(x: np.ndarray, force: np.ndarray, mass: float, stiffness: float, interval: float) -> float:
    """sigma_1 + alpha_2 of (127), N s/m: regression of F - m x'' - sigma_0 x over x', both backward differences."""
    velocity = np.diff(x)[1:] / interval
    left = force[2:] - mass * np.diff(x, 2) / interval**2 - stiffness * x[2:]
    return float(left @ velocity / (velocity @ velocity))


def damping_of(cylinder: str) -> float:
    """sigma_1 of the rig, N s/m."""
    return float(hc.load_machine(RIGS[cylinder]).value("friction.test.bristle-damping").si)


def noise_alone(cylinder: str, side: int) -> float:
    """-(3 m/(2 h) + alpha_2), N s/m."""
    log = experiment("step", cylinder, payload=LOAD[cylinder], interval=INTERVAL, **STEP)
    return -1.5 * parameters(log).mass / INTERVAL - truth(cylinder, 0).pairs["viscous"][side]


def compute() -> dict[str, float]:
    numbers, drowned = {}, []
    for cylinder in RIGS:
        signals = motion("step", cylinder, 0, AVERAGED, **STEP)
        raw = np.diff(signals["raw_x"]) / np.diff(signals["time"])
        numbers[f"{cylinder}_raw_velocity_scatter_m_s"] = float(raw.std())
        numbers[f"{cylinder}_mean_velocity_m_s"] = float(np.polyfit(signals["time"], signals["raw_x"], 1)[0])
        numbers[f"{cylinder}_largest_deflection_m"] = float(signals["z"].max())
        drowned.append(raw.std() > signals["velocity"].max())
        half = 0.5 * damping_of(cylinder)
        for side, direction in enumerate(DIRECTIONS):
            own = printed_way(cylinder, side)
            numbers[f"{cylinder}_{direction}_printed_way"] = own
            numbers[f"{cylinder}_{direction}_noise_alone"] = noise_alone(cylinder, side)
            numbers[f"{cylinder}_{direction}_printed_way_half_the_damping"] = printed_way(cylinder, side, half)
            numbers[f"{cylinder}_{direction}_off_the_table"] = abs(own / PRINTED[cylinder][side] - 1)
            viscous = truth(cylinder, 0).pairs["viscous"]
            same = own + viscous[side] - viscous[0]
            numbers[f"{cylinder}_{direction}_off_with_alpha_2_of_extension"] = abs(same / PRINTED[cylinder][side] - 1)
        low, high = fit(cylinder).intervals()["bristle-damping"]
        numbers[f"{cylinder}_fit"] = fit(cylinder).params["bristle-damping"]
        numbers[f"{cylinder}_fit_low"], numbers[f"{cylinder}_fit_high"] = low, high
    larger = numbers["Rottne_largest_deflection_m"] > numbers["Kalmar_largest_deflection_m"]
    numbers["step_violations"] = violations([*drowned, larger])
    return numbers | {"largest_distance": max(v for key, v in numbers.items() if key.endswith("off_the_table"))}


def repeatability(key: str) -> float:
    """The fit stops somewhere in a flat valley: about a tenth of its standard deviation, N s/m."""
    return 20.0 if "_fit" in key else 1e-2


def report(numbers: dict[str, float]) -> list[str]:
    """Table 5 as printed, as noise gives it, and as the fit has it."""
    titles = {
        "printed_way": "(127), unfiltered differences",
        "printed_way_half_the_damping": "the same, half the damping in the rig",
        "noise_alone": "-(3 m/(2 h) + alpha_2)",
    }
    lines = ["| sigma_1 [N s/m] | " + " | ".join(f"{c}, {LOAD[c]:g} kg, {d}" for c in RIGS for d in DIRECTIONS) + " |"]
    lines += ["|---|---|---|---|---|", "| printed | " + " | ".join(f"{v:.0f}" for c in RIGS for v in PRINTED[c]) + " |"]
    for key, title in titles.items():
        cells = " | ".join(f"{numbers[f'{c}_{d}_{key}']:.0f}" for c in RIGS for d in DIRECTIONS)
        lines.append(f"| {title} | {cells} |")
    both = "one value for both"
    fits = (tuple(numbers[f"{c}_fit{end}"] for end in ("", "_low", "_high")) for c in RIGS)
    cells = " | ".join(f"{v:.0f}, {a:.0f} to {b:.0f} | {both}" for v, a, b in fits)
    lines.append(f"| fit, 0 kg, 95 % interval | {cells} |")
    return [*lines, "| in the rig | " + " | ".join(f"{damping_of(c):.0f} | {both}" for c in RIGS) + " |"]


def draw() -> None:
    fig, axes = figure(3, 2, (9.5, 7.5))
    for column, cylinder in zip(axes.T, RIGS):
        log = experiment("step", cylinder, **STEP)
        readings = calibrated(log)
        first = log.segments[0]
        here = (readings.time > first.start - 0.2) & (readings.time < first.end + 0.6)
        time, x = readings.time[here] - first.start, readings["x"][here]
        truth_x = np.interp(readings.time[here], log.truth.time.values, log.truth.x.values)
        force = steady_friction(readings, parameters(log))[here]
        moved = 1e3 * (x - x[time < 0].mean())
        column[0].plot(time, moved, lw=0.5, color="0.6", label="as read")
        column[0].plot(time, 1e3 * (truth_x - truth_x[0]), label="true")
        column[1].plot(time, np.gradient(moved, time), lw=0.5, color="0.6")
        column[1].plot(time, np.gradient(1e3 * truth_x, time))
        column[2].plot(time, force, lw=0.5, color="0.6")
        column[2].plot(time, np.interp(readings.time[here], log.truth.time.values, log.truth.friction.values))
        column[0].set(title=f"Figure 73, {cylinder}", ylabel="position [mm]")
        column[0].legend(frameon=False, loc="lower right")
        column[1].set_ylabel("velocity [mm/s]")
        column[2].set(xlabel="time [s]", ylabel="friction [N]")
    save(fig, "fig73_step")
