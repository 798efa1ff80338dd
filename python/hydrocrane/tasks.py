"""Tasks for crane-tip control: the velocity that a stick asks of the tip against time, and the path it should give.

Distances are in m, times in s, x forward and z up as everywhere. A task is the stick alone: it neither sees the crane
nor corrects it, so that what the tip misses is the controller's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import Array

STEP = 0.01
RAMP = 0.2
PAUSE = 0.4
REST = 1.5
SPEEDS = (0.05, 0.1, 0.2)
LINE, SIDE, RADIUS = 0.5, 0.3, 0.2
CURVE_SPEED = 0.08
# Both ends lie 0.3 m and more inside the laboratory crane's workspace.
REACH = (-1.2, 0.9)
SENSES = {"up": (0.0, 1.0), "down": (0.0, -1.0), "out": (1.0, 0.0), "in": (-1.0, 0.0)}


@dataclass(frozen=True)
class Task:
    """A motion that is asked of the tip.

    Attributes
    ----------
    name : str
    speed : float
        Largest speed asked for, m/s; a full stick means this speed.
    time : (k,) array
        s, from 0; the velocity is straight in between.
    velocity : (k, 2) array
        Velocity asked for, x and z, m/s; zero at the end, where the tip has time to come to rest.
    """

    name: str
    speed: float
    time: Array
    velocity: Array

    @property
    def duration(self) -> float:
        """s, with the rest at the end."""
        return float(self.time[-1])

    @property
    def moving_time(self) -> float:
        """When the stick comes to its centre for good, s."""
        return float(self.time[np.flatnonzero(self.velocity.any(axis=1))[-1] + 1])

    @property
    def deflections(self) -> dict[str, Array]:
        """Stick axes x and z (k,), -1 to 1."""
        return {axis: np.clip(self.velocity[:, i] / self.speed, -1.0, 1.0) for i, axis in enumerate("xz")}

    @property
    def displacement(self) -> Array:
        """Way (k, 2) asked for since the start: the integral of the velocity, m."""
        steps = 0.5 * (self.velocity[1:] + self.velocity[:-1]) * np.diff(self.time)[:, np.newaxis]
        return np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


def lines() -> list[Task]:
    """Vertical and horizontal lines in both senses at every speed of ``SPEEDS``."""
    return [
        straight(f"{name} {speed:g} m/s", [np.array(sense) * LINE], speed)
        for name, sense in SENSES.items()
        for speed in SPEEDS
    ]


def square() -> Task:
    """Out, up, in, down, with a pause in each corner."""
    return straight("square", [SIDE * np.array(sense) for sense in ((1, 0), (0, 1), (-1, 0), (0, -1))], CURVE_SPEED)


def circle() -> Task:
    """One turn, first upwards, about a centre behind the start."""
    return _task("circle", CURVE_SPEED, [(2.0 * np.pi * RADIUS, _on_circle)])


def reach() -> Task:
    """In as far as the near side of the workspace, then out to the far side and back to the start."""
    near, far = REACH
    return straight("reach", [np.array([x, 0.0]) for x in (near, far - near, -far)], SPEEDS[1])


def straight(name: str, legs: list[Array], speed: float) -> Task:
    """Straight legs (2,) one after the other, each from rest to rest."""
    lengths = [float(np.hypot(*leg)) for leg in legs]
    return _task(name, speed, [(n, _along(leg / n)) for leg, n in zip(legs, lengths, strict=True)])


def _along(direction: Array) -> Callable[[Array], Array]:
    return lambda way: np.broadcast_to(direction, (way.size, 2))


def _on_circle(way: Array) -> Array:
    angle = way / RADIUS
    return np.column_stack([-np.sin(angle), np.cos(angle)])


def _task(name: str, speed: float, curves: list[tuple[float, Callable[[Array], Array]]]) -> Task:
    """Curves, each by its length and its direction (m, 2) at a way along it (m,), with pauses between."""
    time, velocity = [np.zeros(1)], [np.zeros((1, 2))]
    for i, (length, direction) in enumerate(curves):
        t, pace, way = _trapezoid(length, speed)
        pause = REST if i == len(curves) - 1 else PAUSE
        time.append(time[-1][-1] + np.append(t[1:], t[-1] + pause))
        velocity.append(np.vstack([(pace[:, np.newaxis] * direction(way))[1:], np.zeros((1, 2))]))
    return Task(name, speed, np.concatenate(time), np.concatenate(velocity))


def _trapezoid(length: float, speed: float) -> tuple[Array, Array, Array]:
    """Times, speeds and ways of a motion over `length` that ramps up, keeps its speed and ramps down."""
    speed = min(speed, length / RAMP)
    end = length / speed + RAMP
    t = np.linspace(0.0, end, int(np.ceil(end / STEP)) + 1)
    pace = speed * np.clip(np.minimum(t, end - t) / RAMP, 0.0, 1.0)
    way = np.concatenate([[0.0], np.cumsum(0.5 * (pace[1:] + pace[:-1]) * np.diff(t))])
    # The corners of the trapezoid may fall between the samples, which costs a little of the way.
    share = length / way[-1]
    return t, pace * share, way * share
