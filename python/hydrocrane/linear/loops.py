"""Loop gain and margins of the cylinders' sampled PID loops on a linear model.

The plant is sampled exactly: commands are held over a period and arrive after the delay. The gains are determined by
stepping the controller, so they are those of a run.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import Array, brief, positive_number, real_array
from hydrocrane.control.controllers import DEFAULT_PERIOD, Observation
from hydrocrane.control.joystick import Stick
from hydrocrane.control.named import NamedController
from hydrocrane.errors import InputError
from hydrocrane.linear.command_path import common_delay
from hydrocrane.linear.linearise import linearise
from hydrocrane.linear.margins import Margins, margins
from hydrocrane.machine.machine import Machine, MachineLike, as_machine
from hydrocrane.state_space.model import LinearModel
from hydrocrane.state_space.options import Friction, Side
from hydrocrane.state_space.responses import balanced, sampled, transfer

# Controllers with linear loops, and why the others have none.
LINEAR = "heinze-pid"
_NO_LOOP = {
    "lever": "`lever` sends the sticks to the spools and measures nothing: it has no loop",
    "tip": "`tip` plans, learns and switches: it has no loop gain; try it in closed loop with hc.simulate",
}
# Error for the measurement of the gains, rad or m; far below the limits of the command.
_ERROR = 1e-4
# Lowest frequency of a loop, rad/s; a loop with an integrator has its crossover above.
_LOWEST = 1e-6
# Tolerance of the spectral radius for rounding and a lossless mode of the oil.
_RADIUS = 1.0 + 1e-9
# Halvings of all gains that are tried to make the loops stable.
_HALVINGS = 12


@dataclass(frozen=True)
class PidGains:
    """Gains of a PID in velocity form, per sample, m of spool per rad or m of the joint.

    Law (128)-(130) of the thesis: du = kp (e - e1) + ki e + kd (e - 2 e1 + e2).
    """

    proportional: float
    integral: float
    derivative: float

    def at(self, z: np.ndarray) -> np.ndarray:
        """Its transfer function at complex points z."""
        kp, ki, kd = self.proportional, self.integral, self.derivative
        back = 1.0 / z
        return (kp + ki + kd - (kp + 2 * kd) * back + kd * back**2) / (1.0 - back)


@dataclass(frozen=True)
class Loop:
    """The loop of one cylinder, opened at its command, the loops of the other cylinders closed.

    Attributes
    ----------
    cylinder, joint : str
    gains : PidGains
    period, delay : float
        s; the delay is that from a sample until its command arrives at the spool.
    omega : (m,) array
        rad/s, up to half the sampling frequency.
    gain : (m,) complex array
        Loop gain; the loop is closed by subtracting.
    margins : Margins
        They are meaningful only if all loops together are stable.
    stable : bool
        Whether all loops closed together decay; from the eigenvalues, not from the margins.
    radius : float
        Largest magnitude of those eigenvalues, per sample.
    advice : str
        Why all loops together are unstable and what makes them stable; empty if they are.
    """

    cylinder: str
    joint: str
    gains: PidGains
    period: float
    delay: float
    omega: Array
    gain: np.ndarray
    margins: Margins
    stable: bool
    radius: float
    advice: str = ""

    __repr__ = brief

    @property
    def growth(self) -> float:
        """Rate of the slowest decay, negative, or of the fastest growth of all loops together, 1/s."""
        return float(np.log(self.radius) / self.period)


def pid_gains(machine: MachineLike, controller: str = LINEAR) -> dict[str, PidGains]:
    """Gains of each cylinder's loop by the cylinder's name, determined by stepping the controller.

    Raises
    ------
    InputError
        A controller without linear loops, or a machine that it cannot control.
    """
    machine = as_machine(machine)
    if controller != LINEAR:
        why = _NO_LOOP.get(controller, f"`{controller}` is no controller with linear loops")
        raise InputError(f"{why}; choose {LINEAR}, or give the gains with gains=")
    low, high = machine.joint_limits.T
    turning = np.array(machine.joint_units) == "rad"
    pose = np.where(turning, machine.home, np.clip(0.0, low, high))
    signs = np.sign(np.diagonal(machine.stroke_jacobian(pose)))
    stepped = NamedController(controller, machine, monitor=False)
    period = stepped.period
    stepped.reset(machine, _seen(machine, 0.0, pose))
    commands = []
    for sample, q in enumerate([pose, *[pose - _ERROR] * 3]):
        commands.append(stepped.step(_seen(machine, sample * period, q), Stick("tip", np.zeros(2))))
        if stepped.fault:
            raise InputError(f"{controller} has no command for {machine.name}: {stepped.fault}")
    first, second, third = np.diff(commands, axis=0) * signs / _ERROR
    derivative = third - second
    found = np.stack([first - third - derivative, third, derivative], axis=-1)
    return {c: PidGains(*map(float, row)) for c, row in zip(machine.cylinder_names, found, strict=True)}


def cylinder_loops(
    machine: MachineLike,
    q: ArrayLike,
    *,
    controller: str = LINEAR,
    gains: dict[str, PidGains] | None = None,
    period: float | None = None,
    delay: float = 0.0,
    command: ArrayLike | None = None,
    payload: float | None = None,
    friction: Friction = "released",
    side: Side = "extend",
) -> list[Loop]:
    """Loop gain and margins of every cylinder in pose q (n,).

    Parameters
    ----------
    machine : Machine, str or path
    q : (n,) array_like
        rad or m.
    controller : {"heinze-pid"}
        Controller with the gains.
    gains : dict of PidGains, optional
        Gains of your own PID, by cylinder; sign and form as for the controller.
    period : float, optional
        s; by default the controller's for this machine.
    delay : float
        Computation delay, s. The machine's own delay of signal chain and valve is added.
    command, payload, friction, side
        As of :func:`~hydrocrane.linear.linearise`; the gain of a closed valve differs between the sides.

    Raises
    ------
    InputError
        A controller without linear loops, or valves in their dead band: the loop gain is zero there.
    """
    machine = as_machine(machine)
    known = pid_gains(machine, controller) if gains is None else gains
    missing = [c for c in machine.cylinder_names if c not in known]
    if missing:
        raise InputError(f"gains lack the cylinder {missing[0]}; give one PidGains for each of the cylinders")
    if period is None:
        period = NamedController(controller, machine).period if gains is None else DEFAULT_PERIOD
    positive_number("period", period)
    late = float(real_array(delay, "delay"))
    if late < 0:
        raise InputError(f"delay must be zero or more seconds, got {delay!r}")
    late += common_delay(machine)
    outputs = [f"joint.{joint}.q" for joint in machine.joint_names]
    model = linearise(machine, q, command=command, outputs=outputs, payload=payload, friction=friction, side=side)
    if dead := [str(warning) for warning in model.warnings if warning.kind == "valve-in-dead-band"]:
        raise InputError(f"{dead[0]}; there the loop gain is zero")
    pids = [known[c] for c in machine.cylinder_names]
    signs = np.sign(np.diagonal(machine.stroke_jacobian(np.asarray(q, dtype=np.float64))))
    plant = _Sampled(model, float(period), late)
    fastest = plant.fastest(pids, signs)
    stable = abs(fastest) < _RADIUS

    def opened(omega: Array) -> list[np.ndarray]:
        z = np.exp(1j * omega * period)
        controls = np.stack([sign * pid.at(z) for sign, pid in zip(signs, pids, strict=True)], axis=-1)
        response = plant.response(z)
        return [_one_open(response, controls, i) for i in range(len(pids))]

    grid = _grid(model, np.pi / period)
    advice = "" if stable else _advice(model, plant, pids, signs, fastest, opened)
    found = []
    for i, (cylinder, joint, gain) in enumerate(
        zip(machine.cylinder_names, machine.joint_names, opened(grid), strict=True)
    ):
        at = margins(grid, gain, lambda omega: opened(omega)[i])
        found.append(Loop(cylinder, joint, pids[i], float(period), late, grid, gain, at, stable, abs(fastest), advice))
    return found


def _advice(
    model: LinearModel,
    plant: _Sampled,
    pids: list[PidGains],
    signs: Array,
    fastest: complex,
    opened: Callable[[Array], list[np.ndarray]],
) -> str:
    """What grows and why, and changes that were tried and make all loops stable."""
    proportional = [PidGains(p.proportional, 0.0, p.derivative) for p in pids]
    time = plant.period / np.log(abs(fastest))
    if _steady(fastest):
        integral = not _steady(plant.fastest(proportional, signs))
        cause = "the integral parts drive it" if integral else "also without integral parts: is a sign of a gain wrong?"
        why = f"the error grows steadily, without an oscillation, e-fold in {time:.2g} s; {cause}"
    else:
        why = _oscillation(model, abs(np.angle(fastest)) / plant.period, time, opened)
    cures = []
    if share := _stable_share(plant, pids, signs):
        cures.append(f"all gains times {share:.2g}")
    elif share := _stable_share(plant, proportional, signs):
        cures.append(f"no integral part and all other gains times {share:.2g}")
    if plant.delay and abs(_Sampled(model, plant.period, 0.0).fastest(pids, signs)) < _RADIUS:
        cures.append(f"no delay in place of {plant.delay * 1e3:.3g} ms")
    if not cures:
        cures = ["neither smaller gains nor a shorter delay; add damping, or take `tip`"]
    return f"unstable: {why}; what makes it stable: {', or '.join(cures)}"


def _steady(eigenvalue: complex) -> bool:
    """Whether what grows with this eigenvalue per sample does so without changing its sign."""
    return eigenvalue.imag == 0.0 and eigenvalue.real > _RADIUS


def _oscillation(model: LinearModel, omega: float, time: float, opened: Callable[[Array], list[np.ndarray]]) -> str:
    """An oscillation of `omega`, rad/s, with the nearest natural mode and the loop that feeds it."""
    cylinders = [name.split(".")[1] for name in model.input_names]
    gains = [abs(complex(gain[0])) for gain in opened(np.array([omega]))]
    worst = int(np.argmax(gains))
    hertz = model.oscillations.frequency
    near = int(np.argmin(np.abs(hertz * 2 * np.pi - omega))) if hertz.size else -1
    mode = f" (next natural mode: {hertz[near]:.3g} Hz in {model.oscillations.state[near]})" if hertz.size else ""
    return (
        f"an oscillation of {omega / (2 * np.pi):.3g} Hz{mode} grows e-fold in {time:.2g} s; there the loop of "
        f"{cylinders[worst]} has a gain of {gains[worst]:.2g}"
    )


def _stable_share(plant: _Sampled, pids: list[PidGains], signs: Array) -> float | None:
    """Largest common factor of all gains, to 2 % and below one, with which all loops together are stable."""

    def stable(share: float) -> bool:
        scaled = [PidGains(*(share * gain for gain in (p.proportional, p.integral, p.derivative))) for p in pids]
        return abs(plant.fastest(scaled, signs)) < _RADIUS

    low, high = next((0.5**k, 0.5 ** (k - 1)) for k in range(1, _HALVINGS + 1) if k == _HALVINGS or stable(0.5**k))
    if not stable(low):
        return None
    while high > 1.02 * low:
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if stable(middle) else (low, middle)
    # Rounded down in print.
    return 0.98 * low


class _Sampled:
    """The plant from commands to joints at the samples: x+ = F x + G0 u + G1 u_before, with whole samples of delay."""

    def __init__(self, model: LinearModel, period: float, delay: float) -> None:
        self.period, self.delay = period, delay
        a, b, self.c = balanced(model.A, model.B, model.C)
        self.whole = int(delay // period)
        late = delay - self.whole * period
        self.moved, _ = sampled(a, b, period)
        rest, self.now = sampled(a, b, period - late)
        self.before = rest @ sampled(a, b, late)[1]

    def response(self, z: np.ndarray) -> np.ndarray:
        """Gains (m, n_joints, n_cyl) at points z on the unit circle."""
        inputs = self.now.shape[1]
        both = np.hstack([self.now, self.before])
        gains = transfer(self.moved, both, self.c, np.zeros((len(self.c), 2 * inputs)), z)
        now, before = gains[..., :inputs], gains[..., inputs:]
        back = (1.0 / z)[:, None, None]
        return (now + before * back) * back**self.whole

    def fastest(self, pids: list[PidGains], signs: Array) -> complex:
        """The eigenvalue per sample of the largest magnitude with every loop closed."""
        n, inputs = self.now.shape
        kp, ki, kd = (np.array([getattr(p, k) for p in pids]) for k in ("proportional", "integral", "derivative"))
        # States: plant, last two errors, the last commands, newest first.
        kept = self.whole + 1
        size = n + 2 * inputs + kept * inputs
        first, last = n + 2 * inputs, np.eye(inputs)
        error = np.zeros((inputs, size))
        error[:, :n] = -signs[:, None] * self.c
        command = (kp + ki + kd)[:, None] * error
        command[:, n : n + inputs] -= np.diag(kp + 2 * kd)
        command[:, n + inputs : first] += np.diag(kd)
        command[:, first : first + inputs] += last
        history = [command] + [
            np.hstack([np.zeros((inputs, first + k * inputs)), last, np.zeros((inputs, (kept - 1 - k) * inputs))])
            for k in range(kept)
        ]
        step = np.zeros((size, size))
        step[:n, :n] = self.moved
        step[:n] += self.now @ history[self.whole] + self.before @ history[self.whole + 1]
        step[n : n + inputs] = error
        step[n + inputs : first, n : n + inputs] = last
        step[first:] = np.vstack(history[:kept])
        found = np.linalg.eigvals(step)
        return complex(found[np.argmax(np.abs(found))])


def _one_open(plant: np.ndarray, controls: np.ndarray, cylinder: int) -> np.ndarray:
    """Loop gain (m,) at one command, from plant (m, n, n) and controllers (m, n), all others closed."""
    others = [k for k in range(controls.shape[1]) if k != cylinder]
    own = plant[:, cylinder, cylinder]
    if others:
        crossed = controls[:, others, None] * plant[:, others][:, :, others]
        back = np.linalg.solve(
            np.eye(len(others)) + crossed, controls[:, others, None] * plant[:, others][:, :, [cylinder]]
        )
        own = own - (plant[:, [cylinder]][:, :, others] @ back)[:, 0, 0]
    return controls[:, cylinder] * own


def _grid(model: LinearModel, highest: float) -> Array:
    """Angular frequencies, dense around the resonances, below the highest one."""
    near = np.geomspace(1e-6, 0.3, 200)
    peaks = 2 * np.pi * model.oscillations.frequency
    close = [peak * (1 + side * near) for peak in peaks for side in (-1.0, 1.0)]
    every = np.concatenate([np.geomspace(_LOWEST, 0.999 * highest, 2000), *close])
    return np.unique(every[(every > 0) & (every < highest)])


def _seen(machine: Machine, t: float, q: Array) -> Observation:
    n = len(machine.joint_names)
    return Observation(t, q, np.zeros(n), np.zeros((len(machine.cylinder_names), 2)), machine.tip(q), {})
