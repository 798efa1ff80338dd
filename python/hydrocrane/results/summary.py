"""A run in a few lines of text."""

from __future__ import annotations

import json

import numpy as np

from hydrocrane.arrays import path_length
from hydrocrane.files.columns import Columns
from hydrocrane.results.energy import energy_balance
from hydrocrane.results.record import Record
from hydrocrane.scenario.solver import named

SHOWN_EVENTS = 5


def text(run: Record) -> str:
    """Outcome, effort, tip, cylinders and energy of a run."""
    if not run.columns.rows:
        return "\n".join([*_head(run), *_warnings(run)])
    parts = (_head, _accuracy, _tip, _loop, _events, _cylinders, _energy, _warnings)
    return "\n".join(line for part in parts for line in part(run))


def _head(run: Record) -> list[str]:
    about, outcome = run.columns.attrs, run.outcome
    lines = [f"{about['scenario']} on {about['machine']}: {outcome.kind} at {outcome.time:.4g} s"]
    if outcome.message and not outcome.completed:
        lines.append(f"  {outcome.message}")
    method, choice = str(about["solver_method"]), str(about.get("solver_choice", ""))
    fixed = "solver_fixed_step" in about
    size = (
        f"steps of {float(about['solver_fixed_step']) * 1e3:g} ms" if fixed else f"rtol {float(about['solver_rtol']):g}"
    )
    effort = f"  {named(method, choice)}, {size}"
    if "solver_steps" in about:
        effort += f": {about['solver_steps']} steps, {about.get('solver_rejected', 0)} rejected"
    wall = float(about.get("wall_time", 0.0))
    if wall > 0 and outcome.time > 0:
        effort += f", {wall * 1e3:.3g} ms to compute and record ({outcome.time / wall:.3g} x real time)"
    return [*lines, effort]


def _accuracy(run: Record) -> list[str]:
    """How far the run is off: by a tighter repeat, by estimate, or that nobody knows."""
    about = run.columns.attrs
    if run.verification is not None:
        return [f"  accuracy   {run.verification}"]
    if "tip_error" in about:
        off = max(1e3 * float(about["tip_error"]), 1e-3)
        return [f"  accuracy   errors of all steps put the tip off by at most {off:.2g} mm, by estimate"]
    where = " under a controller" if "controller" in about else ""
    return [f"  accuracy   not estimated{where}; `verify` repeats the run with a tighter tolerance"]


def _tip(run: Record) -> list[str]:
    columns = run.columns
    if "tip.x" not in columns:
        return []
    tip = [columns[f"tip.{axis}"].values for axis in run.machine.tip_axes]
    start, end = (", ".join(f"{values[at]:z.3f}" for values in tip) for at in (0, -1))
    return [f"  tip        ({start}) m -> ({end}) m, way {path_length(tip):.3f} m"]


def _loop(run: Record) -> list[str]:
    """Controller, and the largest path deviation."""
    columns, about = run.columns, run.columns.attrs
    if "controller" not in about:
        return []
    line = f"  controller {about['controller']}, {about['sensors']} sensors"
    if "tip.deviation" in columns:
        farthest = float(np.nanmax(columns["tip.deviation"].values))
        line += f", tip at most {farthest * 1e3:.2f} mm from the path of its set-point"
    phases = json.loads(str(about.get("phases", "[]")))
    return [line, *(f"  from {begin:g} s on: controller {driver}" for begin, driver, _ in phases)]


def _warnings(run: Record) -> list[str]:
    """All warnings, each with its cure."""
    lines = []
    for warning in run.warnings:
        lines += [f"  WARNING    from {warning.time:.3f} s on: {warning.text}", f"             {warning.cure}"]
    return lines


def _events(run: Record) -> list[str]:
    """The first events; warnings are at the end of the summary."""
    events = [event for event in run.events if not event.warning]
    shown = [f"  {event.time:.3f} s: {event.text}" for event in events[:SHOWN_EVENTS]]
    more = len(events) - SHOWN_EVENTS
    return [*shown, *([f"  and {more} more events"] if more > 0 else [])]


def _cylinders(run: Record) -> list[str]:
    lines = []
    columns = run.columns
    width = max([10, *(len(name) for name in run.cylinder_names)])
    for name in run.cylinder_names:
        parts = [
            f"{label} {_range(columns, f'cylinder.{name}.{key}', scale)} {unit}"
            for label, key, scale, unit in (("x", "x", 1e3, "mm"), ("p1", "p1", 1e-5, "bar"), ("p2", "p2", 1e-5, "bar"))
        ]
        lines.append(f"  {name:<{width}} {', '.join(parts)}")
    return lines


def _range(columns: Columns, name: str, scale: float) -> str:
    values = columns[name].values * scale
    return f"{values.min():z.1f} .. {values.max():z.1f}"


def _energy(run: Record) -> list[str]:
    """Energy balance, and the residual of the ledger."""
    if not any(name.startswith("ledger.") for name in run.columns):
        return []
    balance = energy_balance(run)
    lost = sorted(balance.lost.items(), key=lambda entry: -abs(entry[1]))
    loads = f", energy of loads {balance.loads:+z.0f} J" if run.payload_changes else ""
    where = ", ".join(f"{name} {value:.0f}" for name, value in lost[:4] if abs(value) >= 0.5)
    return [
        f"  energy     pump {balance.pump:.0f} J{loads}, stored {balance.stored:+z.0f} J,"
        f" lost {sum(balance.lost.values()):.0f} J" + (f" ({where})" if where else ""),
        f"             the ledger closes to {balance.residual:.1e} J",
    ]
