"""Figures 48 to 53: how the static friction map is put together, property by property."""

from __future__ import annotations

import numpy as np
from common import figure, save

import hydrocrane as hc

COULOMB, BREAKAWAY, VISCOUS = 160.0, 340.0, 8000.0  # Table 3, Rottne cylinder, extending, no load
SPEEDS = np.concatenate([[1e-7], np.linspace(1e-5, 0.05, 2000)])  # the first shows stiction


def friction(breakaway=COULOMB, viscous=0.0, stribeck=0.002, exponent=2.0, v=SPEEDS) -> np.ndarray:
    """Static map of the extension cylinder with the given parameters, N."""
    key = "friction.extension."
    crane = hc.load_machine(
        "rottne-f9-lab",
        overrides={
            key + "model": "static",
            key + "coulomb": COULOMB,
            key + "breakaway": breakaway,
            key + "viscous": viscous,
            key + "viscous-exponent": 1.5,
            key + "stribeck-velocity": stribeck,
            key + "stribeck-exponent": exponent,
            key + "smoothing-velocity": 1e-8,
        },
    )
    return crane.friction_map(v, cylinder="extension")


def curves() -> dict[str, dict[str, np.ndarray]]:
    """The curves of each figure by label."""
    full = {"viscous": VISCOUS, "breakaway": BREAKAWAY}
    return {
        "48": {"Coulomb": friction()},
        "49": {"Coulomb + viscous": friction(viscous=VISCOUS)},
        "50": {"+ stiction": friction(**full, stribeck=1e-5)},
        "51": {"+ Stribeck": friction(**full)},
        "52": {f"{1e3 * v:g} mm/s": friction(**full, stribeck=v) for v in (0.001, 0.002, 0.004, 0.008)},
        "53": {f"exponent {d:g}": friction(**full, exponent=d) for d in (0.5, 1.0, 2.0, 4.0)},
    }


def properties(family: dict[str, dict[str, np.ndarray]]) -> dict[str, list[bool]]:
    """What the text says about each figure, as yes or no."""
    one = {which: next(iter(group.values())) for which, group in family.items()}
    odd = np.allclose(friction(viscous=VISCOUS, v=-SPEEDS), -one["49"])
    by_speed, by_exponent = np.array(list(family["52"].values())), np.array(list(family["53"].values()))
    fast = SPEEDS > 0.003  # above the Stribeck velocity of Figure 53
    beyond = SPEEDS > 2e-4
    return {
        "48": [np.allclose(one["48"], COULOMB)],
        "49": [odd, np.isclose(one["49"][0], COULOMB, rtol=1e-3), np.all(np.diff(one["49"]) > 0)],
        "50": [
            friction(BREAKAWAY, VISCOUS, 1e-5, v=np.array([1e-7]))[0] > 0.99 * BREAKAWAY,
            np.allclose(one["50"][beyond], one["49"][beyond]),
        ],
        "51": [
            one["51"][0] > 0.99 * BREAKAWAY,
            0 < one["51"].argmin() < len(SPEEDS) - 1,
            np.all(one["51"] >= one["49"] - 1e-9),
        ],
        "52": [np.all(np.diff(by_speed, axis=0) >= -1e-9)],
        "53": [np.all(np.diff(by_exponent[:, fast], axis=0) <= 1e-9)],
    }


def compute() -> dict[str, float]:
    checks = properties(curves())
    return {f"figure_{which}_violations": float(np.sum(~np.array(held))) for which, held in checks.items()}


def draw() -> None:
    fig, axes = figure(2, 3, (11.0, 6.0))
    for axis, (which, group) in zip(axes.flat, curves().items()):
        for label, force in group.items():
            axis.plot(1e3 * SPEEDS, force, label=label)
        axis.set(title=f"Figure {which}", xlabel="piston velocity [mm/s]", ylabel="friction [N]", ylim=(0, 360))
        axis.legend(frameon=False, fontsize=8)
    save(fig, "fig48_53_friction_maps")
