"""Run every script of the reproduction and write `docs/validation/heinze-2007.md`.

python reproductions/heinze-2007/make.py            compare with expected/, draw, write the page
python reproductions/heinze-2007/make.py --update   accept the numbers found as the expected ones
"""

from __future__ import annotations

import argparse
import importlib
import math
import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from common import EXPECTED, PICTURES, ROOT  # noqa: E402

PAGE = ROOT / "docs" / "validation" / "heinze-2007.md"
# Failures first.
STATUSES = ("not-reproduced", "qualitative", "reproduced", "not-attempted", "not-reproducible")
JUDGED = STATUSES[:3]
RELATIVE, ABSOLUTE = 1e-6, 1e-9


def items() -> list[dict]:
    """The entries of figures.toml."""
    return tomllib.loads((HERE / "figures.toml").read_text(encoding="utf-8"))["item"]


def statements() -> list[dict]:
    """The further statements of figures.toml, which are judged like figures and not counted among them."""
    return tomllib.loads((HERE / "figures.toml").read_text(encoding="utf-8"))["statement"]


def scripts() -> list[str]:
    """Names of all scripts with numbers, the evidence of the errata included."""
    return sorted({Path(i["script"]).stem for i in items() if "script" in i}) + [
        "errata_effects",
        "errata_evidence",
        "errata_switches",
        "published_heights",
        "sampling_study",
    ]


def compute(script: str) -> dict[str, float]:
    """The numbers one script finds."""
    return importlib.import_module(script).compute()


def expected(script: str) -> dict[str, float]:
    """The accepted numbers of one script."""
    return tomllib.loads((EXPECTED / f"{script}.toml").read_text(encoding="utf-8"))


def accept(script: str, numbers: dict[str, float]) -> None:
    """Write the numbers of one script as the expected ones."""
    EXPECTED.mkdir(exist_ok=True)
    lines = [f"# Accepted numbers of {script}.py; SI unless the name says otherwise."]
    lines += [f'"{key}" = {float(value)!r}' for key, value in numbers.items()]
    (EXPECTED / f"{script}.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")


def differences(script: str, found: dict[str, float]) -> list[str]:
    """What differs between found and accepted numbers, one line each."""
    accepted = expected(script)
    repeatability = getattr(importlib.import_module(script), "repeatability", lambda _: ABSOLUTE)
    lines = [f"{key}: only in one of the two sets" for key in found.keys() ^ accepted.keys()]
    lines += [
        f"{key}: found {found[key]!r}, expected {accepted[key]!r}"
        for key in found.keys() & accepted.keys()
        if not math.isclose(found[key], accepted[key], rel_tol=RELATIVE, abs_tol=repeatability(key))
    ]
    return sorted(lines)


def contradictions(entries: list[dict], numbers: dict[str, dict[str, float]]) -> list[str]:
    """Entries whose status is not what their number and tolerance say."""
    lines = []
    for entry in entries:
        if entry["status"] in JUDGED:
            value = numbers[Path(entry["script"]).stem][entry["number"]]
            within = value <= entry["tolerance"]
            if within == (entry["status"] == "not-reproduced"):
                lines.append(f"{entry['id']} is {entry['status']} with {value:g} against {entry['tolerance']:g}")
    return lines


def headline(entries: list[dict]) -> str:
    """Counts by status, computed."""
    counts = {status: sum(e["status"] == status for e in entries) for status in STATUSES}
    judged = sum(counts[s] for s in JUDGED)
    return (
        f"Of {len(entries)} figures and tables {judged} can be judged with the models built so far: "
        f"**{counts['reproduced']} reproduced**, {counts['qualitative']} agree qualitatively, "
        f"**{counts['not-reproduced']} not reproduced**. {counts['not-attempted']} were not attempted, "
        f"{counts['not-reproducible']} cannot be reproduced."
    )


def told(further: list[dict]) -> str:
    """Counts of the statements, computed."""
    counts = ", ".join(f"{sum(e['status'] == s for e in further)} {s}" for s in JUDGED)
    return f"Further numbers that the text states about a figure: {counts}."


def label(entry: dict) -> str:
    kind, number = entry["id"].split("-")
    if kind == "statement":
        return f"Text to Figure {number}"
    return f"{kind.capitalize()} {number}"


def ordered(entries: list[dict]) -> list[dict]:
    return sorted(entries, key=lambda e: STATUSES.index(e["status"]))


def judged_rows(entries: list[dict], numbers: dict[str, dict[str, float]]) -> list[str]:
    rows = ["| | content | status | measure | found | tolerance | script |", "|---|---|---|---|---|---|---|"]
    for e in ordered(entries):
        if e["status"] in JUDGED:
            value = numbers[Path(e["script"]).stem][e["number"]]
            unit = "" if e["unit"] == "1" else " " + e["unit"]
            rows.append(
                f"| {label(e)} | {e['title']} | {e['status']} | {e['metric']} | {value:.3g}{unit} | "
                f"{e['tolerance']:g}{unit} | `{e['script']}` |"
            )
    return rows


def notes(entries: list[dict], numbers: dict[str, dict[str, float]]) -> list[str]:
    """Pictures, tables and notes of the judged entries, script by script."""
    lines: list[str] = []
    for script in dict.fromkeys(e["script"] for e in ordered(entries) if "script" in e):
        group = [e for e in entries if e.get("script") == script]
        lines += ["", f"### {', '.join(label(e) for e in group)}", ""]
        lines += [f"![{p.stem}](heinze-2007/{p.name})" for p in sorted(PICTURES.glob(f"{Path(script).stem}*.png"))]
        if hasattr(module := importlib.import_module(Path(script).stem), "report"):
            lines += ["", *module.report(numbers[Path(script).stem])]
        by_note: dict[str, list[dict]] = {}
        for e in group:
            by_note.setdefault(e["note"], []).append(e)
        lines += [""] + [
            f"- {', '.join(label(e) for e in same)}: {note} *Tolerance: {same[0]['tolerance-reason']}*"
            for note, same in by_note.items()
        ]
    return lines


def unattempted_rows(entries: list[dict]) -> list[str]:
    rows = ["| | content | kind | status | reason |", "|---|---|---|---|---|"]
    return rows + [
        f"| {label(e)} | {e['title']} | {e['kind']} | {e['status']} | {e['note']} |"
        for e in entries
        if e["status"] not in JUDGED
    ]


def switch_rows(numbers: dict[str, float]) -> list[str]:
    """Tip heights of the published runs, one row per corrected switch."""
    columns = list(dict.fromkeys(key.split(".")[1] for key in numbers))
    rows = [
        "| corrected alone | vertical, 3 s | vertical, 5 s | horizontal, 3 s | horizontal, 5 s |",
        "|---|---|---|---|---|",
    ]
    for case in dict.fromkeys(key.split(".")[0] for key in numbers):
        rows.append(f"| {case} | " + " | ".join(f"{numbers[f'{case}.{c}']:.2f} m" for c in columns) + " |")
    return rows


def height_rows(numbers: dict[str, dict[str, float]]) -> list[str]:
    """Tip heights of the two published tasks, from the statement of the thesis to the corrected machine."""
    module = importlib.import_module("published_heights")
    columns = [f"{task}_z_at_{instant:g}s_m" for task in ("vertical", "horizontal") for instant in module.INSTANTS]
    models = {text: [numbers["published_heights"][f"{row}.{c}"] for c in columns] for row, text in module.ROWS.items()}
    inside = {
        "hydrocrane as printed, PID inside the solver": "as-printed",
        "the same with gravity downwards": "gravity-sign",
    }
    models |= {text: [numbers["errata_switches"][f"{case}.{c}"] for c in columns] for text, case in inside.items()}
    return [
        "| model | vertical, 3 s | vertical, 5 s | horizontal, 3 s | horizontal, 5 s |",
        "|---|---|---|---|---|",
        "| stated in the thesis |  | 1.1 m | -0.6 m | -0.3 m |",
        *(f"| {text} | " + " | ".join(f"{z:.3f} m" for z in heights) + " |" for text, heights in models.items()),
    ]


def sampling_rows(numbers: dict[str, float]) -> list[str]:
    """Final tip heights of the sampled PID, one row per sampling time."""
    rows = [
        "| sampling time | vertical, as printed | vertical, gravity down "
        "| horizontal, as printed | horizontal, gravity down |",
        "|---|---|---|---|---|",
    ]
    cases, tasks = ("as-printed", "gravity-down"), ("vertical", "horizontal")
    for sample_time in dict.fromkeys(key.split(".", 1)[1].rsplit(".", 1)[0] for key in numbers):
        heights = [numbers[f"{case}.{sample_time}.{task}_z_at_5s_m"] for task in tasks for case in cases]
        rows.append(f"| {sample_time} | " + " | ".join(f"{height:.3f} m" for height in heights) + " |")
    return rows


def page(numbers: dict[str, dict[str, float]]) -> str:
    """The validation page as Markdown."""
    entries = items()
    judged = entries + statements()
    return "\n".join(
        [
            "# Reproduction of Heinze (2007), figure by figure",
            "",
            "Generated by `python reproductions/heinze-2007/make.py` from `figures.toml`; do not edit.",
            "",
            headline(entries),
            "",
            told(statements()),
            "",
            "*Reproduced* means their model, their numbers, within a tolerance fixed beforehand from the precision of "
            "the print. It is no validation: nothing here was compared with the machine itself. The corrections are "
            "explained in [ERRATA.md](../../reproductions/heinze-2007/ERRATA.md), the values the thesis does not give "
            "in [ASSUMPTIONS.md](../../reproductions/heinze-2007/ASSUMPTIONS.md).",
            "",
            "Figures and tables of chapter 5 from 54 on were measured. Their logs are not available, so their "
            "counterparts come from the virtual rig with the friction of the thesis's own tables: *qualitative* there "
            "means that the statements of the text hold for it, which verifies the chain from rig to parameters and "
            "validates nothing.",
            "",
            "## Judged, failures first",
            "",
            *judged_rows(judged, numbers),
            "",
            "## Pictures and notes",
            *notes(judged, numbers),
            "",
            "## Figures 80 to 85 in heights, model by model",
            "",
            "Tip heights of the two published tasks: one set-point 2.5 m away, the printed gains, all chambers "
            "empty of pressure at the start. With the PID inside the solver the heights repeat to 6 mm.",
            "",
            *height_rows(numbers),
            "",
            "## What each correction does to the published runs",
            "",
            "Tip heights with one switch of `heinze-2007` corrected at a time; the thesis states 1.1 m for the "
            "vertical task at 5 s, and -0.6 m and -0.3 m for the horizontal task at 3 s and 5 s. A controller inside "
            "the right-hand side amplifies rounding: the heights repeat to 6 mm, the vertical ones with "
            "`leakage-viscosity` to 33 mm.",
            "",
            *switch_rows(numbers["errata_switches"]),
            "",
            "## The printed PID, properly sampled (E22)",
            "",
            "Tip height after 5 s with the printed gains, the PID once per sampling time and its commands held. The "
            "gains are per call, so only sampling as fast as the printed solver stepped gives the published height.",
            "",
            *sampling_rows(numbers["sampling_study"]),
            "",
            "## Not attempted",
            "",
            *unattempted_rows(entries),
            "",
        ]
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--update", action="store_true", help="accept the numbers found as the expected ones")
    update = parser.parse_args().update
    problems = []
    for script in scripts():
        found = compute(script)
        if update:
            accept(script, found)
        problems += [f"{script}: {line}" for line in differences(script, found)]
        if hasattr(module := importlib.import_module(script), "draw"):
            module.draw()
    numbers = {script: expected(script) for script in scripts()}
    problems += contradictions(items() + statements(), numbers)
    PAGE.parent.mkdir(parents=True, exist_ok=True)
    PAGE.write_text(page(numbers), encoding="utf-8")
    print("\n".join([headline(items()), f"written: {PAGE.relative_to(ROOT)}", *problems]))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
