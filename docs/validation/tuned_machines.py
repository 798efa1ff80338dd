"""What `hydrocrane control tune` gave each bundled machine: ``python docs/validation/tuned_machines.py``.

Runs the cases that the gains were tuned by with the default gains of ``tip`` and with those of the machine file, and
writes ``tip-control/tuned-machines.csv``, lengths in m.
"""

from __future__ import annotations

import csv
from pathlib import Path

import hydrocrane as hc
from hydrocrane import _core
from hydrocrane.benchmark.cases import run_case
from hydrocrane.benchmark.fitted_tasks import tuning_cases
from hydrocrane.benchmark.tuning import TUNED

TABLE = Path(__file__).resolve().parent / "tip-control" / "tuned-machines.csv"
MACHINES = ("rottne-f9-lab", "hiab-xs031")
COLUMNS = ("machine", "case", "max_default", "rms_default", "max_tuned", "rms_tuned")


def rows() -> list[list[str]]:
    """One row per machine and case."""
    defaults = {f"control.tip.{key}": value for key, _, value in _core.tip_gain_info() if key in TUNED}
    found = []
    for name in MACHINES:
        tuned = hc.load_machine(name)
        plain = hc.load_machine(name, defaults)
        for case in tuning_cases(tuned):
            figures = []
            for crane in (plain, tuned):
                result = run_case(crane, "tip", case)
                if result.metrics is None or not result.outcome.completed:
                    raise SystemExit(f"{name}, {case.task.name}: {result.outcome.kind}; {result.message}")
                figures += [f"{result.metrics.path_max:.4g}", f"{result.metrics.path_rms:.4g}"]
            found.append([name, f"{case.task.name}, {case.condition}", *figures])
    return found


if __name__ == "__main__":
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        writer.writerows(rows())
