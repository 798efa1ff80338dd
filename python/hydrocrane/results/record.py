"""The record of a run: its data, and what it says about itself."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import xarray as xr

from hydrocrane.errors import ResultFileError
from hydrocrane.machine.machine import Machine, load_machine
from hydrocrane.result_warning import ResultWarning, from_json
from hydrocrane.results.outcome import Outcome, Verification
from hydrocrane.scenario.payload import PayloadChange


@dataclass(frozen=True)
class Event:
    """Something worth knowing that happened at `time` (s) of a run, such as a controller without a usable command.

    `warning` is the kind of the warning that the event tells, and empty for any other event.
    """

    time: float
    text: str
    warning: str = ""


class Record:
    """The record of a run.

    Attributes
    ----------
    data : xarray.Dataset
        Over ``time``: every state by its name, ``tip.x``, ``tip.z``,
        ``cylinder.<c>.{x,v,force,friction,q1,q2,command}``, ``supply.{flow,power}``, ``payload``, ``ledger.*``; each
        with ``units`` and ``long_name``. Closed-loop runs add ``measured.*``, ``stick.*``, ``controller.<c>`` and,
        where the controller has one, ``set_point.{x,z}`` and ``tip.deviation``.
    """

    def __init__(self, data: xr.Dataset, machine: Machine | None = None) -> None:
        self.data = data
        self._machine = machine

    def __repr__(self) -> str:
        about = self.data.attrs
        return f"<Run {about['scenario']} on {about['machine']}: {self.outcome.kind} at {self.outcome.time:.4g} s>"

    @cached_property
    def outcome(self) -> Outcome:
        about = self.data.attrs
        return Outcome(str(about["outcome"]), float(about["outcome_time"]), str(about["outcome_message"]))

    @property
    def events(self) -> tuple[Event, ...]:
        """What happened on the way, in order of time: trouble of a controller, loads picked up and let go, warnings."""
        own = [Event(float(time), str(text)) for time, text in json.loads(self.data.attrs.get("events", "[]"))]
        doubts = [Event(warning.time, f"warning: {warning}", warning.kind) for warning in self.warnings]
        return tuple(sorted([*own, *doubts], key=lambda event: event.time))

    @property
    def warnings(self) -> tuple[ResultWarning, ...]:
        """Why the run may be wrong, in order of time, with cause and cure; see docs/reference/warnings.md."""
        return from_json(self.data.attrs.get("warnings", "[]"))

    @property
    def verification(self) -> Verification | None:
        """How the run differs from a tighter repeat; ``None`` where it was run without ``verify``."""
        found = json.loads(self.data.attrs.get("verification", "null"))
        return None if found is None else Verification(**found)

    @property
    def payload_changes(self) -> tuple[PayloadChange, ...]:
        """Loads picked up and let go, in order of time; rows at such a time have the state before it."""
        return tuple(PayloadChange.of(entry) for entry in json.loads(self.data.attrs.get("payload_changes", "[]")))

    @property
    def machine(self) -> Machine:
        """The machine that ran; a loaded run fetches it again by its source and overrides."""
        if self._machine is None:
            about = self.data.attrs
            source = about["machine_source"]
            if ("/" in source or "\\" in source) and not Path(source).is_file():
                raise ResultFileError(f"this run's machine file {source} is gone; its data can still be read")
            self._machine = load_machine(source, json.loads(about["machine_overrides"]))
        return self._machine

    @property
    def joint_names(self) -> tuple[str, ...]:
        return tuple(json.loads(self.data.attrs["joint_names"]))

    @property
    def cylinder_names(self) -> tuple[str, ...]:
        return tuple(json.loads(self.data.attrs["cylinder_names"]))
