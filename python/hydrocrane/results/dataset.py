"""From the raw arrays of a run to columns by name, on request."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from hydrocrane.files.columns import TIME, Attributes, Column, Columns
from hydrocrane.machine.machine import Machine
from hydrocrane.machine.overrides import Override
from hydrocrane.result_warning import to_json
from hydrocrane.results.recording import Recording
from hydrocrane.results.samples import machine_rows, sample_columns
from hydrocrane.scenario.payload import PayloadChange
from hydrocrane.scenario.scenario import Scenario


@dataclass(frozen=True)
class RunDataset:
    """The data of a run, whose columns are made on request, because this takes as long as a run of a few seconds.

    Attributes
    ----------
    attrs : dict
        Attributes of the data.
    machine : Machine
        Machine at the start of the run.
    recorded : Recording
    """

    attrs: Attributes
    machine: Machine
    recorded: Recording

    @cached_property
    def columns(self) -> Columns:
        """Everything the run recorded, over ``time``, with units and long names.

        A ledger entry's ``sign`` states whether it adds to the stored energy (+1), reduces it (-1), or is an internal
        transfer (0).
        """
        machine, run = self.machine, self.recorded
        core = machine.core
        states_info = zip(machine.state_names, machine.state_units, core.state_long_names, strict=True)
        commands_info = [(f"cylinder.{c}.command", "m", f"{c} spool command") for c in machine.cylinder_names]
        columns = _columns(states_info, run.states) | _columns(commands_info, run.commands)
        columns |= _columns(core.output_info, outputs_table(machine, run))
        columns["payload"] = Column(run.payloads, {"units": "kg", "long_name": "payload at the tip"})
        if run.ledger.size:
            info = [(f"ledger.{name}", unit, text) for name, unit, text in core.ledger_info]
            entries = _columns(info, run.ledger)
            for entry, sign in zip(entries.values(), core.ledger_signs, strict=True):
                entry.attrs["sign"] = sign
            columns |= entries
        if any(stage.controlled for stage in run.stages):
            tip = np.column_stack([columns[f"tip.{axis}"].values for axis in machine.tip_axes])
            columns |= sample_columns(tip, machine, run)
        columns[TIME] = Column(run.time, {"units": "s", "long_name": "time"})
        return Columns(columns, self.attrs)


def run_dataset(machine: Machine, plan: Scenario, run: Recording, *, payload: float, wall: float) -> RunDataset:
    """The data of a run that took `wall` s."""
    attrs = _run_attributes(machine, plan, run, payload, wall)
    if any(stage.controlled for stage in run.stages):
        stage = next(stage for _, stage in plan.stages() if stage.driver is not None)
        driver = stage.driver
        attrs["controller"] = driver if isinstance(driver, str) else getattr(driver, "__name__", type(driver).__name__)
        attrs["sensors"] = stage.sensors
        if run.samples and len(run.samples[-1]["learnt"]):
            attrs["learnt"] = json.dumps(
                dict(zip(run.samples[-1]["valves"], run.samples[-1]["learnt"].tolist(), strict=True))
            )
        # The controller model, if it is not that of the crane.
        if plan.controller_model is not None:
            model = run.stages[0].controller_model
            attrs["controller_model_source"] = Path(model.source).name
            attrs["controller_model_overrides"] = json.dumps(model.overrides)
    return RunDataset(attrs, machine, run)


def outputs_table(machine: Machine, run: Recording, *, oil: bool = True) -> np.ndarray:
    """Everything derived from the states, (m, n_outputs), in the order of the core's ``output_info``.

    Without `oil`, ``energy.oil`` is NaN, which saves the tables of the fluid for a machine that runs only once.
    """
    parts = [
        here.core.outputs(run.states[rows], run.commands[rows], run.payloads[rows], oil)
        for rows, here in list(machine_rows(run)) or [(slice(None), machine)]
    ]
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _events(run: Recording) -> list[tuple[float, str]]:
    """Events in order of time."""
    changes = [PayloadChange.of(entry) for entry in run.payload_changes]
    return sorted([*run.events, *((change.time, change.text) for change in changes)], key=lambda e: e[0])


def _columns(info: Iterable[tuple[str, str, str]], table: np.ndarray) -> dict[str, Column]:
    """Variables over time from the columns of a table, by their names, units and meanings."""
    return {
        name: Column(table[:, i].copy(), {"units": unit, "long_name": meaning})
        for i, (name, unit, meaning) in enumerate(info)
    }


def _phases(plan: Scenario) -> list[tuple[float, str, dict[str, Override]]]:
    """Begin, controller and overrides of each phase."""
    later = plan.stages()[1:] if plan.phases else []
    return [(begin, str(then.driver), dict(then.machine_overrides)) for begin, then in later]


def _run_attributes(machine: Machine, plan: Scenario, run: Recording, payload: float, wall: float) -> Attributes:
    """Origin and outcome of the run as plain strings and numbers, which every file format can store."""
    from hydrocrane import __version__

    about: Attributes = {
        "title": plan.title or plan.name,
        "scenario": plan.name,
        "machine": machine.name,
        "machine_source": Path(machine.source).name,
        "machine_overrides": json.dumps(machine.overrides),
        "joint_names": json.dumps(machine.joint_names),
        "cylinder_names": json.dumps(machine.cylinder_names),
        "payload": payload,
        "payload_changes": json.dumps(run.payload_changes),
        "events": json.dumps(_events(run)),
        "warnings": to_json(run.warnings),
        "verification": json.dumps(None if run.verification is None else asdict(run.verification)),
        "seed": plan.seed,
        "phases": json.dumps(_phases(plan)),
        "outcome": run.outcome.kind,
        "outcome_time": float(run.outcome.time),
        "outcome_message": run.outcome.message or "",
        "solver_method": run.method,
        "solver_choice": plan.solver.method,
        "solver_rtol": plan.solver.rtol,
        "solver_max_step": plan.solver.step or plan.solver.max_step,
        "wall_time": wall,
        "source": f"hydrocrane {__version__}",
        "Conventions": "SI units, radians, gauge pressures",
    }
    if plan.solver.step is not None:
        about["solver_fixed_step"] = plan.solver.step
    if run.tip_error is not None:
        about["tip_error"] = run.tip_error
    return about | {f"solver_{key}": value for key, value in run.effort.items()}
