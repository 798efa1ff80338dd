"""Checks of the windows of a log, taken together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrocrane.logs.flags import Flag
from hydrocrane.logs.log import Log
from hydrocrane.signals.friction import RigParameters
from hydrocrane.signals.windows import Window

# Velocities within this share of each other are one level; so many levels a friction map needs at least.
SAME_LEVEL, LEAST_LEVELS = 0.15, 3
# Slips of the bristles after which friction is that of steady motion: less than a hundredth is still to come.
SETTLED_SLIPS = 5.0
DIRECTIONS = ((1, "extending"), (-1, "retracting"))


def checked_windows(log: Log, rig: RigParameters, windows: Sequence[Window]) -> list[Flag]:
    """Flags about the whole set of windows and its rig."""
    start, end = float(log.time[0]), float(log.time[-1])
    texts = _coverage(windows) + _beyond_stroke(log, rig) + _unsettled(rig, windows)
    for direction, word in DIRECTIONS:
        moving = [w for w in windows if w.direction == direction]
        driven = [w for w in moving if w.force * direction < -3.0 * w.force_error]
        if driven and len(driven) * 2 <= len(moving):
            worst = max(abs(w.force) for w in driven)
            text = (
                f"in {len(driven)} of {len(moving)} windows {word} friction would push the piston on, by up to "
                f"{worst:.3g} N; the zeros of the pressure sensors are off by so much at least: log them at zero "
                "pressure and subtract them"
            )
            texts.append(("friction-drives", text))
        if len(driven) * 2 > len(moving):
            text = (
                f"in {len(driven)} of {len(moving)} windows {word} friction would push the piston on; are p1 and p2 "
                f"exchanged, is the sign of x right, is the mass ({rig.mass:.4g} kg) that of the rig?"
            )
            texts.append(("friction-drives", text))
    return [Flag(kind, "", start, end, text) for kind, text in texts]


def velocity_levels(windows: Sequence[Window], direction: int) -> list[float]:
    """Different velocities in one direction, m/s, the slowest first."""
    levels: list[float] = []
    for speed in sorted(abs(w.velocity) for w in windows if w.direction == direction):
        if not levels or speed > (1.0 + SAME_LEVEL) * levels[-1]:
            levels.append(speed)
    return [direction * level for level in levels]


def _coverage(windows: Sequence[Window]) -> list[tuple[str, str]]:
    if not windows:
        return [("no-window", "the log has no window of steady motion; hold each command until the pressures stand")]
    texts = []
    for direction, word in DIRECTIONS:
        levels = len(velocity_levels(windows, direction))
        if levels == 0:
            texts.append(
                ("one-direction", f"no window of {word} motion; the parameters of that direction stay unknown")
            )
        elif levels < LEAST_LEVELS:
            count = "one velocity level" if levels == 1 else f"{levels} velocity levels"
            texts.append(
                ("few-levels", f"{count} {word}; a friction map needs {LEAST_LEVELS} at least, about ten are usual")
            )
    return texts


def _unsettled(rig: RigParameters, windows: Sequence[Window]) -> list[tuple[str, str]]:
    """Windows that begin before the bristles of the rig's file have settled: the drift left may hide in the noise."""
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
