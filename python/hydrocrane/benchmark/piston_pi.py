"""A simple controller for comparison: PI on each piston, speed feed-forward, pressure feedback.

It needs no model of the oil. The stick moves a set-point of the tip; joint rates follow by a
weighted pseudo-inverse of the Jacobian, and each spool opens by

    u = v_ref / v_full + (k_p e + k_i int e dt - k_f HP(F) / A) / v_full

with e the error of the piston, v_full the steady speed at full opening and HP(F) the cylinder force after a high-pass.
A missing reading keeps its last value; without any pressure it does not run. Pressure feedback of this kind is
standard: N. D. Manring, R. C. Fales, Hydraulic Control Systems, 2nd edition (2019).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array
from hydrocrane.control.controllers import Observation
from hydrocrane.control.joystick import Stick
from hydrocrane.errors import InputError
from hydrocrane.machine.machine import Machine

# Share of the pistons' speeds for the set-point; the rest is for corrections.
RESERVE = 0.9
# Share of its range within which a joint slows down before its limit.
SLOW_DOWN = 0.02
# Dead band of the error while the set-point is at rest, m.
REST_BAND = 5e-4
# Damping of the pseudo-inverse near singularities, relative to the largest singular value squared.
DAMPING = 1e-6


@dataclass
class PistonPi:
    """PI with speed feed-forward and pressure feedback, one per piston.

    Attributes
    ----------
    proportional : float
        k_p, 1/s.
    integral : float
        k_i, 1/s^2.
    pressure : float
        k_f, speed per high-passed pressure (force over the piston's area), m/(s Pa).
    corner : float
        Corner of the high-pass, rad/s.
    set_point : (2,) array
        Set-point of the tip, m; recorded with a run.
    """

    # By `hydrocrane control tune rottne-f9-lab --controller pi --trials 300`.
    proportional: float = 1.784
    integral: float = 8.0
    pressure: float = 3.125e-10
    corner: float = 16.97
    set_point: Array = field(default_factory=lambda: np.zeros(2), init=False)

    def reset(self, machine: Machine, obs: Observation) -> None:
        """Restart at rest in the pose of the crane.

        Raises
        ------
        InputError
            If a joint or a chamber pressure has no reading.
        """
        if not (np.isfinite(obs.q).all() and np.isfinite(obs.p).all()):
            raise InputError("`pi` needs a sensor for every joint and every chamber pressure; one gives no reading")
        self._machine, self._t, self._q = machine, obs.t, np.array(obs.q)
        self._read_q, self._read_p = np.array(obs.q), np.array(obs.p)
        self._area = machine.piston_areas[:, 0]
        self._sum = np.zeros(len(self._area))
        self._slow = self._load(self._read_p)
        self.set_point = machine.tip(self._q)

    def step(self, obs: Observation, command: Stick) -> ArrayLike:
        """Spool commands (n_cyl,), m."""
        period, self._t = obs.t - self._t, obs.t
        self._read_q = np.where(np.isfinite(obs.q), obs.q, self._read_q)
        self._read_p = np.where(np.isfinite(obs.p), obs.p, self._read_p)
        fastest = np.maximum(np.abs(self._machine.piston_speeds(self._q)), 1e-4)
        lever_arm = np.diagonal(self._machine.stroke_jacobian(self._q))
        rates = self._rates(command.velocity, fastest / np.maximum(np.abs(lever_arm), 1e-6)[:, np.newaxis])
        self._q = self._q + period * rates
        self.set_point = self._machine.tip(self._q)

        error = self._machine.strokes(self._q) - self._machine.strokes(self._read_q)
        moving = rates.any()
        held = ~moving & (np.abs(error) < REST_BAND)
        error = np.where(held, 0.0, error)
        load = self._load(self._read_p)
        self._slow = self._slow + (1.0 - np.exp(-self.corner * period)) * (load - self._slow)
        wanted = lever_arm * rates + self.proportional * error + self.integral * self._sum
        wanted = wanted - self.pressure * (load - self._slow)
        full = fastest[np.arange(len(wanted)), (wanted > 0.0).astype(int)]
        share = wanted / full
        # Anti-windup: no integration at full speed.
        self._sum = self._sum + np.where(np.abs(share) < 1.0, period * error, 0.0)
        return self._opened(np.clip(share, -1.0, 1.0))

    def _load(self, p: Array) -> Array:
        """Force over the piston's area, Pa."""
        areas = self._machine.piston_areas
        force: Array = (p[:, 0] * areas[:, 0] - p[:, 1] * areas[:, 1]) / self._area
        return force

    def _opened(self, share: Array) -> Array:
        """Spool positions (n_cyl,), m, for shares of the full speed."""
        return np.where(np.abs(share) < 1e-4, 0.0, self._machine.spool_positions(share))

    def _rates(self, velocity: Array, fastest: Array) -> Array:
        """Joint rates (n,) for a tip velocity (2,), limited to the speed of the pistons; `fastest` (n, 2) of the
        joints."""
        if not np.any(velocity):
            return np.zeros(len(self._q))
        jacobian = self._machine.tip_jacobian(self._q)
        free = np.ones(len(self._q))
        lower, upper = self._machine.joint_limits.T
        for _ in range(2):
            ease = free * fastest.min(axis=1) ** 2
            square = jacobian * ease @ jacobian.T
            square = square + DAMPING * np.trace(square) * np.eye(2)
            rates: Array = ease * (jacobian.T @ np.linalg.solve(square, velocity))
            room = np.where(rates > 0.0, upper - self._q, self._q - lower) / (upper - lower)
            if (room > SLOW_DOWN).all():
                break
            free = np.clip(room / SLOW_DOWN, 1e-6, 1.0)
        limit = RESERVE * np.where(rates > 0.0, fastest[:, 1], fastest[:, 0])
        return rates / max(1.0, float(np.max(np.abs(rates) / limit)))
