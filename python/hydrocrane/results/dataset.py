"""From the raw arrays of a run to a labelled ``xarray.Dataset``, where somebody asks for it."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass

import numpy as np
import xarray as xr

from hydrocrane.machine.machine import Machine
from hydrocrane.result_warning import to_json
from hydrocrane.results.recording import Recording
from hydrocrane.results.samples import Columns, sample_columns, stage_rows
from hydrocrane.scenario.payload import PayloadChange
from hydrocrane.scenario.scenario import Scenario


@dataclass(frozen=True)
class RunDataset:
    """The data set of a run before anybody has asked for it: labelling arrays takes as long as a run of a few seconds.

    Attributes
    ----------
    attrs : dict
        Those of the data set.
    machines : list of Machine
        Of each phase.
    """

    attrs: dict[str, str | float]
    machines: list[Machine]
    plan: Scenario
    recorded: Recording

    def labelled(self) -> xr.Dataset:
        """Everything the run recorded, over ``time``, with units and long names.

        A ledger entry's ``sign`` says whether it adds to the stored energy (+1), takes from it (-1), or moves inside
        (0).
        """
        machine, run = self.machines[0], self.recorded
        core = machine.core
        states_info = zip(machine.state_names, machine.state_units, core.state_long_names, strict=True)
        commands_info = [(f"cylinder.{c}.command", "m", f"{c} spool command") for c in machine.cylinder_names]
        # One construction from all columns: adding variables one by one to a data set costs more than the run.
        columns = _columns(states_info, run.states) | _columns(commands_info, run.commands)
        columns |= _columns(core.output_info, outputs_table(self.machines, self.plan, run))
        columns["payload"] = ("time", run.payloads, {"units": "kg", "long_name": "payload at the tip"})
        if run.ledger.size:
            info = [(f"ledger.{name}", unit, text) for name, unit, text in core.ledger_info]
            entries = _columns(info, run.ledger)
            for (_, _, about), sign in zip(entries.values(), core.ledger_signs, strict=True):
                about["sign"] = sign
            columns |= entries
        if run.samples is not None:
            tip = np.column_stack([columns["tip.x"][1], columns["tip.z"][1]])
            columns |= sample_columns(run.time, tip, machine, self.plan, run.samples)
        time = ("time", run.time, {"units": "s", "long_name": "time"})
        return xr.Dataset(columns, coords={"time": time}, attrs=self.attrs)


def run_dataset(machine: Machine, plan: Scenario, run: Recording, *, payload: float, wall: float) -> RunDataset:
    """The data set of a run that took `wall` s. Files of machines are read now, since they may change later."""
    attrs = _run_attributes(machine, plan, run, payload, wall)
    if run.samples is not None:
        driver = plan.driver
        attrs["controller"] = driver if isinstance(driver, str) else getattr(driver, "__name__", type(driver).__name__)
        attrs["sensors"] = plan.sensors
        # What the controller took the crane for, where that was not the truth.
        if plan.believed is not None:
            believed = plan.believed_machine(machine)
            attrs["believed_source"] = believed.source
            attrs["believed_overrides"] = json.dumps(believed.overrides)
    return RunDataset(attrs, stage_machines(machine, plan), plan, run)


def stage_machine(machine: Machine, stage: Scenario) -> Machine:
    """The machine of a phase of a run that began on `machine`."""
    changed = {key: value for key, value in stage.machine_overrides.items() if machine.overrides.get(key) != value}
    return machine.changed(changed)


def stage_machines(machine: Machine, plan: Scenario) -> list[Machine]:
    """The machine of each phase of a run that began on `machine`."""
    return [stage_machine(machine, stage) if plan.phases else machine for _, stage in plan.stages()]


def outputs_table(machines: Sequence[Machine], plan: Scenario, run: Recording, *, oil: bool = True) -> np.ndarray:
    """Everything derived from the states, (m, n_outputs), in the order of the core's ``output_info``.

    `machines` are those of each phase. Without `oil`, ``energy.oil`` is NaN, and a machine that runs only once is
    spared the making of its tables.
    """
    table = np.empty((len(run.states), len(machines[0].core.output_info)))
    for here, (rows, _) in zip(machines, stage_rows(plan, run.time), strict=True):
        for mass in np.unique(run.payloads[rows]):
            some = rows & (run.payloads == mass)
            table[some] = here.core.outputs(run.states[some], run.commands[some], float(mass), oil)
    return table


def _events(run: Recording) -> list[tuple[float, str]]:
    """What happened on the way, in order of time."""
    changes = [PayloadChange.of(entry) for entry in run.payload_changes]
    return sorted([*run.events, *((change.time, change.text) for change in changes)], key=lambda e: e[0])


def _columns(info: Iterable[tuple[str, str, str]], table: np.ndarray) -> Columns:
    """Variables over time from the columns of a table, by their names, units and meanings."""
    return {
        name: ("time", table[:, i].copy(), {"units": unit, "long_name": meaning})
        for i, (name, unit, meaning) in enumerate(info)
    }


def _run_attributes(
    machine: Machine, plan: Scenario, run: Recording, payload: float, wall: float
) -> dict[str, str | float]:
    """Where the run came from and how it ended: plain strings and numbers, so that every file format keeps them."""
    from hydrocrane import __version__

    about: dict[str, str | float] = {
        "title": plan.title or plan.name,
        "scenario": plan.name,
        "machine": machine.name,
        "machine_source": machine.source,
        "machine_overrides": json.dumps(machine.overrides),
        "joint_names": json.dumps(machine.joint_names),
        "cylinder_names": json.dumps(machine.cylinder_names),
        "payload": payload,
        "payload_changes": json.dumps(run.payload_changes),
        "events": json.dumps(_events(run)),
        "warnings": to_json(run.warnings),
        "verification": json.dumps(None if run.verification is None else asdict(run.verification)),
        "seed": plan.seed,
        "phases": json.dumps([(begin, str(then.driver), then.machine_overrides) for begin, then in plan.stages()[1:]]),
        "outcome": run.outcome.kind,
        "outcome_time": float(run.outcome.time),
        "outcome_message": run.outcome.message or "",
        "solver_method": plan.solver.method,
        "solver_rtol": plan.solver.rtol,
        "solver_max_step": plan.solver.step or plan.solver.max_step,
        "wall_time": wall,
        "source": f"hydrocrane {__version__}",
        "Conventions": "SI units, radians, gauge pressures",
    }
    return about | {f"solver_{key}": value for key, value in run.effort.items()}
