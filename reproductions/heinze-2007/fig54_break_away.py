"""Figure 54: the faster the force on the piston grows, the less of it is needed to break the seal away."""

from __future__ import annotations

from functools import cache

import numpy as np
from common import figure, save
from laboratory import RIGS, motion, violations

# Slipping begins at these shares of the Stribeck velocity; one run from rest for each.
SPEEDS = (0.05, 0.1, 0.2, 0.4, 0.7, 1.0)
# Friction is averaged over this share of a ramp's time to the break-away.
AVERAGED = 0.01


@cache
def break_away(cylinder: str, speed: float) -> tuple[float, float]:
    """Force rate (N/s) and break-away force (N) of one ramp, extending from rest with straight bristles."""
    duration = motion("break-away", cylinder, 0, 0.0, speeds=(speed,))["time"][-1]
    found = motion("break-away", cylinder, 0, AVERAGED * duration, speeds=(speed,))
    force, time = found["friction"], found["time"]
    peak = int(force.argmax())
    loading = slice(int(np.argmax(force > 0.3 * force[peak])), int(np.argmax(force > 0.8 * force[peak])))
    return float(np.polyfit(time[loading], force[loading], 1)[0]), float(force[peak])


def curves() -> dict[str, np.ndarray]:
    """(2, n) rate and break-away force by cylinder."""
    return {cylinder: np.array([break_away(cylinder, speed) for speed in SPEEDS]).T for cylinder in RIGS}


def compute() -> dict[str, float]:
    numbers = {}
    for cylinder, (rate, force) in curves().items():
        numbers[f"{cylinder}_slowest_N_s"], numbers[f"{cylinder}_fastest_N_s"] = float(rate[0]), float(rate[-1])
        numbers[f"{cylinder}_slowest_N"], numbers[f"{cylinder}_fastest_N"] = float(force[0]), float(force[-1])
    falls = [bool(fall) for _, force in curves().values() for fall in np.diff(force) < 0]
    return numbers | {"violations": violations(falls)}


def draw() -> None:
    fig, axes = figure(1, 1, (6.5, 3.8))
    for cylinder, (rate, force) in curves().items():
        axes[0, 0].plot(rate, force, "o-", label=cylinder)
    axes[0, 0].set(
        title="Figure 54", xlabel="force rate [N/s]", ylabel="break-away force [N]", xscale="log", ylim=(0, None)
    )
    axes[0, 0].legend(frameon=False)
    save(fig, "fig54_break_away")
