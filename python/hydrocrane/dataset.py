"""From the raw arrays of a run to a labelled ``xarray.Dataset``."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import xarray as xr

from hydrocrane.machine import Machine
from hydrocrane.payload import PayloadChange
from hydrocrane.samples import add_samples
from hydrocrane.scenario import Scenario


def run_dataset(crane: Machine, plan: Scenario, raw: dict[str, Any], *, payload: float, wall: float) -> xr.Dataset:
    """Everything a run recorded, over ``time``, with units and long names.

    A ledger entry's ``sign`` says whether it adds to the stored energy (+1), takes from it (-1), or moves inside (0).

    `raw` is what the core's ``simulate`` returns; `wall` is the time it took, s.
    """
    time = np.asarray(raw["t"])
    states, commands = np.asarray(raw["states"]), np.asarray(raw["commands"])
    data = xr.Dataset(coords={"time": ("time", time, {"units": "s", "long_name": "time"})})
    states_info = zip(crane.state_names, crane.state_units, crane.core.state_long_names, strict=True)
    _add_columns(data, list(states_info), states)
    for i, cylinder in enumerate(crane.cylinder_names):
        about = {"units": "m", "long_name": f"{cylinder} spool command"}
        data[f"cylinder.{cylinder}.command"] = ("time", commands[:, i].copy(), about)
    payloads = np.asarray(raw["payloads"])
    _add_columns(data, crane.core.output_info, _outputs(crane, states, commands, payloads))
    data["payload"] = ("time", payloads, {"units": "kg", "long_name": "payload at the tip"})
    if np.size(raw["ledger"]):
        info = [(f"ledger.{name}", unit, text) for name, unit, text in crane.core.ledger_info]
        _add_columns(data, info, np.asarray(raw["ledger"]))
        for (name, _, _), sign in zip(info, crane.core.ledger_signs, strict=True):
            data[name].attrs["sign"] = sign
    data.attrs = _run_attributes(crane, plan, raw, payload, wall)
    if "samples" in raw:
        add_samples(data, crane, plan, raw)
        _note_belief(data, crane, plan)
    return data


def _outputs(crane: Machine, states: np.ndarray, commands: np.ndarray, payloads: np.ndarray) -> np.ndarray:
    table = np.empty((len(states), len(crane.core.output_info)))
    for mass in np.unique(payloads):
        rows = payloads == mass
        table[rows] = crane.core.outputs(states[rows], commands[rows], float(mass))
    return table


def _events(raw: dict[str, Any]) -> list[tuple[float, str]]:
    """What happened on the way, in order of time."""
    changes = [PayloadChange.of(entry) for entry in raw["payload_changes"]]
    return sorted([*raw.get("events", []), *((change.time, change.text) for change in changes)], key=lambda e: e[0])


def _add_columns(data: xr.Dataset, info: list[tuple[str, str, str]], table: np.ndarray) -> None:
    for i, (name, unit, meaning) in enumerate(info):
        data[name] = ("time", table[:, i].copy(), {"units": unit, "long_name": meaning})


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
        "seed": plan.seed,
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
