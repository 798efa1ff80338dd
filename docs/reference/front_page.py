"""Write the evidence of ``README.md`` from the files that hold it: ``python docs/reference/front_page.py``.

Nothing between the two marks is typed.
"""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "README.md"
BEGIN, END = "<!-- evidence: begin -->", "<!-- evidence: end -->"


def reproduction() -> str:
    """The headline of the validation page."""
    text = (ROOT / "docs/validation/heinze-2007.md").read_text(encoding="utf-8")
    found = re.search(r"^Of \d+ figures and tables .*$", text, re.MULTILINE)
    if found is None:
        raise SystemExit("the validation page has lost its headline; run `make docs`")
    return f"* Reproduction of the thesis: {found[0]} [Details](docs/validation/heinze-2007.md)"


def speed() -> str:
    """What `make bench` measured last."""
    results = json.loads((ROOT / "benches/results.json").read_text(encoding="utf-8"))
    race = results["open_loop"]
    ours, method = race["rows"][race["ours"]], race["ours"].split()[-1]
    processor = " ".join(results["about"]["sections"]["open_loop"]["processor"].replace("(R)", "").split())

    def ratio(name: str) -> str:
        return f"{race['rows'][name]['ratio']:.1f}" if name in race["rows"] else "(not measured)"

    fast, off = ours["times_real_time"], ours["tip_error_m"] * 1e6
    return (
        f'* Speed: `vertical-lift-open-loop` (5 s) with `method="{method}"` runs {fast:.0f} times faster than real '
        f"time on one core ({processor}), with a tip error of {off:.0f} um: the solver alone, with states "
        "recorded every 10 ms, without reading files, energies, outputs and Python. At the same or a smaller error, "
        f"CVODE's BDF on the same compiled laws takes {ratio('CVODE BDF')} times as long, and CasADi's CVODES "
        f"on a compiled model takes {ratio('CasADi CVODES')} times as long. "
        "[What was compared](docs/validation/speed.md)"
    )


def tip_control() -> str:
    """The worst deviations in the table of the tip-control benchmark."""
    with (ROOT / "docs/validation/tip-control/control-benchmark.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))

    def worst(name: str, sensors: str, log: bool) -> float:
        found = (
            float(row["path_max"]) * 1e3
            for row in rows
            if (row["controller"], row["sensors"]) == (name, sensors)
            and row["outcome"] == "completed"
            and row["task"].startswith("log") == log
            and not row["variant"]
            and not float(row["drop_out"])
            and float(row["period"] or 0.0) <= 0.02
        )
        return max(found)

    return (
        "* Tip control (simulated, machine without faults), largest distance from the path over the cases of the "
        f"benchmark: {worst('tip', 'ideal', False):.1f} mm with ideal sensors, "
        f"{worst('tip', 'data-sheet', False):.1f} mm with data-sheet sensors, "
        f"{worst('tip', 'ideal', True):.0f} mm while it picks up a log of unknown mass. For "
        f"comparison: {worst('pi', 'ideal', False):.0f} mm with a tuned PI with pressure feedback, "
        f"{worst('heinze-pid', 'ideal', False):.0f} mm with the thesis's controller. "
        "[Details](docs/validation/tip-control.md)"
    )


def page() -> str:
    """README.md with its evidence brought up to date."""
    text = PAGE.read_text(encoding="utf-8")
    head, rest = text.split(BEGIN)
    tail = rest.split(END)[1]
    return f"{head}{BEGIN}\n{reproduction()}\n{speed()}\n{tip_control()}\n{END}{tail}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
