"""The single motions of a log, from rest to rest, with the friction force that the thesis's (118) gives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.logs import Log
from hydrocrane.machine.machine import Machine
from hydrocrane.signals import RigParameters, friction_force

# The spool counts as open beyond this share of its largest opening.
OPEN = 1e-3
# Samples before the spool opens that belong to a motion.
RESTING_SAMPLES = 5


@dataclass(frozen=True)
class Motion:
    """A piston's motion from rest.

    Attributes
    ----------
    name : str
        Log and time.
    time, position, velocity, friction : (n,) arrays
        s, m from the place of rest, m/s, N. Friction counts from its value at the log's beginning, where the bristles
        are straight and what is read is the sensors' zero; later motions begin with bent bristles.
    """

    name: str
    time: Array
    position: Array
    velocity: Array
    friction: Array


def motions(log: Log, rig: Machine, payload: float | None) -> list[Motion]:
    """All motions of a log of x, p1, p2 and command; none where the spool never opens."""
    data = friction_force(log.usable("x", "p1", "p2", "command"), RigParameters.of(rig, payload=payload))
    time, velocity, friction = (np.asarray(data[name].values) for name in ("time", "velocity", "friction"))
    command = np.interp(time, log.time, log["command"])
    way = np.where(np.abs(command) > OPEN * np.abs(command).max(), np.sign(command), 0.0)
    edges = np.flatnonzero(np.diff(way)) + 1
    if not edges.size:
        return []
    datum = float(np.median(friction[: edges[0]]))
    x = np.interp(time, log.time, log["x"])
    found = []
    for begin, end in zip(edges, [*edges[1:], time.size], strict=True):
        if way[begin] == 0.0:
            continue
        first = max(int(begin) - RESTING_SAMPLES, 0)
        pick = slice(first, int(end))
        rest = float(np.median(x[first : int(begin)]))
        name = f"{log.source}, {time[begin]:.2f} to {time[end - 1]:.2f} s"
        found.append(Motion(name, time[pick], x[pick] - rest, velocity[pick], friction[pick] - datum))
    return found
