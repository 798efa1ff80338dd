"""A log of the rig, predicted: simulated signals as its sensors would read them, with exact slopes.
                                                              theory: docs/theory/identification/dynamic.md

The rig starts at rest with its bristles straight. Its start pressures follow from the first reading of p1 and the
balance of forces, so that a bias of the transmitters does not set the piston in motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.logs import Log
from hydrocrane.machine import Machine
from hydrocrane.scenario import Command, Scenario, Solver
from hydrocrane.sensitivity import Experiment, solve

SIGNALS = ("x", "p1", "p2")
# Share of its own largest value to which the logged command is followed by straight lines.
COMMAND_TOLERANCE = 1e-4
# A start is read from the samples up to this time, s, in which a transmitter may still be settling.
START = 0.05
# Smooth and direction-dependent errors of a potentiometer are few, however many samples there are: a log counts for as
# many independent readings of its position.
INDEPENDENT_POSITIONS = 10
SOLVER = Solver(rtol=1e-6, max_step=1.0)


@dataclass(frozen=True)
class Reader:
    """What the rig's sensors do to a signal, as far as it is known.

    Attributes
    ----------
    lag : float
        Time constant of the pressure transmitters, s.
    pressure_noise, position_noise : float
        Standard deviation of one reading, Pa and m.
    position_error : float
        Standard deviation of the smooth and direction-dependent errors of the position, m.
    """

    lag: float
    pressure_noise: float
    position_noise: float
    position_error: float


class LogModel:
    """One log and the simulation that shall explain it."""

    def __init__(self, log: Log, rig: Machine, reader: Reader, *, payload: float | None, keys: Sequence[str]) -> None:
        log = _even(log.usable(*SIGNALS, "command"))
        self.time = log.time - log.time[0]
        self.measured = np.stack([log[name] for name in SIGNALS], axis=-1)
        self.interval = float(self.time[-1] / (len(self.time) - 1))
        self.reader = reader
        self.counted = self.time > START
        self.experiment = Experiment(
            _scenario(log, rig, self.time, self.measured, payload),
            list(keys),
            signals=_signals(rig),
            times=np.minimum(self.time, self.time[-1] * (1 - 1e-12)),
        )

    @property
    def deviation(self) -> Array:
        """(3,) standard deviation that one sample of x, p1, p2 is weighed by."""
        r = self.reader
        thinned = len(self.time) / INDEPENDENT_POSITIONS
        x = np.sqrt(r.position_noise**2 + r.position_error**2 * max(thinned, 1.0))
        return np.array([x, r.pressure_noise, r.pressure_noise])

    @property
    def weight(self) -> Array:
        """(m, 3) one over :attr:`deviation`; zero while the transmitters settle."""
        return self.counted[:, np.newaxis] / self.deviation

    def predict(self, values: Array) -> tuple[Array, Array]:
        """x, p1, p2 as a sensor without bias reads them (m, 3), SI, and their slopes by the keys (m, 3, k)."""
        found = solve(self.experiment, values)
        if len(found.times) < len(self.time):
            raise InputError(f"the rig could not be simulated with these parameters: {found.outcome.message}")
        y, slopes = found.y.copy(), found.slopes.copy()
        y[:, 1:] = self._lagged(y[:, 1:])
        slopes[:, 1:] = self._lagged(slopes[:, 1:])
        return y, slopes

    def _lagged(self, signal: Array) -> Array:
        """Behind a first-order lag, between samples along straight lines: what the transmitter's law gives."""
        if self.reader.lag <= 0.0:
            return signal
        ratio = self.interval / self.reader.lag
        fade = np.exp(-ratio)
        mean = (1.0 - fade) / ratio
        b, a = [1.0 - mean, mean - fade], [1.0, -fade]
        # With this memory the filter begins settled at the first value.
        memory = (1.0 - b[0]) * signal[:1]
        return np.asarray(lfilter(b, a, signal, axis=0, zi=memory)[0], dtype=np.float64)


def _even(log: Log) -> Log:
    """The log without a last interval that is shorter than the others."""
    step = np.diff(log.time)
    if len(step) > 2 and step[-1] < 0.999 * step[0]:
        log, step = log.between(log.time[0], log.time[-2]), step[:-1]
    if len(step) < 2 or np.ptp(step) > 1e-3 * step.mean():
        raise InputError(f"{log.source}: a dynamic fit needs evenly spaced samples; resample the log first")
    return log


def _signals(rig: Machine) -> tuple[str, str, str]:
    cylinder = rig.cylinder_names[0]
    return f"cylinder.{cylinder}.x", f"cylinder.{cylinder}.p1", f"cylinder.{cylinder}.p2"


def _scenario(log: Log, rig: Machine, time: Array, measured: Array, payload: float | None) -> Scenario:
    first = np.median(measured[(0.5 * START <= time) & (time <= START)], axis=0)
    a1, a2 = rig.piston_areas[0]
    held = float(rig.static_cylinder_force([0.0], payload=payload)[0])
    p1 = max(float(first[1]), (held + 1e5 * a2) / a1)
    cylinder, joint = rig.cylinder_names[0], rig.joint_names[0]
    low, high = rig.joint_limits[0]
    at, spool = straight_lines(time, log["command"], COMMAND_TOLERANCE * float(np.abs(log["command"]).max()))
    return Scenario(
        machine=rig,
        joints={joint: float(np.clip(rig.joints_from_strokes([first[0]])[0], low, high))},
        commands={cylinder: Command(at, spool, "linear")},
        pressures={cylinder: (p1, (p1 * a1 - held) / a2)},
        duration=float(time[-1]),
        record_interval=float(time[1] - time[0]),
        payload=payload,
        solver=SOLVER,
        name=log.source or "log",
    )


def straight_lines(time: Array, values: Array, tolerance: float) -> tuple[Array, Array]:
    """The fewest of the points (time, values) whose connecting lines stay within `tolerance` of all of them
    (Douglas and Peucker, 1973)."""
    keep = np.zeros(len(time), dtype=bool)
    keep[[0, -1]] = True
    stack = [(0, len(time) - 1)]
    while stack:
        a, b = stack.pop()
        if b - a < 2:
            continue
        line = np.interp(time[a : b + 1], [time[a], time[b]], [values[a], values[b]])
        off = np.abs(values[a : b + 1] - line)
        worst = a + int(off.argmax())
        if off[worst - a] > tolerance:
            keep[worst] = True
            stack += [(a, worst), (worst, b)]
    return time[keep], values[keep]
