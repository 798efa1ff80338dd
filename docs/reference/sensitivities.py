"""Write the tables about sensitivities from what ``make bench`` measured: ``python docs/reference/sensitivities.py``.

Nothing between the marks of the two pages is typed.
"""

from __future__ import annotations

import json
from math import floor, log10
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
MEASURED = ROOT / "benches/sensitivities.json"
BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"
TITLES = {"single-cylinder-step": "rig", "vertical-lift-open-loop": "laboratory crane"}


def rounded(value: float) -> str:
    """Two digits, as a reader needs them."""
    digits = max(1 - floor(log10(abs(value))), 0)
    return f"{value:.{digits}f}"


def one_digit(value: float) -> str:
    """40, 0.1, 3e-3."""
    mantissa, exponent = f"{value:.0e}".split("e")
    return f"{float(f'{value:.0e}'):g}" if int(exponent) >= -1 else f"{mantissa}e{int(exponent)}"


def cost(results: dict[str, Any]) -> str:
    """CPU time of runs with slopes."""
    counts = list(next(iter(results["cost"].values()))["keys"])
    heads = [f"{count} key{'s' if count != '1' else ''}" for count in counts]
    lines = [f"| | run alone | {' | '.join(heads)} |", "|---" * (2 + len(counts)) + "|"]
    for scenario, row in results["cost"].items():
        about = f"{TITLES[scenario]}, `{scenario}`, {row['duration_s']:g} s, {row['times']} times"
        whole = [rounded(row["keys"][count]["ms"]) for count in counts]
        start = [rounded(row["keys"][count]["before_the_first_step_ms"]) for count in counts]
        lines.append(f"| {about} | {rounded(row['alone_ms'])} | {' | '.join(whole)} |")
        lines.append(f"| of it before the first step | | {' | '.join(start)} |")
    return "\n".join(lines)


def exactness(results: dict[str, Any]) -> str:
    """Errors of slopes against tolerance, with and without the slopes in the choice of steps."""
    lines = [
        "| method | rtol | steps by the states: steps, largest error | steps by the slopes too: steps, largest error |",
        "|---|---|---|---|",
    ]
    for row in results["exactness"]["rows"]:
        cells = [f"{row[n]['steps']}, {one_digit(row[n]['largest_error'])}" for n in ("states", "slopes")]
        lines.append(f"| `{row['method']}` | {one_digit(row['rtol'])} | {' | '.join(cells)} |")
    difference = results["exactness"]["reference_difference"]
    lines += [
        "",
        f"At rtol 1e-11 `tsit5` and `rodas5p` agree to {one_digit(difference)}; `rodas5p` there is the reference.",
    ]
    return "\n".join(lines)


PAGES = {
    ROOT / "docs/howto/parameter-sensitivities.md": cost,
    ROOT / "docs/theory/sensitivities.md": exactness,
}


def page(path: Path) -> str:
    """A page with its table brought up to date."""
    head, rest = path.read_text(encoding="utf-8").split(BEGIN)
    tail = rest.split(END)[1]
    table = PAGES[path](json.loads(MEASURED.read_text(encoding="utf-8")))
    return f"{head}{BEGIN}\n{table}\n{END}{tail}"


if __name__ == "__main__":
    for path in PAGES:
        path.write_text(page(path), encoding="utf-8")
