"""The record of a run: its data and metadata."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, cast

from hydrocrane.errors import ResultFileError, nearest
from hydrocrane.files.columns import Attributes, Columns
from hydrocrane.machine.machine import Machine
from hydrocrane.result_warning import ResultWarning, from_json
from hydrocrane.results.carried import made, statement
from hydrocrane.results.dataset import RunDataset
from hydrocrane.results.learnt import LearntValve, LearntValves
from hydrocrane.results.outcome import KINDS, Outcome, Verification
from hydrocrane.scenario.payload import PayloadChange

if TYPE_CHECKING:
    import xarray as xr


# Attributes that every run states, with what reads them; and those with a property that does.
STATED: dict[str, Callable[[str], object]] = {
    "scenario": str, "machine": str, "source": str, "solver_method": str, "solver_rtol": float
}  # fmt: skip
READ = ("outcome", "events", "learnt", "verification", "payload_changes", "joint_names", "cylinder_names")


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
        where the controller has one, ``set_point.{x,z}`` and ``tip.deviation``. Machines in space add
        ``tip.y`` and ``set_point.y``.
    columns : Columns
        The same as plain arrays by name, ``run.columns["tip.x"].values``: a program that does not use `data` does not
        import xarray and pandas.
    """

    def __init__(
        self, data: xr.Dataset | RunDataset, machine: Machine | None = None, carried: Attributes | None = None
    ) -> None:
        self._unlabelled: RunDataset | None = None
        if isinstance(data, RunDataset):
            self._unlabelled = data
        else:
            self.data = data
        self._machine = machine
        # The text of the machine; made when the run is saved.
        self._carried = carried or {}

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
        kind = str(about["outcome"])
        if kind not in KINDS:
            raise ResultFileError(f"a run does not end as `{kind}`{nearest(kind, KINDS)}")
        return Outcome(kind, float(about["outcome_time"]), str(about["outcome_message"]))

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
        return LearntValves({name: LearntValve(*map(float, values)) for name, values in found.items()})

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
        """The machine that ran; a loaded run makes it from the text that the run carries, whatever its file has become.

        Its ``source`` is no file: to use it elsewhere, write its :meth:`~hydrocrane.Machine.to_toml` to one.
        """
        if self._machine is None:
            self._machine = made(self._attrs, self._carried)
        return self._machine

    def _carrying_its_machine(self) -> xr.Dataset | Columns:
        """The data, which state the text of the machine."""
        if not self._carried and self._machine is not None:
            self._carried = statement(self._machine)
        return self._held.assign_attrs(self._carried)

    def _check(self, source: str) -> None:
        """An error if something that the record says about itself cannot be understood.

        Raises
        ------
        ResultFileError
            With the `source` and the attribute.
        """
        for name in (*STATED, *READ):
            try:
                str(getattr(self, name) if name in READ else STATED[name](str(self._attrs[name])))
            except (LookupError, TypeError, ValueError, AttributeError, RecursionError) as error:
                reason = f"what it says of its `{name}` is missing or damaged ({type(error).__name__}: {error})"
                raise ResultFileError(f"{source}: {reason}; copy it again from where it was saved") from None

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints from the base to the tip."""
        return self._names("joint_names")

    @property
    def cylinder_names(self) -> tuple[str, ...]:
        """Names of the cylinders; cylinder i moves joint i."""
        return self._names("cylinder_names")

    def _names(self, attribute: str) -> tuple[str, ...]:
        found = json.loads(str(self._attrs[attribute]))
        if not isinstance(found, list):
            raise TypeError(f"not a list but {found!r}")
        return tuple(map(str, found))
