"""Shapes of the crane's modes, and how frequency and damping change along a joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.analysis.linear import modes, places
from hydrocrane.arrays import Array, brief
from hydrocrane.errors import InputError, OutOfReachError, check_known
from hydrocrane.linear.linearise import linearise
from hydrocrane.machine.machine import MachineLike, as_machine
from hydrocrane.result_warning import ResultWarning
from hydrocrane.state_space.options import Friction
from hydrocrane.state_space.oscillations import Oscillations

# Share of a joint's range without curves at both ends, because of the end stops.
_INSET = 0.05


@dataclass(frozen=True)
class ModeShapes:
    """Mode shapes of the crane.

    Attributes
    ----------
    q : (n,) array
        The pose.
    frequency, damping : (k,) arrays
        Hz and ratio, slowest first; spools are left out.
    state : tuple of str
        The state with the largest participation in each mode.
    joints : (k, n) complex array
        Deviation of each joint, rad or m; normalised to a tip motion of 1, or to a joint motion of 1 if the tip does
        not move.
    tip : (k, 2) complex array
        Corresponding motion of the tip, m.
    """

    q: Array
    frequency: Array
    damping: Array
    state: tuple[str, ...]
    joints: np.ndarray
    tip: np.ndarray

    __repr__ = brief


@dataclass(frozen=True)
class DampingCurves:
    """Frequency and damping ratio of the crane's modes along one joint, the others held.

    Attributes
    ----------
    joint : str
    unit : str
        Of the joint: rad or m.
    coordinate : (m,) array
    frequency, damping : (m, k) arrays
        Sorted by frequency in every pose; NaN where a pose has fewer modes.
    friction : str
    warnings : tuple of ResultWarning
        One of each kind.
    """

    joint: str
    unit: str
    coordinate: Array
    frequency: Array
    damping: Array
    friction: str
    warnings: tuple[ResultWarning, ...]

    __repr__ = brief


def mode_shapes(
    machine: MachineLike, q: ArrayLike, *, payload: float | None = None, friction: Friction = "held"
) -> ModeShapes:
    """Shapes of the modes of :func:`hydrocrane.modes` in pose q (n,)."""
    machine = as_machine(machine)
    model = linearise(machine, q, payload=payload, friction=friction)
    found = model.oscillations
    picked = _of_the_crane(found)
    pose = model.x[places(machine, "joint", "q")]
    joints = found.shapes[np.ix_(picked, places(machine, "joint", "q"))]
    tip = joints @ machine.tip_jacobian(pose).T
    largest = np.abs(tip).max(axis=1, initial=0.0)
    still = largest < 1e-9 * np.abs(joints).max(axis=1, initial=0.0)
    largest = np.where(still, np.abs(joints).max(axis=1, initial=0.0), largest)
    # Phases are relative to the coordinate with the largest motion.
    lead = np.take_along_axis(joints, np.abs(joints).argmax(axis=1)[:, None], axis=1)
    scale = np.exp(-1j * np.angle(lead)) / largest[:, None]
    return ModeShapes(
        q=pose,
        frequency=found.frequency[picked],
        damping=found.damping[picked],
        state=tuple(found.state[i] for i in picked),
        joints=joints * scale,
        tip=tip * scale,
    )


def damping_curves(
    machine: MachineLike,
    joint: str,
    *,
    q: ArrayLike | None = None,
    samples: int = 40,
    payload: float | None = None,
    friction: Friction = "held",
) -> DampingCurves:
    """Frequency and damping of the crane's modes at `samples` places of one joint, the others as in q (n,).

    Poses without an equilibrium are left out of the curves (NaN). By default the other joints are in mid-range.
    """
    machine = as_machine(machine)
    check_known("joint", joint, machine.joint_names)
    if samples < 2:
        raise InputError(f"samples must be at least 2, got {samples}")
    index = machine.joint_names.index(joint)
    low, high = machine.joint_limits[index]
    coordinate = np.linspace(low + _INSET * (high - low), high - _INSET * (high - low), samples)
    base = machine.home if q is None else np.asarray(q, dtype=np.float64)
    rows: list[Array] = []
    warnings: dict[str, ResultWarning] = {}
    for value in coordinate:
        pose = base.copy()
        pose[index] = value
        try:
            found = modes(machine, pose, payload=payload, friction=friction)
        except OutOfReachError:
            rows.append(np.empty((0, 2)))
            continue
        own = _of_the_crane(found)
        rows.append(np.stack([found.frequency[own], found.damping[own]], axis=-1))
        warnings |= {warning.kind: warning for warning in found.warnings if warning.kind not in warnings}
    table = np.full((samples, max(len(row) for row in rows), 2), np.nan)
    for k, row in enumerate(rows):
        table[k, : len(row)] = row
    return DampingCurves(
        joint,
        machine.joint_units[index],
        coordinate,
        table[..., 0],
        table[..., 1],
        friction,
        tuple(warnings.values()),
    )


def _of_the_crane(found: Oscillations) -> list[int]:
    """Indices of the modes that do not belong to a spool."""
    return [i for i, state in enumerate(found.state) if not state.endswith((".xs", ".vs"))]
