"""Names, limits and sizes of a machine, and its functions over batches of any shape."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array, real_array, rows, scalars, scenario_quantity, vectors
from hydrocrane.errors import HydrocraneError, InputError, translated, unknown
from hydrocrane.machine.poses import in_motion, poses, states
from hydrocrane.machine.stated import Stated


class Shaped(Stated):
    """What all quantities of a machine are ordered and checked by."""

    @property
    def name(self) -> str:
        """Name of the machine, as its file states it."""
        return self.core.name

    @property
    def title(self) -> str:
        """What it is, in a few words."""
        return self.core.title

    @property
    def description(self) -> str:
        """What the machine file says about it."""
        return self.core.description

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints from the base to the tip, in the order of every `q`."""
        return tuple(self.core.joint_names)

    @cached_property
    def joint_units(self) -> tuple[str, ...]:
        """Unit of each joint coordinate: ``rad`` or ``m``."""
        return tuple(self.core.joint_units)

    @cached_property
    def cylinder_names(self) -> tuple[str, ...]:
        """Cylinder names; cylinder i moves joint i."""
        return tuple(self.core.cylinder_names)

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states, in the order of every state vector."""
        return tuple(self.core.state_names)

    @cached_property
    def state_units(self) -> tuple[str, ...]:
        """SI unit of each state."""
        return tuple(self.core.state_units)

    @cached_property
    def joint_limits(self) -> Array:
        """(n, 2) lowest and highest coordinate, rad or m; reasons in :attr:`joint_limit_reasons`."""
        return np.array(self.core.joint_limits, dtype=np.float64)

    @property
    def joint_limit_reasons(self) -> tuple[tuple[str, str], ...]:
        """Per joint, what sets its lower and its upper limit."""
        return tuple((low, high) for low, high in self.core.joint_limit_reasons)

    @cached_property
    def stroke_limits(self) -> Array:
        """(n_cyl, 2) piston positions from mid-stroke, m."""
        return np.array(self.core.stroke_limits, dtype=np.float64)

    @cached_property
    def spool_strokes(self) -> Array:
        """(n_cyl,) largest spool displacement, m."""
        return np.array(self.core.spool_strokes, dtype=np.float64)

    @property
    def supply_pressure(self) -> float:
        """Pa, gauge."""
        return float(self.core.supply_pressure)

    @property
    def payload_mass(self) -> float:
        """Default payload at the tip, kg."""
        return float(self.core.payload_mass)

    @cached_property
    def home(self) -> Array:
        """(n,) pose in the middle of the joint limits."""
        return self.joint_limits.mean(axis=1)

    @cached_property
    def piston_areas(self) -> Array:
        """(n_cyl, 2) piston-side and rod-side area, m^2; of all cylinders in parallel together."""
        return np.array(self.core.areas, dtype=np.float64)

    @cached_property
    def holdable_pressures(self) -> Array:
        """(n_cyl, 2) highest pressure at which piston side and rod side carry a load at rest, Pa.

        The least of the highest pressure of the mains, at which the pump still gives its leakage, and the pressures to
        which relief valves at the port are tight, with the tank's pressure on the other side.
        """
        return np.array(self.core.holdable, dtype=np.float64)

    @property
    def tip_gains(self) -> dict[str, float]:
        """Gains of the controller ``tip`` by their keys in ``[control.tip]``, SI: from the file, else the defaults."""
        return dict(self.core.tip_gains)

    # --- helpers ------------------------------------------------------------------------------------------------

    def _joints(self, value: ArrayLike, name: str = "q") -> Array:
        return poses(self, value) if name == "q" else vectors(value, name, self.joint_names)

    def _moving(self, q: ArrayLike) -> Array:
        return in_motion(self, q)

    def _plant(self, state: ArrayLike, spool_command: ArrayLike) -> tuple[Array, Array]:
        return states(self, state), vectors(spool_command, "spool_command", self.cylinder_names)

    def payload(self, payload: float | None = None) -> float:
        """A mass at the tip in kg, checked; the machine's own if none is given.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> print(crane.payload(), crane.payload(150))
        0.0 150.0
        """
        if payload is None:
            return self.payload_mass
        return scenario_quantity("scenario.payload", "payload", payload)

    def _over(
        self,
        function: Callable[..., Array],
        *arrays: Array,
        error: type[HydrocraneError] = InputError,
        **options: float | None,
    ) -> Array:
        """Call a core function row by row over the broadcast leading axes."""
        extra = [self.payload(options["payload"])] if "payload" in options else []
        lead, tables = rows(*arrays)
        with translated(error):
            result = np.asarray(function(*tables, *extra))
        return result.reshape(lead + result.shape[1:])[()]

    def _over_scalars(self, function: Callable[..., Array], *before: int, **named: ArrayLike) -> Array:
        lead, columns = scalars(*(real_array(value, name) for name, value in named.items()))
        with translated():
            return np.asarray(function(*before, *columns)).reshape(lead)[()]

    def _per_cylinder(self, function: Callable[..., Array], cylinder: str | None, **named: ArrayLike) -> Array:
        return self._over_scalars(function, self._index_of(cylinder), **named)

    def _index_of(self, cylinder: str | None) -> int:
        if cylinder is not None and cylinder not in self.cylinder_names:
            raise unknown("cylinder", cylinder, self.cylinder_names)
        return 0 if cylinder is None else self.cylinder_names.index(cylinder)
