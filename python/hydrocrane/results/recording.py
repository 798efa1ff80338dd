"""What the core recorded of a run, before it is labelled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hydrocrane._core_types import PayloadEntry, RunRecord, Samples
from hydrocrane.arrays import Array
from hydrocrane.result_warning import ResultWarning
from hydrocrane.results.outcome import Outcome, Verification


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
    effort : dict
        Steps, rejections, evaluations.
    warnings : tuple of ResultWarning
    payload_changes : sequence
        As the core tells them.
    samples : sequence or None
        What the controller of each phase saw and did; ``None`` without a controller.
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
    effort: dict[str, int]
    warnings: tuple[ResultWarning, ...] = ()
    payload_changes: Sequence[PayloadEntry] = ()
    samples: Sequence[Samples] | None = None
    events: Sequence[tuple[float, str]] = ()
    error: BaseException | None = None
    verification: Verification | None = None

    @classmethod
    def of(cls, raw: RunRecord, doubts: tuple[ResultWarning, ...]) -> Recording:
        """What the core recorded, with its warnings behind those of the machine and of the start, `doubts`."""
        return cls(
            time=np.asarray(raw["t"]),
            states=np.asarray(raw["states"]),
            commands=np.asarray(raw["commands"]),
            ledger=np.asarray(raw["ledger"]),
            payloads=np.asarray(raw["payloads"]),
            outcome=Outcome(*raw["outcome"]),
            effort=raw["stats"],
            warnings=(*doubts, *(ResultWarning(*entry) for entry in raw["warnings"])),
            payload_changes=raw["payload_changes"],
            samples=raw.get("samples"),
            events=raw.get("events", ()),
        )
