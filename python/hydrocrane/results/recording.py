"""The arrays that the core recorded of a run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hydrocrane._core_types import PayloadEntry, RunRecord, Samples, StageTable
from hydrocrane.arrays import Array
from hydrocrane.machine.machine import Machine
from hydrocrane.result_warning import ResultWarning
from hydrocrane.results.outcome import Outcome, Verification


@dataclass(frozen=True)
class RecordedStage:
    """Settings of a stage of a run.

    Attributes
    ----------
    begin : float
        s.
    machine, controller_model : Machine
        The machine and the controller model.
    changes : sequence of (time, Machine)
        Machines that took its place during the stage, with the times (s) of these changes.
    stick_mode : {"tip", "lever"}
    controlled : bool
        Whether a controller moved the spools.
    """

    begin: float
    machine: Machine
    controller_model: Machine
    stick_mode: str
    controlled: bool
    changes: Sequence[tuple[float, Machine]] = ()

    @classmethod
    def of(cls, stage: StageTable, first: Machine) -> RecordedStage:
        """From the core's record; `first` is the machine at the start of the run."""
        machine = first.made(stage["machine"])
        controlled = stage["controller"] is not None or stage["own"] is not None
        changes = tuple((time, first.made(changed)) for time, changed in stage["changes"])
        return cls(stage["from"], machine, machine.made(stage["controller_model"]), stage["mode"], controlled, changes)


@dataclass
class Recording:
    """The arrays of a run, a row per time, and its outcome.

    Attributes
    ----------
    time : (m,) array
        s.
    states, commands, ledger : (m, n) arrays
        `ledger` is empty if it was not integrated.
    payloads : (m,) array
        At the tip, kg.
    outcome : Outcome
    method : str
        Method of integration.
    effort : dict
        Steps, rejections, evaluations.
    warnings : tuple of ResultWarning
    payload_changes : sequence
        As recorded by the core.
    stages : sequence of RecordedStage
        The stages that begin before the end.
    samples : sequence
        Inputs and outputs of the controller of each stage.
    events : sequence of (time, text)
    error : BaseException or None
        Exception of your own controller, if it ended the run.
    tip_error : float or None
        How far the errors of all steps put the tip off at most, by estimate, m; ``None`` where they are not estimated.
    verification : Verification or None
    """

    time: Array
    states: Array
    commands: Array
    ledger: Array
    payloads: Array
    outcome: Outcome
    method: str
    effort: dict[str, int]
    warnings: tuple[ResultWarning, ...] = ()
    payload_changes: Sequence[PayloadEntry] = ()
    stages: Sequence[RecordedStage] = ()
    samples: Sequence[Samples] = ()
    events: Sequence[tuple[float, str]] = ()
    error: BaseException | None = None
    tip_error: float | None = None
    verification: Verification | None = None

    @classmethod
    def of(cls, raw: RunRecord, machine: Machine, doubts: Sequence[ResultWarning] = ()) -> Recording:
        """From the core's record of a run that began on `machine`; its warnings and the plan's `doubts` come first."""
        return cls(
            time=np.asarray(raw["t"]),
            states=np.asarray(raw["states"]),
            commands=np.asarray(raw["commands"]),
            ledger=np.asarray(raw["ledger"]),
            payloads=np.asarray(raw["payloads"]),
            outcome=Outcome(*raw["outcome"]),
            method=raw["method"],
            effort=raw["stats"],
            warnings=(*machine.warnings, *doubts, *(ResultWarning(*e) for e in (*raw["doubts"], *raw["warnings"]))),
            payload_changes=raw["payload_changes"],
            stages=tuple(RecordedStage.of(stage, machine) for stage in raw["stages"]),
            samples=raw["samples"],
            events=raw["events"],
            tip_error=raw["tip_error"],
        )
