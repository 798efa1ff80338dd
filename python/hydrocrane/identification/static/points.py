"""Data for the identification of static friction: steady velocity, friction force, and the errors of both."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError

EXTENDING, RETRACTING = 0, 1
DIRECTIONS = ("extending", "retracting")
# Points whose velocities differ by less than this share belong to one commanded level.
LEVEL_SHARE = 0.1
# A new level begins only at a gap that the errors of the velocities do not explain.
LEVEL_ERRORS = 3.0
# Fields with one entry per point.
COLUMNS = (
    "velocity", "force", "velocity_error", "force_error", "direction", "chambers", "position", "time", "load",
)  # fmt: skip


class SteadyWindow(Protocol):
    """A stretch of a log at constant velocity; implementations may have further attributes."""

    @property
    def velocity(self) -> float: ...
    @property
    def velocity_error(self) -> float: ...
    @property
    def force(self) -> float: ...
    @property
    def force_error(self) -> float: ...


@dataclass(frozen=True)
class Levels:
    """Points gathered by commanded velocity, slowest first within each direction; arrays of shape (n_levels,).

    Attributes
    ----------
    velocity, force : ndarray
        Medians over the points of a level, m/s and N; force positive against positive velocity.
    scatter : ndarray
        Standard deviation of the force over the points of a level, N; NaN for a single point.
    error : ndarray
        Standard error of one point's force, N: the median of the stated ones.
    count, direction : ndarray of int
        Number of points; 0 extending, 1 retracting.
    """

    velocity: Array
    force: Array
    scatter: Array
    error: Array
    count: NDArray[np.int_]
    direction: NDArray[np.int_]


@dataclass(frozen=True)
class FrictionPoints:
    """Steady friction readings; arrays of shape (n,).

    Attributes
    ----------
    velocity : ndarray
        Piston velocity, m/s, positive extending. Zero marks a break-away reading, the largest force without motion of
        the piston.
    force : ndarray
        Friction, N, positive against positive velocity   (120).
    velocity_error, force_error : ndarray
        Standard errors, m/s and N.
    direction : ndarray of int
        0 extending, 1 retracting.
    source : tuple of str
        Names of the files that the points come from.
    chambers : ndarray, shape (n, 2), optional
        p1 A1 and p2 A2 as read, N; errors of the transmitters' span are proportional to them.
    position : ndarray, shape (n,), optional
        x as read, m, from the middle of the position sensor's range; the error of its slope is proportional to it.
    of_log : ndarray of int, shape (n,), optional
        Number of the log of each point, from 0; None if all come from one log.
    time : ndarray, shape (n,), optional
        Middle of the window in its log, s; friction changes with it while the oil warms up.
    load : ndarray, shape (n,), optional
        Mass on the rod, kg.
    """

    velocity: Array
    force: Array
    velocity_error: Array
    force_error: Array
    direction: NDArray[np.int_]
    source: tuple[str, ...] = ()
    chambers: Array | None = None
    position: Array | None = None
    of_log: NDArray[np.int_] | None = None
    time: Array | None = None
    load: Array | None = None

    @classmethod
    def of(
        cls,
        velocity: ArrayLike,
        force: ArrayLike,
        *,
        velocity_error: ArrayLike = 0.0,
        force_error: ArrayLike = 0.0,
        direction: ArrayLike | None = None,
        source: Iterable[str] = (),
        chambers: ArrayLike | None = None,
        position: ArrayLike | None = None,
    ) -> FrictionPoints:
        """Checked points from plain arrays; errors may be one number for all.

        Only break-away readings, whose velocity is zero, need `direction` (+1 extending, -1 retracting).
        """
        v = np.atleast_1d(real_array(velocity, "velocity"))
        f = np.atleast_1d(real_array(force, "force"))
        if v.ndim != 1 or v.shape != f.shape:
            raise InputError(f"velocity and force must be vectors of equal length, got shapes {v.shape} and {f.shape}")
        if v.size == 0:
            raise InputError("no friction points: no steady window was accepted or given")
        of_v, of_f = _error(velocity_error, "velocity_error", v), _error(force_error, "force_error", f)
        sign = np.sign(v) if direction is None else _signs(direction, v)
        if (sign == 0).any():
            at = int(np.flatnonzero(sign == 0)[0])
            raise InputError(
                f"point {at} has velocity 0 and no direction; a break-away reading needs direction +1 or -1"
            )
        pushed = _given(chambers, "chambers", "p1 A1 and p2 A2", (v.size, 2))
        place = _given(position, "position", "x", v.shape)
        return cls(v, f, of_v, of_f, np.where(sign > 0, EXTENDING, RETRACTING), tuple(source), pushed, place)

    @classmethod
    def from_windows(cls, windows: Iterable[SteadyWindow], *, source: Iterable[str] = ()) -> FrictionPoints:
        """Points from accepted steady windows: objects with velocity, force and their errors as attributes.

        Windows of several logs may be mixed. `chambers` (p1 A1, p2 A2), `position` and the time between `start` and
        `end` are used if every window has them.
        """
        given = list(windows)
        table = [(w.velocity, w.force, w.velocity_error, w.force_error) for w in given]
        columns = np.array(table, dtype=float).reshape(-1, 4).T
        pushed = [getattr(w, "chambers", None) for w in given]
        place = np.array([getattr(w, "position", np.nan) for w in given])
        time = np.array([0.5 * (getattr(w, "start", np.nan) + getattr(w, "end", np.nan)) for w in given])
        points = cls.of(
            columns[0],
            columns[1],
            velocity_error=columns[2],
            force_error=columns[3],
            source=source,
            chambers=[p for p in pushed if p is not None] if pushed and None not in pushed else None,
            position=place if np.isfinite(place).all() else None,
        )
        return replace(points, time=time) if np.isfinite(time).all() else points

    @classmethod
    def joined(cls, logs: Sequence[FrictionPoints]) -> FrictionPoints:
        """Points of several logs, one log after the other.

        `chambers`, `position`, `time` and `load` are kept if every log has them.
        """
        if not logs:
            raise InputError("no friction points: no log was given")

        def column(name: str) -> Array | None:
            parts = [getattr(points, name) for points in logs]
            return None if any(part is None for part in parts) else np.concatenate(parts)

        counts = np.cumsum([0, *(points.logs for points in logs)])
        of_log = np.concatenate([points.log + first for points, first in zip(logs, counts, strict=False)])
        source = tuple(name for points in logs for name in points.source)
        columns: dict[str, Any] = {name: column(name) for name in COLUMNS}
        return cls(**columns, source=source, of_log=of_log)

    def __len__(self) -> int:
        return self.velocity.size

    def select(self, keep: NDArray[np.bool_]) -> FrictionPoints:
        """The points for which `keep` is true."""
        columns = {name: getattr(self, name) for name in COLUMNS}
        kept: dict[str, Any] = {name: None if values is None else values[keep] for name, values in columns.items()}
        return replace(self, **kept, of_log=self.log[keep])

    @cached_property
    def log(self) -> NDArray[np.int_]:
        """Number of the log of each point, (n,)."""
        return np.zeros(len(self), dtype=int) if self.of_log is None else self.of_log

    @property
    def logs(self) -> int:
        """Number of logs that the points come from."""
        return int(self.log.max()) + 1 if len(self) else 0

    @cached_property
    def sign(self) -> Array:
        """+1 extending, -1 retracting."""
        return np.where(self.direction == EXTENDING, 1.0, -1.0)

    @cached_property
    def speed(self) -> Array:
        """Magnitude of the velocity, m/s."""
        return np.abs(self.velocity)

    @cached_property
    def level(self) -> NDArray[np.int_]:
        """Number of the level of each point, counted over both directions, slowest first.

        Points are sorted by speed. A level ends where the next point is faster by more than a tenth and by more than
        the errors of both velocities.
        """
        level = np.empty(len(self), dtype=int)
        count = 0
        for side in (EXTENDING, RETRACTING):
            at = np.flatnonzero(self.direction == side)
            at = at[np.argsort(self.speed[at], kind="stable")]
            if at.size:
                level[at] = count + np.concatenate([[0], np.cumsum(self._gaps(at))])
                count = int(level[at[-1]]) + 1
        return level

    def _gaps(self, order: NDArray[np.int_]) -> NDArray[np.bool_]:
        """Whether a level ends between neighbours in `order`."""
        speed, error = self.speed[order], self.velocity_error[order]
        explained = LEVEL_ERRORS * np.hypot(error[1:], error[:-1])
        return np.diff(speed) > np.maximum(LEVEL_SHARE * speed[:-1], explained)

    @cached_property
    def levels(self) -> Levels:
        """The points grouped by level."""
        groups = [np.flatnonzero(self.level == k) for k in range(int(self.level.max()) + 1)]
        force = [self.force[g] for g in groups]
        return Levels(
            velocity=np.array([np.median(self.velocity[g]) for g in groups]),
            force=np.array([np.median(f) for f in force]),
            scatter=np.array([f.std(ddof=1) if f.size > 1 else np.nan for f in force]),
            error=np.array([np.median(self.force_error[g]) for g in groups]),
            count=np.array([g.size for g in groups]),
            direction=np.array([self.direction[g[0]] for g in groups]),
        )


@dataclass(frozen=True)
class RejectedPoint:
    """A point that was left out, and why."""

    index: int
    reason: str


def _error(value: ArrayLike, name: str, like: Array) -> Array:
    error = real_array(value, name)
    if error.shape not in ((), like.shape):
        raise InputError(f"{name} must be one number or one per point ({like.size}), got shape {error.shape}")
    if (error < 0).any():
        raise InputError(f"{name} must not be negative")
    return np.broadcast_to(error, like.shape).astype(float)


def _given(value: ArrayLike | None, name: str, what: str, shape: tuple[int, ...]) -> Array | None:
    found = None if value is None else real_array(value, name)
    if found is not None and found.shape != shape:
        raise InputError(f"{name} must hold {what} of each point, shape {shape}, got {found.shape}")
    return found


def _signs(direction: ArrayLike, velocity: Array) -> Array:
    sign = np.broadcast_to(real_array(direction, "direction"), velocity.shape).astype(float)
    if not np.isin(sign, (-1.0, 1.0)).all():
        raise InputError("direction must be +1 (extending) or -1 (retracting) for each point")
    if (sign * velocity < 0).any():
        at = int(np.flatnonzero(sign * velocity < 0)[0])
        raise InputError(f"direction of point {at} contradicts its velocity {velocity[at]:g} m/s")
    return sign
