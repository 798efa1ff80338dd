"""Logs prepared for identification.

Those of a rig get their role and load, and the zero of their sensors is subtracted. For a fit of any values the
readings get the names of the model's signals; samples are excluded or held out.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import TypeAlias

import numpy as np

from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError, nearest
from hydrocrane.identification.sensors import PRESSURES, largest_error
from hydrocrane.logs import Log, noise_of
from hydrocrane.logs.columns import LogLike
from hydrocrane.logs.log import stretch
from hydrocrane.logs.mapping import LogMapping, MappingLike
from hydrocrane.logs.noise import BY_MEDIAN
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


# Most samples of a log that are compared; a longer log is decimated.
MOST_SAMPLES = 6000
LEAST_SAMPLES = 10
# Wanted standard error of a start value, as a share of the signal's range.
AT_START = 1e-4
# Distance in robust standard deviations at which a reading at the start is an outlier.
STRAY = 5.0
# The last share of each log, or (from, to), s of the log's clock.
HoldOut: TypeAlias = "float | tuple[float, float] | None"


@dataclass(frozen=True)
class FittedLog:
    """The part of a log that is fitted.

    Attributes
    ----------
    name : str
    time : (m,) array
        s from the start of the window.
    begin : float
        Time of that start on the log's clock, s.
    signals : tuple of str
    readings : (m, n) array
        SI; NaN where there is no usable reading.
    noise : (n,) array
        Standard deviation of one reading's fast noise and rounding.
    held_out : (m,) array of bool
    log : Log
        The window of the log, all samples.
    every : int
        Decimation: every `every`-th sample is a row of the record.
    notes : tuple of str
    unmodelled : (m, n) array or float
        Standard deviation of effects that the model cannot describe, such as friction at rest, SI.
    """

    name: str
    time: Array
    begin: float
    signals: tuple[str, ...]
    readings: Array
    noise: Array
    held_out: np.ndarray
    log: Log
    every: int = 1
    notes: tuple[str, ...] = field(default=())
    unmodelled: Array | float = 0.0

    @property
    def used(self) -> np.ndarray:
        """(m, n) True where a reading is fitted."""
        return np.asarray(np.isfinite(self.readings) & ~self.held_out[:, None])

    @property
    def judged(self) -> np.ndarray:
        """(m, n) True where a reading is held out."""
        return np.asarray(np.isfinite(self.readings) & self.held_out[:, None])


def opened(log: LogLike, mapping: LogMapping | None) -> Log:
    """A checked log whose columns have the names of the model's signals."""
    return Log.of(log, mapping).usable()


def window_of(log: Log, window: tuple[float, float] | None) -> Log:
    """The part of a log that is used."""
    return log if window is None else log.between(*stretch("window", window)).usable()


def record_of(
    log: Log, signals: Sequence[str], units: Mapping[str, str], hold_out: HoldOut, values: Mapping[str, Array]
) -> FittedLog:
    """The record of the `signals` of a log, whose model has these `units`; `values` replace columns."""
    notes = [str(flag) for flag in log.flags]
    every = max(-(-log.time.size // MOST_SAMPLES), 1)
    if every > 1:
        notes.append(f"{log.source}: of {log.time.size} samples every {every}th is compared")
    columns = [_readings(log, name, units[name], values) for name in signals]
    begin = float(log.time[0])
    table = np.stack(columns, axis=1)
    return FittedLog(
        name=log.source,
        time=(log.time - begin)[::every],
        begin=begin,
        signals=tuple(signals),
        readings=table[::every],
        noise=np.array([noise_of(column).total for column in columns]),
        held_out=_held_out(log.time, hold_out)[::every],
        log=log,
        every=every,
        notes=tuple(notes),
    )


def chosen_signals(
    log: Log, asked: Sequence[str] | None, known: Mapping[str, str], also: Sequence[str] = ()
) -> list[str]:
    """Names of the fitted signals: the requested ones, or all that both the log and the model have and that change."""
    there = [*map(str, log.data.data_vars), *also]
    if asked is None:
        found = [name for name in known if name in there and (name in also or _changes(log, name))]
        if not found:
            raise InputError(
                f"{log.source}: no column is named as a signal of the model; it has {', '.join(there)}. State in a "
                'mapping which column is which signal, for example [signal."cylinder.lift.p1"] column = "..."'
            )
        return found
    if isinstance(asked, str):
        raise InputError(f"signals must be a list of names, such as [{asked!r}]")
    for name in asked:
        if name not in known:
            raise InputError(f"the model has no signal `{name}`{nearest(name, list(known))}")
        if name not in there:
            raise InputError(f"{log.source} has no signal `{name}`{nearest(name, there)}; it has {', '.join(there)}")
    return list(asked)


@dataclass(frozen=True)
class Start:
    """A signal at the start of a log, and its standard error, SI."""

    value: float
    error: float


def at_start(log: Log, name: str, longest: float) -> Start:
    """A signal at the start: from a line through as many samples as its noise requires, at most `longest` s."""
    values = log[name]
    span = float(np.nanmax(values) - np.nanmin(values)) if np.isfinite(values).any() else 0.0
    noise = noise_of(values).total
    asked = (noise / (AT_START * span)) ** 2 if span > 0.0 else 1.0
    within = max(int(np.searchsorted(log.time, log.time[0] + longest)), 5)
    count = int(np.clip(np.ceil(asked), 1, within))
    looked = values[: max(count, 5)]
    there = np.flatnonzero(np.isfinite(looked))
    if not there.size:
        raise InputError(f"{log.source}: `{name}` has no readings in its first {longest:g} s; begin later with window=")
    off = np.abs(looked[there] - np.median(looked[there]))
    good = there[off <= STRAY * max(BY_MEDIAN * float(np.median(off)), noise)][:count]
    if good.size < 3:
        return Start(float(values[good[0]]), noise)
    # The end of a regression line has twice the standard error of the mean.
    line = np.polynomial.polynomial.polyfit(log.time[good] - log.time[0], values[good], 1)
    return Start(float(line[0]), 2.0 * noise / float(np.sqrt(good.size)))


def _changes(log: Log, name: str) -> bool:
    """Whether a column has more than one value."""
    values = log[name][np.isfinite(log[name])]
    return values.size > 0 and float(np.ptp(values)) > 0.0


def _readings(log: Log, name: str, unit: str, values: Mapping[str, Array]) -> Array:
    if name in values:
        return values[name]
    stated = str(log.data[name].attrs.get("units", ""))
    if stated and unit and stated != unit:
        raise InputError(
            f"{log.source}: `{name}` is in {stated}, the model's is in {unit}; state column and unit in a mapping, "
            f'[signal."{name}"]'
        )
    readings = np.where(log.spoilt(name), np.nan, log[name])
    if not _changes(log, name):
        raise InputError(f"{log.source}: `{name}` never changes; omit it from signals, and check its sensor")
    if np.isfinite(readings).sum() < LEAST_SAMPLES:
        raise InputError(f"{log.source}: `{name}` has fewer than {LEAST_SAMPLES} usable readings")
    return readings


def _held_out(time: Array, hold_out: HoldOut) -> np.ndarray:
    if hold_out is None:
        return np.zeros(time.size, dtype=bool)
    if np.ndim(hold_out) == 0:
        share = float(real_array(hold_out, "hold_out"))
        if not 0.0 < share < 1.0:
            raise InputError(
                f"hold_out is the last share of each log, between 0 and 1, or (from, to) in s; got {share:g}"
            )
        return np.asarray(time > time[-1] - share * (time[-1] - time[0]))
    start, end = stretch("hold_out", hold_out)
    inside = (time >= start) & (time <= end)
    if not inside.any() or inside.all():
        what = "no" if not inside.any() else "every"
        raise InputError(f"hold_out from {start:g} to {end:g} s takes {what} sample of {time[0]:g} to {time[-1]:g} s")
    return np.asarray(inside)
