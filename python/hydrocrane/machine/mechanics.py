"""Mechanics, hydraulics and friction of a machine, law by law."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane._core_types import Passivity
from hydrocrane.arrays import Array, real_array, scalars, vectors
from hydrocrane.errors import translated
from hydrocrane.machine.geometry import Geometry


class Mechanics(Geometry):
    """The part of a machine that forces and flows at one instant determine."""

    def mass_matrix(self, q: ArrayLike, *, payload: float | None = None) -> Array:
        """Mass matrix M (..., n, n)   (59).

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> print(np.diagonal(crane.mass_matrix(q, payload=100)).round(1))
        [1255.7  251.3  110.1]
        """
        return self._over(self.core.mass_matrix, self._moving(q), payload=payload)

    def bias_force(self, q: ArrayLike, qd: ArrayLike, *, payload: float | None = None) -> Array:
        """Coriolis, centrifugal and gravity terms h (..., n): M qdd + h = J_l^T f_cyl.

        It is minus the thesis's h of (60), without the cylinder forces Q.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> print(crane.bias_force(q, np.zeros(3)).round(1))
        [1647.5  107.5  -93.2]
        """
        return self._over(self.core.bias_force, self._moving(q), self._joints(qd, "qd"), payload=payload)

    def forward_dynamics(
        self, q: ArrayLike, qd: ArrayLike, cylinder_force: ArrayLike, *, payload: float | None = None
    ) -> Array:
        """Joint accelerations (..., n) under net cylinder forces (..., n_cyl), N.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> held = crane.static_cylinder_force(q)
        >>> print(abs(crane.forward_dynamics(q, np.zeros(3), held)).max() < 1e-12)
        True
        """
        force = vectors(cylinder_force, "cylinder_force", self.cylinder_names)
        return self._over(self.core.forward_dynamics, self._moving(q), self._joints(qd, "qd"), force, payload=payload)

    def static_cylinder_force(self, q: ArrayLike, *, payload: float | None = None) -> Array:
        """Net cylinder forces (..., n_cyl) that hold the crane at rest, N.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> print(crane.static_cylinder_force(q).round(), crane.static_cylinder_force(q, payload=100).round())
        [7916. -909.  -93.] [21232. -5600. -1015.]
        """
        return self._over(self.core.static_cylinder_force, self._joints(q), payload=payload)

    def piston_speeds(self, q: ArrayLike, *, payload: float | None = None) -> Array:
        """Lowest and highest steady piston speed (..., n_cyl, 2) at full spool stroke under the load at rest, m/s.

        Negative retracts. One piston moves and the other spools are closed; the whole circuit counts: pump and its
        limits, compensators, load-holding and port valves, friction. Zero if the supply cannot move the load.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-mobile")
        >>> slow = crane.changed({"pump.main.displacement": "5 ml"})
        >>> q = crane.home
        >>> print(bool((abs(slow.piston_speeds(q)) < abs(crane.piston_speeds(q))).any()))
        True
        """
        return self._over(self.core.piston_speeds, self._joints(q), payload=payload)

    def spool_positions(self, shares: ArrayLike) -> Array:
        """Spool positions (..., n_cyl), m, that have signed `shares` (..., n_cyl) of the steady speed at full stroke.

        A share is that of the speed through the valve alone; positive extends, 0 is the middle. Overlaps and curves of
        the metering edges are in it; dead bands and gains of `valve.<name>.command` are not.
        Source: docs/theory/control/valve.md.

        Examples
        --------
        >>> import hydrocrane as hc
        >>> hc.load_machine("rottne-f9-mobile").spool_positions([0.5, 0.0, -1.0])
        array([ 0.0275,  0.    , -0.05  ])
        """
        return self._over(self.core.spool_positions, vectors(shares, "shares", self.cylinder_names))

    def kinetic_energy(self, q: ArrayLike, qd: ArrayLike, *, payload: float | None = None) -> Array:
        """Kinetic energy (...), J   (45).

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> print(crane.kinetic_energy(q, [0.5, 0.0, 0.0]).round(2))
        46.42
        """
        return self._over(self.core.kinetic_energy, self._moving(q), self._joints(qd, "qd"), payload=payload)

    def potential_energy(self, q: ArrayLike, *, payload: float | None = None) -> Array:
        """Potential energy (...), J   (52), increasing upwards.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> lifted = q + [0.1, 0.0, 0.0]
        >>> print((crane.potential_energy(lifted) - crane.potential_energy(q)).round(2))
        163.64
        """
        return self._over(self.core.potential_energy, self._moving(q), payload=payload)

    # --- hydraulics and friction --------------------------------------------------------------------------------

    def orifice_flow(self, spool: ArrayLike, dp: ArrayLike, cylinder: str | None = None) -> Array:
        """Flow through one metering edge, m^3/s   (64)-(74).

        Parameters
        ----------
        spool : array_like
            Opening of the edge, m of spool stroke.
        dp : array_like
            Pressure drop across the edge, Pa; broadcasts against `spool`.
        cylinder : str, optional
            Cylinder of the valve; the first one by default.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> print((6e4 * crane.orifice_flow(0.05, [75e5, 300e5], "lift")).round(2))
        [ 6. 12.]
        """
        return self._per_cylinder(self.core.orifice_flow, cylinder, spool=spool, dp=dp)

    def edge_areas(self, spool: ArrayLike, cylinder: str | None = None) -> Array:
        """Areas (..., 4) of the metering edges at spool positions, m: supply to A, A to tank, supply to B, B to tank.

        Shares of the area that has the nominal flow at the nominal drop: times :meth:`orifice_flow` at the opening
        of the full stroke they give flows. `cylinder` says whose valve, the first one's by default.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> print(crane.edge_areas(0.025, "lift").round(3))
        [0.5 0.  0.  0.5]
        """
        index = self._index_of(cylinder)
        lead, (column,) = scalars(real_array(spool, "spool"))
        with translated():
            return np.asarray(self.core.edge_areas(index, column)).reshape((*lead, 4))

    def friction_map(self, v: ArrayLike, cylinder: str | None = None) -> Array:
        """Steady friction force, N, at piston velocity v, m/s; positive against positive velocity   (107)-(113).

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> print(crane.friction_map([-0.1, 0.1], "extension").round())
        [-659.  413.]
        """
        return self._per_cylinder(self.core.friction_map, cylinder, v=v)

    def bulk_modulus(self, p: ArrayLike) -> Array:
        """Effective bulk modulus of the fluid at gauge pressure p, Pa   (96).

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> print((1e-9 * crane.bulk_modulus([0.0, 100e5])).round(2))
        [0.24 0.84]
        """
        return self._over_scalars(self.core.bulk_modulus, p=p)

    def density(self, p: ArrayLike) -> Array:
        """Density of the fluid at gauge pressure p, kg/m^3.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> print(crane.density([0.0, 100e5]).round(1))
        [1000.  1016.3]
        """
        return self._over_scalars(self.core.density, p=p)

    def passivity(self) -> list[Passivity]:
        """Per cylinder with LuGre friction, whether and up to which velocity the passivity condition holds.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> print([entry["holds"] for entry in crane.passivity()])
        [True, True, True]
        """
        return self.core.passivity()
