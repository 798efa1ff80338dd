"""The record of a run: its data and metadata."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, cast

from hydrocrane.errors import ResultFileError
from hydrocrane.files.columns import Attributes, Columns
from hydrocrane.machine.machine import Machine, load_machine
from hydrocrane.result_warning import ResultWarning, from_json
from hydrocrane.results.dataset import RunDataset
from hydrocrane.results.learnt import LearntValve, LearntValves
from hydrocrane.results.outcome import Outcome, Verification
from hydrocrane.scenario.payload import PayloadChange

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Event:
    """An event at `time` (s) of a run, such as a controller without a usable command.

    `warning` is the kind of the warning that the event reports, and empty for any other event.

    Examples
    --------
    >>> run = hc.simulate("vertical-lift-open-loop", payload_changes={1.0: 50.0}, duration=1.5)
    >>> print(run.events[0].time, run.events[0].text)
    1.0 picks up 50 kg; payload 50 kg, tip from 0.173 to 0.0292 m/s, 0.126 J lost
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
    columns : Columns
        The same as plain arrays by name, ``run.columns["tip.x"].values``: a program that does not use `data` does not
        import xarray and pandas.
    """

    def __init__(self, data: xr.Dataset | RunDataset, machine: Machine | None = None) -> None:
        self._unlabelled: RunDataset | None = None
        if isinstance(data, RunDataset):
            self._unlabelled = data
        else:
            self.data = data
        self._machine = machine

    @cached_property
    def data(self) -> xr.Dataset:
        unlabelled = self._unlabelled
        if unlabelled is None:
            # Another thread may have made it in the meantime.
            return cast(xr.Dataset, self.__dict__["data"])
        self.data = unlabelled.columns.labelled()
        self._unlabelled = None
        return self.data

    @property
    def _held(self) -> xr.Dataset | Columns:
        """The data; the labelled data set if it exists, because the user may have changed it."""
        unlabelled = self._unlabelled
        return self.data if unlabelled is None else unlabelled.columns

    @property
    def columns(self) -> Columns:
        """The same as `data`, as plain arrays by name: ``run.columns["tip.x"].values``.

        A program that does not use `data` does not import xarray and pandas.
        """
        return Columns.of(self._held)

    @property
    def _attrs(self) -> Attributes:
        """Attributes of the data."""
        unlabelled = self._unlabelled
        return cast("Attributes", self.data.attrs) if unlabelled is None else unlabelled.attrs

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, "data": self.data, "_unlabelled": None}

    def __repr__(self) -> str:
        about = self._attrs
        return f"<Run {about['scenario']} on {about['machine']}: {self.outcome.kind} at {self.outcome.time:.4g} s>"

    @cached_property
    def outcome(self) -> Outcome:
        """How and when the run ended."""
        about = self._attrs
        return Outcome(str(about["outcome"]), float(about["outcome_time"]), str(about["outcome_message"]))

    @property
    def events(self) -> tuple[Event, ...]:
        """Events in order of time: errors of a controller, loads picked up and released, warnings."""
        own = [Event(float(time), str(text)) for time, text in json.loads(str(self._attrs.get("events", "[]")))]
        doubts = [Event(warning.time, f"warning: {warning}", warning.kind) for warning in self.warnings]
        return tuple(sorted([*own, *doubts], key=lambda event: event.time))

    @property
    def warnings(self) -> tuple[ResultWarning, ...]:
        """Why the run may be wrong, in order of time, with cause and cure; see docs/reference/warnings.md."""
        return from_json(str(self._attrs.get("warnings", "[]")))

    @property
    def learnt(self) -> LearntValves:
        """What the controller learnt about each valve, by the valve's name; empty if it does not learn."""
        found = json.loads(str(self._attrs.get("learnt", "{}")))
        return LearntValves({name: LearntValve(*values) for name, values in found.items()})

    @property
    def verification(self) -> Verification | None:
        """Difference of the run from a tighter repeat; ``None`` if it was run without ``verify``."""
        found = json.loads(str(self._attrs.get("verification", "null")))
        return None if found is None else Verification(**found)

    @property
    def payload_changes(self) -> tuple[PayloadChange, ...]:
        """Loads picked up and released, in order of time; rows at such a time have the state before it."""
        return tuple(PayloadChange.of(entry) for entry in json.loads(str(self._attrs.get("payload_changes", "[]"))))

    @property
    def machine(self) -> Machine:
        """The machine that ran; a loaded run loads it again by its source and overrides."""
        if self._machine is None:
            about = self._attrs
            source = str(about["machine_source"])
            if ("/" in source or "\\" in source) and not Path(source).is_file():
                raise ResultFileError(f"this run's machine file {source} is gone; its data can still be read")
            self._machine = load_machine(source, json.loads(str(about["machine_overrides"])))
        return self._machine

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints from the base to the tip."""
        return tuple(json.loads(str(self._attrs["joint_names"])))

    @property
    def cylinder_names(self) -> tuple[str, ...]:
        """Names of the cylinders; cylinder i moves joint i."""
        return tuple(json.loads(str(self._attrs["cylinder_names"])))
