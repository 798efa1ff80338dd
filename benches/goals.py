"""What the project asked of itself, and what came out."""

from __future__ import annotations

from benches.tables import Results, digits, lacking, table

# 1.3 times what a prototype of this model took, ns.
RHS_NS, SLOPED_NS = 195, 494
# Time of an exported function in that of CasADi's, by the kind of the function.
IN_C = {"rhs": ("right-hand side", 0.75), "slopes": ("with all derivatives", 0.65)}
# Cranes in lanes cost little more than one of them.
MANY_IN_ONE = 1.5


def alone(setting: Results) -> list[Results]:
    """Throughputs on one thread, by the number of cranes."""
    return [row for row in setting["throughput"] if row["threads"] == 1]


def thread_shares(section: Results, setting: Results) -> list[tuple[int, float]]:
    """By its place, the gain of each throughput on several threads, in the gain of cranes that share no memory."""
    free = {row["threads"]: row["crane_seconds_per_second"] for row in section["free_of_memory"]}
    single = {row["cranes"]: row["crane_seconds_per_second"] for row in alone(setting)}
    return [
        (i, (row["crane_seconds_per_second"] / single[row["cranes"]]) / (free[row["threads"]] / free[1]))
        for i, row in enumerate(setting["throughput"])
        if row["threads"] > 1
    ]


def sides(rows: dict[str, Results]) -> dict[str, list[tuple[str, float]]]:
    """Names and times of this package's methods and of the others."""
    parted: dict[str, list[tuple[str, float]]] = {"ours": [], "theirs": []}
    for name, row in rows.items():
        parted["ours" if name.startswith("hydrocrane") else "theirs"].append((name, row["seconds"]))
    return parted


def goals(results: Results) -> str:
    """Every goal with what was wanted, what was found, and whether that meets it."""
    rows = []

    def row(
        text: str,
        wanted: float,
        found: float | None,
        unit: str = "x",
        least: bool = True,
        otherwise: str = "not measured",
    ) -> None:
        if found is None:
            return rows.append([text, f"{wanted:g} {unit}".strip(), otherwise, ""])
        met = found >= wanted if least else found <= wanted
        return rows.append(
            [
                text,
                f"{'>=' if least else '<='} {wanted:g} {unit}".strip(),
                f"{digits(found)} {unit}".strip(),
                "yes" if met else "**no**",
            ]
        )

    def ratio(family: str, only: str = "") -> float | None:
        """That of the fastest solver of a family whose name holds a word."""
        race = results["open_loop"]["rows"].items()
        return min((r["ratio"] for name, r in race if r["family"] == family and only in name), default=None)

    row("faster than CVODE's BDF", 10, ratio("CVODE", "BDF"))
    row("faster than diffsol's BDF", 4, ratio("diffsol", "diffsol BDF"))
    row("faster than CasADi's CVODES, compiled", 50, ratio("CasADi"))
    row("faster than SciPy on laws in NumPy, its fastest", 1000, ratio("SciPy, laws in NumPy"))
    loops = results.get("closed_loop")
    for name in () if lacking(loops) else loops:
        best = loops[name]["candidates"][loops[name]["best"]]
        row(f"closed loop at 100 Hz within 50 µm, controller `{name}`", 5000, best["times_real_time"], "x real time")
    law = results.get("laws") or {}
    row("right-hand side, called from Rust", RHS_NS, law.get("compiled_rhs_ns"), "ns", least=False)
    row("the same with the structured Jacobian", SLOPED_NS, law.get("compiled_structured_ns"), "ns", least=False)
    models = results.get("exported")
    for what, (text, most) in {} if lacking(models) else IN_C.items():
        shares = [1.0 / programs[f"CasADi, same model: {what}"]["ratio"] for programs in models["machines"].values()]
        whole = f"exported C in the time of CasADi's, {text}, the slowest of three machines"
        row(whole, most, max(shares), "", least=False)
    old = results.get("printed")
    if not lacking(old):
        for kind, variant in old["variants"].items():
            seconds = {side: min(t for _, t in group) for side, group in sides(variant).items()}
            text = f"as-printed model, friction {kind}: time in that of the best other solver"
            row(text, 10, seconds["ours"] / seconds["theirs"], least=False)
    batches = results.get("batch")
    if not lacking(batches):
        good = [s for s in batches["tolerances"] if s["worst_m"] <= 1e-3]
        speeds = [[r["crane_seconds_per_cpu_second"] for r in alone(s)] for s in good]
        worst = min(s["worst_m"] for s in batches["tolerances"])
        row("batch, worst tip error of all manoeuvres at the best tolerance", 1, worst * 1e3, "mm", least=False)
        wanted = (20000, max(map(max, speeds), default=None), "crane-seconds per CPU second")
        row("batch at a tolerance within 1 mm, one core", *wanted, otherwise="no tolerance is")
        flat = max((min(of_sizes) / max(of_sizes) for of_sizes in speeds), default=None)
        row("the same from the fewest to the most cranes, least to most", 0.9, flat, "")
        shares = [[share for _, share in thread_shares(batches, s)] for s in good]
        called = {r["cranes"]: r["seconds"] for r in batches.get("calls", ())}
        few = max(called.values()) / called[1] if called else None
        row(
            "one call of a batch with eight cranes in the time of one with one crane", MANY_IN_ONE, few, "", least=False
        )
        row("batch, two threads: share of what two threads give", 0.9, max(map(min, shares), default=None), "")
    return table(["goal", "wanted", "found", "met"], rows)
