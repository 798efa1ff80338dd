"""The page of speed from what was measured: ``python -m benches.report`` writes docs/validation/speed.md and a picture.

Nothing on the page is typed but its words.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from benches.as_called import printed as calls
from benches.competitors.exudyn_crane import DIFFERENCES
from benches.goals import goals, thread_shares
from benches.picture import work_precision
from benches.tables import Results, digits, lacking, table
from hydrocrane.plots.style import write as write_picture

ROOT = Path(__file__).resolve().parents[1]
RESULTS = Path(__file__).with_name("results.json")
PAGE = ROOT / "docs/validation/speed.md"
PICTURE = PAGE.with_suffix(".png")

# What is compared, by family: the model and who evaluates it.
MODELS = {
    "hydrocrane": "the product: its laws, its structured Jacobian, its methods",
    "CVODE": "the same compiled laws and exact Jacobian, dense; SUNDIALS' own dense solver; no Python in the way",
    "diffsol": "the same compiled laws and exact Jacobian, dense; nalgebra's factorisation; no largest step",
    "CasADi": "an independent model in CasADi's symbols, compiled to C with its exact Jacobian; scaled states",
    "SciPy, compiled laws": "the same compiled laws, called back through Python",
    "SciPy, laws in NumPy": "the independent model in NumPy, Jacobians by difference quotients",
}


def ours(results: Results) -> Results:
    """The row of this package at its operating point."""
    race = results["open_loop"]
    return race["rows"][race["ours"]]


def tolerance(row: Results) -> str:
    """What a solver was set to."""
    return f"{digits(row['step_s'] * 1e3)} ms" if "step_s" in row else f"{row['rtol']:.0e}"


def open_loop(results: Results) -> str:
    race = results["open_loop"]
    rows = []
    for name, row in sorted(race["rows"].items(), key=lambda item: item[1]["ratio"]):
        cells = [f"**{name}**" if row["family"] == "hydrocrane" else name, tolerance(row)]
        cells += [digits(row["tip_error_m"] * 1e6, 2), digits(row["seconds"] * 1e3), digits(row["times_real_time"], 2)]
        spread = f"{digits(row['ratio_low'])} to {digits(row['ratio_high'])}"
        same = name == race["ours"]
        cells += ["1" if same else f"{digits(row['ratio'])} ({spread})", str(row.get("rhs", ""))]
        rows.append([*cells, str(row.get("jacobians", ""))])
    heads = [
        "solver",
        "rtol or step",
        "tip error [µm]",
        "time [ms]",
        "x real time",
        "time in ours (quartiles)",
        "rhs",
        "Jacobians",
    ]
    text = table(heads, rows)
    for name, reason in race["missing"].items():
        text += f"\n\n{name}: {reason}."
    return text


def models(_results: Results) -> str:
    return table(["family", "model, and who evaluates it"], [[name, text] for name, text in MODELS.items()])


def exudyn(results: Results) -> str:
    section = results.get("exudyn")
    if lacking(section):
        return lacking(section)
    rows = [
        [
            digits(p["step"] * 1e3),
            digits(p["tip_error_m"] * 1e6),
            digits(p["seconds"] * 1e3),
            digits(p["seconds"] / ours(results)["seconds"]),
        ]
        for p in section["points"]
    ]
    text = table(["step [ms]", "tip error against its own limit [µm]", "time [ms]", "time in ours"], rows)
    lines = "\n".join(f"* {line}" for line in DIFFERENCES)
    return (
        f"{text}\n\nDifferences of its model:\n\n{lines}\n\n"
        f"With all of this its tip stays within {digits(section['apart_m'] * 1e3, 2)} mm of that of the full model."
    )


def closed_loop(results: Results) -> str:
    section = results.get("closed_loop")
    if lacking(section):
        return lacking(section)
    rows = []
    for controller, found in section.items():
        for name, row in found["candidates"].items():
            shown = f"**{name}**" if name == found["best"] else name
            cells = [controller, shown, digits(row["tip_error_m"] * 1e6, 2), digits(row["times_real_time"], 2)]
            rows.append([*cells, str(row["steps"]), str(row["rhs"])])
    return table(["controller", "method, tolerance or step", "tip error [µm]", "x real time", "steps", "rhs"], rows)


def laws(results: Results) -> str:
    section = results.get("laws")
    if lacking(section):
        return lacking(section)
    names = {
        "rhs_ns": "right-hand side, in a batch through Python",
        "dense_jacobian_ns": "exact Jacobian written out dense, in a batch through Python",
        "rhs_one_python_call_ns": "right-hand side, one call from Python",
        "compiled_rhs_ns": "right-hand side, called from Rust",
        "compiled_structured_ns": "right-hand side with the structured Jacobian, called from Rust",
    }
    rows = [[text, digits(section[name])] for name, text in names.items() if name in section]
    return table([f"law, {section['states']} states", "ns"], rows)


def exported(results: Results) -> str:
    section = results.get("exported")
    if lacking(section):
        return lacking(section)
    texts = {"rhs": "right-hand side", "slopes": "with all derivatives by the states"}
    rows = [
        [machine, texts[what], who, digits(row["ns"]), digits(row["ratio"])]
        for machine, programs in section["machines"].items()
        for program, row in programs.items()
        for who, what in [program.split(": ")]
    ]
    names = {"compiled_rhs_ns": texts["rhs"], "compiled_structured_ns": texts["slopes"]}
    for name, ns in section["product"].items():
        rows.append(["rottne-f9-lab", names[name], "the product, called from Rust", digits(ns), ""])
    return table(
        ["machine", "function", "code", "ns", "time in that of the export with the platform's functions"], rows
    )


QUANTILES = {"median_us": "median [us]", "p99_us": "99 % below [us]", "p999_us": "99.9 % below [us]"}


def real_time(results: Results) -> str:
    section = results.get("real_time")
    if lacking(section):
        return lacking(section)
    names = {"core": "one step in the core", "python": "one call of `hc.Simulator.step` from Python, valves closed"}
    rows = [[text] + [digits(section[name][key]) for key in QUANTILES] for name, text in names.items()]
    return table([f"{section['steps']} steps of {section['step_s'] * 1e3:g} ms", *QUANTILES.values()], rows)


def batch(results: Results) -> str:
    section = results.get("batch")
    if lacking(section):
        return lacking(section)
    exact = [
        [
            f"{s['tolerance']:g}",
            str(s["manoeuvres"]),
            digits(s["worst_m"] * 1e3, 2),
            digits(s["median_m"] * 1e6, 2),
            str(s["within_1_mm"]),
        ]
        for s in section["tolerances"]
    ]
    text = table(["tolerance", "random manoeuvres", "worst tip error [mm]", "median [µm]", "within 1 mm"], exact)
    rows = []
    for s in section["tolerances"]:
        shares = dict(thread_shares(section, s))
        for i, row in enumerate(s["throughput"]):
            speeds = (row["crane_seconds_per_second"], row["crane_seconds_per_cpu_second"])
            cells = [
                f"{s['tolerance']:g}",
                str(row["cranes"]),
                str(row["threads"]),
                *(f"{speed:.0f}" for speed in speeds),
            ]
            rows.append([*cells, digits(shares[i], 2) if i in shares else ""])
    units = ["crane-seconds per second", "per CPU second"]
    heads = ["tolerance", "cranes", "threads", *units, "share of what two threads give"]
    sets = [
        [r["instruction_set"], f"{r['crane_seconds_per_second']:.0f}", f"{r['crane_seconds_per_cpu_second']:.0f}"]
        for r in section["instruction_sets"]
    ]
    vectors = table(["vector instructions, one thread", *units], sets)
    return f"{text}\n\n{table(heads, rows)}\n\n{vectors}"


def growth(results: Results) -> str:
    section = results.get("growth")
    if lacking(section):
        return lacking(section)
    joints = [
        [
            str(r["joints"]),
            str(r["states"]),
            digits(r["rhs_ns"]),
            digits(r["seconds_per_step"] * 1e6),
            digits(r["times_real_time"], 2),
        ]
        for r in section["joints"]
    ]
    parts = [table(["joints", "states", "right-hand side [ns]", "one step [us]", "x real time"], joints)]
    rates = [[str(r["rate_hz"]), digits(r["times_real_time"], 2)] for r in section["controller_rate"]]
    parts.append(table(["controller [Hz]", "x real time"], rates))
    record = [[f"{r['interval_s'] * 1e3:g}", digits(r["times_real_time"], 2)] for r in section["recording"]]
    parts.append(table(["recorded every [ms]", "x real time"], record))
    if "workers" in section:
        rows = [[str(r["workers"]), digits(r["cases_per_second"])] for r in section["workers"]]
        parts.append(table(["workers of a study", "5 s runs per second"], rows))
    return "\n\n".join(parts)


def printed(results: Results) -> str:
    section = results.get("printed")
    if lacking(section):
        return lacking(section)
    titles = {"jumping": "It jumps", "smoothed": f"It passes through zero over {section['smoothing']}"}
    rows = [
        [titles[kind], name, tolerance(r), digits(r["tip_error_m"] * 1e3, 2), digits(r["seconds"] * 1e3)]
        for kind, variant in section["variants"].items()
        for name, r in sorted(variant.items(), key=lambda item: item[1]["seconds"])
    ]
    return table(["the sign of friction", "solver", "rtol or step", "tip error [mm]", "time [ms]"], rows)


def circumstances(results: Results) -> str:
    """With which sources and where each section was measured, and how busy the computer was."""
    facts, rows = results["about"], []
    for name, row in facts["sections"].items():
        load = "unknown" if row["load"] is None else digits(row["load"], 2)
        place = row.get("processor", facts["processor"])
        pace = " and ".join(f"{ns:.0f}" for ns in row["pace_ns"])
        rows.append([name.replace("_", " "), f"`{row['commit']}`", place, load, pace])
    heads = ["section", "commit", "processor", "processes at work on average, this one among them"]
    return table([*heads, "a right-hand side before and after [ns]"], rows)


def as_called(results: Results) -> str:
    section = results.get("as_called")
    if section is None:
        return lacking(section)
    this, *others = (f"`{commit}`" for commit in section["commits"])
    before = f", *before* {others[0]}" if others else ""
    where = f"Measured on {section['processor']}, {section['rounds']} rounds; this state is {this}{before}."
    return f"{where}\n\n{calls(section['figures'])}"


PARTS: dict[str, Callable[[Results], str]] = {
    "goals": goals,
    "open_loop": open_loop,
    "models": models,
    "exudyn": exudyn,
    "closed_loop": closed_loop,
    "batch": batch,
    "real_time": real_time,
    "laws": laws,
    "exported": exported,
    "as_called": as_called,
    "printed": printed,
    "growth": growth,
    "circumstances": circumstances,
}


def page(results: Results) -> str:
    """The page: the words of ``speed.md`` beside this file, with every {part} filled in."""
    words = Path(__file__).with_name("speed.md").read_text(encoding="utf-8")
    facts = results["about"]
    packages = ", ".join(f"{name} {number}" for name, number in facts["packages"].items())
    filled = {name: part(results) for name, part in PARTS.items()}
    place = f"{facts['processor']}, {facts['cores']} cores, {facts['system']}, Python {facts['python']}; {packages}"
    return words.format(place=place, tip=digits(ours(results)["tip_error_m"] * 1e6, 2), **filled)


def write() -> None:
    results = json.loads(RESULTS.read_text(encoding="utf-8"))
    PAGE.write_text(page(results), encoding="utf-8")
    race = results["open_loop"]
    families = {name: row["family"] for name, row in race["rows"].items()}
    curves = {name: points for name, points in race["curves"].items() if name in families}
    write_picture(work_precision(curves, families, race["ours"]), PICTURE)


if __name__ == "__main__":
    write()
