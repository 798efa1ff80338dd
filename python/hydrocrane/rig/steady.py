"""The rig in steady motion: spool opening and pressures as functions of velocity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError
from hydrocrane.machine.machine import Machine


@dataclass(frozen=True)
class SteadyMotion:
    """Motion at constant velocity: spool (m), pressures (Pa), velocity (m/s), friction (N)."""

    velocity: float
    spool: float
    p1: float
    p2: float
    friction: float


def steady_motion(machine: Machine, velocity: float, *, payload: float | None = None) -> SteadyMotion:
    """Spool and pressures that move the rig's piston at a constant `velocity` (m/s, not zero) in mid-stroke.

    The pressures balance load and friction (83) and are constant (105), (106): metering edges and leakage pass the flow
    that the piston displaces.

    Raises
    ------
    InputError
        If valve or supply cannot move it this fast.
    """
    speed = real_array(velocity, "velocity")
    if speed.ndim or speed == 0:
        raise InputError(f"velocity must be one number other than zero, in m/s; got {velocity!r}")
    balance = _Balance(machine, float(speed), machine.payload(payload))
    found = balance.solution(balance.guess())
    faster = 1
    # The guess is poor if leakage is most of the flow: continue from faster motions.
    while found is None and faster < FASTEST:
        faster *= 2
        found = _slowed(machine, float(speed), balance.payload, faster)
    if found is None:
        raise InputError(
            f"{machine.name} cannot move {float(speed):g} m/s steadily with {balance.payload:g} kg at"
            f" {machine.supply_pressure / 1e5:g} bar; ask for a slower motion or increase supply.pressure"
        )
    p1, p2, spool = found
    return SteadyMotion(float(speed), float(spool), float(p1), float(p2), balance.friction)


# Largest ratio of the speeds in this continuation.
FASTEST = 64


def _slowed(machine: Machine, velocity: float, payload: float, faster: int) -> Array | None:
    """Pressures (Pa) and spool (m) at `velocity`, by continuation from the motion that is `faster` times as fast, in
    steps of half the speed."""
    balance = _Balance(machine, faster * velocity, payload)
    found = balance.solution(balance.guess())
    while found is not None and faster > 1:
        faster //= 2
        balance = _Balance(machine, faster * velocity, payload)
        found = balance.solution(found * [1.0, 1.0, 0.5] / balance.scale)
    return found


class _Balance:
    """Three equations for both pressures and the spool, scaled to order one."""

    def __init__(self, machine: Machine, velocity: float, payload: float) -> None:
        self.machine, self.velocity, self.payload = machine, velocity, payload
        self.areas = machine.piston_areas[0]
        self.friction = float(machine.friction_map(velocity))
        self.force = float(machine.static_cylinder_force([0.0], payload=payload)[0]) + self.friction
        cylinder = machine.cylinder_names[0]
        self.places = [machine.state_names.index(f"cylinder.{cylinder}.{name}") for name in ("p1", "p2", "xs")]
        full = float(machine.spool_strokes[0])
        # Piston speed for the flow at full opening and half the supply pressure as drop.
        flow = float(machine.orifice_flow(full, 0.5 * machine.supply_pressure))
        self.opening = full * abs(velocity) * self.areas[0] / flow
        self.scale = np.array([1e5, 1e5, self.opening])
        self.moving = machine.pack_state([0.0], [velocity])

    def guess(self) -> Array:
        """Start values: equal openings, no leakage, turbulent flow."""
        (a1, a2), supply = self.areas, self.machine.supply_pressure
        ratio = (a1 / a2) ** 2
        if self.velocity > 0:
            p2 = (supply * a1 - self.force) / (a2 + ratio * a1)
            p1 = supply - ratio * p2
        else:
            p1 = (supply * a2 + self.force) / (a1 + a2 / ratio)
            p2 = supply - p1 / ratio
        return np.array([p1 / 1e5, p2 / 1e5, np.sign(self.velocity)])

    def solution(self, guess: Array) -> Array | None:
        """Both pressures (Pa) and the spool (m), if the solution from the `guess` converges and is admissible."""
        from scipy.optimize import root

        found = root(self.residual, guess, tol=1e-12)
        p1, p2, spool = values = found.x * self.scale
        solved = np.abs(self.residual(found.x)).max() < 1e-6
        possible = abs(spool) <= float(self.machine.spool_strokes[0]) and min(p1, p2) >= 0
        return np.asarray(values) if solved and possible else None

    def residual(self, unknowns: Array) -> Array:
        p1, p2, spool = values = unknowns * self.scale
        state = self.moving.copy()
        state[self.places] = values
        rates = self.machine.state_derivative(state, [spool], payload=self.payload)
        a1, a2 = self.areas
        # Change of the pressures while the piston moves 0.1 mm.
        change = rates[self.places[:2]] * 1e-4 / abs(self.velocity)
        return np.array([(p1 * a1 - p2 * a2 - self.force) / 100.0, *(change / 1e5)])


class SteadyValve:
    """Spool opening against velocity in both directions, by interpolation of steady motions."""

    def __init__(self, machine: Machine, fastest: float, payload: float) -> None:
        speeds = np.geomspace(min(5e-5, 0.1 * fastest), fastest, 12)
        self.motions = {sign: [steady_motion(machine, sign * v, payload=payload) for v in speeds] for sign in (1, -1)}
        self.speeds = speeds

    def spool(self, velocity: Array) -> Array:
        """Spool (m) for velocities (m/s); zero for zero."""
        speed = np.abs(velocity)
        found = np.zeros_like(speed)
        for sign, motions in self.motions.items():
            per_speed = np.array([motion.spool for motion in motions]) / self.speeds
            # The ratio of opening to velocity is nearly constant, unlike the opening itself.
            gain = np.interp(np.log(np.maximum(speed, 1e-12)), np.log(self.speeds), per_speed)
            found = np.where(np.sign(velocity) == sign, gain * speed, found)
        return found

    def pressures(self, direction: int) -> tuple[float, float]:
        """p1, p2 (Pa) in the middle of the speeds of one direction."""
        motion = self.motions[direction][len(self.speeds) // 2]
        return motion.p1, motion.p2
