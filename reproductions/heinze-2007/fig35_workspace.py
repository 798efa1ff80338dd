"""Figure 35: area the tip can reach under Table 1, and under the printed cylinders."""

from __future__ import annotations

import numpy as np
from common import TABLE_1, figure, save

import hydrocrane as hc

JOINT_2 = np.array([0.0, 0.73])
LIMITS = {
    f"joint.{joint}.limits": list(TABLE_1[symbol])
    for joint, symbol in (("boom", "alpha"), ("jib", "beta"), ("extension", "x3"))
}
# Table 1 does not follow from the printed cylinders (E13): longer strokes with the same distance of the pins reach it.
REACHED = {
    f"cylinder.{cylinder}.{part}": f"{length} mm"
    for cylinder, lengths in {"lift": (506.5, 3.5, 380, 0, 0), "jib": (535, 10, 440, 0, 0)}.items()
    for part, length in zip(
        ("barrel-length", "piston-length", "rod-length", "barrel-offset", "rod-offset"), lengths, strict=True
    )
}
CORRECTED_IK = {"errata.ik-quadrant": "corrected", "errata.ik-extension": "corrected"}


def boundary(crane, x3: float, points: int = 200) -> np.ndarray:
    """Tips (4 * points, 2) along the edges of the (alpha, beta) box at one extension, m."""
    (a0, a1), (b0, b1), _ = crane.joint_limits
    s = np.linspace(0.0, 1.0, points)
    alpha = np.concatenate([a0 + s * (a1 - a0), np.full(points, a1), a1 + s * (a0 - a1), np.full(points, a0)])
    beta = np.concatenate([np.full(points, b0), b0 + s * (b1 - b0), np.full(points, b1), b1 + s * (b0 - b1)])
    return crane.tip(np.column_stack([alpha, beta, np.full_like(alpha, x3)]))


def compute() -> dict[str, float]:
    crane = hc.load_machine("heinze-2007", overrides=LIMITS | REACHED | CORRECTED_IK)
    limits = np.asarray(crane.joint_limits)
    poses = np.random.default_rng(35).uniform(*limits.T, size=(400, 3))
    missed = 0
    for q in poses:
        found = crane.inverse_kinematics(crane.tip(q), x3=q[2])
        missed += not any(np.allclose(q, candidate, atol=1e-9) for candidate in found)
    reach = {x3: np.linalg.norm(boundary(crane, x3) - JOINT_2, axis=1).max() for x3 in limits[2]}
    return {
        "poses_not_recovered": missed / len(poses),
        "reach_from_joint_2_m": float(reach[limits[2, 1]]),
        "reach_gain_of_extension_m": float(reach[limits[2, 1]] - reach[limits[2, 0]]),
    }


def draw() -> None:
    fig, axes = figure(1, 2, (10.0, 5.0))
    cranes = {
        "Table 1": hc.load_machine("heinze-2007", overrides=LIMITS | REACHED),
        "printed cylinders": hc.load_machine("heinze-2007"),
    }
    for axis, (name, crane) in zip(axes.flat, cranes.items()):
        for x3, label, colour in zip(crane.joint_limits[2], ("retracted", "extended"), ("black", "tab:blue")):
            edge = boundary(crane, x3)
            axis.fill(*edge.T, color=colour, alpha=0.15)
            axis.plot(*edge.T, color=colour, label=label)
        axis.set(
            title=f"Figure 35, limits of {name}",
            xlabel="x [m]",
            ylabel="z [m]",
            aspect="equal",
            xlim=(-1.5, 4.6),
            ylim=(-3.6, 5.0),
        )
    axes[0, 0].legend(frameon=False)
    save(fig, "fig35_workspace")
