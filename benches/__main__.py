"""``python -m benches``: measure everything in one run, write ``results.json`` and the page made of it."""

from __future__ import annotations

import argparse
import json
import os
import platform
import time
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from benches import report
from benches.compete import QUICK, TIP_ERROR, Effort, compete
from benches.competitors import exudyn_crane
from benches.computer import commit_of, processor
from benches.measures import batch, closed_loop, exported, growth, laws, printed, real_time
from benches.problem import NotAvailable, Problem

RESULTS = Path(__file__).with_name("results.json")
PACKAGES = ("hydrocrane", "numpy", "scipy", "scikit-sundae", "casadi", "exudyn")
QUICK_STEPS = (5e-3, 1e-3)


def about() -> dict[str, Any]:
    """Where and with what it was measured."""

    def installed(package: str) -> str:
        try:
            return version(package)
        except PackageNotFoundError:
            return "not installed"

    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
        "packages": {package: installed(package) for package in PACKAGES},
    }


def circumstances(before: float) -> dict[str, Any]:
    """The version of the sources, the computer, how busy it was, and its pace before the measurement and after it."""
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    return {
        "commit": commit_of(RESULTS.parent),
        "load": load,
        "processor": processor(),
        "pace_ns": [before, laws.pace()],
    }


def sections(quick: bool) -> dict[str, Callable[[], dict[str, Any]]]:
    """What can be measured, by its name in the results."""
    effort = QUICK if quick else Effort()
    if quick:
        return {
            "open_loop": lambda: compete(Problem(), effort, ("hydrocrane", "CVODE", "diffsol", "CasADi")),
            "laws": lambda: laws.measure(Problem()),
            "exudyn": lambda: exudyn_crane.measure(Problem(), TIP_ERROR, QUICK_STEPS),
            "real_time": lambda: real_time.measure(2),
            "batch": lambda: batch.measure(20, (1000,)),
        }
    return {
        "open_loop": lambda: compete(Problem(), effort),
        "laws": lambda: laws.measure(Problem()),
        "exported": lambda: exported.measure(Problem()),
        "closed_loop": closed_loop.measure,
        "real_time": real_time.measure,
        "batch": batch.measure,
        "printed": printed.measure,
        "growth": growth.measure,
        "exudyn": lambda: exudyn_crane.measure(Problem(), TIP_ERROR),
    }


def measured(section: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """Its numbers, or what it lacks."""
    try:
        return section()
    except NotAvailable as reason:
        return {"not_available": str(reason)}


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benches", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a rough look in two minutes, printed and not kept")
    parser.add_argument("--only", nargs="+", metavar="SECTION", help="measure these anew, keep the others")
    options = parser.parse_args()
    known = sections(options.quick)
    chosen = options.only or list(known)
    for name in chosen:
        if name not in known:
            parser.error(f"no section is called `{name}`; choose from {', '.join(known)}")
    results = json.loads(RESULTS.read_text(encoding="utf-8")) if options.only and RESULTS.exists() else {}
    # What was kept was measured where it says.
    results.setdefault("about", about() | {"sections": {}})
    rounds = results["about"]["sections"]
    for name in chosen:
        print(f"--- {name}", flush=True)
        began, pace = time.perf_counter(), laws.pace()
        results[name] = measured(known[name])
        rounds[name] = circumstances(pace)
        print(f"    {time.perf_counter() - began:.0f} s", flush=True)
    if options.quick:
        print(json.dumps({name: results[name] for name in chosen if name != "open_loop"}, indent=2))
        return
    RESULTS.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")
    report.write()


if __name__ == "__main__":
    main()
