"""Draw the pictures of the front page and of the tutorials: ``python docs/pictures/make.py``."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import drive_the_tip  # noqa: E402

import hydrocrane as hc  # noqa: E402

FOLDER = Path(__file__).parent

if __name__ == "__main__":
    run = hc.simulate("vertical-lift-open-loop")
    run.animate(FOLDER / "lift.gif", fps=10, speed=1.5)
    run.plot("lift", path=FOLDER / "lift.png")
    drive_the_tip.draw_all(FOLDER)
