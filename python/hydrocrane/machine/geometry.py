"""Geometry of a machine: pistons, tip, poses, workspace."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrocrane.arrays import Array, real_array, rows, vectors
from hydrocrane.errors import InputError, OutOfReachError, translated
from hydrocrane.machine.shaped import Shaped

# Poses of a tip, nested like the tips.
Poses: TypeAlias = "list[Array] | list[Poses]"


class Geometry(Shaped):
    """The part of a machine that lengths and angles determine."""

    def strokes(self, q: ArrayLike) -> Array:
        """Piston positions from mid-stroke (..., n_cyl), m, of joint coordinates q (..., n)   (40)-(42).

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> print(crane.strokes(q).round(4))
        [0.0427 0.0485 0.    ]
        """
        return self._over(self.core.strokes, self._joints(q))

    def joints_from_strokes(self, x: ArrayLike) -> Array:
        """Joint coordinates (..., n) of piston positions x (..., n_cyl), on the branch inside the joint limits.

        Raises
        ------
        OutOfReachError
            If no pose inside the limits has these strokes.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> print(np.rad2deg(crane.joints_from_strokes(crane.strokes(q))[:2]).round(6))
        [100. 100.]
        """
        x = vectors(x, "x", self.cylinder_names)
        return self._over(self.core.joints_from_strokes, x, error=OutOfReachError)

    def stroke_jacobian(self, q: ArrayLike) -> Array:
        """d(strokes)/d(q), (..., n_cyl, n).

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> print(np.diagonal(crane.stroke_jacobian(q)).round(3))
        [ 0.208 -0.118  1.   ]
        """
        return self._over(self.core.stroke_jacobian, self._joints(q))

    def cylinder_slopes(self, q: ArrayLike) -> Array:
        """Direction of each cylinder from barrel to rod (..., n_cyl), rad from x towards z; thesis (15), (28).

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> print(np.rad2deg(crane.cylinder_slopes(q)).round(1))
        [-97.8  15.4 -70. ]
        """
        return self._over(self.core.cylinder_slopes, self._joints(q))

    def centres_of_gravity(self, q: ArrayLike) -> Array:
        """Centre of gravity of each moving link (..., n, 2) in the inertial frame, m; thesis (31)-(33).

        A machine in space gives (..., n, 3): x, y, z.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> print(crane.centres_of_gravity(q).round(2).tolist())
        [[1.05, 1.0], [2.49, 0.87], [2.72, 0.25]]
        """
        return self._over(self.core.centres_of_gravity, self._joints(q))

    def tip(self, q: ArrayLike) -> Array:
        """Crane tip in the inertial frame (..., 2): x forward, z up, m   (30)-(34).

        A machine in space gives (..., 3): x forward, y to the left, z up; :attr:`tip_axes` says which.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> print(crane.tip(q).round(3), crane.tip(np.tile(q, (4, 5, 1))).shape)
        [ 2.825 -0.199] (4, 5, 2)
        """
        return self._over(self.core.tip, self._joints(q))

    def tip_in_plane(self, q: ArrayLike) -> Array:
        """Tip seen from the side, (..., 2) x and z, m: where the crane slews, in the plane of its boom.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-forwarder")
        >>> ahead, aside = crane.home, crane.home + [0.5, 0.0, 0.0, 0.0]
        >>> print(np.allclose(crane.tip_in_plane(ahead), crane.tip_in_plane(aside)))
        True
        """
        return self._over(self.core.tip_in_plane, self._joints(q))

    def tip_jacobian(self, q: ArrayLike) -> Array:
        """d(tip)/d(q), (..., 2, n); of a machine in space (..., 3, n).

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> rates = np.array([0.1, 0.0, 0.0])
        >>> print((crane.tip_jacobian(q) @ rates).round(3))
        [0.093 0.283]
        """
        return self._over(self.core.tip_jacobian, self._joints(q))

    def inverse_kinematics(self, tip: ArrayLike, x3: float = 0.0) -> Poses:
        """Poses that put the tip at `tip` (2,) with the telescope at `x3`, m   (35)-(39).

        Returns
        -------
        list of (n,) arrays
            Only poses inside the joint limits, best first; empty if none reaches it. A batch of tips (..., 2)
            gives lists nested in its leading axes.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> poses = crane.inverse_kinematics([2.5, 0.5])
        >>> print(len(poses), crane.tip(poses[0]).round(6))
        1 [2.5 0.5]
        """
        self.require_plane("inverse kinematics")
        tip = vectors(tip, "tip", ("x", "z"))
        extension = real_array(x3, "x3")
        if extension.ndim:
            raise InputError(f"x3 must be one number in metres, got shape {extension.shape}")
        if tip.ndim > 1:
            return [self.inverse_kinematics(point, float(extension)) for point in tip]
        with translated():
            found = self.core.inverse_kinematics(np.ascontiguousarray(tip), float(extension))
        return [np.array(pose, dtype=np.float64) for pose in found]

    def workspace(self) -> list[Array]:
        """Boundary curves of the tip's reach, each (k, 2) in the inertial frame, m   (3.1.3).

        Where the crane slews, those in the plane of its boom, as in :meth:`tip_in_plane`.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> print(max(curve[:, 0].max() for curve in crane.workspace()).round(2))
        4.14
        """
        self.require_plane("the workspace", slewing=True)
        return [np.asarray(curve, dtype=np.float64) for curve in self.core.workspace()]

    def drawing(self, q: ArrayLike) -> list[tuple[str, str, Array]]:
        """Lines of the crane in pose q (n,): (kind, name, (k, 2) points in the inertial frame, m).

        `kind` is one of ``link``, ``cylinder-barrel``, ``cylinder-rod``, ``torque-link``, ``joint``, ``tip``.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> print(sorted({kind for kind, name, line in crane.drawing(q)}))
        ['cylinder-barrel', 'cylinder-rod', 'joint', 'link', 'tip', 'torque-link']
        """
        q = self._joints(q)
        if q.ndim != 1:
            raise InputError(f"drawing takes one pose of shape ({len(self.joint_names)},), got shape {q.shape}")
        with translated():
            return [(kind, name, np.asarray(line)) for kind, name, line in self.core.drawing(np.ascontiguousarray(q))]

    def clearance(self, place: ArrayLike) -> Array:
        """Distance of places (..., 2) from the nearest :attr:`keep_out` region, m, negative inside.

        Of places in space (..., 3) the regions turn with a crane that slews about its first joint; on other machines in
        space they extend along y.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> print(crane.clearance([[2.0, 0.5], [0.0, -0.5]]).round(2))
        [ 1.71 -0.2 ]
        """
        lead, points = self._in_space(place)
        return self.core.clearance(points).reshape(lead)

    def forbidden(self, place: ArrayLike, load: ArrayLike = 0.0) -> NDArray[np.bool_]:
        """Whether places (..., 2) or (..., 3) of the tip with `load` (...), kg, lie in a region or in the ground.

        The regions are :attr:`keep_out`, as in :meth:`clearance`; a load lies in the ground if its underside does.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> print(crane.forbidden([[2.0, 0.5], [0.0, -0.5]]))
        [False  True]
        """
        lead, points = self._in_space(place)
        loads = np.broadcast_to(real_array(load, "load"), lead).reshape(-1)
        height = self.core.heights_above_ground(np.ascontiguousarray(points[:, [0, 2]]), np.ascontiguousarray(loads))
        return ((self.core.clearance(points) < 0.0) | (height < 0.0)).reshape(lead)

    def _in_space(self, place: ArrayLike) -> tuple[tuple[int, ...], Array]:
        """Leading axes and rows (x, y, z) of places of the tip."""
        lead, (points,) = rows(vectors(place, "place", self.tip_axes))
        return lead, points if points.shape[1] == 3 else np.insert(points, 1, 0.0, axis=1)

    @property
    def tip_axes(self) -> tuple[str, ...]:
        """Axes along which the tip moves: ("x", "z"), or ("x", "y", "z") of a machine in space.

        Examples
        --------
        >>> hc.load_machine("rottne-f9-lab").tip_axes, hc.load_machine("rottne-f9-forwarder").tip_axes
        (('x', 'z'), ('x', 'y', 'z'))
        """
        return tuple(self.core.tip_axes)

    @property
    def first_in_plane(self) -> int:
        """Index of the first joint that moves in the plane of the boom: 1 where the one before it slews all others.

        Examples
        --------
        >>> hc.load_machine("rottne-f9-lab").first_in_plane, hc.load_machine("rottne-f9-forwarder").first_in_plane
        (0, 1)
        """
        return int(self.core.slews)

    def require_plane(self, what: str, *, slewing: bool = False) -> None:
        """Raise an error if the machine moves in space, for `what` is worked out in the plane only.

        With `slewing` it may slew: a first joint about the vertical axis turns the plane of all others.

        Examples
        --------
        >>> hc.load_machine("rottne-f9-lab").require_plane("a load chart")
        >>> hc.load_machine("rottne-f9-forwarder").require_plane("a load chart", slewing=True)
        """
        if "y" in self.tip_axes and not (slewing and self.first_in_plane):
            raise InputError(
                f"{what}: worked out for machines in the plane of x and z only, and {self.core.name} moves in space; "
                "take a machine file without its joints that have an `axis`"
            )
