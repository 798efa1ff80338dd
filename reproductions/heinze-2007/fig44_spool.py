"""Figure 44: the spool's step response, and the two parameters that (78) and (79) read from its ringing."""

from __future__ import annotations

import numpy as np
from common import figure, save

import hydrocrane as hc

# The text: omega_n of about 2 pi 161 1/s and a damping ratio of about 0.48.
PRINTED = {"frequency_hz": (161.0, 0.5), "damping_ratio": (0.48, 0.005)}
STEP, INTERVAL, DURATION = 0.01, 1e-5, 0.03


def response() -> tuple[np.ndarray, np.ndarray]:
    """Time (s) and position (m) of the lift spool after a step of its command at rest."""
    crane = hc.load_machine("heinze-2007")
    simulator = hc.Simulator(crane, sample_time=INTERVAL, method="tsit5", step=INTERVAL)
    start = crane.pack_state(np.array([np.deg2rad(100.0), np.deg2rad(100.0), 0.0]))
    simulator.reset(state=start)
    place = crane.state_names.index("cylinder.lift.xs")
    spool = np.zeros(round(DURATION / INTERVAL) + 1)
    for k in range(1, len(spool)):
        simulator.step(np.array([STEP, 0.0, 0.0]))
        spool[k] = simulator.state[place]
    return INTERVAL * np.arange(len(spool)), spool


def peak(time: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Time and height of the highest sample, by a parabola through it and its neighbours."""
    k = int(values.argmax())
    a, b, c = np.polyfit(time[k - 1 : k + 2] - time[k], values[k - 1 : k + 2], 2)
    return float(time[k] - b / (2 * a)), float(c - b * b / (4 * a))


def compute() -> dict[str, float]:
    time, spool = response()
    first, top = peak(time, spool)
    period = 2 * first
    # Twice the time of the first peak is one period of the ringing; its envelope decays with tau.
    ringing = 2 * np.pi / period
    tau = -first / np.log(top / STEP - 1)
    natural = np.sqrt(1 / tau**2 + ringing**2)
    found = {
        "frequency_hz": float(natural / (2 * np.pi)),
        "damping_ratio": float(1 / np.sqrt(1 + (tau * ringing) ** 2)),
    }
    shares = [abs(found[key] - value) / rounding for key, (value, rounding) in PRINTED.items()]
    return found | {"overshoot": float(top / STEP - 1), "largest_share_of_the_rounding": max(shares)}


def repeatability(_: str) -> float:
    return 1e-5


def draw() -> None:
    time, spool = response()
    fig, axes = figure(1, 1, (6.0, 3.6))
    axes[0, 0].plot(1e3 * time, 1e3 * spool)
    axes[0, 0].axhline(1e3 * STEP, color="0.5", lw=0.8)
    axes[0, 0].set(title="Figure 44: step of the spool", xlabel="time [ms]", ylabel="spool [mm]")
    save(fig, "fig44_spool")
