"""Checks of the windows of a log, taken together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.logs.log import Log
from hydrocrane.logs.signals import Flag
from hydrocrane.signals.friction import RigParameters
from hydrocrane.signals.windows import Window

# Velocities within this share are one level; and the least number of levels for a friction map.
SAME_LEVEL, LEAST_LEVELS = 0.15, 3
# Travel in bristle slips after which friction is that of steady motion within one percent.
SETTLED_SLIPS = 5.0
# Ratio of friction in both directions above which another cause than a seal is likelier.
LOPSIDED = 3.0
DIRECTIONS = ((1, "extending"), (-1, "retracting"))


def checked_windows(log: Log, rig: RigParameters, windows: Sequence[Window]) -> list[Flag]:
    """Flags on the whole set of windows and its rig."""
    start, end = float(log.time[0]), float(log.time[-1])
    texts = _coverage(windows) + _beyond_stroke(log, rig) + _unsettled(rig, windows)
    for direction, word in DIRECTIONS:
        moving = [w for w in windows if w.direction == direction]
        driven = [w for w in moving if w.force * direction < -3.0 * w.force_error]
        if driven and len(driven) * 2 <= len(moving):
            worst = max(abs(w.force) for w in driven)
            text = (
                f"in {len(driven)} of {len(moving)} windows {word} friction would drive the piston, by up to "
                f"{worst:.3g} N; the zeros of the pressure sensors have at least this error: log them at zero "
                "pressure and subtract them"
            )
            texts.append(("friction-drives", text))
        if len(driven) * 2 > len(moving):
            text = (
                f"in {len(driven)} of {len(moving)} windows {word} friction would drive the piston; "
                f"{_likely_cause(windows, rig)}"
            )
            texts.append(("friction-drives", text))
    if not any(kind == "friction-drives" for kind, _ in texts):
        texts += _lopsided(windows)
    return [Flag(kind, "", start, end, text) for kind, text in texts]


def _likely_cause(windows: Sequence[Window], rig: RigParameters) -> str:
    """Single mistakes that explain driving friction: those whose correction makes all windows plausible."""
    v, force = (np.array([getattr(w, name) for w in windows]) for name in ("velocity", "force"))
    cures = []
    if all(w.chambers is not None for w in windows):
        c1, c2 = np.array([w.chambers for w in windows], dtype=np.float64).T
        if _opposes(v, force - (c1 - c2) + c2 * rig.piston_area / rig.rod_area - c1 * rig.rod_area / rig.piston_area):
            cures.append("p1 and p2 exchanged")
    if _opposes(-v, force):
        cures.append("the sign of x")
    out, back = force[v > 0], force[v < 0]
    if out.size and back.size and out.min() > back.max():
        # Bounds of the missing force; their middle makes friction equal in both directions.
        lacking = -0.5 * float(np.median(out) + np.median(back))
        if rig.gravity:
            cures.append(
                f"the mass: {rig.mass + lacking / rig.gravity:.4g} kg would make friction equal in both ways; the "
                f"rig has {rig.mass:.4g} kg"
            )
        else:
            cures.append(
                f"a force of {lacking:.4g} N along the piston that the rig's file lacks, or zeros of p1 and p2"
            )
    if cures:
        return "each of these corrections would make all windows plausible: " + "; ".join(cures)
    return (
        "neither exchanged pressures, nor the sign of x, nor another mass would make all windows plausible: check "
        f"the areas ({rig.piston_area * 1e4:.4g} and {rig.rod_area * 1e4:.4g} cm^2), units, scales, and "
        "whether this is the rig"
    )


def _opposes(velocity: Array, force: Array) -> bool:
    """Whether friction opposes motion in nearly all windows."""
    return bool(np.mean(velocity * force > 0.0) >= 0.9)


def _lopsided(windows: Sequence[Window]) -> list[tuple[str, str]]:
    """Flag of friction that is much larger in one direction than in the other."""
    medians = [float(np.median([abs(w.force) for w in windows if w.direction == d] or [np.nan])) for d in (1, -1)]
    errors = [float(np.median([w.force_error for w in windows if w.direction == d] or [np.nan])) for d in (1, -1)]
    low, high = sorted(medians)
    if not np.isfinite(low) or high < LOPSIDED * low or high - low < 10.0 * max(errors):
        return []
    text = (
        f"friction extending is {medians[0]:.4g} N and retracting {medians[1]:.4g} N in the median; that of a seal "
        "is seldom so asymmetric: check mass and weight, zeros and units of p1 and p2, and both areas"
    )
    return [("lopsided-friction", text)]


def velocity_levels(windows: Sequence[Window], direction: int) -> list[float]:
    """Different velocities in one direction, m/s, the slowest first."""
    levels: list[float] = []
    for speed in sorted(abs(w.velocity) for w in windows if w.direction == direction):
        if not levels or speed > (1.0 + SAME_LEVEL) * levels[-1]:
            levels.append(speed)
    return [direction * level for level in levels]


def _coverage(windows: Sequence[Window]) -> list[tuple[str, str]]:
    if not windows:
        return [("no-window", "the log has no window of steady motion; hold commands until pressures are constant")]
    texts = []
    for direction, word in DIRECTIONS:
        levels = len(velocity_levels(windows, direction))
        if levels == 0:
            texts.append(
                ("one-direction", f"no window of {word} motion; the parameters of that direction remain unknown")
            )
        elif levels < LEAST_LEVELS:
            count = "one velocity level" if levels == 1 else f"{levels} velocity levels"
            texts.append(
                ("few-levels", f"{count} {word}; a friction map needs {LEAST_LEVELS} at least, about ten are usual")
            )
    return texts


def _unsettled(rig: RigParameters, windows: Sequence[Window]) -> list[tuple[str, str]]:
    """Flag of windows that begin before the bristles have settled by the rig's file; noise may hide the remaining
    drift."""
    early = [w for w in windows if w.before < SETTLED_SLIPS * rig.slip]
    if not early:
        return []
    least = min(w.before for w in early) / rig.slip
    text = (
        f"{len(early)} of {len(windows)} windows begin before the piston has moved {SETTLED_SLIPS:g} slips of the "
        f"bristles ({SETTLED_SLIPS * rig.slip * 1e3:.3g} mm by the rig's file; the earliest {least:.1f}): friction may "
        "not be steady yet, and intervals from such windows are too narrow; let each velocity last for ten slips, "
        f"{10.0 * rig.slip * 1e3:.3g} mm"
    )
    return [("unsettled", text)]


def _beyond_stroke(log: Log, rig: RigParameters) -> list[tuple[str, str]]:
    low, high = rig.stroke
    travel = float(np.nanmax(log["x"]) - np.nanmin(log["x"]))
    if not travel > 1.05 * (high - low):
        return []
    return [
        (
            "wrong-unit",
            f"the piston travels {travel:.4g} m, its stroke is {high - low:.4g} m; check unit and scale of x",
        )
    ]
