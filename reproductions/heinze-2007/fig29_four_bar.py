"""Figure 29: the angle theta_1 at joint 3 between the torque links, measured on hydrocrane's machine, against (23)."""

from __future__ import annotations

import numpy as np
from common import figure, save
from scipy.optimize import brentq

import hydrocrane as hc

# (23): theta_1 = 4.011 - beta, printed to a thousandth of a radian; it passes 180 deg below "50 deg".
PRINTED_SUM, SUM_ROUNDING = 4.011, 0.5e-3
PRINTED_BETA, BETA_ROUNDING = 50.0, 0.5
BETAS = np.deg2rad(np.linspace(10.0, 170.0, 33))


def theta_1(crane, beta: float) -> float:
    """Angle (rad) from the pin of the torque link on the boom to that on the jib, counted through the quadrangle."""
    drawn = crane.drawing([np.deg2rad(100.0), beta, 0.0])
    links = {(kind, name): np.asarray(line) for kind, name, line in drawn}
    rocker, coupler = links["torque-link", "jib"][[0, -1]]
    joint = links["joint", "jib"][0]
    on_boom, on_jib = ((complex(*(pin - joint))) for pin in (rocker, coupler))
    return float(np.angle(on_boom / on_jib) % (2 * np.pi))


def compute() -> dict[str, float]:
    crane = hc.load_machine("heinze-2007")
    sums = np.array([theta_1(crane, beta) + beta for beta in BETAS])
    straight = np.rad2deg(brentq(lambda beta: theta_1(crane, beta) - np.pi, np.deg2rad(30.0), np.deg2rad(70.0)))
    shares = (abs(sums - PRINTED_SUM).max() / SUM_ROUNDING, abs(straight - PRINTED_BETA) / BETA_ROUNDING)
    return {
        "sum_of_theta_1_and_beta_rad": float(sums.mean()),
        "scatter_of_the_sum_rad": float(np.ptp(sums)),
        "beta_at_180_deg_deg": float(straight),
        "largest_share_of_the_rounding": float(max(shares)),
    }


def draw() -> None:
    crane = hc.load_machine("heinze-2007")
    fig, axes = figure(1, 1, (6.0, 3.6))
    axis = axes[0, 0]
    axis.plot(np.rad2deg(BETAS), [np.rad2deg(theta_1(crane, beta)) for beta in BETAS], label="machine")
    axis.plot(np.rad2deg(BETAS), np.rad2deg(PRINTED_SUM - BETAS), "k:", label="(23)")
    axis.axhline(180.0, color="0.5", lw=0.8)
    axis.set(title="Figure 29: angle between the torque links", xlabel=r"$\beta$ [deg]", ylabel=r"$\theta_1$ [deg]")
    axis.legend(frameon=False)
    save(fig, "fig29_four_bar")
