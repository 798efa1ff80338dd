"""Signals that a study can store, and their times."""

from __future__ import annotations

import itertools
from typing import cast

import numpy as np

from hydrocrane.arrays import Array, positive_number
from hydrocrane.errors import InputError
from hydrocrane.machine.machine import Machine
from hydrocrane.scenario.record_size import check_record, row_count
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.studies.design import Cases
from hydrocrane.units import converted


def known_signals(plan: Scenario, machine: Machine) -> dict[str, tuple[str, str]]:
    """Name to unit and meaning of all signals of a run of `plan` on `machine`."""
    states = zip(machine.state_names, machine.state_units, machine.core.state_long_names, strict=True)
    known = {name: (unit, text) for name, unit, text in (*states, *machine.core.output_info)}
    known |= {f"cylinder.{c}.command": ("m", f"{c} spool command") for c in machine.cylinder_names}
    known["payload"] = ("kg", "payload at the tip")
    if plan.has_controller:
        known["tip.deviation"] = ("m", "distance of the crane tip from the path of its set-point")
        known |= {f"controller.{c}": ("m", f"{c} spool command as given") for c in machine.cylinder_names}
        known |= {f"set_point.{axis}": ("m", f"set-point of the crane tip, {axis}") for axis in ("x", "z")}
    return known


def signal_times(plan: Scenario, cases: Cases, resample: float | str | None) -> Array:
    """Common times (n_times,) of all cases, up to the longest duration, s."""
    if resample is None and cases.along("record-interval"):
        raise InputError("signals of runs with different record intervals need a common one: resample=0.05")
    interval = plan.record_interval if resample is None else _interval(resample)
    longest = max([float(cast(float, value)) for value in cases.along("duration")] or [plan.duration])
    rows = row_count(longest, interval)
    check_record(plan.load_machine(), plan, rows, interval="resample or record_interval")
    return np.arange(int(rows), dtype=np.float64) * interval


def check_records(plan: Scenario, machine: Machine, cases: Cases, *, ledger: bool) -> None:
    """Refuse a study before its first case if the record of a case would take more than its limit."""
    durations = cast("list[float]", cases.along("duration")) or [plan.duration]
    intervals = cast("list[float]", cases.along("record-interval")) or [plan.record_interval]
    both = not cases.grid and min(len(durations), len(intervals)) > 1
    pairs = zip(durations, intervals, strict=True) if both else itertools.product(durations, intervals)
    # What is no time is refused in its case.
    rows = max(
        (row_count(duration, interval) for duration, interval in pairs if min(duration, interval) > 0), default=0
    )
    check_record(machine, plan, rows, ledger=ledger)


def _interval(given: float | str) -> float:
    return positive_number("resample", converted("resample", given, "s") if isinstance(given, str) else given, "s")
