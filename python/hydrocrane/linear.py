"""What follows from a pose alone: natural modes of small motions, and what the crane can hold at its tip."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array, vectors
from hydrocrane.errors import InputError
from hydrocrane.machine import Machine

# Share of a joint's range in which an end stop may act: its zone is a twentieth of the barrel or less.
_END_STOPS = 0.07


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
    """Slowest oscillation of the crane over a grid of poses (k_1, ..., k_n).

    Attributes
    ----------
    q, tip : (k_1, ..., k_n, n), (k_1, ..., k_n, 2) arrays
        Poses and their tips.
    frequency, damping : (k_1, ..., k_n) arrays
        Hz and ratio; NaN where supply pressure cannot hold the crane, or nothing but the spools oscillates.
    """

    q: Array
    tip: Array
    frequency: Array
    damping: Array


def mode_map(crane: Machine, *, samples: int = 16, payload: float | None = None) -> ModeMap:
    """Slowest mode that is not a spool's own, over a grid of poses clear of the end stops.

    Poses that need more than supply pressure to hold are left out: no valve brings the crane to rest there.
    """
    poses = pose_grid(crane, samples, inset=_END_STOPS)
    flat = poses.reshape(-1, poses.shape[-1])
    found = np.array([_slowest(crane, q, payload) for q in flat]).reshape(*poses.shape[:-1], 2)
    return ModeMap(poses, crane.tip(poses), found[..., 0], found[..., 1])


def _slowest(crane: Machine, q: Array, payload: float | None) -> tuple[float, float]:
    state = crane.equilibrium(q, payload=payload)
    pressures = [i for i, name in enumerate(crane.state_names) if name.endswith((".p1", ".p2"))]
    if state[pressures].max() > crane.supply_pressure:
        return np.nan, np.nan
    here = modes(crane, q, payload=payload)
    for frequency, damping, leading in zip(here.frequency, here.damping, here.state, strict=True):
        if not leading.endswith((".xs", ".vs")):
            return frequency, damping
    return np.nan, np.nan


@dataclass(frozen=True)
class LoadChart:
    """Largest static payload over a grid of poses (k_1, ..., k_n).

    Attributes
    ----------
    q, tip : (k_1, ..., k_n, n), (k_1, ..., k_n, 2) arrays
        Poses and their tips, m.
    payload : (k_1, ..., k_n) array
        kg; NaN where even the empty crane cannot be held.
    limiting : (k_1, ..., k_n) array of int
        Index of the cylinder that gives out first; -1 where none does up to the ceiling.
    supply_pressure : float
        Pa.
    """

    q: Array
    tip: Array
    payload: Array
    limiting: np.ndarray
    supply_pressure: float

    def against_reach(self, bins: int = 40, *, layer: int | None = None) -> tuple[Array, Array]:
        """Reach (b,), m, and the largest payload (b,), kg, found at it.

        `layer` keeps to one position of the last joint, by its index in the grid.
        """
        chosen = np.s_[...] if layer is None else np.s_[..., layer]
        reach = self.tip[..., 0][chosen].reshape(-1)
        # A pose that cannot even be held empty carries nothing.
        payload = np.nan_to_num(self.payload[chosen], nan=0.0).reshape(-1)
        # A tip that moves straight up and down has one reach only.
        bins = bins if np.ptp(reach) > 1e-6 else 1
        edges = np.linspace(reach.min(), reach.max(), bins + 1)
        index = np.clip(np.digitize(reach, edges) - 1, 0, bins - 1)
        best = np.full(bins, -np.inf)
        np.maximum.at(best, index, payload)
        hit = np.isfinite(best)
        return 0.5 * (edges[1:] + edges[:-1])[hit], best[hit]


def load_chart(crane: Machine, *, samples: int = 50, ceiling: float = 1e5) -> LoadChart:
    """Largest payload, kg, that the cylinders hold at rest with supply pressure on one side and none on the other.

    A cylinder's force then lies within [-p_s A2, p_s A1]. The static forces are affine in the payload, so two
    evaluations per pose give the payload at which each cylinder reaches its limit; the smallest one counts.
    `ceiling` ends the search where no cylinder is the limit (next to a vertical boom).
    """
    poses = pose_grid(crane, samples)
    empty = crane.static_cylinder_force(poses, payload=0.0)
    slope = (crane.static_cylinder_force(poses, payload=1000.0) - empty) / 1000.0
    low, high = -crane.supply_pressure * crane.piston_areas[:, 1], crane.supply_pressure * crane.piston_areas[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        room = np.where(slope > 0, (high - empty) / slope, (low - empty) / slope)
    room[slope == 0] = np.inf
    capacity = room.min(axis=-1)
    limiting = np.where(capacity < ceiling, room.argmin(axis=-1), -1)
    held = ((empty >= low) & (empty <= high)).all(axis=-1)
    payload = np.where(held, np.minimum(capacity, ceiling), np.nan)
    return LoadChart(poses, crane.tip(poses), payload, limiting, crane.supply_pressure)


def pose_grid(crane: Machine, samples: int, *, inset: float = 1e-6) -> Array:
    """Regular grid of poses (k_1, ..., k_n, n) inside the limits.

    Turning joints get `samples` points; a telescope gets fewer, it matters less. `inset` is the share of each range
    that is kept clear at both ends: exactly at a limit the inverse relations may already be undefined.
    """
    if samples < 2:
        raise InputError(f"samples must be at least 2, got {samples}")
    axes = []
    for (low, high), unit in zip(crane.joint_limits, crane.joint_units, strict=True):
        margin = inset * (high - low)
        count = samples if unit == "rad" or len(crane.joint_units) == 1 else max(3, samples // 6)
        axes.append(np.linspace(low + margin, high - margin, count))
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
