"""What follows from a pose alone: natural modes of small motions, and what the crane can hold at its tip."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array, vectors
from hydrocrane.errors import HydrocraneError, InputError
from hydrocrane.machine import Machine


@dataclass(frozen=True)
class Modes:
    """Small motions about rest in one pose, slowest oscillation first.

    Attributes
    ----------
    frequency : (k,) array
        Natural frequency |lambda| / (2 pi) of each oscillating pair, Hz.
    damping : (k,) array
        Damping ratio -Re(lambda) / |lambda|; negative where the motion grows.
    state : tuple of str
        The state that takes most part in each mode.
    eigenvalues : (n_states,) complex array
        All eigenvalues of the exact Jacobian, 1/s.
    """

    q: Array
    frequency: Array
    damping: Array
    state: tuple[str, ...]
    eigenvalues: np.ndarray


def modes(crane: Machine, q: ArrayLike, *, payload: float | None = None) -> Modes:
    """Natural modes at the ``hold`` equilibrium of pose q (n,), valves closed.

    They are the eigenvalues of the exact Jacobian. A mode is named by its largest participation factor, the product
    of the left and right eigenvector entries: it does not depend on the units of the states.
    """
    from scipy.linalg import eig

    q = vectors(q, "q", crane.joint_names)
    if q.ndim != 1:
        raise InputError(f"modes takes one pose of shape ({len(crane.joint_names)},), got shape {q.shape}")
    state = crane.equilibrium(q, payload=payload)
    jacobian = crane.jacobian(state, np.zeros(len(crane.cylinder_names)), payload=payload)
    values, left, right = eig(jacobian, left=True, right=True)  # type: ignore[misc]
    # One of each conjugate pair; what is left of rounding in a real eigenvalue is no oscillation.
    swinging = np.flatnonzero(values.imag > 1e-9 * np.abs(values).max())
    swinging = swinging[np.argsort(np.abs(values[swinging]))]
    leading = np.argmax(np.abs(left.conj() * right), axis=0)
    size = np.abs(values[swinging])
    return Modes(
        q=q,
        frequency=size / (2 * np.pi),
        damping=-values.real[swinging] / size,
        state=tuple(crane.state_names[leading[i]] for i in swinging),
        eigenvalues=values,
    )


@dataclass(frozen=True)
class ModeMap:
    """Slowest oscillation of the joints over the workspace.

    Attributes
    ----------
    q, tip : (m, n), (m, 2) arrays
        Poses and their tips.
    frequency, damping : (m,) arrays
        Hz and ratio; NaN where no equilibrium exists or nothing but the spools oscillates.
    """

    q: Array
    tip: Array
    frequency: Array
    damping: Array


def mode_map(crane: Machine, *, samples: int = 12, payload: float | None = None) -> ModeMap:
    """Slowest mode that is not a spool's own, over a grid of poses inside the limits."""
    poses = pose_grid(crane, samples)
    found = np.array([_slowest(crane, q, payload) for q in poses])
    return ModeMap(poses, crane.tip(poses), found[:, 0], found[:, 1])


def _slowest(crane: Machine, q: Array, payload: float | None) -> tuple[float, float]:
    try:
        here = modes(crane, q, payload=payload)
    except HydrocraneError:
        return np.nan, np.nan
    for frequency, damping, state in zip(here.frequency, here.damping, here.state, strict=True):
        if not state.endswith((".xs", ".vs")):
            return frequency, damping
    return np.nan, np.nan


@dataclass(frozen=True)
class LoadChart:
    """Largest static payload over the workspace.

    Attributes
    ----------
    q, tip : (m, n), (m, 2) arrays
        Poses and their tips, m.
    payload : (m,) array
        kg; NaN where even the empty crane cannot be held.
    limiting : (m,) array of int
        Index of the cylinder that gives out first; -1 where none does up to `ceiling`.
    """

    q: Array
    tip: Array
    payload: Array
    limiting: np.ndarray
    cylinder_names: tuple[str, ...]
    supply_pressure: float

    def against_reach(self, bins: int = 60) -> tuple[Array, Array, Array]:
        """Reach (b,), and the largest and the smallest capacity (b,) found at it, m and kg."""
        reach = self.tip[:, 0]
        edges = np.linspace(reach.min(), reach.max(), bins + 1)
        index = np.clip(np.digitize(reach, edges) - 1, 0, bins - 1)
        # A pose that cannot even be held empty carries nothing.
        capacity = np.nan_to_num(self.payload, nan=0.0)
        best, worst = np.full(bins, -np.inf), np.full(bins, np.inf)
        np.maximum.at(best, index, capacity)
        np.minimum.at(worst, index, capacity)
        hit = np.isfinite(best)
        return 0.5 * (edges[1:] + edges[:-1])[hit], best[hit], worst[hit]


def load_chart(crane: Machine, *, samples: int = 50, ceiling: float = 1e5) -> LoadChart:
    """Largest payload, kg, that the cylinders hold at rest with supply pressure on one side and none on the other.

    A cylinder's force then lies within [-p_s A2, p_s A1]. The static forces are affine in the payload, so two
    evaluations per pose give the payload at which each cylinder reaches its limit; the smallest one counts.
    `ceiling` ends the search where no cylinder is the limit (next to a vertical boom).
    """
    poses = pose_grid(crane, samples)
    empty = crane.static_cylinder_force(poses, payload=0.0)
    slope = (crane.static_cylinder_force(poses, payload=1000.0) - empty) / 1000.0
    low, high = np.array([-1.0, 1.0])[:, np.newaxis] * crane.supply_pressure * crane.piston_areas.T[::-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        room = np.where(slope > 0, (high - empty) / slope, (low - empty) / slope)
    room[slope == 0] = np.inf
    capacity = room.min(axis=1)
    limiting = np.where(capacity < ceiling, room.argmin(axis=1), -1)
    held = ((empty >= low) & (empty <= high)).all(axis=1)
    payload = np.where(held, np.minimum(capacity, ceiling), np.nan)
    return LoadChart(poses, crane.tip(poses), payload, limiting, crane.cylinder_names, crane.supply_pressure)


def pose_grid(crane: Machine, samples: int) -> Array:
    """Regular grid of poses (m, n) inside the limits; prismatic joints get fewer points, they matter less."""
    if samples < 2:
        raise InputError(f"samples must be at least 2, got {samples}")
    axes = []
    for (low, high), unit in zip(crane.joint_limits, crane.joint_units, strict=True):
        # A hair inside: exactly at a limit the inverse relations may already be undefined.
        margin = 1e-6 * (high - low)
        count = samples if unit == "rad" or len(crane.joint_units) == 1 else max(2, samples // 6)
        axes.append(np.linspace(low + margin, high - margin, count))
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
