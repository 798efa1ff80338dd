"""Logs prepared for a fit: readings by the names of the model's signals, excluded and held-out samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError, nearest
from hydrocrane.logs import Log, noise_of
from hydrocrane.logs.columns import LogLike
from hydrocrane.logs.log import stretch
from hydrocrane.logs.mapping import LogMapping
from hydrocrane.logs.noise import BY_MEDIAN

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
