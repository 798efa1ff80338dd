"""From the raw arrays of a run to a labelled ``xarray.Dataset``."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

import numpy as np
import xarray as xr

from hydrocrane.machine.machine import Machine
from hydrocrane.result_warning import to_json
from hydrocrane.results.samples import add_samples, stage_rows
from hydrocrane.scenario.payload import PayloadChange
from hydrocrane.scenario.scenario import Scenario


def run_dataset(crane: Machine, plan: Scenario, raw: dict[str, Any], *, payload: float, wall: float) -> xr.Dataset:
    """Everything a run recorded, over ``time``, with units and long names.

    A ledger entry's ``sign`` says whether it adds to the stored energy (+1), takes from it (-1), or moves inside (0).

    `raw` is what the core's ``simulate`` returns; `wall` is the time it took, s.
    """
    time = np.asarray(raw["t"])
    states, commands = np.asarray(raw["states"]), np.asarray(raw["commands"])
    states_info = zip(crane.state_names, crane.state_units, crane.core.state_long_names, strict=True)
    commands_info = [(f"cylinder.{c}.command", "m", f"{c} spool command") for c in crane.cylinder_names]
    payloads = np.asarray(raw["payloads"])
    # One construction from all columns: adding variables one by one to a data set costs more than the run.
    columns = _columns(states_info, states) | _columns(commands_info, commands)
    columns |= _columns(crane.core.output_info, outputs_table(crane, plan, raw))
    columns["payload"] = ("time", payloads, {"units": "kg", "long_name": "payload at the tip"})
    if np.size(raw["ledger"]):
        info = [(f"ledger.{name}", unit, text) for name, unit, text in crane.core.ledger_info]
        entries = _columns(info, np.asarray(raw["ledger"]))
        for (_, _, about), sign in zip(entries.values(), crane.core.ledger_signs, strict=True):
            about["sign"] = sign
        columns |= entries
    data = xr.Dataset(columns, coords={"time": ("time", time, {"units": "s", "long_name": "time"})})
    data.attrs = _run_attributes(crane, plan, raw, payload, wall)
    if "samples" in raw:
        data = add_samples(data, crane, plan, raw)
        _note_belief(data, crane, plan)
    return data


def stage_machine(crane: Machine, stage: Scenario) -> Machine:
    """The machine of a phase of a run that began on `crane`."""
    changed = {key: value for key, value in stage.machine_overrides.items() if crane.overrides.get(key) != value}
    return crane.changed(changed)


def outputs_table(crane: Machine, plan: Scenario, raw: dict[str, Any], *, oil: bool = True) -> np.ndarray:
    """Everything derived from the states, (m, n_outputs), in the order of the core's ``output_info``.

    Without `oil`, ``energy.oil`` is NaN, and a machine that runs only once is spared the making of its tables.
    """
    time, payloads = np.asarray(raw["t"]), np.asarray(raw["payloads"])
    states, commands = np.asarray(raw["states"]), np.asarray(raw["commands"])
    table = np.empty((len(states), len(crane.core.output_info)))
    for rows, stage in stage_rows(plan, time):
        here = stage_machine(crane, stage) if plan.phases else crane
        for mass in np.unique(payloads[rows]):
            some = rows & (payloads == mass)
            table[some] = here.core.outputs(states[some], commands[some], float(mass), oil)
    return table


def _events(raw: dict[str, Any]) -> list[tuple[float, str]]:
    """What happened on the way, in order of time."""
    changes = [PayloadChange.of(entry) for entry in raw["payload_changes"]]
    return sorted([*raw.get("events", []), *((change.time, change.text) for change in changes)], key=lambda e: e[0])


def _columns(info: Iterable[tuple[str, str, str]], table: np.ndarray) -> dict[str, tuple[str, np.ndarray, dict]]:
    """Variables over time from the columns of a table, by their names, units and meanings."""
    return {
        name: ("time", table[:, i].copy(), {"units": unit, "long_name": meaning})
        for i, (name, unit, meaning) in enumerate(info)
    }


def _note_belief(data: xr.Dataset, crane: Machine, plan: Scenario) -> None:
    """What the controller took the crane for, where that was not the truth."""
    if plan.believed is not None:
        believed = plan.believed_machine(crane)
        data.attrs["believed_source"] = believed.source
        data.attrs["believed_overrides"] = json.dumps(believed.overrides)


def _run_attributes(crane: Machine, plan: Scenario, raw: dict[str, Any], payload: float, wall: float) -> dict[str, Any]:
    """Where the run came from and how it ended: plain strings and numbers, so that every file format keeps them."""
    from hydrocrane import __version__

    kind, time, message = raw["outcome"]
    about = {
        "title": plan.title or plan.name,
        "scenario": plan.name,
        "machine": crane.name,
        "machine_source": crane.source,
        "machine_overrides": json.dumps(crane.overrides),
        "joint_names": json.dumps(crane.joint_names),
        "cylinder_names": json.dumps(crane.cylinder_names),
        "payload": payload,
        "payload_changes": json.dumps(raw["payload_changes"]),
        "events": json.dumps(_events(raw)),
        "warnings": to_json(raw["warnings"]),
        "verification": json.dumps(asdict(raw["verification"]) if "verification" in raw else None),
        "seed": plan.seed,
        "phases": json.dumps([(begin, str(then.driver), then.machine_overrides) for begin, then in plan.stages()[1:]]),
        "outcome": kind,
        "outcome_time": float(time),
        "outcome_message": message or "",
        "solver_method": plan.solver.method,
        "solver_rtol": plan.solver.rtol,
        "solver_max_step": plan.solver.step or plan.solver.max_step,
        "wall_time": wall,
        "source": f"hydrocrane {__version__}",
        "Conventions": "SI units, radians, gauge pressures",
    }
    return about | {f"solver_{key}": value for key, value in raw["stats"].items()}
