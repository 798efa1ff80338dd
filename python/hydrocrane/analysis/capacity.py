"""Payload that a crane can hold at its tip: over its poses, and against reach and height.

What a cylinder holds ends at the highest pressure of the mains or at a relief valve of its port; positions in keep-out
regions, or with the load in the ground, count as out of reach.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from hydrocrane.analysis.poses import pose_grid
from hydrocrane.arrays import Array, brief, rows
from hydrocrane.errors import InputError
from hydrocrane.machine.machine import Machine, MachineLike, as_machine
from hydrocrane.notebook import card

Height = Literal["best", "worst"] | float
# Number of reaches of a curve, of heights at each, and of bisections for the end of the reachable heights.
_REACHES, _HEIGHTS, _HALVINGS = 50, 50, 8
# Initial numbers of values of the joint along a curve and of the other joints, and the most doublings.
_FINE, _COARSE, _DOUBLINGS = 24, 3, 3
# Relative change of a curve that ends the doubling.
_CHANGE = 0.01
# Iterations for the position of the tip along a curve.
_STEPS = 4
# Poses of a map that are computed together.
_BLOCK = 2**16
# Turn of a joint by which its pivot is found, rad; travel of one that slides, m.
_TURN = 0.5
# Lengths below this are zero, m.
_NEAR = 1e-6


@dataclass(frozen=True)
class LoadChart:
    """Largest static payload over a grid of poses (k_1, ..., k_n), and against reach.

    Attributes
    ----------
    q, tip : (k_1, ..., k_n, n), (k_1, ..., k_n, 2) arrays
        Poses and their tips, m.
    payload : (k_1, ..., k_n) array
        kg; NaN if even the empty crane cannot be held, and at forbidden positions.
    limiting : (k_1, ..., k_n) array of int
        Index of the cylinder that limits the payload; -1 if none does up to the ceiling.
    forbidden : (k_1, ..., k_n) array of bool
        Whether the tip is in a keep-out region, or it or its load in the ground.
    supply_pressure : float
        Pa.
    machine : Machine
        The crane.

    Examples
    --------
    >>> chart = hc.load_chart("rottne-f9-lab", samples=5)
    >>> reach, payload = chart.against_reach()
    >>> print(chart.payload.shape, reach.shape == payload.shape)
    (5, 5, 3) True
    """

    q: Array
    tip: Array
    payload: Array
    limiting: np.ndarray
    forbidden: np.ndarray
    supply_pressure: float
    machine: Machine = field(repr=False)
    ceiling: float = 1e5

    __repr__ = brief

    def _repr_html_(self) -> str:
        reach, best = self.against_reach()
        worst = self.against_reach("worst")[1]
        rows = spread(reach.size, 10)
        lines = [f"{reach[i]:.2f} m  {best[i]:.0f} kg at the best height, {worst[i]:.0f} kg at the worst" for i in rows]
        return card(f"Load chart of {self.machine.name} at {self.supply_pressure * 1e-5:.4g} bar", lines)

    def against_reach(self, height: Height = "best") -> tuple[Array, Array]:
        """Reach (r,), m, and the payload (r,), kg, that the crane holds there.

        At each place the pose with the highest payload counts; 0 if even the empty crane cannot be held. The places do
        not depend on the grid of poses: they are refined until the curve changes by less than 1 %.

        Parameters
        ----------
        height : {"best", "worst"} or float
            Height of the tip, m: the best or the worst of those that are permitted and within
            reach, or a given one; NaN if the tip cannot or must not be at that height.

        Examples
        --------
        >>> chart = hc.load_chart("rottne-f9-lab", samples=5)
        >>> reach, payload = chart.against_reach("worst")
        >>> best = chart.against_reach("best")[1]
        >>> print(np.nanmax(payload) <= np.nanmax(best))
        True
        """
        best, worst = self._best_and_worst
        if height == "best":
            return self._reaches, best
        if height == "worst":
            return self._reaches, worst
        if isinstance(height, str | bool) or not np.isfinite(height):
            raise InputError(f"height is `best`, `worst` or a height in metres; got {height!r}")
        points = np.stack([self._reaches, np.full_like(self._reaches, height)], axis=-1)
        return self._reaches, self._refined(lambda places: places.payload(points)[None])[0]

    def over_places(self) -> tuple[Array, Array, Array]:
        """Places x (r,), z (h,), m, and the payload (h, r), kg, of the pose that holds most there; NaN out of reach.

        Examples
        --------
        >>> chart = hc.load_chart("rottne-f9-lab", samples=5)
        >>> x, z, payload = chart.over_places()
        >>> print(payload.shape == (z.size, x.size))
        True
        """
        low, high = self._extent[1]
        levels = np.linspace(low, high, _HEIGHTS)
        points = np.stack(np.meshgrid(self._reaches, levels), axis=-1)
        return self._reaches, levels, Places(self.machine, self.ceiling, 4 * _FINE, 2 * _COARSE).payload(points)

    @cached_property
    def _reaches(self) -> Array:
        low, high = self._extent[0]
        # A tip that only moves up and down has a single reach.
        return np.linspace(low, high, _REACHES + 2)[1:-1] if high - low > _NEAR else np.array([(low + high) / 2])

    @cached_property
    def _extent(self) -> Array:
        """(2, 2) lowest and highest x and z of the tip, m."""
        outline = np.concatenate([self.machine.tip_in_plane(_line(self.machine)), *self.machine.workspace()])
        return np.stack([outline.min(axis=0), outline.max(axis=0)], axis=-1)

    @cached_property
    def _best_and_worst(self) -> tuple[Array, Array]:
        best, worst = self._refined(self._extremes)
        return best, worst

    def _refined(self, curves: Callable[[Places], Array]) -> Array:
        """(k, r) `curves`, over as many values of the joints as it takes to change them no more."""
        found = curves(Places(self.machine, self.ceiling, _FINE, _COARSE))
        for doubling in range(1, _DOUBLINGS + 1):
            finer = curves(Places(self.machine, self.ceiling, _FINE << doubling, _COARSE << doubling))
            least = _CHANGE * np.maximum(np.abs(finer), 0.1 * np.nanmax(np.abs(finer), initial=0.0))
            done = not (np.abs(finer - found) > least).any()
            found = finer
            if done:
                break
        return found

    def _extremes(self, places: Places) -> Array:
        """(2, r) best and worst payload over the heights."""
        low, high = self._extent[1]
        levels = np.linspace(low, high, _HEIGHTS)
        points = np.stack(np.meshgrid(self._reaches, levels, indexing="ij"), axis=-1)
        payload = places.payload(points)
        column, level = np.nonzero(np.isfinite(payload[:, 1:]) != np.isfinite(payload[:, :-1]))
        inside = np.where(np.isfinite(payload[column, level]), level, level + 1)
        near, far = levels[inside], levels[2 * level + 1 - inside]
        for _ in range(_HALVINGS):
            middle = 0.5 * (near + far)
            there = np.isfinite(places.payload(np.stack([self._reaches[column], middle], axis=-1)))
            near, far = np.where(there, middle, near), np.where(there, far, middle)
        ends = places.payload(np.stack([self._reaches[column], near], axis=-1))
        best, worst = (np.where(np.isfinite(payload), payload, empty) for empty in (-np.inf, np.inf))
        best, worst = best.max(axis=1), worst.min(axis=1)
        np.maximum.at(best, column, np.where(np.isfinite(ends), ends, -np.inf))
        np.minimum.at(worst, column, np.where(np.isfinite(ends), ends, np.inf))
        return np.where(np.isfinite([best, worst]), [best, worst], np.nan)


class Places:
    """The payload at places of the tip, over poses in which all joints but two take `coarse` values.

    The first joint in the plane rotates the rest about a fixed point, or moves it along a line. It remains to find the
    point of a curve, along which one of the other joints moves, with the right distance from that point or line.
    """

    def __init__(self, machine: Machine, ceiling: float, fine: int, coarse: int) -> None:
        self.machine, self.ceiling = machine, ceiling
        self._first = machine.first_in_plane
        self._turning = machine.joint_units[self._first] == "rad"
        self._pivot, self._along = _pivot(machine) if self._turning else _rail(machine)
        others = range(self._first + 1, len(machine.joint_names))
        self._curves = [curve for moved in others for curve in _curves(machine, moved, fine, coarse)]
        self._one_joint = not self._curves

    def payload(self, points: Array) -> Array:
        """(...) kg at places (..., 2), m: of the pose that holds most, 0 where none holds itself; NaN out of reach.

        Forbidden places count as out of reach.
        """
        flat = points.reshape(-1, 2)
        best = np.full(len(flat), -np.inf)
        for curve in self._curves:
            self._raise(best, flat, curve)
        if self._one_joint:
            everywhere = np.arange(len(flat))
            self._keep(best, everywhere, np.tile(self.machine.home, (len(flat), 1)), flat)
        return np.where(np.isfinite(best), best, np.nan).reshape(points.shape[:-1])

    def _raise(self, best: Array, places: Array, curve: Array) -> None:
        """Raise `best` (p,) to what poses between those of a curve (s, n) hold with the tip at `places` (p, 2)."""
        here, wanted = self._distance(self.machine.tip_in_plane(curve)), self._distance(places)
        beyond = here > wanted[:, None]
        place, piece = np.nonzero(beyond[:, 1:] != beyond[:, :-1])
        if not place.size:
            return
        ends = [curve[piece].copy(), curve[piece + 1].copy()]
        misses = [here[piece] - wanted[place], here[piece + 1] - wanted[place]]
        for _ in range(_STEPS):
            share = (misses[0] / (misses[0] - misses[1]))[:, None]
            pose = ends[0] * (1 - share) + ends[1] * share
            miss = self._distance(self.machine.tip_in_plane(pose)) - wanted[place]
            first = (miss > 0) == (misses[0] > 0)
            for side, chosen in ((0, first), (1, ~first)):
                ends[side][chosen], misses[side][chosen] = pose[chosen], miss[chosen]
        self._keep(best, place, pose, places[place])

    def _keep(self, best: Array, place: np.ndarray, poses: Array, wanted: Array) -> None:
        """Set that joint of `poses` (k, n) such that the tip is at `wanted` (k, 2), and raise `best` there."""
        low, high = self.machine.joint_limits[self._first]
        tip, poses = self.machine.tip_in_plane(poses), poses.copy()
        joint = poses[:, self._first]
        if self._turning:
            turn = [np.arctan2(*(point - self._pivot).T[::-1]) for point in (wanted, tip)]
            # The coordinate within the limits, of those that are a turn apart.
            first = joint + float(self._along[0]) * (turn[0] - turn[1])
            joint[:] = low - _NEAR + np.mod(first - low + _NEAR, 2 * np.pi)
        else:
            joint += (wanted - tip) @ self._along
        inside = (joint >= low - _NEAR) & (joint <= high + _NEAR)
        np.clip(joint, low, high, out=joint)
        inside &= np.linalg.norm(self.machine.tip_in_plane(poses) - wanted, axis=-1) < 1e-3
        place, poses = place[inside], poses[inside]
        payload = np.nan_to_num(capacity(self.machine, poses, self.ceiling)[0], nan=0.0)
        permitted = ~self.machine.forbidden(self.machine.tip(poses), payload)
        np.maximum.at(best, place[permitted], payload[permitted])

    def _distance(self, places: Array) -> Array:
        """What the first joint leaves as it is: the distance from its pivot, or from its line."""
        arm = places - self._pivot
        if self._turning:
            return np.hypot(arm[..., 0], arm[..., 1])
        return np.asarray(arm @ np.array([-self._along[1], self._along[0]]))


def spread(count: int, rows: int) -> list[int]:
    """Indices of so many rows at most, evenly spread over `count`."""
    return sorted({round(i * (count - 1) / max(rows - 1, 1)) for i in range(rows)})


def at_height(height: Height) -> str:
    """The height of a curve in words."""
    if height == "best":
        return "at the best height"
    return "at the worst permitted height" if height == "worst" else f"at z = {height:g} m"


def load_chart(machine: MachineLike, *, samples: int = 50, ceiling: float = 1e5) -> LoadChart:
    """Largest payload, kg, that the cylinders hold at rest, at each position of the tip that is permitted.

    One side of a cylinder has the highest pressure that the supply gives and the relief valves of its port keep, the
    other one that of the tank. Of a crane that slews it is the chart in the plane of its boom, with the slewing joint
    at home, which matters on a slope. Whether the crane tips over is not asked.

    Parameters
    ----------
    machine : Machine, str or path
    samples : int
        Poses of the map per turning joint, the first two of them, up to what 1 GB holds; curves against reach have a
        separate grid.
    ceiling : float
        Payload, kg, at which the search ends if no cylinder is the limit (next to a vertical boom).

    Examples
    --------
    >>> chart = hc.load_chart("rottne-f9-lab", samples=5)
    >>> print(chart.payload.shape, int(chart.supply_pressure / 1e5), "bar")
    (5, 5, 3) 140 bar
    """
    machine = as_machine(machine)
    machine.require_plane("a load chart", slewing=True)
    if not (np.isfinite(ceiling) and ceiling > 0):
        raise InputError(f"ceiling must be a payload in kg, greater than zero; got {ceiling!r}")
    grid = pose_grid(machine, samples)
    shape, poses = grid.shape[:-1], grid.reshape(-1, grid.shape[-1])
    tip, payload = np.empty((len(poses), 2)), np.empty(len(poses))
    limiting, out = np.empty(len(poses), dtype=np.int64), np.empty(len(poses), dtype=bool)
    # Block by block, so that what is needed on the way takes no memory.
    for first in range(0, len(poses), _BLOCK):
        here = slice(first, first + _BLOCK)
        tip[here] = machine.tip_in_plane(poses[here])
        payload[here], limiting[here] = capacity(machine, poses[here], ceiling)
        out[here] = machine.forbidden(machine.tip(poses[here]), np.nan_to_num(payload[here], nan=0.0))
    payload[out], limiting[out] = np.nan, -1
    return LoadChart(
        q=grid,
        tip=tip.reshape(*shape, 2),
        payload=payload.reshape(shape),
        limiting=limiting.reshape(shape),
        forbidden=out.reshape(shape),
        supply_pressure=machine.supply_pressure,
        machine=machine,
        ceiling=float(ceiling),
    )


def capacity(machine: Machine, poses: Array, ceiling: float) -> tuple[Array, np.ndarray]:
    """Payload (...), kg, at which the first cylinder reaches its limit in poses (..., n), and which one, -1 for none.

    NaN where even the empty crane cannot be held.
    """
    lead, (table,) = rows(poses)
    found = machine.core.capacity(table, ceiling).reshape(*lead, 2)
    return found[..., 0], found[..., 1].astype(int)


def _curves(machine: Machine, moved: int, fine: int, coarse: int) -> Array:
    """Curves (m, s, n) of poses along which one joint moves, those up to the first in the plane at home, the others on
    a grid.
    """
    fixed = 1 + machine.first_in_plane
    axes = list(machine.home[:fixed, None])
    for i, (low, high) in list(enumerate(machine.joint_limits))[fixed:]:
        margin = 1e-6 * (high - low)
        axes.append(np.linspace(low + margin, high - margin, (fine if i == moved else coarse) + 1))
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    return np.moveaxis(grid, moved, -2).reshape(-1, fine + 1, len(axes))


def _line(machine: Machine) -> Array:
    """Poses (3, n) along the first joint in the plane, the others at home."""
    return _beside_home(machine, 0.49 * float(np.ptp(machine.joint_limits[machine.first_in_plane])))


def _beside_home(machine: Machine, step: float) -> Array:
    """Poses (3, n) at home and a step of the first joint in the plane to both sides."""
    poses = np.tile(machine.home, (3, 1))
    poses[:, machine.first_in_plane] += np.array([-step, 0.0, step])
    return poses


def _pivot(machine: Machine) -> tuple[Array, Array]:
    """The point (2,) about which that joint turns the tip; +1, or -1 where a growing coordinate turns it back."""
    tip = machine.tip_in_plane(_beside_home(machine, _TURN))
    # Half of the chord between both sides, turned by a quarter, lies on the line from its middle to the pivot.
    chord, middle = 0.5 * (tip[2] - tip[0]), 0.5 * (tip[2] + tip[0])
    across = np.array([-chord[1], chord[0]])
    sense = np.copysign(1.0, across @ (middle - tip[1]))
    return middle + sense * across / np.tan(_TURN), np.array([sense])


def _rail(machine: Machine) -> tuple[Array, Array]:
    """A point (2,) of the tip and the direction (2,) in which that joint moves it."""
    tip = machine.tip_in_plane(_beside_home(machine, _TURN))
    return tip[1], (tip[2] - tip[0]) / (2.0 * _TURN)
