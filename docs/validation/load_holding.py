"""Where lowering through a counterbalance valve is steady and where it hunts: by linear stability and by runs.

Writes its part of docs/validation/mobile-hydraulics.md and its picture. Run with a Python that has hydrocrane;
takes a minute.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import marked_page
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import hydrocrane as hc

PAGE = Path(__file__).with_name("mobile-hydraulics.md")
PICTURE = Path(__file__).with_name("load-holding.png")

RATIOS = (1.0, 1.5, 2.0, 3.0, 4.5, 7.0)
LOADS = (100.0, 200.0, 400.0, 800.0)
# Lines of 10 mm at both chambers, m: their oil counts to the chambers.
LINES = (0.25, 10.0)
POSITION, SPOOL, DURATION = -0.1, 0.01, 6.0
# What counts as hunting: swing of the velocity over its mean in the last second.
SWING = 0.05
FRICTION = {"model": "static", "coulomb": 0, "breakaway": 0, "viscous-exponent": 1, "viscous": "20000 N s/m"}
VALVE = {
    "nominal-flow": "6 l/min",
    "nominal-pressure-drop": "16 bar",
    "compensator": "before-spool",
    "compensator-setting": "8 bar",
}
COUNTERBALANCE = {
    "cylinder": "test",
    "side": "rod-side",
    "setting": "110 bar",
    "opening-pressure": "30 bar",
    "nominal-flow": "20 l/min",
    "nominal-pressure-drop": "10 bar",
}


class Point(NamedTuple):
    """Growth rate (1/s) and frequency (Hz) of the least damped swing; swing of the velocity over its mean in a run."""

    growth: float
    frequency: float
    swing: float

    @property
    def agrees(self) -> bool:
        return (self.growth > 0) == (self.swing > SWING)


def machine(ratio: float, line: float) -> hc.Machine:
    """A mass that hangs on a cylinder whose rod side is held."""
    tables = {
        "friction.test": FRICTION,
        "valve.test": VALVE,
        "counterbalance.load": COUNTERBALANCE | {"pilot-ratio": ratio},
        "cylinder.test": {"dead-length": f"{line} m"},
    }
    return hc.load_machine(
        "single-cylinder", {f"{t}.{key}": v for t, keys in tables.items() for key, v in keys.items()}
    )


def steady(crane: hc.Machine, position: float, load: float) -> np.ndarray:
    """The state in which the load sinks evenly through `position`."""
    state = crane.equilibrium([position], payload=load)
    names = list(crane.state_names)
    v, p1, p2 = (names.index(name) for name in ("joint.slide.qd", "cylinder.test.p1", "cylinder.test.p2"))
    state[names.index("cylinder.test.xs")] = SPOOL

    def rate(of: int) -> float:
        return float(crane.state_derivative(state, [SPOOL], payload=load)[of])

    def close(rate_of: int, by: int, step: float) -> None:
        """Makes a rate zero that is nearly a straight line in one state."""
        for _ in range(4):
            before, state[by] = rate(rate_of), state[by] + step
            state[by] -= step + before * step / (rate(rate_of) - before)

    def left(fed: float) -> float:
        """p2' where the flow gives the speed, and speed and weight the pressure of the rod side."""
        state[p1] = fed
        close(p1, v, 1e-3)
        close(v, p2, 1e4)
        return rate(p2)

    brentq(left, 1e4, 100e5, xtol=1e-3)
    return state


def lowered(crane: hc.Machine, load: float) -> tuple[float, float]:
    """Position, and swing of the velocity over its mean, in the last second of a run that begins at rest."""
    scenario = hc.Scenario(
        machine=crane,
        joints={"slide": POSITION},
        commands={"test": hc.Command([0.0, 0.1, 0.4, DURATION], [0.0, 0.0, SPOOL, SPOOL], "linear")},
        payload=load,
        duration=DURATION,
        record_interval=0.002,
    )
    run = hc.simulate(scenario, rtol=1e-6)
    assert run.outcome.kind == "completed", run.outcome
    late = run.data.isel(time=run.data.time.values > DURATION - 1)
    v = late["joint.slide.qd"].values
    return float(late["joint.slide.q"].mean()), float(np.std(v) * math.sqrt(8) / np.mean(v))


def point(ratio: float, load: float, line: float) -> Point:
    crane = machine(ratio, line)
    position, swing = lowered(crane, load)
    values = np.linalg.eigvals(crane.jacobian(steady(crane, position, load), [SPOOL], payload=load))
    # The spool's own mode is the same everywhere.
    swinging = values[(values.imag > 1.0) & (np.abs(values) < 900.0)]
    least = swinging[np.argmax(swinging.real)] if len(swinging) else complex(values.real.max(), 0.0)
    return Point(float(least.real), float(abs(least.imag)) / (2 * math.pi), swing)


def picture(found: dict[tuple[float, float, float], Point]) -> None:
    figure, charts = plt.subplots(1, len(LINES), figsize=(11, 3.8), layout="constrained", sharey=True)
    for chart, line in zip(charts, LINES, strict=True):
        for (ratio, load, of), at in found.items():
            if of == line:
                hunts, ran = at.growth > 0, at.swing > SWING
                chart.plot(ratio, load, "s", ms=13, mfc="none", mec="tab:red" if hunts else "tab:blue", mew=2)
                chart.plot(ratio, load, "x" if ran else "o", ms=6, color="tab:red" if ran else "tab:blue")
        chart.set(xscale="log", yscale="log", xlabel="pilot ratio", title=f"lines of {line:g} m")
        chart.set_xticks(RATIOS, [f"{ratio:g}" for ratio in RATIOS], minor=False)
        chart.set_yticks(LOADS, [f"{load:.0f}" for load in LOADS], minor=False)
        chart.minorticks_off()
    charts[0].set_ylabel("load, kg")
    figure.suptitle("frame: linear stability, inside: run (red hunts, blue is steady)", fontsize=10)
    figure.savefig(PICTURE, dpi=110)


def table(found: dict[tuple[float, float, float], Point]) -> list[str]:
    lines = [
        "| lines, m | load, kg | " + " | ".join(f"ratio {ratio:g}" for ratio in RATIOS) + " |",
        "|" + "---|" * (2 + len(RATIOS)),
    ]
    for line in LINES:
        for load in LOADS:
            of = [found[ratio, load, line] for ratio in RATIOS]
            cells = [f"{at.growth:+.1f} 1/s at {at.frequency:.1f} Hz, {100 * at.swing:.0f} %" for at in of]
            lines.append(f"| {line:g} | {load:.0f} | " + " | ".join(cells) + " |")
    return lines


def numbers() -> list[str]:
    cases = [(ratio, load, line) for line in LINES for load in LOADS for ratio in RATIOS]
    found = {case: point(*case) for case in cases}
    picture(found)
    agreed = sum(at.agrees for at in found.values())
    border = max((abs(at.growth) for at in found.values() if not at.agrees), default=0.0)
    hunting = sum(at.growth > 0 for at in found.values())
    return [
        f"{len(found)} operating points, {hunting} of them unstable by eigenvalues; runs agree in {agreed}.",
        f"The others are within {border:.1f} 1/s of the border, too slow for {DURATION:g} s to show.",
        "A cell: growth rate and frequency of the least damped oscillation, and the velocity oscillation of a run.",
        "",
        *table(found),
        "",
        "![Stable and hunting points](load-holding.png)",
    ]


if __name__ == "__main__":
    marked_page.write(PAGE, numbers(), "load_holding")
