"""Prediction of a rig's log: simulated signals as its sensors would read them, with exact derivatives.
                                                              theory: docs/theory/identification/dynamic.md

The rig starts at rest. Its start pressures follow from the first readings of p1 and the equilibrium of forces, so that
a zero error of the transmitters does not move the piston. The errors of the start pressure p1 and of the start
position, which determines the oil volumes, and the friction at rest, which bends the bristles, are nuisances. Their
effects are found once, by simulations with other start values. The delay of the readings against the command is a
nuisance too; its effect is minus the rate of the signals.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Unpack

import numpy as np
from numpy.typing import NDArray

from hydrocrane.analysis.sensitivity import Experiment, solve
from hydrocrane.arrays import Array, rms
from hydrocrane.errors import InputError
from hydrocrane.identification.bristles.readings import DYNAMIC, key_of, number, with_values
from hydrocrane.identification.sensors import NUISANCES, OF_A_LOG, RigSensors, gains, read, whitened
from hydrocrane.logs import Log
from hydrocrane.machine.machine import Machine
from hydrocrane.scenario.changes import RunChanges
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.scenario.series import Command
from hydrocrane.scenario.solver import Solver

# Length of a block as a share of the time since the last corner, and its largest as a share of the log.
GROWTH = 0.1
LONGEST = 1.0 / 400.0


@dataclass(frozen=True)
class Blocks:
    """A log in blocks: single samples after a change of the command, means of many samples later.

    The response to a step of the spool decays, so blocks may grow with the time since the last corner of the command. A
    mean has the information of its samples as long as a parabola describes the signal within the block.

    Attributes
    ----------
    first, count : (b,) arrays
        Index of a block's first sample, and its number of samples.
    nodes : (k,) array
        Times, s, at which a simulated signal must be known for its means: one to three per block.
    places : (b, 3) array
        Indices of the nodes at a block's first sample, middle and last sample.
    """

    first: NDArray[np.intp]
    count: NDArray[np.intp]
    nodes: Array
    places: NDArray[np.intp]

    @classmethod
    def of(cls, time: Array, corners: Array) -> Blocks:
        """Blocks of samples at `time` (n,), s. No block contains one of the `corners`, s, in its interior."""
        first = _starts(time, corners)
        count = np.diff(np.append(first, time.size))
        begin, end = time[first], time[first + count - 1]
        nodes, places = np.unique(np.stack([begin, 0.5 * (begin + end), end], axis=-1), return_inverse=True)
        return cls(first, count, nodes, np.asarray(places).reshape(-1, 3))

    def mean(self, samples: Array) -> Array:
        """(b, ...) means of samples (n, ...)."""
        shape = (-1, *[1] * (samples.ndim - 1))
        return np.asarray(np.add.reduceat(samples, self.first, axis=0) / self.count.reshape(shape))

    def mean_of_nodes(self, values: Array) -> Array:
        """(b, ...) means over a block's samples of a signal known at the nodes (k, ...), exact for parabolas."""
        ends = np.where(self.count > 1, (self.count + 1) / (6.0 * np.maximum(self.count - 1, 1)), 0.0)
        weights = np.stack([ends, 1.0 - 2.0 * ends, ends], axis=-1)
        return np.asarray(np.einsum("bj,bj...->b...", weights, values[self.places]))


def _starts(time: Array, corners: Array) -> NDArray[np.intp]:
    """Index of the first sample of each block."""
    interval = (time[-1] - time[0]) / (time.size - 1)
    most = max(int(LONGEST * time.size), 1)
    edges = np.unique(np.concatenate([[0], np.searchsorted(time, corners), [time.size]]))
    starts = []
    for begin, end in zip(edges[:-1], edges[1:], strict=True):
        at = int(begin)
        while at < end:
            starts.append(at)
            since = time[at] - time[begin]
            at += int(np.clip(GROWTH * since / interval, 1, most))
    return np.array(starts, dtype=np.intp)


SIGNALS = ("x", "p1", "p2")
# Tolerance of the piecewise linear approximation of the logged command, as a share of its largest value.
COMMAND_TOLERANCE = 1e-5
# Seconds in which a transmitter may still be settling, and the end of the readings for the start pressures.
SETTLING, START = 0.05, 0.5
LEAST_SAMPLES = 10
# Lowest start pressure, Pa, above the onset of air release; and changes of p1, Pa, and x, m, that determine their
# effect.
LEAST_PRESSURE = 1e5
OTHER_PRESSURE, OTHER_PLACE = 1e4, 1e-3
# Friction at rest, N, that determines its effect.
OTHER_FRICTION = 10.0
# Delay, s, that determines its effect: a small part of a pressure transmitter's lag.
OTHER_DELAY = 1e-4
# The step size control uses the states alone, which makes sensitivities twenty times as fast. The tolerance is far
# below the noise: where many unknowns have nearly the same effect, sensitivities with an error of a percent would count
# as information.
SOLVER = Solver(rtol=1e-8, max_step=10.0)


class RigLogModel:
    """One log and its simulation.

    Parameters
    ----------
    log : Log
        From rest, with ``x``, ``p1``, ``p2`` and ``command``, evenly sampled.
    rig : Machine
    sensors : RigSensors
    payload : float or None
        kg.
    keys : sequence of str
        Keys of the machine that are fitted.
    moved : (float, float, float, float)
        Differences of the start values p1 (Pa) and x (m) from the readings, friction at rest (N), and delay (s) of the
        command against the log.
    near : (k,) array, optional
        Values of the keys for which the effects of the start values are found; default is the rig's file.

    Attributes
    ----------
    time : (b,) array
        Mean times of the blocks, s from the start of the log.
    measured : (b, 3) array
        Mean x, p1, p2, SI; NaN where a sensor has no reading.
    """

    def __init__(
        self,
        log: Log,
        rig: Machine,
        sensors: RigSensors,
        *,
        payload: float | None,
        keys: Sequence[str],
        moved: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0),
        near: Array | None = None,
    ) -> None:
        self.log, self.rig, self.payload, self.moved = log, rig, payload, moved
        log = _even(log.usable(*SIGNALS, "command"))
        time = log.time - log.time[0]
        samples = np.stack([log[name] for name in SIGNALS], axis=-1)
        samples[log.spoilt(*SIGNALS)] = np.nan
        self.source, self.sensors = log.source, sensors
        corner, spool = corners(time, _command(log), COMMAND_TOLERANCE * float(np.abs(log["command"]).max()))
        command = corner + moved[3], spool
        self.blocks = Blocks.of(time, command[0])
        self.time, self.measured = self.blocks.mean(time), self.blocks.mean(samples)
        self.counted = np.isfinite(self.measured).all(axis=1) & (self.time > SETTLING)
        if not self.counted.any():
            raise InputError(f"{log.source}: no stretch in which every sensor reads")
        self._near = rig if near is None else with_values(rig, keys, near)
        plan = _scenario(log, rig, command, _start(log, samples) + np.array(moved[:2]), payload)
        self.experiment = Experiment(
            plan,
            list(keys),
            signals=[f"cylinder.{rig.cylinder_names[0]}.{name}" for name in SIGNALS],
            times=np.minimum(self.blocks.nodes, time[-1] * (1 - 1e-12)),
            start=self._bent(plan, moved[2], moved[2]),
            resolve_sensitivities=False,
        )

    def restarted(self, by: Array, near: Array) -> RigLogModel:
        """This log with the start values p1 (Pa) and x (m), the friction at rest (N) and the delay (s) changed `by`
        (4,)."""
        p1, x, friction, delay = (np.array(self.moved) + by).tolist()
        moved = p1, x, friction, delay
        keys = self.experiment.keys
        return RigLogModel(self.log, self.rig, self.sensors, payload=self.payload, keys=keys, moved=moved, near=near)

    def _bent(self, plan: Scenario, friction: float, bent: float) -> Array:
        """The start of a scenario: p2 in balance with a `friction` at rest, N, and bristles as `bent` N bend them."""
        cylinder, names = self.rig.cylinder_names[0], self.rig.state_names
        state = plan.initial_state(self.rig)
        state[names.index(f"cylinder.{cylinder}.z")] = bent / number(self._near, self._stiffness)
        state[names.index(f"cylinder.{cylinder}.p2")] -= friction / self.rig.piston_areas[0][1]
        return state

    @property
    def _stiffness(self) -> str:
        return key_of(self.rig, "friction", DYNAMIC[0])

    @cached_property
    def by_start(self) -> Array:
        """(b, 3, 3) derivatives of x, p1, p2 by the start pressure p1 in equilibrium, by the start position with the
        same reading, and by the friction at rest."""
        plan, rig = self.experiment.plan, self.experiment.machine
        cylinder, (a1, a2) = rig.cylinder_names[0], rig.piston_areas[0]
        assert not isinstance(plan.pressures, str), "this scenario was made with pressures"
        p1, p2 = plan.pressures[cylinder]
        balanced = {cylinder: (p1 + OTHER_PRESSURE, p2 + OTHER_PRESSURE * a1 / a2)}
        by_pressure = (self._started(pressures=balanced) - self._nominal) / OTHER_PRESSURE
        ((joint, place),) = plan.joints.items()
        other = rig.joints_from_strokes(rig.strokes([place]) + OTHER_PLACE)
        by_place = (self._started(joints={joint: float(other[0])}) - self._nominal) / OTHER_PLACE
        by_place[:, 0] -= 1.0
        by_friction = (self._started(friction=OTHER_FRICTION, bent=OTHER_FRICTION) - self._nominal) / OTHER_FRICTION
        return np.stack([by_pressure, by_place, by_friction], axis=-1)

    @cached_property
    def _by_bending(self) -> Array:
        """(b, 3) derivatives by a relative change of the bristles' first deflection alone."""
        if self.moved[2] == 0.0:
            return np.zeros_like(self._nominal)
        return (self._started(bent=OTHER_FRICTION) - self._nominal) * self.moved[2] / OTHER_FRICTION

    @cached_property
    def by_delay(self) -> Array:
        """(b, 3) derivatives of x, p1, p2 by a common delay, s: minus their rates."""
        return (self._started(later=OTHER_DELAY) - self._nominal) / OTHER_DELAY

    def _started(
        self, later: float = 0.0, friction: float = 0.0, bent: float = 0.0, **start: Unpack[RunChanges]
    ) -> Array:
        """(b, 3) prediction from other start values, with more friction at rest or bristles more `bent`, N, or with
        readings `later`, s."""
        made, plan = self.experiment, self.experiment.plan.changed(**start, machine=self._near)
        state = self._bent(plan, self.moved[2] + friction, self.moved[2] + bent)
        # In the first sample the rig is at rest.
        times = np.clip(self.blocks.nodes - later, 0.0, plan.duration * (1 - 1e-12))
        one = Experiment(
            plan, made.keys[:1], signals=made.signals, times=times, start=state, resolve_sensitivities=False
        )
        return self._means(one, one.values)[0]

    @cached_property
    def turned(self) -> Array:
        """(b,) state of the position sensor's hysteresis along the motion assumed before the fit."""
        return self.sensors.turned(self._nominal[:, 0])

    def predict(self, values: Array) -> tuple[Array, Array]:
        """Mean x, p1, p2 (b, 3), SI, as sensors without error read them, and their derivatives by the keys (b, 3,
        k)."""
        y, slopes = self._means(self.experiment, values)
        y[:, 0] -= self.moved[1]
        if self._stiffness in self.experiment.keys:
            # The same friction bends stiffer bristles less.
            at = self.experiment.keys.index(self._stiffness)
            softer = number(self._near, self._stiffness) / float(values[at])
            y += self._by_bending * (softer - 1.0)
            slopes[:, :, at] -= self._by_bending * softer / float(values[at])
        return y, slopes

    def _means(self, experiment: Experiment, values: Array) -> tuple[Array, Array]:
        found = solve(experiment, values)
        if len(found.times) < len(self.blocks.nodes):
            raise InputError(f"{self.source}: the rig could not be simulated: {found.outcome.message}")
        both = np.concatenate([found.y[:, :, np.newaxis], found.sensitivities], axis=-1)
        both[:, 1:] = lagged(self.blocks.nodes, both[:, 1:], self.sensors.lag)
        both = self.blocks.mean_of_nodes(both)
        return both[:, :, 0].copy(), both[:, :, 1:]

    def weighted(self, residuals: Array) -> tuple[Array, Array, Array]:
        """Residuals (b, 3, ...) of x, p1, p2, or their derivatives, as independent numbers of variance one, one array
        each."""
        kept = residuals[self.counted]
        scale = np.sqrt(self.blocks.count[self.counted]) / self.sensors.pressure_noise
        scale = scale.reshape(-1, *[1] * (kept.ndim - 2))
        return whitened(self._root, kept[:, 0]), kept[:, 1] * scale, kept[:, 2] * scale

    @cached_property
    def _root(self) -> Array:
        return self.sensors.root_of_covariance(self._nominal[self.counted, 0], self.blocks.count[self.counted])

    @cached_property
    def _nominal(self) -> Array:
        return self._started()


def lagged(time: Array, signal: Array, lag: float) -> Array:
    """A signal (n, ...) at times (n,), s, after a first-order lag, s, in steady state at the start; linear between the
    times."""
    if lag <= 0.0:
        return signal
    ratio = np.diff(time) / lag
    keep = np.exp(-ratio)
    mean = (1.0 - keep) / ratio
    out = signal.copy()
    for i, (k, m) in enumerate(zip(keep, mean, strict=True)):
        out[i + 1] = k * out[i] + (m - k) * signal[i] + (1.0 - m) * signal[i + 1]
    return out


def straight_lines(time: Array, values: Array, tolerance: float) -> tuple[Array, Array]:
    """A subset of the points (time, values) whose polygon stays within `tolerance` of all points (Douglas and Peucker,
    1973)."""
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


def corners(time: Array, values: Array, tolerance: float) -> tuple[Array, Array]:
    """:func:`straight_lines`, with a corner between two samples at the intersection of the lines on both sides.

    A spool that opens half a sample earlier displaces oil that a stiff, closed chamber shows as pressure.
    """
    t, u = straight_lines(time, values, tolerance)
    interval = 1.5 * (time[-1] - time[0]) / (time.size - 1)
    adjacent = np.diff(t) < interval
    # Corners between two longer lines; the ends of the log have only one.
    lone = np.flatnonzero(adjacent[1:-1] & ~adjacent[:-2] & ~adjacent[2:]) + 1
    drop = np.zeros(t.size, dtype=bool)
    for k in lone:
        before, after = (u[k] - u[k - 1]) / (t[k] - t[k - 1]), (u[k + 2] - u[k + 1]) / (t[k + 2] - t[k + 1])
        if before == after:
            continue
        meet = (u[k + 1] - u[k] + before * t[k] - after * t[k + 1]) / (before - after)
        if t[k] <= meet <= t[k + 1]:
            u[k] += before * (meet - t[k])
            t[k], drop[k + 1] = meet, True
    return t[~drop], u[~drop]


def _even(log: Log) -> Log:
    """The log without its last interval if that is shorter than the others."""
    step = np.diff(log.time)
    if len(step) > 2 and step[-1] < 0.999 * step[0]:
        log, step = log.between(log.time[0], log.time[-2]), step[:-1]
    if len(step) < 2 or np.ptp(step) > 1e-3 * step.mean():
        raise InputError(
            f"{log.source}: a dynamic fit needs evenly spaced samples; take hydrocrane.signals.resample first"
        )
    return log


def _command(log: Log) -> Array:
    command = log["command"]
    if not np.isfinite(command).all():
        raise InputError(f"{log.source}: the command has gaps, so the motion cannot be simulated; cut the log")
    if not command.any():
        raise InputError(f"{log.source}: the spool was never opened; a dynamic fit needs a log of a motion")
    return command


def _start(log: Log, samples: Array) -> Array:
    """Pressure p1 (Pa) and position (m) at the first sample; p1 drifts by leakage while the spool is closed."""
    time = log.time - log.time[0]
    opened = time[np.argmax(log["command"] != 0.0)]
    pick = (time > SETTLING) & (time <= min(START, opened)) & np.isfinite(samples).all(axis=1)
    if np.count_nonzero(pick) < LEAST_SAMPLES:
        raise InputError(
            f"{log.source}: a log must begin with the piston at rest; it has {np.count_nonzero(pick)} readings between "
            f"{SETTLING:g} s and the opening of the spool, {LEAST_SAMPLES} are needed"
        )
    p1 = np.polynomial.Polynomial.fit(time[pick], samples[pick, 1], 1)(0.0)
    return np.array([p1, samples[pick, 0].mean()])


def _scenario(log: Log, rig: Machine, command: tuple[Array, Array], start: Array, payload: float | None) -> Scenario:
    a1, a2 = rig.piston_areas[0]
    held = float(rig.static_cylinder_force([0.0], payload=payload)[0])
    p1 = max(float(start[0]), LEAST_PRESSURE, (held + LEAST_PRESSURE * a2) / a1)
    cylinder, joint = rig.cylinder_names[0], rig.joint_names[0]
    return Scenario(
        machine=rig,
        joints={joint: float(np.clip(rig.joints_from_strokes([start[1]])[0], *rig.joint_limits[0]))},
        commands={cylinder: Command(*command, "linear")},
        pressures={cylinder: (p1, (p1 * a1 - held) / a2)},
        duration=float(log.time[-1] - log.time[0]),
        record_interval=float(log.time[1] - log.time[0]),
        payload=payload,
        solver=SOLVER,
        name=log.source or "log",
    )


Progress = Callable[[int, float], None]


class RigResiduals:
    """Residuals of all logs, in standard deviations, with their derivatives by keys and nuisances.

    Parameters
    ----------
    models : sequence of RigLogModel
        With the same keys.
    progress : callable, optional
        Called with the number of evaluations and the root-mean-square residual.
    """

    def __init__(self, models: Sequence[RigLogModel], progress: Progress | None = None) -> None:
        self.models = tuple(models)
        self.keys = len(models[0].experiment.keys)
        self.progress = progress
        self.evaluations = 0

    def __call__(self, theta: Array) -> tuple[Array, Array]:
        residuals: list[Array] = []
        slopes: list[Array] = []
        for k, model in enumerate(self.models):
            seen, row = self._readings(theta, k)
            residuals += model.weighted(seen - model.measured)
            slopes += model.weighted(row)
        found = np.concatenate(residuals)
        self.evaluations += 1
        if self.progress is not None:
            self.progress(self.evaluations, rms(found))
        return found, np.concatenate(slopes)

    def restarted(self, theta: Array) -> RigResiduals:
        """The same logs, simulated with the start values and the delay in `theta`."""
        models = [model.restarted(theta[self._moving(k)], theta[: self.keys]) for k, model in enumerate(self.models)]
        moved = RigResiduals(models, self.progress)
        moved.evaluations = self.evaluations
        return moved

    def counted_from_logs(self, theta: Array) -> Array:
        """`theta` with start values and delay relative to the logs, and not to those of the simulation."""
        total = theta.copy()
        for k, model in enumerate(self.models):
            total[self._moving(k)] = theta[self._moving(k)] + model.moved
        return total

    def predicted(self, theta: Array, log: int) -> Array:
        """Readings x, p1, p2 (b, 3) of one log, SI."""
        return self._readings(theta, log)[0]

    def of_signals(self, theta: Array) -> Iterator[tuple[str, str, Array]]:
        """Log, signal, and its residuals in standard deviations with their derivatives by all unknowns, (b, 1 + k)."""
        for k, model in enumerate(self.models):
            seen, row = self._readings(theta, k)
            residuals, slopes = model.weighted(seen - model.measured), model.weighted(row)
            for signal, values, over_theta in zip(SIGNALS, residuals, slopes, strict=True):
                yield model.source, signal, np.column_stack([values, over_theta])

    def _readings(self, theta: Array, log: int) -> tuple[Array, Array]:
        """Readings of one log (b, 3) and their derivatives by all unknowns (b, 3, k)."""
        model, common = self.models[log], self.keys + len(NUISANCES)
        own = self._own(log)
        y, dy = model.predict(theta[: self.keys])
        seen, by_nuisance = read(y, model.turned, model.by_delay, model.by_start, theta[self.keys : common], theta[own])
        row = np.zeros((*y.shape, theta.size))
        row[:, :, : self.keys] = dy * gains(y, theta[self.keys : common])[:, :, np.newaxis]
        row[:, :, self.keys : common] = by_nuisance[:, :, : len(NUISANCES)]
        row[:, :, own] = by_nuisance[:, :, len(NUISANCES) :]
        return seen, row

    def _moving(self, log: int) -> list[int]:
        """Indices of start pressure, position and friction of a log, and of the common delay, among the unknowns."""
        first = self._own(log).start
        own = [first + OF_A_LOG.index(name) for name in ("p1.start", "x.start", "rest.friction")]
        return [*own, self.keys + NUISANCES.index("delay")]

    def _own(self, log: int) -> slice:
        """Indices of :data:`OF_A_LOG` of a log among the unknowns."""
        first = self.keys + len(NUISANCES) + log * len(OF_A_LOG)
        return slice(first, first + len(OF_A_LOG))
