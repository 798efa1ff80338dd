"""Logs of a rig prepared for identification: role, load, and subtraction of the zero."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

import numpy as np

from hydrocrane.errors import InputError
from hydrocrane.identification.sensors import PRESSURES, largest_error
from hydrocrane.logs import Log
from hydrocrane.logs.columns import LogLike
from hydrocrane.logs.log import stretch
from hydrocrane.logs.mapping import MappingLike
from hydrocrane.machine.machine import Machine
from hydrocrane.signals import ZeroCalibrated, zero_calibrated
from hydrocrane.signals.resample import at_common_rate

STEADY, RAMP, STEP = "steady", "ramp", "step"
# Role of a log by the name of its experiment; empty if no stage uses it.
ROLES = {
    "constant-velocity": STEADY,
    "load-variation": STEADY,
    "pressure-variation": STEADY,
    "ramp": RAMP,
    "step": STEP,
    "small-sine": "",
    "break-away": "",
    "frictional-lag": "",
}
# With open chambers a pressure differs from zero by at most this multiple of the bound in the data sheet.
MOST_ZERO = 3.0


@dataclass(frozen=True)
class FrictionLog:
    """One log and its role.

    Attributes
    ----------
    log : Log
        The log with the zero subtracted, from the end of the zero on.
    role : {"steady", "ramp", "step", ""}
        Empty if no stage uses the log's experiment.
    payload : float
        kg.
    supply : float
        Pa.
    zero : ZeroCalibrated or None
        The subtracted zero and its standard error.
    notes : tuple of str
        Assumptions.
    """

    log: Log
    role: str
    payload: float
    supply: float
    zero: ZeroCalibrated | None = None
    notes: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The file's name, or the name of the log."""
        return name_of(self.log)


@dataclass(frozen=True)
class ReadingOptions:
    """How logs are read: the options of :func:`~hydrocrane.identification.identify_friction`."""

    rig: Machine
    mapping: MappingLike = None
    payload: float | None = None
    zero: tuple[float, float] | None = None
    load_cell: bool = False
    window: tuple[float, float] | None = None

    def records(self, given: LogLike | Iterable[LogLike], role: str) -> list[FrictionLog]:
        """Records of one log or of several: paths, logs, or other arguments of :meth:`hydrocrane.Log.of`."""
        if isinstance(given, str | PathLike | Log) or not isinstance(given, Iterable):
            return [self._record(given, role)]
        return [self._record(each, role) for each in given]

    def _record(self, given: LogLike, role: str) -> FrictionLog:
        experiment = getattr(getattr(given, "data", None), "attrs", {}).get("experiment", "")
        log = Log.of(given, self.mapping, source=str(experiment))
        role = _role(log, role)
        signals = ("x", "p1", "p2", *(["force"] if self.load_cell else []))
        for signal in (*signals, *(["command"] if role != STEADY else [])) if role else ():
            log[signal]  # Names the missing signal and the cure.
        payload, notes = self._payload(log)
        about = log.data.attrs
        if about.get("machine", self.rig.name) != self.rig.name:
            notes.append(f"was recorded on {about['machine']}, but is used for {self.rig.name}")
        notes += _cut_off(log)
        if role and not log.fatal:
            log = at_common_rate(log, *signals)
        supply = float(about.get("supply", self.rig.supply_pressure))
        if not role:
            notes.append(f"is of the experiment `{about['experiment']}`, which no stage uses")
        if log.fatal:
            # The window may exclude bad stretches of the log.
            log = self._within(log)
        record = FrictionLog(log, role, payload, supply, notes=tuple(notes))
        if log.fatal or not role:
            return record
        record = self._less_zero(record)
        return replace(record, log=self._within(record.log))

    def _within(self, log: Log) -> Log:
        """The log within the window; the zero is read before and may lie outside it."""
        return log if self.window is None else log.between(*stretch("window", self.window))

    def _payload(self, log: Log) -> tuple[float, list[str]]:
        stated = log.data.attrs.get("payload")
        if self.payload is None and isinstance(stated, str):
            raise InputError(f"{log.source}: its payload is `{stated}`; it must be a number of kg")
        if self.payload is None and stated is None:
            own = self.rig.payload()
            return own, [f"states no load; {own:g} kg is taken"]
        mass = self.rig.payload(stated if self.payload is None else self.payload)
        if stated is not None and stated != mass:
            return mass, [f"states a load of {stated} kg; {mass:g} kg is taken, as asked for"]
        return mass, []

    def _less_zero(self, record: FrictionLog) -> FrictionLog:
        """The record without its calibration, and with the zeros found there subtracted."""
        log, stretch = record.log, self.zero
        stated = log.data.attrs.get("calibration", 0.0)
        if stretch is None and isinstance(stated, float | int) and stated > 0:
            if log.time[0] > 0.5 * stated:
                note = f"states a calibration in its first {stated:g} s, but begins at {log.time[0]:.6g} s"
                return replace(record, notes=(*record.notes, note))
            stretch = (0.0, float(stated))
        if stretch is None:
            return record
        self._check_zero(log, *stretch)
        signals = ("p1", "p2", *(["force"] if self.load_cell else []))
        zero = zero_calibrated(log, stretch[1], start=stretch[0], signals=signals)
        return replace(record, log=zero.log, zero=zero)

    def _check_zero(self, log: Log, start: float, end: float) -> None:
        """Checks that pressures with open chambers are zero within the errors of their sensors."""
        inside = (log.time >= start) & (log.time < end)
        for name in PRESSURES if inside.any() else ():
            mean, bound = float(np.nanmean(log[name][inside])), largest_error(self.rig, name)
            if bound is not None and abs(mean) > MOST_ZERO * bound:
                raise InputError(
                    f"{log.source}: `{name}` reads {mean * 1e-5:.4g} bar in its zero, where the data sheet allows "
                    f"{bound * 1e-5:.3g} bar; were both chambers open to the tank?"
                )


def _cut_off(log: Log) -> list[str]:
    """A note if a log ends before the last piece of its experiment."""
    try:
        end = max(float(piece["end"]) for piece in json.loads(str(log.data.attrs.get("segments", "[]"))))
    except (ValueError, TypeError, KeyError):
        return []
    if not log.time.size or log.time[-1] > end - 2.0 * float(np.median(np.diff(log.time))):
        return []
    return [f"ends at {log.time[-1]:.6g} s, its experiment at {end:.6g} s; was it cut, or not copied whole?"]


def name_of(log: Log) -> str:
    """The file's name, or the name of a log."""
    return Path(log.source).name or "log"


def _role(log: Log, asked: str) -> str:
    """The role of a log as given by the caller, checked against its own experiment."""
    experiment = log.data.attrs.get("experiment")
    own = ROLES.get(str(experiment))
    if own is None:
        return asked or STEADY
    if asked and own != asked:
        raise InputError(f"{log.source} was given as a {asked}, but states that it is a `{experiment}`")
    return own
