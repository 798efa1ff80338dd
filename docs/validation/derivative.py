"""Derivatives of a noisy, rounded position compared on motions of known velocity; writes docs/validation/derivative.md.

Run with a Python that has hydrocrane installed; takes a few seconds.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import marked_page
import numpy as np
from scipy.signal import savgol_filter

from hydrocrane.logs import Noise, noise_of
from hydrocrane.signals import derivative, low_pass

PAGE = Path(__file__).with_name("derivative.md")
RATE, DURATION, SEEDS = 200.0, 20.0, 4
# A wire potentiometer of 1250 mm behind 16 and behind 12 bits; its noise is assumed.
SENSORS = {"16 bits, 50 um": (5e-5, 1.25 / 65535), "12 bits, 50 um": (5e-5, 1.25 / 4095)}


def motions() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Position and velocity of each motion over time: slow ramp, fast ramp, steps of velocity, sine."""
    t = np.arange(int(DURATION * RATE)) / RATE
    smooth = 0.5 * (1 + np.tanh((t - 5) / 0.03)) - 0.5 * (1 + np.tanh((t - 15) / 0.03))
    found = {}
    for name, v in {
        "ramp 0.2 mm/s": np.full(t.size, 2e-4),
        "ramp 20 mm/s": np.full(t.size, 0.02),
        "steps 0, 20, 0 mm/s": 0.02 * smooth,
        "sine 20 mm/s, 0.5 Hz": 0.02 * np.cos(np.pi * t),
    }.items():
        found[name] = (np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1])) / RATE]) + 0.0123, v)
    return found


def smoothed_by_kalman(x: np.ndarray, noise: Noise, jerk: float = 0.3) -> np.ndarray:
    """Velocity of a Kalman filter with white jerk and a Rauch-Tung-Striebel pass backwards."""
    dt = 1.0 / RATE
    step = np.array([[1, dt, dt**2 / 2], [0, 1, dt], [0, 0, 1]])
    shape = np.array(
        [[dt**5 / 20, dt**4 / 8, dt**3 / 6], [dt**4 / 8, dt**3 / 3, dt**2 / 2], [dt**3 / 6, dt**2 / 2, dt]]
    )
    mean, cov = np.array([x[0], 0.0, 0.0]), np.diag([noise.total**2, 1e-2, 1.0])
    past = []
    for value in x:
        ahead, ahead_cov = step @ mean, step @ cov @ step.T + jerk**2 * shape
        gain = ahead_cov[:, 0] / (ahead_cov[0, 0] + noise.total**2)
        mean, cov = ahead + gain * (value - ahead[0]), ahead_cov - np.outer(gain, ahead_cov[0])
        past.append((ahead, ahead_cov, mean, cov))
    velocity = np.empty(x.size)
    velocity[-1], later, later_cov = mean[1], mean, cov
    for k in range(x.size - 2, -1, -1):
        ahead, ahead_cov = past[k + 1][:2]
        mean, cov = past[k][2:]
        back = np.linalg.solve(ahead_cov, step @ cov).T
        later, later_cov = mean + back @ (later - ahead), cov + back @ (later_cov - ahead_cov) @ back.T
        velocity[k] = later[1]
    return velocity


CANDIDATES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "difference": lambda x: np.gradient(x, 1.0 / RATE),
    "Bessel 5 Hz, then difference": lambda x: np.gradient(low_pass(x, RATE, 5.0), 1.0 / RATE),
    "Savitzky-Golay, 0.1 s": lambda x: savgol_filter(x, 21, 2, deriv=1, delta=1.0 / RATE),
    "Savitzky-Golay, 1 s": lambda x: savgol_filter(x, 201, 2, deriv=1, delta=1.0 / RATE),
    "Kalman smoother, white jerk": lambda x: smoothed_by_kalman(x, noise_of(x)),
    "grown window (used)": lambda x: derivative(x, RATE).value,
}


def readings(x: np.ndarray, sensor: str, seed: int) -> np.ndarray:
    sigma, step = SENSORS[sensor]
    return np.round((x + np.random.default_rng(seed).normal(0.0, sigma, x.size)) / step) * step


def compared(sensor: str, seeds: int = SEEDS) -> dict[str, dict[str, float]]:
    """Root mean square error of velocity, m/s, by candidate and motion, over all samples and `seeds` draws."""
    table: dict[str, dict[str, float]] = {name: {} for name in CANDIDATES}
    for motion, (x, v) in motions().items():
        for name, estimate in CANDIDATES.items():
            squares = [np.mean((estimate(readings(x, sensor, seed)) - v) ** 2) for seed in range(seeds)]
            table[name][motion] = float(np.sqrt(np.mean(squares)))
    return table


def honesty(sensor: str, seeds: int = SEEDS) -> dict[str, float]:
    """Share of samples within two of their own standard uncertainties, by motion."""
    shares = {}
    for motion, (x, v) in motions().items():
        found = [derivative(readings(x, sensor, seed), RATE) for seed in range(seeds)]
        shares[motion] = float(np.mean([np.abs(d.value - v) <= 2 * d.error for d in found]))
    return shares


def numbers() -> list[str]:
    lines: list[str] = []
    for sensor in SENSORS:
        table, within = compared(sensor), honesty(sensor)
        columns = list(motions())
        lines += [f"## Sensor: {sensor}", "", "| velocity error (rms), mm/s | " + " | ".join(columns) + " |"]
        lines += ["|---" * (len(columns) + 1) + "|"]
        lines += [f"| {n} | " + " | ".join(f"{row[c] * 1e3:.3g}" for c in columns) + " |" for n, row in table.items()]
        lines += ["| *within two of its uncertainties* | " + " | ".join(f"{within[c]:.0%}" for c in columns) + " |", ""]
    return lines[:-1]


if __name__ == "__main__":
    marked_page.write(PAGE, numbers())
