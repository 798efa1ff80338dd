"""Construction of a motion of the rig's piston: from velocities against time to a spool command."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.machine.machine import Machine
from hydrocrane.rig.log import Segment

# Duration of a commanded step, s: one or two samples of a real-time computer, well below the time constant of the
# spool.
EDGE = 5e-3
# Share of the stroke that is not used at either end, so that the piston does not reach the end stops.
CLEARANCE = 0.08


@dataclass(frozen=True)
class Seal:
    """Scales of the seal's friction that an experimenter must know in advance.

    Attributes
    ----------
    slip : float
        Travel over which the bristles bend before they slip, break-away force over stiffness, m.
    velocity : float
        Velocity at which the Stribeck rise has decreased to 1/e (121), m/s; the smaller one of both directions.
    room : float
        Available travel between the end stops of the cylinder, m.
    """

    slip: float
    velocity: float
    room: float


def seal_of(machine: Machine) -> Seal:
    """Scales of the seal of the rig's only cylinder."""
    speeds = np.geomspace(1e-5, 1.0, 600)
    maps = [np.abs(machine.friction_map(sign * speeds)) for sign in (1, -1)]
    falls = [np.argmax(f <= f.min() + (f[0] - f.min()) / np.e) for f in maps]
    name = f"cylinder.{machine.cylinder_names[0]}.z"
    slip = 1e-3
    if name in machine.state_names:
        bent = machine.pack_state([0.0])
        bent[machine.state_names.index(name)] = 1e-6
        stiffness = machine.outputs(bent, [0.0])[f"cylinder.{machine.cylinder_names[0]}.friction"] / 1e-6
        slip = float(max(f[0] for f in maps) / stiffness)
    room = float(np.ptp(machine.stroke_limits[0])) * (1 - 2 * CLEARANCE)
    return Seal(slip, float(min(speeds[i] for i in falls)), room)


class Course:
    """Velocity against time, piece by piece, from rest to rest."""

    def __init__(self) -> None:
        self.time: list[float] = [0.0]
        self.velocity: list[float] = [0.0]
        self.pieces: list[tuple[str, float, float, float]] = []

    def rest(self, duration: float) -> None:
        """Spool centred for `duration`, s."""
        self.hold("", 0.0, duration)

    def hold(self, name: str, velocity: float, duration: float) -> None:
        """`velocity` (m/s) for `duration` (s)."""
        self.follow(name, lambda t: np.full_like(t, velocity), duration, points=2)

    def follow(self, name: str, velocity: Callable[[Array], Array], duration: float, *, points: int) -> None:
        """`velocity(t)` for t from 0 to `duration`, in `points` linear pieces; with a `name` it is a segment."""
        start = self.time[-1]
        if duration <= EDGE:
            raise InputError(f"a motion of {duration:g} s is shorter than a step of the spool; use a slower one")
        t = np.linspace(EDGE, duration, points)
        v = velocity(t)
        self.time += (start + t).tolist()
        self.velocity += np.asarray(v, dtype=np.float64).tolist()
        if name:
            self.pieces.append((name, start, start + duration, float(np.mean(v))))

    @property
    def fastest(self) -> float:
        return float(np.abs(self.velocity).max())

    @property
    def travel(self) -> Array:
        """(k,) displacement of the piston from its start at the course's times, m."""
        time, velocity = np.array(self.time), np.array(self.velocity)
        steps = 0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time)
        return np.concatenate([[0.0], np.cumsum(steps)])

    def start(self, machine: Machine) -> float:
        """Start position of the piston (m) for a course in the middle of the stroke."""
        travel = self.travel
        low, high = machine.stroke_limits[0] * (1 - 2 * CLEARANCE)
        if np.ptp(travel) > high - low:
            raise InputError(
                f"the experiment needs {np.ptp(travel) * 1e3:.0f} mm of stroke, {machine.name} has"
                f" {(high - low) * 1e3:.0f} mm between its end stops; take fewer, slower or shorter levels"
            )
        return float(0.5 * (low + high) - 0.5 * (travel.max() + travel.min()))

    def segments(self, shift: float) -> tuple[Segment, ...]:
        """The named pieces, `shift` seconds later."""
        return tuple(Segment(name, begin + shift, end + shift, v) for name, begin, end, v in self.pieces)
