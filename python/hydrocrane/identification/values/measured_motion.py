"""A log whose motion is measured: pressures against weight, inertia and friction along it.
                                                              theory: docs/theory/identification/fitting.md

    A_1 p_1 - A_2 p_2 = F(q, q', q'') + F_f(v)

with the force F that the mechanism needs (inverse dynamics over the lever arm) and the static friction map F_f. Nothing
is integrated, so errors of valve, supply or oil do not matter. Motion and forces pass the same filter, forwards and
backwards, before the motion is differentiated (Gautier, Dynamic identification of robots with power model, ICRA 1997).
The filter removes the same components from both sides.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.identification.records import FittedLog
from hydrocrane.identification.values.models import by_differences
from hydrocrane.identification.values.parameters import SensorError
from hydrocrane.logs import Log, noise_of
from hydrocrane.machine.machine import Machine
from hydrocrane.machine.overrides import Overrides
from hydrocrane.scenario.solver import Solver
from hydrocrane.signals.filters import low_pass

FORCE = "cylinder.{}.pressure_force"
# A piston slower than this many standard errors of its speed, or than this speed (m/s), may be at rest; its friction is
# then indeterminate.
CLEAR, LEAST_SPEED = 3.0, 5e-4
# Displacement after a reversal within which the friction of a piston reaches its static map, m: bristles bend, seals
# roll.
TRAVEL = 1e-3
LEAST_READINGS = 20
# Memory of the filter as a share of a period of its bandwidth.
MEMORY = 0.5


@dataclass(frozen=True)
class JointMotion:
    """Joint coordinates (m, n_joints), their first and second derivatives, and the standard error of the first."""

    q: Array
    qd: Array
    qdd: Array
    error: Array

    def every(self, step: int) -> JointMotion:
        """Every `step`-th sample of it."""
        return JointMotion(self.q[::step], self.qd[::step], self.qdd[::step], self.error[::step])


@dataclass(frozen=True)
class MeasuredMotion:
    """The forces of a log's cylinders along its measured motion.

    Parameters
    ----------
    machine : Machine
        With the values that are not fitted.
    inputs : tuple of SensorError
        Zeros of the joint sensors, zeros and spans of the pressure sensors; among the unknowns they follow the keys.
    pressures : dict of (m,) arrays
        Readings of the pressures by their signals, Pa.
    moves : dict of (m,) arrays of bool
        True where a piston certainly moves, by cylinder; elsewhere its friction counts as zero.
    scales : tuple of float
        Standard deviations of keys and inputs, SI.
    """

    machine: Machine
    record: FittedLog
    motion: JointMotion
    cylinders: tuple[str, ...]
    keys: tuple[str, ...]
    inputs: tuple[SensorError, ...]
    pressures: dict[str, Array]
    moves: dict[str, np.ndarray]
    scales: tuple[float, ...]

    @property
    def solver(self) -> None:
        return None

    def predict(self, values: Array) -> tuple[Array, Array]:
        return by_differences(self._forces, values, self.scales)

    def varied(self, values: Array, overrides: Overrides, interpolation: str = "") -> Array:
        """Neither valve nor oil enters."""
        return self._forces(values)

    def with_solver(self, solver: Solver) -> MeasuredMotion:
        return self

    def _forces(self, values: Array) -> Array:
        machine = self.machine.changed(self.machine.overrides_at(self.keys, values[: len(self.keys)]))
        q, added = self.motion.q.copy(), np.zeros(self.record.readings.shape)
        for error, value in zip(self.inputs, values[len(self.keys) :].tolist(), strict=True):
            _, name, quantity = error.signal.split(".")
            if error.signal.startswith("joint."):
                q[:, machine.joint_names.index(name)] -= value
            elif name in self.cylinders:
                side = ("p1", "p2").index(quantity)
                area = (1.0, -1.0)[side] * machine.piston_areas[machine.cylinder_names.index(name), side]
                reading = self.pressures[error.signal] if error.kind == "span" else 1.0
                added[:, self.cylinders.index(name)] += area * value * reading
        motion = JointMotion(q, self.motion.qd, self.motion.qdd, self.motion.error)
        return pressure_forces(machine, motion, self.cylinders, self.moves) + added


def pressure_forces(
    machine: Machine, motion: JointMotion, cylinders: tuple[str, ...], moves: Mapping[str, np.ndarray]
) -> Array:
    """A_1 p_1 - A_2 p_2 (m, n) of some cylinders along a motion, N, positive outwards, friction by its static map."""
    torque = np.einsum("tij,tj->ti", machine.mass_matrix(motion.q), motion.qdd)
    torque += machine.bias_force(motion.q, motion.qd)
    lever = machine.stroke_jacobian(motion.q)
    force = np.linalg.solve(np.swapaxes(lever, -1, -2), torque[..., None])[..., 0]
    speed = np.einsum("tcj,tj->tc", lever, motion.qd)
    columns = []
    for name in cylinders:
        c = machine.cylinder_names.index(name)
        columns.append(force[:, c] + np.where(moves[name], machine.friction_map(speed[:, c], name), 0.0))
    return np.stack(columns, axis=1)


def motion_of(machine: Machine, log: Log, joints: dict[str, float], bandwidth: float) -> JointMotion:
    """The motion of a log by its joints' sensors below `bandwidth`, Hz; joints without a sensor have the value in
    `joints`."""
    columns = []
    for joint, signal in zip(machine.joint_names, joint_signals(machine, log), strict=True):
        name = f"joint.{joint}.q"
        if signal is not None:
            columns.append(_joint(log, _joint_readings(machine, log, joint, signal), bandwidth))
        elif joint in joints:
            still = np.zeros(log.time.size)
            columns.append((still + joints[joint], still, still, still))
        else:
            raise InputError(
                f"{log.source} has no `{name}`, and the scenario does not say where joint `{joint}` stands; map its "
                f"column or its cylinder's stroke, `cylinder.<name>.x`, or give joints={{{joint!r}: ...}}"
            )
    q, qd, qdd, error = (np.stack(part, axis=1) for part in zip(*columns, strict=True))
    return JointMotion(q, qd, qdd, error)


def joint_signals(machine: Machine, log: Log) -> list[str | None]:
    """The signal that measures each joint: its own, the stroke of its cylinder, or None."""
    found: list[str | None] = []
    for j, joint in enumerate(machine.joint_names):
        own = f"joint.{joint}.q"
        lever = machine.stroke_jacobian(machine.home)[:, j]
        strokes = [f"cylinder.{c}.x" for c, arm in zip(machine.cylinder_names, lever, strict=True) if arm != 0.0]
        found.append(next((name for name in (own, *strokes) if name in log), None))
    return found


def _joint_readings(machine: Machine, log: Log, joint: str, signal: str) -> Array:
    """Readings (m,) of a joint, rad or m; NaN if a reading is missing."""
    readings = np.where(log.spoilt(signal), np.nan, log[signal])
    if not signal.startswith("cylinder."):
        return readings
    good = np.isfinite(readings)
    strokes = np.tile(machine.strokes(machine.home), (int(good.sum()), 1))
    strokes[:, machine.cylinder_names.index(signal.split(".")[1])] = readings[good]
    found = np.full(readings.size, np.nan)
    found[good] = machine.joints_from_strokes(strokes)[:, machine.joint_names.index(joint)]
    return found


def _joint(log: Log, readings: Array, bandwidth: float) -> tuple[Array, Array, Array, Array]:
    """A joint's coordinate, its derivatives, and the standard error of the first."""
    if np.isfinite(readings).sum() < LEAST_READINGS:
        raise InputError(f"{log.source}: a joint has fewer than {LEAST_READINGS} usable readings")
    rate = (log.time.size - 1) / float(log.time[-1] - log.time[0])
    q = _below(log.time, readings, bandwidth)
    qd = np.gradient(q, log.time)
    # Standard deviation of white noise below the bandwidth after one differentiation.
    error = noise_of(readings).total * 2.0 * np.pi * bandwidth * np.sqrt(2.0 * bandwidth / (3.0 * rate))
    return q, qd, np.gradient(qd, log.time), np.full(q.size, error)


def _below(time: Array, values: Array, bandwidth: float) -> Array:
    """A signal (m,) without components above `bandwidth`, Hz, without phase shift; gaps are filled by straight
    lines."""
    good = np.isfinite(values)
    even = np.linspace(time[0], time[-1], time.size)
    rate = (time.size - 1) / float(time[-1] - time[0])
    smooth = low_pass(np.interp(even, time[good], values[good]), rate, min(bandwidth, 0.2 * rate))
    return np.asarray(np.interp(time, even, smooth))


def measured_forces(
    machine: Machine, log: Log, motion: JointMotion, bandwidth: float, at_rest: bool
) -> tuple[dict[str, Array], dict[str, np.ndarray]]:
    """Measured A_1 p_1 - A_2 p_2 (m,) of each cylinder with both pressures below `bandwidth`, Hz, in N; and where its
    piston certainly moves (m,), by its name.

    NaN where it touches an end stop and, unless `at_rest`, where it may be at rest, and within the memory of the filter
    before and after.
    """
    found, moves = {}, {}
    lever = machine.stroke_jacobian(motion.q)
    speed = np.einsum("tcj,tj->tc", lever, motion.qd)
    error = np.sqrt(np.einsum("tcj,tj->tc", lever**2, motion.error**2))
    joints = [name for name in joint_signals(machine, log) if name is not None]
    memory = max(int(np.searchsorted(log.time, log.time[0] + MEMORY / bandwidth)), 1)
    for c, name in enumerate(machine.cylinder_names):
        signals = [f"cylinder.{name}.p{i}" for i in (1, 2)]
        if not all(signal in log for signal in signals):
            continue
        lost = log.spoilt(*signals, *joints)
        force = sum(
            sign * area * log[s] for sign, area, s in zip((1, -1), machine.piston_areas[c], signals, strict=True)
        )
        still = np.abs(speed[:, c]) < np.maximum(CLEAR * error[:, c], LEAST_SPEED)
        still |= _travel_since_turn(log.time, speed[:, c]) < TRAVEL
        doubtful = lost | _at_an_end(machine, c, motion.q)
        doubtful[[0, -1]] = True
        moves[name] = ~maximum_filter1d(still, 2 * memory + 1)
        near = maximum_filter1d(doubtful, 2 * memory + 1) | (~moves[name] & (not at_rest))
        found[FORCE.format(name)] = np.where(near, np.nan, _below(log.time, np.where(lost, np.nan, force), bandwidth))
    if not found:
        raise InputError(
            f"{log.source} has no cylinder with both pressures; map columns to `cylinder.<name>.p1` and "
            "`cylinder.<name>.p2`"
        )
    return found, moves


def force_noise(machine: Machine, log: Log, signals: Sequence[str]) -> Array:
    """(n,) standard deviation of a force's fast noise from those of its pressures, N, before any filter."""
    found = []
    for signal in signals:
        name = signal.split(".")[1]
        areas = machine.piston_areas[machine.cylinder_names.index(name)]
        noise = [noise_of(log[f"cylinder.{name}.p{side}"]).total for side in (1, 2)]
        found.append(float(np.linalg.norm(areas * noise)))
    return np.array(found)


def _at_an_end(machine: Machine, c: int, q: Array) -> np.ndarray:
    """(m,) True where a piston is within the zone of an end stop, whose force is not modelled."""
    key = f"cylinder.{machine.cylinder_names[c]}.end-stop.zone"
    zone = float(np.max(machine.value(key).si)) if key in machine.keys else 0.0
    low, high = machine.stroke_limits[c]
    stroke = machine.strokes(q)[:, c]
    return np.asarray((stroke < low + zone) | (stroke > high - zone))


def _travel_since_turn(time: Array, speed: Array) -> Array:
    """(m,) displacement of a piston since its last reversal, m; before the first reversal, since the start."""
    travel = np.concatenate([[0.0], np.cumsum(0.5 * np.abs(speed[1:] + speed[:-1]) * np.diff(time))])
    turned = np.concatenate([[True], np.sign(speed[1:]) != np.sign(speed[:-1])])
    return travel - np.maximum.accumulate(np.where(turned, travel, 0.0))
