"""What the core recorded of a run, before it is labelled."""

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
    """What held in a stage of a run.

    Attributes
    ----------
    begin : float
        s.
    machine, believed : Machine
        The machine, and what the controller took it for.
    stick_mode : {"tip", "lever"}
    controlled : bool
        Whether a controller moved the spools.
    """

    begin: float
    machine: Machine
    believed: Machine
    stick_mode: str
    controlled: bool

    @classmethod
    def of(cls, told: StageTable, first: Machine) -> RecordedStage:
        """From what the core tells of it; `first` is the machine that the run began on."""
        machine = first.made(told["machine"])
        controlled = told["controller"] is not None or told["own"] is not None
        return cls(told["from"], machine, machine.made(told["believed"]), told["mode"], controlled)


@dataclass
class Recording:
    """The arrays of a run, a row per time, and how it ended.

    Attributes
    ----------
    time : (m,) array
        s.
    states, commands, ledger : (m, n) arrays
        `ledger` is empty where it was not integrated.
    payloads : (m,) array
        At the tip, kg.
    outcome : Outcome
    method : str
        That integrated it.
    effort : dict
        Steps, rejections, evaluations.
    warnings : tuple of ResultWarning
    payload_changes : sequence
        As the core tells them.
    stages : sequence of RecordedStage
        Those that were to begin before the end.
    samples : sequence
        What the controller of each stage saw and did.
    events : sequence of (time, text)
    error : BaseException or None
        What a controller of one's own raised, where that ended the run.
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
    verification: Verification | None = None

    @classmethod
    def of(cls, raw: RunRecord, machine: Machine, doubts: Sequence[ResultWarning] = ()) -> Recording:
        """What the core recorded of a run that began on `machine`; its warnings and the plan's `doubts` come first."""
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
            stages=tuple(RecordedStage.of(told, machine) for told in raw["stages"]),
            samples=raw["samples"],
            events=raw["events"],
        )
