"""Checks of a log; each finding is a flag with its cure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from hydrocrane.arrays import Array
from hydrocrane.logs.hum import hum_of
from hydrocrane.logs.noise import Noise, carries_noise, finite_of, most_noise, noise_of
from hydrocrane.logs.rates import own_samples, runs
from hydrocrane.logs.signals import ATMOSPHERE, PRESSURES, Flag

if TYPE_CHECKING:
    import xarray as xr

LEAST_SAMPLES = 10
# Sampling intervals above this multiple of the usual one are gaps; a spread above this share is irregular.
GAP, JITTER = 5.0, 0.2
# Least number of samples of a suspicious constant stretch, and its least length as a multiple of the usual one.
LONGEST_CONSTANT, USUAL_TIMES = 25, 5
# Least number of consecutive samples at an end of the range that is no coincidence if noise exceeds the converter's
# step; and least number of all such samples for the conclusion that the range is too narrow.
CLIPPED_RUN, LEAST_CLIPPED = 3, 12
# Chance below which a constant stretch is no accident of rounding.
ACCIDENT = 1e-5
# Number of samples over which changes of the other signals are judged, and least change of the other pressure, in steps
# of a converter, that is one.
PART, CHANGED_STEPS = 12, 3.0
# A pressure that misses fewer than this share of these changes follows them all.
SELDOM = 0.05
# Readings of a coarse pressure are equal to their predecessors in more than this share.
MOSTLY = 0.7
# Bounds of the usual values of hydraulic signals.
LEAST_PRESSURE, MOST_PRESSURE = 2000.0, 2e8
LONGEST_STROKE = 20.0
SLOWEST_SAMPLING = 0.5
MOST_RUNS = 20
# Signals of sensors; a command may be constant.
MEASURED = ("x", "v", "p1", "p2", "force")
# Flags that follow from the values; a resampled log no longer shows its slow signals.
_OF_VALUES = (
    "too-short", "time-not-increasing", "not-finite", "gap", "irregular-time", "saturated", "frozen", "unmoving",
    "clipped", "coarse", "wrong-unit", "hum", "slow-signal",
)  # fmt: skip
# A larger number, in any SI unit, is a mark and no reading.
ABSURD = 1e30


class _Signal:
    """Values (n,) of a signal, NaN where they are `missing`, and what several checks need of them."""

    def __init__(self, values: Array) -> None:
        self.values = readings(values)
        self.missing = np.isnan(self.values)

    @cached_property
    def ends(self) -> tuple[float, float]:
        """Least and largest value; NaN if there is none."""
        return float(np.fmin.reduce(self.values)), float(np.fmax.reduce(self.values))

    @cached_property
    def noise(self) -> Noise:
        return noise_of(self.values)

    @cached_property
    def constant(self) -> tuple[list[list[int]], NDArray[np.bool_]]:
        """First and last + 1 sample of the unusually long constant stretches, and the samples outside of these."""
        stretches = runs(self.values[1:] == self.values[:-1]) + (0, 1)
        lengths = stretches[:, 1] - stretches[:, 0]
        usual = float(np.quantile(lengths, 0.9)) if lengths.size > 4 else 1.0
        long = stretches[lengths >= max(LONGEST_CONSTANT, USUAL_TIMES * usual)].tolist()
        outside = np.ones(self.values.size, dtype=bool)
        for a, b in long:
            outside[a:b] = False
        return long, outside

    @property
    def empty(self) -> bool:
        return math.isnan(self.ends[0])

    @property
    def least_motion(self) -> float:
        """Change of means that is no noise."""
        return 5.0 * self.noise.sigma + 2.0 * self.noise.step


_Signals: TypeAlias = Mapping[str, _Signal]


def checked(data: xr.Dataset, notes: Iterable[Flag] = ()) -> tuple[Flag, ...]:
    """All flags of a log, fatal ones first; `notes` are those of its file."""
    time = np.asarray(data["time"].values, dtype=np.float64)
    ends = (float(np.nanmin(time, initial=0.0)), float(np.nanmax(time, initial=0.0)))
    flags = [note if np.isfinite(note.start) else replace(note, start=ends[0], end=ends[1]) for note in notes]
    signals = {str(name): _Signal(data[name].values) for name in data.data_vars}
    interval = np.diff(time)
    flags += _broken_time(time, interval)
    if not any(flag.fatal for flag in flags):
        usual = float(np.median(interval))
        flags += _intervals(time, interval, usual, signals.get("x"))
        for name, signal in signals.items():
            flags += _slow(time, name, signal.values, usual) or _missing(time, name, signal, usual)
        for name in [n for n in MEASURED if n in signals and n != "v"]:
            stuck = _stuck(time, name, signals)
            saturated = any(flag.kind == "saturated" for flag in stuck)
            flags += stuck if saturated else stuck + _clipped(time, name, signals[name].values)
        flags += [flag for name in PRESSURES if name in signals for flag in _coarse(time, name, signals[name])]
        flags += _hums(time, usual, signals) + _unmoving(time, signals) + _wrong_units(time, usual, signals)
    return tuple(sorted(flags, key=lambda flag: (not flag.fatal, flag.start)))


def rechecked(data: xr.Dataset, flags: Iterable[Flag]) -> tuple[Flag, ...]:
    """Flags of a part of a log or of a corrected log: its own, and those of the earlier `flags` that do not follow from
    values."""
    kept = [flag for flag in flags if flag.kind not in _OF_VALUES]
    found = checked(data, kept)
    slow = {flag.signal for flag in found if flag.kind == "slow-signal"}
    return found + tuple(flag for flag in flags if flag.kind == "slow-signal" and flag.signal not in slow)


def readings(values: Array) -> Array:
    """Values; infinite or absurdly large ones count as missing."""
    values = np.asarray(values, dtype=np.float64)
    return np.where(np.abs(values) < ABSURD, values, np.nan)


# --- time -----------------------------------------------------------------------------------------------------------


def _broken_time(time: Array, interval: Array) -> list[Flag]:
    if not np.isfinite(time).all():
        where = int(np.argmin(np.isfinite(time)))
        message = f"the time of sample {where + 1} is missing; repair the column or give `sample-rate` in a mapping"
        return [Flag("not-finite", "time", 0.0, 0.0, message, fatal=True)]
    start, end = (float(time[0]), float(time[-1])) if time.size else (0.0, 0.0)
    if time.size < LEAST_SAMPLES:
        message = f"the log has {time.size} samples; at least {LEAST_SAMPLES} are needed"
        return [Flag("too-short", "", start, end, message, fatal=True)]
    if (interval <= 0).any():
        first = int(np.argmax(interval <= 0))
        if (interval >= 0).all():
            cause = "it repeats: times have too few digits, or rows are repeated; give `sample-rate` in a mapping"
        else:
            back = float(-interval.min())
            cause = (
                f"it goes back by up to {back:.4g} s: the clock was set, or several recordings follow each other; cut "
                "the log there, or give `sample-rate` in a mapping where no sample is missing"
            )
        count = int((interval <= 0).sum())
        message = f"time does not increase at {count} of its steps, first after {time[first]:.6g} s; {cause}"
        return [Flag("time-not-increasing", "time", start, end, message, fatal=True)]
    return []


def _intervals(time: Array, interval: Array, usual: float, x: _Signal | None) -> list[Flag]:
    gaps = np.flatnonzero(interval > GAP * usual)
    flags = []
    for i in gaps[:MOST_RUNS]:
        message = f"no sample for {interval[i]:.4g} s after {time[i]:.6g} s, usual is {usual:.4g} s; no window spans it"
        if x is not None and _goes_on(x, int(i), float(interval[i]) / usual):
            message += (
                ". The piston moves before and after, and its position is as if there were no gap: the clock was set "
                "rather than samples lost; give `sample-rate` in a mapping"
            )
        flags.append(Flag("gap", "time", float(time[i]), float(time[i + 1]), message))
    if gaps.size > MOST_RUNS:
        message = f"{gaps.size} gaps in time; is the sampling irregular on purpose?"
        flags.append(Flag("gap", "", float(time[gaps[MOST_RUNS]]), float(time[gaps[-1] + 1]), message))
    kept = interval[interval <= GAP * usual] if gaps.size else interval
    if float(np.std(kept)) > JITTER * usual:
        message = (
            f"sampling intervals vary from {kept.min():.4g} to {kept.max():.4g} s; resample before filtering, and "
            f"check whether the logger wrote the time at which it sampled"
        )
        flags.append(Flag("irregular-time", "time", float(time[0]), float(time[-1]), message))
    return flags


def _goes_on(x: _Signal, i: int, rows: float) -> bool:
    """Whether the piston moves about row i, and moves only by the displacement of one row over a gap of `rows` rows."""
    before, after = x.values[max(i - 20, 0) : i + 1], x.values[i + 1 : i + 22]
    if before.size < 10 or after.size < 10 or not np.isfinite([*before, *after]).all():
        return False
    speeds = [np.polyfit(np.arange(part.size), part, 1) for part in (before[::-1], after)]
    # Both lines are evaluated half a row beyond their ends, where they meet if no sample is lost.
    apart = abs(float(np.polyval(speeds[0], -0.5) - np.polyval(speeds[1], -0.5)))
    travel = abs(float(speeds[1][0])) * rows
    return travel > 20.0 * (x.noise.total + abs(float(speeds[1][0]))) and apart < 0.1 * travel


# --- values ---------------------------------------------------------------------------------------------------------


def _missing(time: Array, name: str, signal: _Signal, usual: float) -> list[Flag]:
    stretches = runs(signal.missing)
    if not stretches.size:
        return []
    lost = np.count_nonzero(signal.missing)
    if lost == time.size:
        message = f"`{name}` holds no finite number; is it the right column?"
        return [Flag("not-finite", name, float(time[0]), float(time[-1]), message, fatal=name in ("x", *PRESSURES))]
    longest = float((time[stretches[:, 1] - 1] - time[stretches[:, 0]]).max()) + usual
    text = (
        f"`{name}` misses {lost} values in {len(stretches)} stretches, the longest {longest:.3g} s; windows continue "
        f"across up to {GAP - 1:g} samples and end at longer ones. Look for a loose contact or a full buffer"
    )
    if len(stretches) > MOST_RUNS:
        stretches = np.array([[stretches[0, 0], stretches[-1, 1]]])
    return [Flag("not-finite", name, float(time[a]), float(time[b - 1]), text) for a, b in stretches]


def _slow(time: Array, name: str, values: Array, usual: float) -> list[Flag]:
    """Flag of a signal with fewer samples than the log has rows."""
    own = own_samples(values) if name in MEASURED else None
    if own is None:
        return []
    rate = 1.0 / float(np.median(np.diff(time[own.rows])))
    text = (
        f"`{name}` was sampled at {rate:.4g} Hz beside {1.0 / usual:.4g} Hz of the log and is {own.between} between; "
        "windows and friction are computed at the slowest rate, with means of the faster signals. If that is too slow, "
        "sample it faster"
    )
    return [Flag("slow-signal", name, float(time[0]), float(time[-1]), text)]


def _hums(time: Array, usual: float, signals: _Signals) -> list[Flag]:
    flags = []
    for name in [n for n in ("p1", "p2", "force") if n in signals and "x" in signals]:
        for hum in hum_of(time, signals[name].values, signals["x"].values, usual):
            size = f"{hum.amplitude / 1e5:.3g} bar" if name in PRESSURES else f"{hum.amplitude:.3g} N"
            text = (
                f"`{name}` carries {size} at {hum.frequency:.4g} Hz independent of the motion: hum of {hum.mains:g} Hz "
                "mains, it does not count as motion. Shield and earth its cable, at one end"
            )
            flags.append(Flag("hum", name, float(time[0]), float(time[-1]), text))
    return flags


def _stuck(time: Array, name: str, signals: _Signals) -> list[Flag]:
    """Stretches in which a sensor with noise is exactly constant while other signals change."""
    values, (long, outside) = signals[name].values, signals[name].constant
    if not long or not _lives(values[outside]):
        return []
    noise = noise_of(values[outside])
    events = _Events(name, signals, noise.step) if noise.step and name in PRESSURES else None
    flags = []
    for a, b in [s for s in long if _others_move(name, signals, *s)]:
        if _rounded(noise, b - a) * (events.missed(a, b) if events else 1.0) > ACCIDENT:
            continue
        start, end = float(time[a]), float(time[b - 1])
        if values[a] in signals[name].ends:
            text = f"stays at the end of its range, {values[a]:.6g}, from {start:.6g} to {end:.6g} s; widen the range"
            flags.append(Flag("saturated", name, start, end, f"`{name}` {text} or leave this part out"))
        else:
            text = (
                f"is exactly {values[a]:.6g} from {start:.6g} to {end:.6g} s while others move; check sensor and cable"
            )
            flags.append(Flag("frozen", name, start, end, f"`{name}` {text}"))
    return flags


def clipped_at(values: Array) -> list[float]:
    """Ends of the range at which a noisy sensor repeatedly stays for a few samples.

    Noise larger than the converter's step practically never repeats the outermost value for three samples in a row.
    """
    finite = finite_of(values)
    if finite.size < LEAST_CLIPPED * 2:
        return []
    ends = [end for end in (float(finite.max()), float(finite.min())) if _dwells(finite == end)]
    if not ends or not carries_noise(finite):
        return []
    noise = noise_of(finite)
    return ends if noise.sigma > noise.step else []


def _dwells(there: np.ndarray) -> bool:
    """Whether samples are `there` repeatedly, for a few samples each time."""
    lengths = np.diff(runs(there))
    lengths = lengths[lengths >= CLIPPED_RUN]
    return lengths.size > 1 and lengths.sum() >= LEAST_CLIPPED and lengths.max() < there.size / 2


def _clipped(time: Array, name: str, values: Array) -> list[Flag]:
    flags = []
    for end in clipped_at(values):
        at = np.flatnonzero(values == end)
        text = (
            f"`{name}` is cut off at {end:.6g} in {at.size} samples, repeatedly: its range or that of its "
            "converter ends there; widen it. No window holds such samples"
        )
        flags.append(Flag("clipped", name, float(time[at[0]]), float(time[at[-1]]), text))
    return flags


def _lives(values: Array) -> bool:
    """Whether a sensor's reading changes even at rest, so that a constant reading is suspicious."""
    finite = finite_of(values)
    return finite.size > LONGEST_CONSTANT and (carries_noise(finite) or np.unique(finite).size > 0.9 * finite.size)


def _means(values: Array, parts: int = 6) -> Array:
    return np.array([np.mean(block) for block in np.array_split(values, parts)])


def _others_move(name: str, signals: _Signals, a: int, b: int) -> bool:
    others = [signals[other] for other in ("x", "p1", "p2", "force") if other != name and other in signals]
    return any((found := np.ptp(_means(other.values[a:b]))) > 0.0 and found > other.least_motion for other in others)


def _fine(noise: Noise) -> bool:
    """Whether noise exceeds half a step, by which quiet readings at the edge of a step scatter too."""
    return noise.sigma > 0.5 * noise.step


def _rounded(noise: Noise, count: int) -> float:
    """Largest chance that noise leaves `count` readings in one step of the converter: in the middle of the step."""
    if not _fine(noise):
        return 1.0 if noise.step else 0.0
    return math.erf(noise.step / (2.0 * math.sqrt(2.0) * noise.sigma)) ** count


class _Events:
    """Changes that a pressure may have to follow: of the other pressure, and of the direction of the piston.

    How often it does is learnt from the rest of the log: a pressure that a relief valve or the tank holds does not.
    """

    def __init__(self, name: str, signals: _Signals, step: float) -> None:
        values = signals[name].values
        count = values.size // PART
        found: list[np.ndarray] = [np.empty((0, 2), dtype=int)]
        for other in {"x", *PRESSURES} & signals.keys() - {name}:
            means = signals[other].values[: count * PART].reshape(count, PART).mean(axis=1)
            if other == "x":
                found.append(_turns(means, signals[other].least_motion))
            else:
                found.append(runs(np.abs(np.diff(means)) > CHANGED_STEPS * step) + (0, 1))
        # First and last + 1 sample of each, (k, 2).
        self.at = PART * np.concatenate(found)
        changes = np.concatenate([[0], np.cumsum(np.diff(values) != 0.0)])
        self.followed = changes[self.at[:, 1] - 1] != changes[self.at[:, 0]]

    def missed(self, a: int, b: int) -> float:
        """Chance that a reading is constant in samples a .. b - 1, by the changes of the others during these."""
        inside = (self.at[:, 0] >= a) & (self.at[:, 1] <= b)
        others = self.followed[~inside]
        share = (np.count_nonzero(~others) + 0.5) / (others.size + 1.0)
        return float(share ** np.count_nonzero(inside)) if share < SELDOM else 1.0


def _turns(x: Array, least: float) -> np.ndarray:
    """(k, 2) first and last + 1 of the places (n,) between which the piston turns round, by more than `least`."""
    found, sign, at = [], 0.0, 0
    for i, place in enumerate(x.tolist()):
        if math.isnan(x[at]) or (sign and (place - x[at]) * sign >= 0.0):
            at = i
        elif abs(place - x[at]) > least:
            found += [(at, i + 1)] if sign else []
            sign, at = math.copysign(1.0, place - x[at]), i
    return np.array(found, dtype=int).reshape(-1, 2)


def _coarse(time: Array, name: str, signal: _Signal) -> list[Flag]:
    """Flag of a pressure that rounding keeps constant for long."""
    noise = noise_of(signal.values[signal.constant[1]])
    same = np.count_nonzero(signal.values[1:] == signal.values[:-1])
    if not noise.step or _fine(noise) or same < MOSTLY * time.size or own_samples(signal.values) is not None:
        return []
    text = (
        f"`{name}` is read in steps of {noise.step / 1e5:.3g} bar, wider than its noise: where it is steady its "
        f"mean has a standard error of {noise.step / np.sqrt(12.0) / 1e5:.2g} bar. Record more digits, or use a "
        "narrower range"
    )
    return [Flag("coarse", name, float(time[0]), float(time[-1]), text)]


def _unmoving(time: Array, signals: _Signals) -> list[Flag]:
    x = signals.get("x")
    if x is None or x.empty:
        return []
    finite = finite_of(x.values)
    moved = float(np.ptp(_means(finite, min(50, finite.size))))
    for noise in (most_noise, noise_of):
        found = noise(finite)
        if moved > 5.0 * found.sigma + 3.0 * found.step and moved > 0.0:
            return []
    message = f"the piston moves by no more than its sensor's noise ({np.ptp(x.ends):.3g} m in all); command more spool"
    return [Flag("unmoving", "x", float(time[0]), float(time[-1]), message)]


# --- units ----------------------------------------------------------------------------------------------------------


def _wrong_units(time: Array, usual: float, signals: _Signals) -> list[Flag]:
    ends = (float(time[0]), float(time[-1]))
    flags = []
    travel = float(np.ptp(signals["x"].ends)) if "x" in signals and not signals["x"].empty else 0.0
    held = {name: signals[name].ends for name in PRESSURES if name in signals and not signals[name].empty}
    highest = {name: max(-low, high) for name, (low, high) in held.items()}
    for name, peak in highest.items():
        if 0.0 < peak < LEAST_PRESSURE:
            message = f"`{name}` reaches only {peak:.4g} Pa; is it in bar? State the unit in the file or the mapping"
            if travel > LONGEST_STROKE:
                message += f". x travels {travel:.4g} m: are the columns of `{name}` and x exchanged?"
            # One chamber alone may be open to the tank.
            flags.append(Flag("wrong-unit", name, *ends, message, fatal=max(highest.values()) < LEAST_PRESSURE))
        if peak > MOST_PRESSURE:
            message = f"`{name}` reaches {peak:.4g} Pa; check its unit and its scale"
            flags.append(Flag("wrong-unit", name, *ends, message, fatal=True))
    for name, (low, _) in held.items():
        if low < -ATMOSPHERE - 5.0 * signals[name].noise.total:
            count = np.count_nonzero(signals[name].values < -ATMOSPHERE)
            message = (
                f"`{name}` falls to {low / 1e5:.4g} bar, in {count} samples below vacuum, {-ATMOSPHERE / 1e5:.4g} bar "
                "gauge; check its zero, its sign, and whether it is gauge or absolute"
            )
            flags.append(Flag("wrong-unit", name, *ends, message))
    if travel > LONGEST_STROKE:
        message = f"the piston travels {travel:.4g} m; is it in mm? State the unit in the file or the mapping"
        flags.append(Flag("wrong-unit", "x", *ends, message, fatal=True))
    if usual >= SLOWEST_SAMPLING:
        message = f"samples are {usual:.4g} s apart; is time in ms? State the unit under [time] of a mapping"
        flags.append(Flag("wrong-unit", "time", *ends, message))
    return flags
