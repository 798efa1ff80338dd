"""One lift by several supplies, in open loop and by tip control: where the energy of the shaft goes.

Writes its part of docs/validation/mobile-hydraulics.md and its picture. Run with a Python that has hydrocrane;
takes a few seconds.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import marked_page
import matplotlib.pyplot as plt
import numpy as np

import hydrocrane as hc

PAGE = Path(__file__).with_name("mobile-hydraulics.md")
PICTURE = Path(__file__).with_name("supply.png")
SCENARIO = "vertical-lift-open-loop"

PUMP = """extends = "rottne-f9-lab"
[machine]
class = "assumed"
source = "comparison of supplies"
[supply]
pressure = "{pressure}"
[pump.main]
type = "{kind}"
displacement = "{displacement}"
speed = "1450 rpm"
volumetric-efficiency = 0.94
hydromechanical-efficiency = 0.9
{more}
[mains]
volume = "0.4 l"
hose-compliance = "0.04 ml/bar"
relief-gradient = "4 l/(min bar)"
"""
SUPPLIES = {
    "constant pressure": None,
    "fixed, 12 ml": ("fixed", "12 ml"),
    "pressure-compensated, 12 ml": ("pressure-compensated", "12 ml"),
    "pressure-compensated, 5 ml": ("pressure-compensated", "5 ml"),
}

# The same path by tip control, with compensated sections.
PATH = "tip-vertical-line"
SECTION = """[valve.{name}]
type = "4/3"
nominal-flow = "12 l/min"
nominal-pressure-drop = "16 bar"
compensator = "{compensator}"
"""
COMMON = "return-area-ratio = [0.4, 1]\n"
SETTING = 'compensator-setting = "8 bar"\n'
BEFORE, BEHIND, MARGIN = "before-spool", "behind-spool", 'ls-margin = "20 bar"'
SEPARATE = "load sensing, separate meter-out"
FEEDS = {
    "fixed": ("fixed", "", BEFORE),
    "fixed, unloaded": ("fixed", MARGIN, BEFORE),
    "pressure-compensated": ("pressure-compensated", "", BEFORE),
    "load sensing, compensators before the spools": ("load-sensing", MARGIN, BEFORE),
    "load sensing, flow sharing": ("load-sensing", MARGIN, BEHIND),
    SEPARATE: ("load-sensing", MARGIN, BEFORE),
}
# Ports A and B: the piston sides carry 20 to 45 bar on this path and are braked, the rod sides are nearly free.
RETURNS = 'return-area-ratio = 1\nreturn-pressure = ["50 bar", "3 bar"]\n'
# Where the energy of the shaft goes, by the terms of the ledger.
SHARES = {
    "delivered to the valves": "ledger.mains.delivered",
    "relief valve": "ledger.mains.relief",
    "leakage of the pump": "ledger.mains.pump_leakage",
    "mechanical loss of the pump": "ledger.mains.mechanical_loss",
}


PATH_TEXT = """The path of `tip-vertical-line` (8 s, tip control, the crane's own sensors) with compensated sections on
pumps of 18 ml and at most 180 bar: one motion, so only the supply differs, and in the last row the return:
separate spools keep 50 bar in the piston sides and 3 bar in the rod sides while these drain."""


def runs() -> dict[str, hc.Run]:
    """The lift by each supply."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, pump in SUPPLIES.items():
            machine: str | Path = "rottne-f9-lab"
            if pump is not None:
                machine = Path(folder) / "machine.toml"
                machine.write_text(
                    PUMP.format(pressure="140 bar", kind=pump[0], displacement=pump[1], more=""), encoding="utf-8"
                )
            found[name] = hc.simulate(SCENARIO, machine=machine, rtol=1e-6)
    return found


def runs_on_a_path() -> dict[str, hc.Run]:
    """The path of tip control by each supply, all with the same sections."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, (kind, more, compensator) in FEEDS.items():
            rest = (SETTING if compensator == BEFORE else "") + (RETURNS if name == SEPARATE else COMMON)
            sections = [SECTION.format(name=c, compensator=compensator) + rest for c in ("lift", "jib", "extension")]
            machine = Path(folder) / "machine.toml"
            text = PUMP.format(pressure="180 bar", kind=kind, displacement="18 ml", more=more)
            machine.write_text(text + "".join(sections), encoding="utf-8")
            found[name] = hc.simulate(PATH, machine=machine, rtol=1e-6)
    return found


def last(run: hc.Run, name: str) -> float:
    return float(run.data[name].values[-1]) if name in run.data else float("nan")


def delivered(run: hc.Run) -> float:
    """Work of the supply on all valves, J."""
    return sum(last(run, f"ledger.{cylinder}.supply") for cylinder in run.cylinder_names)


def losses_at_edges(run: hc.Run) -> float:
    edges = ("edge_pa", "edge_at", "edge_pb", "edge_bt")
    return sum(last(run, f"ledger.{cylinder}.{edge}") for cylinder in run.cylinder_names for edge in edges)


def table(found: dict[str, hc.Run]) -> list[str]:
    ideal = found["constant pressure"]
    lines = [
        "| supply | shaft, kJ | delivered, kJ | of it lost at metering edges, kJ | relief, kJ | pump leakage, kJ "
        "| mechanical loss, kJ | least pressure, bar | tip ends off the ideal supply's, mm |",
        "|" + "---|" * 9,
    ]
    for name, run in found.items():
        off = np.hypot(last(run, "tip.x") - last(ideal, "tip.x"), last(run, "tip.z") - last(ideal, "tip.z"))
        numbers = [last(run, "ledger.mains.shaft"), delivered(run), losses_at_edges(run)]
        numbers += [last(run, f"ledger.mains.{term}") for term in ("relief", "pump_leakage", "mechanical_loss")]
        least = run.data["mains.p"].min().item() / 1e5 if "mains.p" in run.data else 140.0
        cells = [f"{number / 1e3:.2f}" if np.isfinite(number) else "-" for number in numbers]
        lines.append(f"| {name} | " + " | ".join(cells) + f" | {least:.0f} | {1e3 * off:.1f} |")
    return lines


def table_of_the_path(found: dict[str, hc.Run]) -> list[str]:
    lines = [
        "| supply | shaft, kJ | metering edges, kJ | compensators, kJ | relief, kJ "
        "| pump leakage and mechanical loss, kJ | tip off its path, mm |",
        "|" + "---|" * 7,
    ]
    for name, run in found.items():
        of_pump = last(run, "ledger.mains.pump_leakage") + last(run, "ledger.mains.mechanical_loss")
        ledger = (last(run, f"ledger.{term}") for term in ("valves.compensators", "mains.relief"))
        numbers = [last(run, "ledger.mains.shaft"), losses_at_edges(run), *ledger, of_pump]
        off = abs(run.data["tip.deviation"].values)
        cells = [f"{number / 1e3:.2f}" for number in numbers]
        lines.append(f"| {name} | " + " | ".join(cells) + f" | {1e3 * np.nanmax(off):.1f} |")
    return lines


def picture(found: dict[str, hc.Run]) -> None:
    pumped = {name: run for name, run in found.items() if "mains.p" in run.data}
    figure, (bars, course) = plt.subplots(1, 2, figsize=(11, 3.6), layout="constrained")
    left = np.zeros(len(pumped))
    for label, term in SHARES.items():
        width = np.array([last(run, term) for run in pumped.values()]) / 1e3
        bars.barh(list(pumped), width, left=left, label=label)
        left += width
    bars.set_xlabel("energy of the shaft in 5 s, kJ")
    bars.invert_yaxis()
    bars.legend(fontsize=8)
    for name, run in pumped.items():
        course.plot(run.data.time, run.data["mains.p"] / 1e5, label=name)
    course.set_xlabel("time, s")
    course.set_ylabel("pressure of the mains, bar")
    course.legend(fontsize=8)
    figure.savefig(PICTURE, dpi=110)


def numbers() -> list[str]:
    found = runs()
    picture(found)
    text = ["", "![Energy and pressure](supply.png)", "", PATH_TEXT, ""]
    return [*table(found), *text, *table_of_the_path(runs_on_a_path())]


if __name__ == "__main__":
    marked_page.write(PAGE, numbers(), "supply")
