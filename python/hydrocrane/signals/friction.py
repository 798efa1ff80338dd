"""Friction force of a cylinder on the rig, from pressures and motion. Theory: docs/theory/signals/friction_force.md"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.logs.columns import LogLike
from hydrocrane.logs.log import Log
from hydrocrane.logs.noise import noise_of
from hydrocrane.machine.description import described
from hydrocrane.machine.machine import Machine, MachineLike, as_machine
from hydrocrane.signals.derivative import derivative
from hydrocrane.signals.resample import at_common_rate, resample, unbroken


@dataclass(frozen=True)
class RigParameters:
    """Parameters for the friction force of a rig that moves along a straight line.

    Attributes
    ----------
    piston_area, rod_area : float
        m^2, of the chambers of p1 and p2.
    mass : float
        Moving mass including the load, kg.
    gravity : float
        Component along the extending piston, m/s^2: +9.81 where the load hangs, 0 where the cylinder lies.
    rod_mass : float
        Moving mass on the cylinder's side of a load cell, kg.
    stroke : (float, float)
        Range of the piston position from mid-stroke, m.
    slip : float
        Travel over which the bristles of the seal bend before they slip, m; 0 if it is not known.
    """

    piston_area: float
    rod_area: float
    mass: float
    gravity: float = 0.0
    rod_mass: float = 0.0
    stroke: tuple[float, float] = (-np.inf, np.inf)
    slip: float = 0.0

    def __post_init__(self) -> None:
        for name in ("piston_area", "rod_area", "mass"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise InputError(f"{name} of a rig must be positive and finite, got {getattr(self, name)!r}")
        if not (np.isfinite(self.gravity) and np.isfinite(self.rod_mass) and self.rod_mass >= 0):
            raise InputError("gravity of a rig must be finite, and rod_mass finite and not negative")

    @classmethod
    def of(cls, machine: MachineLike, *, payload: float | None = None, rod_mass: float = 0.0) -> RigParameters:
        """The parameters of a machine, or of its name, with one cylinder that moves its load along a straight line."""
        machine = as_machine(machine)
        if len(machine.cylinder_names) != 1:
            raise InputError(
                f"a friction rig has one cylinder; {machine.name} has {', '.join(machine.cylinder_names)}. "
                f"Take a machine like rig-rottne that has the cylinder alone, or give RigParameters"
            )
        (cylinder,) = described(machine.core).records("cylinders")
        if (count := cylinder.number("count")) != 1.0:
            raise InputError(
                f"a friction rig has one cylinder; {machine.name} has {count:g} in parallel, of which a log shows the "
                f"sum. Set `cylinder.{cylinder.text('name')}.count = 1` and load it as one cylinder, or give "
                "RigParameters"
            )
        low, high = machine.joint_limits[0]
        q = np.linspace(low, high, 5)[:, np.newaxis]
        slope = machine.stroke_jacobian(q)[:, 0, 0]
        mass = machine.mass_matrix(q, payload=payload)[:, 0, 0] / slope**2
        weight = -machine.static_cylinder_force(q, payload=payload)[:, 0]
        if np.ptp(mass) > 1e-6 * mass.max() or np.ptp(weight) > 1e-6 * (np.abs(weight).max() + 1.0):
            raise InputError(
                f"mass and weight that the cylinder of {machine.name} feels change along its stroke; a friction rig "
                f"moves its load along a straight line"
            )
        areas, stroke = machine.piston_areas[0], machine.stroke_limits[0]
        return cls(
            float(areas[0]), float(areas[1]), float(mass[0]), float(weight[0] / mass[0]), float(rod_mass),
            (float(stroke[0]), float(stroke[1])), _slip(machine),
        )  # fmt: skip


def _slip(machine: Machine) -> float:
    """Break-away force over bristle stiffness, m; 0 for a machine without bristles."""
    stiffness = [key for key in machine.keys if key.startswith("friction.") and key.endswith(".bristle-stiffness")]
    if not stiffness:
        return 0.0
    seal = stiffness[0].rsplit(".", 1)[0]
    return float(np.max(machine.value(f"{seal}.breakaway").si) / machine.value(stiffness[0]).si)


def pressure_force(log: Log, rig: RigParameters) -> Array:
    """p1 A1 - p2 A2 (n,), N."""
    return log["p1"] * rig.piston_area - log["p2"] * rig.rod_area


def steady_friction(log: Log, rig: RigParameters, *, load_cell: bool = False) -> Array:
    """Friction force (n,) at constant velocity, N; positive against positive velocity   (120)."""
    if load_cell:
        return pressure_force(log, rig) - log["force"] + rig.rod_mass * rig.gravity
    return pressure_force(log, rig) + rig.mass * rig.gravity


def friction_force(log: LogLike, rig: RigParameters | MachineLike, *, load_cell: bool = False) -> xr.Dataset:
    """Friction force over time, N: F = p1 A1 - p2 A2 + m g - m x''   (118, with the sign of erratum E17).

    With `load_cell` the measured net force includes the load's weight and inertia, so only `rod_mass` remains in the
    balance.

    Parameters
    ----------
    log : Log
        Or anything that :meth:`Log.of` takes. With ``x``, ``p1``, ``p2``, and ``force`` for `load_cell`.
    rig : RigParameters, Machine, or the name or path of one
    load_cell : bool

    Returns
    -------
    xarray.Dataset
        Over evenly spaced ``time``: ``friction``, ``velocity``, ``acceleration`` and their standard uncertainties
        ``friction_error``, ``velocity_error``, ``acceleration_error``; NaN where the log has gaps.
    """
    rig = rig if isinstance(rig, RigParameters) else RigParameters.of(rig)
    signals = ("x", "p1", "p2", *(("force",) if load_cell else ()))
    log = resample(at_common_rate(Log.of(log).usable(*signals), *signals))
    table = {name: np.full(log.time.size, np.nan) for name in _UNITS}
    rate = (log.time.size - 1) / (log.time[-1] - log.time[0])
    noise = noise_of(log["x"])
    for a, b in unbroken(log, *signals):
        motion = derivative(log["x"][a:b], rate, 1, noise=noise), derivative(log["x"][a:b], rate, 2, noise=noise)
        for name, found in zip(("velocity", "acceleration"), motion):
            table[name][a:b], table[f"{name}_error"][a:b] = found.value, found.error
    mass = rig.rod_mass if load_cell else rig.mass
    table["friction"] = steady_friction(log, rig, load_cell=load_cell) - mass * table["acceleration"]
    table["friction_error"] = np.sqrt(
        _reading_variance(log, rig, load_cell) + (mass * table["acceleration_error"]) ** 2
    )
    data = xr.Dataset(coords={"time": log.data["time"]}, attrs={"source": log.source})
    for name, (unit, text) in _UNITS.items():
        data[name] = ("time", table[name], {"units": unit, "long_name": text})
    return data


def _reading_variance(log: Log, rig: RigParameters, load_cell: bool) -> float:
    """Variance of one sample of p1 A1 - p2 A2 (- force), N^2."""
    parts = [(log["p1"], rig.piston_area), (log["p2"], rig.rod_area)] + ([(log["force"], 1.0)] if load_cell else [])
    return float(sum((noise_of(values).total * factor) ** 2 for values, factor in parts))


_UNITS = {
    "friction": ("N", "friction force, positive against positive velocity"),
    "friction_error": ("N", "standard uncertainty of the friction force"),
    "velocity": ("m/s", "piston velocity"),
    "velocity_error": ("m/s", "standard uncertainty of the velocity"),
    "acceleration": ("m/s^2", "piston acceleration"),
    "acceleration_error": ("m/s^2", "standard uncertainty of the acceleration"),
}
