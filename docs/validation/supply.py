"""One lift by three supplies: where the energy of the shaft goes, and what a small pump does to the motion.

Writes docs/validation/supply.md and its picture. Run with a Python that has hydrocrane installed; takes a few seconds.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import hydrocrane as hc

PAGE = Path(__file__).with_name("supply.md")
PICTURE = Path(__file__).with_name("supply.png")
SCENARIO = "vertical-lift-open-loop"

PUMP = """extends = "rottne-f9-lab"
[machine]
class = "assumed"
source = "comparison of supplies"
[pump.main]
type = "{kind}"
displacement = "{displacement}"
speed = "1450 rpm"
volumetric-efficiency = 0.94
hydromechanical-efficiency = 0.9
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
# Where the energy of the shaft goes, by the terms of the ledger.
SHARES = {
    "delivered to the valves": "ledger.mains.delivered",
    "relief valve": "ledger.mains.relief",
    "leakage of the pump": "ledger.mains.pump_leakage",
    "rubbing in the pump": "ledger.mains.rubbing",
}


def runs() -> dict[str, hc.Run]:
    """The lift by each supply."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, pump in SUPPLIES.items():
            machine: str | Path = "rottne-f9-lab"
            if pump is not None:
                machine = Path(folder) / "machine.toml"
                machine.write_text(PUMP.format(kind=pump[0], displacement=pump[1]), encoding="utf-8")
            found[name] = hc.simulate(SCENARIO, machine=machine, rtol=1e-6)
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
        "| rubbing, kJ | least pressure, bar | tip ends off the ideal supply's, mm |",
        "|" + "---|" * 9,
    ]
    for name, run in found.items():
        off = np.hypot(last(run, "tip.x") - last(ideal, "tip.x"), last(run, "tip.z") - last(ideal, "tip.z"))
        numbers = [last(run, "ledger.mains.shaft"), delivered(run), losses_at_edges(run)]
        numbers += [last(run, f"ledger.mains.{term}") for term in ("relief", "pump_leakage", "rubbing")]
        least = run.data["mains.p"].min().item() / 1e5 if "mains.p" in run.data else 140.0
        cells = [f"{number / 1e3:.2f}" if np.isfinite(number) else "-" for number in numbers]
        lines.append(f"| {name} | " + " | ".join(cells) + f" | {least:.0f} | {1e3 * off:.1f} |")
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


def page() -> str:
    head = PAGE.read_text(encoding="utf-8").split("<!-- numbers -->")[0]
    found = runs()
    picture(found)
    return head + "\n".join(["<!-- numbers -->", "", *table(found), "", "![Energy and pressure](supply.png)", ""])


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE)
