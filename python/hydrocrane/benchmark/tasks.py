"""Tasks for crane-tip control: the tip velocity that a stick commands against time, and the resulting path.

Distances are in m, times in s, x forward and z up as everywhere. A task is a stick without feedback, so all deviations
of the tip are due to the controller.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hydrocrane.arrays import Array

STEP = 0.01
RAMP = 0.2
PAUSE = 0.4
REST = 1.5
SPEEDS = (0.05, 0.1, 0.2)
LINE, SIDE, RADIUS = 0.5, 0.3, 0.2
CURVE_SPEED = 0.08
# Both ends lie at least 0.3 m inside the laboratory crane's workspace.
REACH = (-1.2, 0.9)
# Log handling: down to the log, slow motion while the grapple closes, up, out, down, and back to the start.
LOG_LEGS = ((0.0, -0.3), (0.06, 0.0), (0.0, 0.4), (0.4, 0.0), (0.0, -0.3), (-0.46, 0.2))
LOG_SPEED, GRIP_SPEED = 0.1, 0.03
GRIP_LEG, RELEASE_LEG = 1, 4
SENSES = {"up": (0.0, 1.0), "down": (0.0, -1.0), "out": (1.0, 0.0), "in": (-1.0, 0.0)}


# Length, speed, and direction (m, 2) as a function of the arc length (m,).
Curve = tuple[float, float, Callable[[Array], Array]]


@dataclass(frozen=True)
class Task:
    """A commanded motion of the tip.

    Attributes
    ----------
    name : str
    speed : float
        Largest commanded speed, m/s, that of a full stick.
    time : (k,) array
        s, from 0; the velocity is interpolated linearly.
    velocity : (k, 2) array
        Commanded velocity, x and z, m/s; zero at the end, for the time in which the tip comes to rest.
    carries : (float, float) or None
        Times at which the payload is picked up and released, s; ``None``: it is at the tip all the time.
    """

    name: str
    speed: float
    time: Array
    velocity: Array
    carries: tuple[float, float] | None = None

    @property
    def duration(self) -> float:
        """s, including the rest at the end."""
        return float(self.time[-1])

    @property
    def moving_time(self) -> float:
        """Time after which the stick stays at its centre, s."""
        return float(self.time[np.flatnonzero(self.velocity.any(axis=1))[-1] + 1])

    @property
    def deflections(self) -> dict[str, Array]:
        """Stick axes x and z (k,), -1 to 1."""
        return {axis: np.clip(self.velocity[:, i] / self.speed, -1.0, 1.0) for i, axis in enumerate("xz")}

    @property
    def displacement(self) -> Array:
        """Commanded displacement (k, 2) since the start: the integral of the velocity, m."""
        steps = 0.5 * (self.velocity[1:] + self.velocity[:-1]) * np.diff(self.time)[:, np.newaxis]
        return np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


def lines() -> list[Task]:
    """Vertical and horizontal lines in both directions at every speed of ``SPEEDS``."""
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
    return _task("circle", CURVE_SPEED, [(2.0 * np.pi * RADIUS, CURVE_SPEED, _on_circle)])


def reach() -> Task:
    """In to the near side of the workspace, then out to the far side and back to the start."""
    near, far = REACH
    return straight("reach", [np.array([x, 0.0]) for x in (near, far - near, -far)], SPEEDS[1])


def pick_and_place() -> Task:
    """To a log, up with it, out, down, release, and back; the tip moves slowly while it picks up the log."""
    speeds = [LOG_SPEED] * len(LOG_LEGS)
    speeds[GRIP_LEG] = GRIP_SPEED
    task = _task("log pick-and-place", LOG_SPEED, _legs([np.array(leg) for leg in LOG_LEGS], speeds))
    moves = _moves(task)
    grip = 0.5 * sum(moves[GRIP_LEG])
    release = 0.5 * (moves[RELEASE_LEG][1] + moves[RELEASE_LEG + 1][0])
    return replace(task, carries=(grip, release))


def straight(name: str, legs: list[Array], speed: float) -> Task:
    """Straight legs (2,) one after the other, each from rest to rest."""
    return _task(name, speed, _legs(legs, [speed] * len(legs)))


def _legs(legs: list[Array], speeds: list[float]) -> list[Curve]:
    lengths = [float(np.hypot(*leg)) for leg in legs]
    return [(n, speed, _along(leg / n)) for leg, n, speed in zip(legs, lengths, speeds, strict=True)]


def _moves(task: Task) -> list[tuple[float, float]]:
    """Begin and end of each leg, s; in pauses the velocity is zero."""
    resting = np.asarray(~task.velocity.any(axis=1))
    paused = resting[:-1] & resting[1:]
    ends, begins = task.time[:-1][paused], np.append(0.0, task.time[1:][paused])
    return list(zip(begins.tolist(), ends.tolist(), strict=False))


def _along(direction: Array) -> Callable[[Array], Array]:
    return lambda travel: np.broadcast_to(direction, (travel.size, 2))


def _on_circle(travel: Array) -> Array:
    angle = travel / RADIUS
    return np.column_stack([-np.sin(angle), np.cos(angle)])


def _task(name: str, speed: float, curves: list[Curve]) -> Task:
    """Curves one after the other with pauses between."""
    time, velocity = [np.zeros(1)], [np.zeros((1, 2))]
    for i, (length, own_speed, direction) in enumerate(curves):
        t, pace, travel = _trapezoid(length, own_speed)
        pause = REST if i == len(curves) - 1 else PAUSE
        time.append(time[-1][-1] + np.append(t[1:], t[-1] + pause))
        velocity.append(np.vstack([(pace[:, np.newaxis] * direction(travel))[1:], np.zeros((1, 2))]))
    return Task(name, speed, np.concatenate(time), np.concatenate(velocity))


def _trapezoid(length: float, speed: float) -> tuple[Array, Array, Array]:
    """Times, speeds and displacements of a motion over `length` with a trapezoidal speed."""
    speed = min(speed, length / RAMP)
    end = length / speed + RAMP
    t = np.linspace(0.0, end, int(np.ceil(end / STEP)) + 1)
    pace = speed * np.clip(np.minimum(t, end - t) / RAMP, 0.0, 1.0)
    travel = np.concatenate([[0.0], np.cumsum(0.5 * (pace[1:] + pace[:-1]) * np.diff(t))])
    # The corners of the trapezoid may lie between the samples, which loses a little of the displacement.
    share = length / travel[-1]
    return t, pace * share, travel * share
