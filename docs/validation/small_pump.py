"""Tip control on pumps that give less than the motion needs, with and without what the controller knows of them.

Writes the numbers of docs/validation/mobile-hydraulics.md. Run with a Python that has hydrocrane; takes a few seconds.
"""

from __future__ import annotations

from pathlib import Path

import marked_page
import numpy as np

import hydrocrane as hc

PAGE = Path(__file__).with_name("mobile-hydraulics.md")
MACHINE = "rottne-f9-mobile"
START = {"boom": np.deg2rad(100.0), "jib": np.deg2rad(100.0), "extension": 0.0}
SPEED = 0.3
DISPLACEMENTS = ("18 ml", "8 ml", "5 ml", "3 ml")
LARGE = {"pump.main.displacement": DISPLACEMENTS[0]}
# Deflections of the stick in x and z from 0.5 s on, each held for 2 s; load in kg.
MOTIONS = {
    "up": ([[0, 1], [0, 1]], 250.0),
    "up and out": ([[0.7, 0.7], [0.7, 0.7]], 250.0),
    "out and back": ([[1, 0], [-1, 0]], 250.0),
    "down": ([[0, -1], [0, -1]], 500.0),
}


def run(motion: str, displacement: str, model: dict[str, str] | None) -> hc.Run:
    sticks, payload = MOTIONS[motion]
    x, z = np.transpose([[0, 0], *sticks, [0, 0]]).tolist()
    stick = hc.Joystick([0.0, 0.5, 2.5, 4.5], {"x": x, "z": z}, full_speed=SPEED)
    scenario = hc.Scenario(
        machine=MACHINE,
        joints=START,
        joystick=stick,
        payload=payload,
        duration=6.0,
        overrides={"pump.main.displacement": displacement},
        controller_model=model,
    )
    return hc.simulate(scenario)


def row(motion: str, displacement: str) -> str:
    knowing, ignorant = (run(motion, displacement, model) for model in (None, LARGE))
    way = np.hypot(*(np.diff(knowing.data[f"tip.{axis}"].values) for axis in "xz")).sum()
    kinds = {warning.kind for warning in knowing.warnings}
    cells = [motion, f"{MOTIONS[motion][1]:.0f}", displacement.removesuffix(" ml"), f"{way / 4.0:.2f}"]
    cells += [f"{1e3 * np.nanmax(np.abs(r.data['tip.deviation'].values)):.1f}" for r in (knowing, ignorant)]
    return "| " + " | ".join([*cells, "yes" if "pump-saturated" in kinds else "no"]) + " |"


def numbers() -> list[str]:
    lines = [
        "| motion | load, kg | pump, ml | mean speed of the tip, m/s | off its path, mm "
        "| the same without knowledge of the pump, mm | pump saturated |",
        "|" + "---|" * 7,
    ]
    return lines + [row(motion, displacement) for motion in MOTIONS for displacement in DISPLACEMENTS]


if __name__ == "__main__":
    marked_page.write(PAGE, numbers(), "small_pump")
