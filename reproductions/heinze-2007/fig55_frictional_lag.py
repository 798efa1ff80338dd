"""Figure 55: friction while the velocity swings about the Stribeck velocity without turning."""

from __future__ import annotations

from functools import cache

import numpy as np
from common import figure, save
from laboratory import RIGS, experiment, motion, violations

from hydrocrane import rig

SWING = {"shares": (0.025, 0.05, 0.1), "cycles": 2}
# Signals are averaged over this share of a period.
AVERAGED = 0.03


@cache
def loops(cylinder: str) -> dict[float, tuple[np.ndarray, np.ndarray]]:
    """Velocity (m/s) and friction (N) of one cycle from the middle of the run, by frequency (Hz)."""
    segments = experiment("frictional-lag", cylinder, **SWING).segments
    found = {}
    for k, segment in enumerate(segments):
        period = (segment.end - segment.start) / SWING["cycles"]
        signals = motion("frictional-lag", cylinder, k, AVERAGED * period, **SWING)
        # From the fastest moment to the next, where start and stop are many slips of the bristles away.
        cycle = (signals["time"] >= 0.25 * period) & (signals["time"] < 1.25 * period)
        found[1 / period] = signals["velocity"][cycle], signals["friction"][cycle]
    return found


def branches(velocity: np.ndarray, friction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Friction (n,), N, while the velocity rises and while it falls, at the same velocities."""
    start, top = int(velocity.argmin()), int(velocity.argmax())
    v, f = np.roll(velocity, -start), np.roll(friction, -start)
    top = (top - start) % len(v)
    inner = velocity.min() + np.ptp(velocity) * np.linspace(0.03, 0.95, 60)
    sides = ((v[: top + 1], f[: top + 1]), (v[top:], f[top:]))
    rising, falling = (np.interp(inner, side[np.argsort(side)], force[np.argsort(side)]) for side, force in sides)
    return rising, falling


def peak(cylinder: str, load: int) -> float:
    """Largest friction (N) in any of the loops with the row of Table 3 for this load; the rig's own, not as read."""
    overrides = rig.loaded_friction(RIGS[cylinder], load)
    log = experiment("frictional-lag", cylinder, payload=load, overrides=overrides, **SWING)
    return max(float(log.part(segment, truth=True).friction.max()) for segment in log.segments)


def compute() -> dict[str, float]:
    numbers, held = {}, []
    for cylinder in RIGS:
        parts = [branches(*loop) for loop in loops(cylinder).values()]
        widths = [float(np.max(np.abs(rise - fall))) for rise, fall in parts]
        for frequency, width in zip(loops(cylinder), widths):
            numbers[f"{cylinder}_width_at_{frequency:.3g}Hz_N"] = width
        wider = bool(np.all(np.diff(widths) > 0))
        deeper_when_rising = all(np.ptp(rise) > np.ptp(fall) for rise, fall in parts)
        higher_when_falling = all(fall.max() > rise.max() for rise, fall in parts)
        held += [wider, deeper_when_rising, higher_when_falling]
        numbers[f"{cylinder}_is_higher_when_falling"] = float(higher_when_falling)
    # The Rottne cylinder is too short for these loops with the Stribeck velocity of its loaded row.
    peaks = {
        f"{c}_{load}kg_largest_friction_N": peak(c, load) for c, load in (("Rottne", 0), ("Kalmar", 0), ("Kalmar", 115))
    }
    return numbers | peaks | {"violations": violations(held)}


def draw() -> None:
    fig, axes = figure(1, 2, (9.5, 3.8))
    for axis, cylinder in zip(axes.flat, RIGS):
        for frequency, (velocity, friction) in loops(cylinder).items():
            axis.plot(1e3 * velocity, friction, label=f"{frequency:.3g} Hz", lw=1.2)
        axis.set(title=f"Figure 55, {cylinder}", xlabel="piston velocity [mm/s]", ylabel="friction [N]", ylim=(0, None))
        axis.legend(frameon=False)
    save(fig, "fig55_frictional_lag")
