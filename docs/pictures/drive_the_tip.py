"""Pictures of the tutorial on tip control, drawn from the runs that it makes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

import hydrocrane as hc
from hydrocrane.benchmark.fitted_tasks import walk
from hydrocrane.plots.style import COLOURS, MUTED, figure, styled, write
from hydrocrane.results.run import Run

START = {"boom": np.radians(100.0), "jib": np.radians(100.0), "extension": 0.0}
UP = hc.Joystick([0.5, 4.5, 5.0, 9.0], {"z": [1.0, 0.0, -1.0, 0.0]}, full_speed=0.1, ramp=0.2)
MILLIMETRE, SECOND = "[mm]", "time [s]"


def drive(stick: hc.Joystick = UP, duration: float = 10.0, **options) -> Run:
    """A run of the laboratory crane under a stick, with the controller `tip` where none is named."""
    choice = {"controller": "tip", **options}
    return hc.simulate(hc.Scenario(joints=START, joystick=stick, duration=duration, **choice), ledger=False)


def of(run: Run, name: str) -> np.ndarray:
    return run.data[name].values


@styled
def set_point():
    """Stick, set-point and tip during the first second, and the distance between the last two."""
    run = drive(duration=2.5)
    fig, (left, right) = figure(9.5, 3.6, ncols=2)
    time, start = of(run, "time"), of(run, "tip.z")[0]
    asked = np.concatenate([[0.0], np.cumsum(of(run, "stick.z")[:-1] * 0.1 * np.diff(time))])
    left.plot(time, asked * 1e3, color=MUTED, ls="--", label="integral of the stick")
    left.plot(time, (of(run, "set_point.z") - start) * 1e3, label="set-point")
    left.plot(time, (of(run, "tip.z") - start) * 1e3, label="tip", lw=1)
    left.set(xlim=(0.4, 1.5), ylim=(-5, 100), xlabel=SECOND, ylabel=f"height above the start {MILLIMETRE}")
    left.set_title("What the stick asks, and what is followed")
    left.legend()
    gap = np.hypot(*(of(run, f"set_point.{axis}") - of(run, f"tip.{axis}") for axis in "xz"))
    right.plot(time, gap * 1e3, color=COLOURS[4])
    right.set(xlim=(0.0, 2.4), xlabel=SECOND, ylabel=f"from the set-point {MILLIMETRE}")
    right.set_title("Distance of the tip from its set-point")
    return fig


@styled
def three_ways():
    """The same line under `tip`, `heinze-pid`, and `tip` with the crane's own sensors."""
    runs = {
        "heinze-pid": drive(controller="heinze-pid"),
        "tip": drive(),
        "tip, data-sheet sensors": drive(sensors="data-sheet", seed=1),
    }
    fig, (left, right) = figure(9.5, 4.4, ncols=2)
    for name, colour in zip(runs, (COLOURS[4], COLOURS[0], COLOURS[1]), strict=True):
        aside, height = (of(runs[name], f"tip.{axis}") for axis in "xz")
        left.plot((aside - aside[0]) * 1e3, (height - height[0]) * 1e3, color=colour, label=name)
        if name != "heinze-pid":
            right.plot(of(runs[name], "time"), (aside - aside[0]) * 1e3, color=colour, label=name)
    left.set(xlabel=f"x from the line {MILLIMETRE}", ylabel=f"height {MILLIMETRE}", title="The path of the tip")
    right.set(xlabel=SECOND, ylabel=f"x from the line {MILLIMETRE}", title="Without the thesis's controller, closer")
    left.legend()
    right.legend()
    return fig


def _speed(axes: Axes, run: Run, asked: float) -> None:
    time = of(run, "time")
    axes.plot(time, np.gradient(of(run, "tip.x"), time) * 1e3, label=f"asked {asked * 1e3:.0f} mm/s")


@styled
def too_fast():
    """The speed of the tip and its deviation where the stick asks for more than there is."""
    crane = hc.load_machine("rottne-f9-lab")
    feasible = walk(crane, np.array(list(START.values())), np.array([1.0, 0.0]), 0.4).feasible_speed
    fig, (left, right) = figure(9.5, 3.6, ncols=2)
    for asked in (0.1, 0.2, 0.4):
        stick = hc.Joystick([0.5, 0.5 + 0.4 / asked], {"x": [1.0, 0.0]}, full_speed=asked, ramp=0.2)
        run = drive(stick, 6.0)
        _speed(left, run, asked)
        height = of(run, "tip.z")
        right.plot(of(run, "time"), (height - height[0]) * 1e3, lw=0.9)
    left.axhline(feasible * 1e3, color=MUTED, ls="--", label="feasible along 0.4 m")
    left.set(ylim=(-20, 250), xlabel=SECOND, ylabel="speed outwards [mm/s]", title="The speed gives way,")
    left.legend(ncols=2, loc="upper right")
    right.set(xlabel=SECOND, ylabel=f"z from the line {MILLIMETRE}", title="the direction does not")
    return fig


def draw_all(folder: Path) -> None:
    """Write every picture of the tutorial."""
    for name, make in (("tip-set-point", set_point), ("tip-three-ways", three_ways), ("tip-too-fast", too_fast)):
        write(make(), folder / f"{name}.png")
