"""Logs at evenly spaced times."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError
from hydrocrane.logs.checks import GAP, MEASURED, checked
from hydrocrane.logs.log import Log
from hydrocrane.logs.rates import own_samples, runs
from hydrocrane.signals.filters import low_pass

# Cut-off before a lower rate, as a share of that rate: half the Nyquist frequency.
CUTOFF = 0.25


def sampling_rate(time: Array) -> float:
    """Usual number of samples per second."""
    return 1.0 / float(np.median(np.diff(time)))


def resample(log: Log, rate: float | None = None, *, longest_gap: float | None = None) -> Log:
    """The log at evenly spaced times.

    Values are interpolated linearly. Before a lower rate a filter prevents aliasing.

    Parameters
    ----------
    log : Log
    rate : float, optional
        Samples per second; by default the log's usual rate.
    longest_gap : float, optional
        Longer stretches without samples or values, s, remain empty (NaN); by default five usual intervals.
    """
    log = log.usable()
    time = log.time
    usual = sampling_rate(time)
    rate = usual if rate is None else float(real_array(rate, "rate"))
    if not 0.0 < rate <= 1e7:
        raise InputError(f"rate must be between 0 and 1e7 samples per second, got {rate}")
    limit = GAP / usual if longest_gap is None else float(longest_gap)
    count = int(np.floor((time[-1] - time[0]) * rate * (1 + 1e-9))) + 1
    # By rounding the last one may lie beyond the record.
    even = np.minimum(time[0] + np.arange(count) / rate, time[-1])
    data = xr.Dataset(coords={"time": ("time", even, dict(log.data["time"].attrs))}, attrs=dict(log.data.attrs))
    for name in log.data.data_vars:
        data[name] = ("time", _series(time, log[str(name)], even, usual, rate, limit), dict(log.data[name].attrs))
    carried = [flag for flag in log.flags if flag.kind not in ("gap", "irregular-time", "not-finite")]
    fresh = [flag for flag in checked(data) if flag.kind in ("not-finite", "gap")]
    return Log(data, tuple(carried + fresh), log.source)


def readable(log: Log, *signals: str) -> Log:
    """The log at the rate of the slowest of the `signals`, without rows in which one of them is missing.

    Windows continue across a gap of a few rows; a longer gap ends a window, see :func:`unbroken`.
    """
    log = at_common_rate(log, *signals)
    whole = np.isfinite(np.stack([log[name] for name in signals])).all(axis=0)
    return log if whole.all() or not whole.any() else replace(log, data=log.data.isel(time=whole))


def at_common_rate(log: Log, *signals: str) -> Log:
    """The log at the sampling times of the slowest of the `signals`; the log itself if all have its rate.

    Faster signals are means of all samples around each of these times, up to half way to the next ones. This prevents
    aliasing and uses all samples. Commands have their value at these times.
    """
    own = [found.rows for name in signals if (found := own_samples(log[name])) is not None]
    if not own:
        return log
    rows = min(own, key=len)
    # Blocks at both ends would be one-sided.
    edges = (rows[:-1] + rows[1:] + 1) // 2
    rows = rows[1:-1]
    data = log.data.isel(time=rows).copy()
    for name in map(str, data.data_vars):
        values = log[name]
        slow = own_samples(values) if name in MEASURED else None
        if name in MEASURED and (slow is None or slow.rows.size > rows.size + 2):
            known = np.isfinite(values)
            total = np.add.reduceat(np.where(known, values, 0.0)[: edges[-1]], edges[:-1])
            count = np.add.reduceat(known[: edges[-1]].astype(np.float64), edges[:-1])
            mean = np.divide(total, count, out=np.full(rows.size, np.nan), where=count > 0)
            data[name] = ("time", mean, dict(log.data[name].attrs))
    return replace(log, data=data)


def _series(time: Array, values: Array, even: Array, usual: float, rate: float, limit: float) -> Array:
    finite = np.isfinite(values)
    if finite.sum() < 2:
        return np.full(even.size, np.nan)
    known, kept = time[finite], values[finite]
    if rate < 0.5 * usual:
        kept = _smoothed(known, kept, usual, CUTOFF * rate, limit)
    found = np.interp(even, known, kept, left=np.nan, right=np.nan)
    for i in np.flatnonzero(np.diff(known) > limit):
        found[(even > known[i]) & (even < known[i + 1])] = np.nan
    return found


def _smoothed(time: Array, values: Array, usual: float, cutoff: float, limit: float) -> Array:
    """Each stretch between long gaps, filtered separately at the usual rate."""
    smooth = values.copy()
    edges = [0, *(np.flatnonzero(np.diff(time) > limit) + 1), time.size]
    for a, b in zip(edges[:-1], edges[1:]):
        if b - a > 3:
            even = np.linspace(time[a], time[b - 1], max(int(round((time[b - 1] - time[a]) * usual)) + 1, 4))
            rate = (even.size - 1) / (even[-1] - even[0])
            smooth[a:b] = np.interp(
                time[a:b], even, low_pass(np.interp(even, time[a:b], values[a:b]), rate, cutoff, order=8)
            )
    return smooth


def unbroken(log: Log, *signals: str, least: int = 10) -> list[tuple[int, int]]:
    """(first, last + 1) of every stretch of samples without gap or missing value, at least `least` samples long."""
    whole = np.asarray(np.isfinite(np.stack([log[name] for name in signals])).all(axis=0))
    time = log.time
    interval = np.diff(time)
    after_gap = [int(i) + 1 for i in np.flatnonzero(interval > GAP * np.median(interval))]
    pieces: list[tuple[int, int]] = []
    for a, b in runs(whole).tolist():
        cuts = [a, *(cut for cut in after_gap if a < cut < b), b]
        pieces += list(zip(cuts[:-1], cuts[1:]))
    return [(a, b) for a, b in pieces if b - a >= least]
