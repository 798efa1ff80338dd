"""From the raw arrays of a run to a labelled ``xarray.Dataset``."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import xarray as xr

from hydrocrane.machine import Machine
from hydrocrane.scenario import Scenario

# Last part of a state's name -> what it is.
_STATE_MEANING = {
    "q": "coordinate of joint {}",
    "qd": "rate of joint {}",
    "p1": "piston-side pressure of cylinder {}",
    "p2": "rod-side pressure of cylinder {}",
    "xs": "spool position of cylinder {}'s valve",
    "vs": "spool velocity of cylinder {}'s valve",
    "z": "bristle deflection of cylinder {}'s friction",
}


def run_dataset(crane: Machine, plan: Scenario, raw: dict[str, Any], *, payload: float, wall: float) -> xr.Dataset:
    """Everything a run recorded, over ``time``, with units and long names.

    `raw` is what the core's ``simulate`` returns; `wall` is the time it took, s.
    """
    time = np.asarray(raw["t"])
    states, commands = np.asarray(raw["states"]), np.asarray(raw["commands"])
    data = xr.Dataset(coords={"time": ("time", time, {"units": "s", "long_name": "time"})})
    for i, (name, unit) in enumerate(zip(crane.state_names, crane.state_units, strict=True)):
        data[name] = ("time", states[:, i].copy(), {"units": unit, "long_name": state_meaning(name)})
    for i, cylinder in enumerate(crane.cylinder_names):
        about = {"units": "m", "long_name": f"spool command of cylinder {cylinder}'s valve"}
        data[f"cylinder.{cylinder}.command"] = ("time", commands[:, i].copy(), about)
    _add_columns(data, crane.core.output_info, _outputs(crane, states, commands, payload))
    if np.size(raw["ledger"]):
        info = [(_ledger_name(name), unit, text) for name, unit, text in crane.core.ledger_info]
        _add_columns(data, info, np.asarray(raw["ledger"]))
    data.attrs = _run_attributes(crane, plan, raw, payload, wall)
    return data


def state_meaning(name: str) -> str:
    """Long name of a state, from its own name: ``joint.boom.q`` is the coordinate of joint boom."""
    _, owner, quantity = name.split(".")
    return _STATE_MEANING.get(quantity, quantity + " of {}").format(owner)


def _outputs(crane: Machine, states: np.ndarray, commands: np.ndarray, payload: float) -> np.ndarray:
    return np.asarray(crane.core.outputs(np.ascontiguousarray(states), np.ascontiguousarray(commands), payload))


def _add_columns(data: xr.Dataset, info: list[tuple[str, str, str]], table: np.ndarray) -> None:
    for i, (name, unit, meaning) in enumerate(info):
        data[name] = ("time", table[:, i].copy(), {"units": unit, "long_name": meaning})


def _ledger_name(name: str) -> str:
    return name if name.startswith("ledger.") else f"ledger.{name}"


def _run_attributes(crane: Machine, plan: Scenario, raw: dict[str, Any], payload: float, wall: float) -> dict[str, Any]:
    """Where the run came from and how it ended: plain strings and numbers, so that every file format keeps them."""
    from hydrocrane import __version__

    outcome = raw["outcome"]
    kind, time, message = outcome if not isinstance(outcome, dict) else outcome.values()
    about = {
        "title": plan.title or plan.name,
        "scenario": plan.name,
        "machine": crane.name,
        "machine_source": crane.source,
        "machine_overrides": json.dumps(crane.overrides),
        "joint_names": json.dumps(crane.joint_names),
        "cylinder_names": json.dumps(crane.cylinder_names),
        "payload": payload,
        "seed": plan.seed,
        "outcome": kind,
        "outcome_time": float(time),
        "outcome_message": message or "",
        "solver_method": plan.solver.method,
        "solver_rtol": plan.solver.rtol,
        "solver_max_step": plan.solver.max_step,
        "wall_time": wall,
        "source": f"hydrocrane {__version__}",
        "Conventions": "SI units, radians, gauge pressures",
    }
    return about | {f"solver_{key}": value for key, value in raw["stats"].items()}
