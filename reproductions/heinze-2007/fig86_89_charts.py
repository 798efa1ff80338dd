"""Figures 86 to 89: six charts per cylinder and the line drawing, for the published vertical task."""

from __future__ import annotations

import numpy as np
from common import figure, printed_program, save
from fig80_85_published_run import run

import hydrocrane as hc

LABELS = ("$p_1$ [bar]", "$p_2$ [bar]", "$x_s$ [mm]", "$v_s$ [m/s]")
SCALES = (1e-5, 1e-5, 1e3, 1.0)
COORDINATES = (
    (r"$\alpha$ [deg]", r"$\omega_\alpha$ [deg/s]"),
    (r"$\beta$ [deg]", r"$\omega_\beta$ [deg/s]"),
    (r"$x_3$ [mm]", r"$v_3$ [mm/s]"),
)


def repeatability(key: str) -> float:
    """Spool peaks of a run that amplifies rounding; the drawing itself is exact."""
    return 0.1 if key.startswith("spool") else 1e-9


def drawn_tip(crane, q: np.ndarray) -> np.ndarray:
    """Where hydrocrane's line drawing puts the tip, m."""
    return np.asarray(next(line for kind, _, line in crane.drawing(q) if kind == "tip"))[-1]


def compute() -> dict[str, float]:
    _, states = run("vertical")
    if not np.isfinite(states).all():
        raise RuntimeError("the published vertical task left the finite numbers")
    stroke = printed_program.SPOOL_STROKE
    crane = hc.load_machine("heinze-2007")
    gaps = [np.linalg.norm(drawn_tip(crane, q) - printed_program.tip(q)) for q in states[::100, [0, 6, 12]]]
    numbers = {f"spool_overshoot_{i + 1}": float(np.abs(states[:, 6 * i + 4]).max() / stroke - 1) for i in range(3)}
    return numbers | {"drawing_gap_m": float(max(gaps))}


def draw() -> None:
    time, states = run("vertical")
    for i in range(3):
        fig, axes = figure(3, 2, (9.0, 7.5))
        angular = np.rad2deg(1.0) if i < 2 else 1e3
        scales = (angular, angular, *SCALES)
        labels = (*COORDINATES[i], *LABELS)
        for k, axis in enumerate(axes.flat):
            axis.plot(time, scales[k] * states[:, 6 * i + k], lw=1)
            axis.set(xlabel="time [s]", ylabel=labels[k])
        fig.suptitle(f"Figure {86 + i}: cylinder {i + 1}, vertical task")
        save(fig, f"fig86_89_charts_{i + 1}")
    crane = hc.load_machine("heinze-2007")
    fig, axes = figure(1, 1, (6.0, 5.0))
    for shade, y in zip(np.linspace(0.75, 0.0, 6), states[:: len(states) // 5]):
        for kind, _, line in crane.drawing(y[[0, 6, 12]]):
            axes[0, 0].plot(*np.asarray(line).T, color=str(shade), lw=2.5 if kind == "cylinder-barrel" else 1.2)
    axes[0, 0].set(title="Figure 89: line drawing", xlabel="x [m]", ylabel="z [m]", aspect="equal")
    save(fig, "fig86_89_charts_drawing")
