"""What can be wrong with a log; each finding is a flag with its cure, none is passed over in silence."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.logs.flags import Flag
from hydrocrane.logs.noise import carries_noise, noise_of
from hydrocrane.logs.signals import PRESSURES

if TYPE_CHECKING:
    import xarray as xr

LEAST_SAMPLES = 10
# Sampling intervals this many times the usual one are gaps; a spread beyond this share is irregular.
GAP, JITTER = 5.0, 0.2
# A constant stretch is suspicious from this many samples on, and from this many times the usual length.
LONGEST_CONSTANT, USUAL_TIMES = 25, 5
# Nothing hydraulic happens within these bounds, or beyond them.
LEAST_PRESSURE, MOST_PRESSURE = 2000.0, 2e8
LONGEST_STROKE = 20.0
SLOWEST_SAMPLING = 0.5
MOST_RUNS = 20
# Beyond this, in any SI unit, a number is a mark and no reading.
ABSURD = 1e30


def checked(data: xr.Dataset, notes: Iterable[Flag] = ()) -> tuple[Flag, ...]:
    """All flags of a log, fatal ones first; `notes` are those of its file."""
    time = np.asarray(data["time"].values, dtype=np.float64)
    ends = (float(np.nanmin(time, initial=0.0)), float(np.nanmax(time, initial=0.0)))
    flags = [_placed(note, *ends) for note in notes]
    flags += _time_flags(time)
    if not any(flag.fatal for flag in flags):
        signals = {str(name): readings(data[name].values) for name in data.data_vars}
        for name, values in signals.items():
            flags += _missing(time, name, values)
        for name in [n for n in ("x", "p1", "p2", "force") if n in signals]:
            flags += _stuck(time, name, signals)
        flags += _unmoving(time, signals) + _wrong_units(time, signals)
    return tuple(sorted(flags, key=lambda flag: (not flag.fatal, flag.start)))


def readings(values: Array) -> Array:
    """Values with those that no sensor reads, infinite or absurdly large ones, as missing."""
    values = np.asarray(values, dtype=np.float64)
    return np.where(np.abs(values) < ABSURD, values, np.nan)


def _placed(note: Flag, start: float, end: float) -> Flag:
    if np.isfinite(note.start):
        return note
    return Flag(note.kind, note.signal, start, end, note.message, note.fatal)


# --- time -----------------------------------------------------------------------------------------------------------


def _time_flags(time: Array) -> list[Flag]:
    if not np.isfinite(time).all():
        where = int(np.argmin(np.isfinite(time)))
        message = f"the time of sample {where + 1} is missing; repair the column or give `sample-rate` in a mapping"
        return [Flag("not-finite", "time", 0.0, 0.0, message, fatal=True)]
    start, end = (float(time[0]), float(time[-1])) if time.size else (0.0, 0.0)
    if time.size < LEAST_SAMPLES:
        message = f"the log has {time.size} samples; at least {LEAST_SAMPLES} are needed"
        return [Flag("too-short", "", start, end, message, fatal=True)]
    interval = np.diff(time)
    if (interval <= 0).any():
        first = int(np.argmax(interval <= 0))
        message = (
            f"time does not increase at {int((interval <= 0).sum())} of its steps, first after {time[first]:.6g} s; "
            f"cut the log where the clock restarts, or give `sample-rate` in a mapping"
        )
        return [Flag("time-not-increasing", "time", start, end, message, fatal=True)]
    return _intervals(time, interval)


def _intervals(time: Array, interval: Array) -> list[Flag]:
    usual = float(np.median(interval))
    gaps = np.flatnonzero(interval > GAP * usual)
    flags = []
    for i in gaps[:MOST_RUNS]:
        message = f"no sample for {interval[i]:.4g} s after {time[i]:.6g} s, usual is {usual:.4g} s; no window spans it"
        flags.append(Flag("gap", "time", float(time[i]), float(time[i + 1]), message))
    if gaps.size > MOST_RUNS:
        message = f"{gaps.size} gaps in time; is the sampling irregular on purpose?"
        flags.append(Flag("gap", "", float(time[gaps[MOST_RUNS]]), float(time[gaps[-1] + 1]), message))
    kept = interval[interval <= GAP * usual]
    if float(np.std(kept)) > JITTER * usual:
        message = (
            f"sampling intervals vary from {kept.min():.4g} to {kept.max():.4g} s; resample before filtering, and "
            f"check whether the logger wrote the time at which it sampled"
        )
        flags.append(Flag("irregular-time", "time", float(time[0]), float(time[-1]), message))
    return flags


# --- values ---------------------------------------------------------------------------------------------------------


def runs(mask: np.ndarray) -> list[tuple[int, int]]:
    """(first, last + 1) of every stretch in which `mask` is true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2])]


def _missing(time: Array, name: str, values: Array) -> list[Flag]:
    stretches = runs(~np.isfinite(values))
    if not stretches:
        return []
    lost = sum(b - a for a, b in stretches)
    if lost == values.size:
        message = f"`{name}` holds no finite number; is it the right column?"
        return [Flag("not-finite", name, float(time[0]), float(time[-1]), message, fatal=name in ("x", *PRESSURES))]
    if len(stretches) > MOST_RUNS:
        stretches = [(stretches[0][0], stretches[-1][1])]
    cure = "they are left out; look for a loose contact or a full buffer"
    return [
        Flag("not-finite", name, float(time[a]), float(time[b - 1]), f"`{name}` misses {lost} values in all; {cure}")
        for a, b in stretches
    ]


def _stuck(time: Array, name: str, signals: dict[str, Array]) -> list[Flag]:
    """Stretches in which a sensor that otherwise lives is exactly constant while something else moves."""
    values = signals[name]
    stretches = [(a, b + 1) for a, b in runs(np.diff(values) == 0.0)]
    if not stretches:
        return []
    lengths = np.array([b - a for a, b in stretches])
    usual = float(np.quantile(lengths, 0.9)) if lengths.size > 4 else 1.0
    least = max(LONGEST_CONSTANT, USUAL_TIMES * usual)
    long = [(a, b) for a, b in stretches if b - a >= least]
    outside = np.ones(values.size, dtype=bool)
    for a, b in long:
        outside[a:b] = False
    if not _lives(values[outside]) or (name == "x" and _repeats(values[outside]) > 0.3):
        # A coarse position sensor repeats itself whenever the piston rests.
        return []
    top, bottom = np.nanmax(values), np.nanmin(values)
    flags = []
    for a, b in [s for s in long if _others_move(name, signals, *s)]:
        start, end = float(time[a]), float(time[b - 1])
        if values[a] in (top, bottom):
            text = f"stands at the end of its range, {values[a]:.6g}, from {start:.6g} to {end:.6g} s; widen the range"
            flags.append(Flag("saturated", name, start, end, f"`{name}` {text} or leave this part out"))
        else:
            text = (
                f"is exactly {values[a]:.6g} from {start:.6g} to {end:.6g} s while others move; check sensor and cable"
            )
            flags.append(Flag("frozen", name, start, end, f"`{name}` {text}"))
    return flags


def _lives(values: Array) -> bool:
    """Whether a sensor's reading would change even at rest, so that standing still is odd."""
    finite = values[np.isfinite(values)]
    return finite.size > LONGEST_CONSTANT and (carries_noise(finite) or np.unique(finite).size > 0.9 * finite.size)


def _repeats(values: Array) -> float:
    """Share of samples that repeat the one before."""
    return float(np.mean(np.diff(values) == 0.0))


def _others_move(name: str, signals: dict[str, Array], a: int, b: int) -> bool:
    for other in ("x", "p1", "p2", "force"):
        if other != name and other in signals:
            noise = noise_of(signals[other])
            means = [np.mean(block) for block in np.array_split(signals[other][a:b], 6)]
            if np.ptp(means) > 5.0 * noise.sigma + 2.0 * noise.step and np.ptp(means) > 0.0:
                return True
    return False


def _unmoving(time: Array, signals: dict[str, Array]) -> list[Flag]:
    x = signals.get("x")
    if x is None or not np.isfinite(x).any():
        return []
    finite = x[np.isfinite(x)]
    noise = noise_of(finite)
    means = [np.mean(block) for block in np.array_split(finite, min(50, finite.size))]
    if np.ptp(means) > 5.0 * noise.sigma + 3.0 * noise.step and np.ptp(means) > 0.0:
        return []
    message = f"the piston moves by no more than its sensor's noise ({np.ptp(finite):.3g} m in all); command more spool"
    return [Flag("unmoving", "x", float(time[0]), float(time[-1]), message)]


# --- units ----------------------------------------------------------------------------------------------------------


def _wrong_units(time: Array, signals: dict[str, Array]) -> list[Flag]:
    ends = (float(time[0]), float(time[-1]))
    flags = []
    held = {n: signals[n] for n in PRESSURES if n in signals and np.isfinite(signals[n]).any()}
    highest = {name: float(np.nanmax(np.abs(values))) for name, values in held.items()}
    for name, peak in highest.items():
        if 0.0 < peak < LEAST_PRESSURE:
            message = f"`{name}` reaches {peak:.4g} Pa only; is it in bar? State the unit in the file or the mapping"
            # One chamber alone may be open to the tank.
            flags.append(Flag("wrong-unit", name, *ends, message, fatal=max(highest.values()) < LEAST_PRESSURE))
        if peak > MOST_PRESSURE:
            message = f"`{name}` reaches {peak:.4g} Pa; check its unit and its scale"
            flags.append(Flag("wrong-unit", name, *ends, message, fatal=True))
    x = signals.get("x")
    if x is not None and np.isfinite(x).any() and float(np.nanmax(x) - np.nanmin(x)) > LONGEST_STROKE:
        travel = np.nanmax(x) - np.nanmin(x)
        message = f"the piston travels {travel:.4g} m; is it in mm? State the unit in the file or the mapping"
        flags.append(Flag("wrong-unit", "x", *ends, message, fatal=True))
    usual = float(np.median(np.diff(time)))
    if usual >= SLOWEST_SAMPLING:
        message = f"samples are {usual:.4g} s apart; is time in ms? State the unit under [time] of a mapping"
        flags.append(Flag("wrong-unit", "time", *ends, message))
    return flags
