"""The search for windows of steady motion in a log. Theory: docs/theory/signals/steady_windows.md"""

from __future__ import annotations

import numpy as np

from hydrocrane.errors import InputError
from hydrocrane.logs.columns import LogLike
from hydrocrane.logs.hum import at_mains, hum_of
from hydrocrane.logs.log import Log
from hydrocrane.logs.noise import Noise, noise_before_rounding, noise_of
from hydrocrane.machine.machine import Machine
from hydrocrane.signals.friction import RigParameters, pressure_force, steady_friction
from hydrocrane.signals.resample import readable, unbroken
from hydrocrane.signals.segments import LEAST_SAMPLES, command_changes, straight_pieces
from hydrocrane.signals.steadiness import (
    MARGIN,
    OSCILLATION_SHARE,
    Piece,
    WindowMotion,
    mean_force,
    motion_of,
    oscillation,
    settled,
)
from hydrocrane.signals.window_checks import checked_windows
from hydrocrane.signals.windows import Rejected, SteadyWindows, Window

# Allowance for a sensor's slow noise, which neighbouring samples do not show, as a factor on its fast noise.
WAVINESS = 1.3
# Velocities of neighbouring pieces that differ by less than this share belong to one motion.
SAME_SPEED = 0.3
# Travel in bristle slips that is left out at the start of a piece, and its largest share of the piece.
LEFT_OUT_SLIPS, LEFT_OUT_SHARE = 6.0, 0.6
# Largest deviation of a steady piece from a straight line, as a share of its travel: velocity is constant within about
# 5 %.
STRAIGHTNESS = 0.002


def steady_windows(
    log: LogLike,
    rig: RigParameters | Machine | str,
    *,
    load_cell: bool = False,
    least_duration: float = 0.2,
    least_travel: float = 5e-4,
    settle_travel: float | None = None,
    straightness: float = STRAIGHTNESS,
) -> SteadyWindows:
    """Find the windows of constant velocity in a log, with mean velocity and friction of each   (thesis 5.2.2).

    Parameters
    ----------
    log : Log
        A log or any argument of :meth:`Log.of`, such as a log of the virtual rig. It needs ``x``, ``p1``, ``p2``, and
        ``force`` for `load_cell`; a ``command`` helps to find the pieces.
    rig : RigParameters, Machine, or the name or path of one
    load_cell : bool
        Take the load's weight from the load cell, see :func:`friction_force`.
    least_duration, least_travel : float
        Least duration and travel after the transient, s and m.
    settle_travel : float, optional
        Least travel to leave out at the start of each piece, m. The default is six bristle slips if the rig's file has
        them, but at most 60 % of a piece. A visible transient is removed in any case.
    straightness : float
        Deviation from a straight line that counts as constant velocity, as a share of the travel.

    Returns
    -------
    SteadyWindows
        Empty, with the reasons, if nothing is steady.
    """
    rig = rig if isinstance(rig, RigParameters) else RigParameters.of(rig)
    for name, value in (("least_duration", least_duration), ("least_travel", least_travel)):
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"{name} must be positive and finite, got {value!r}")
    if not ((settle_travel is None or settle_travel >= 0) and straightness >= 0):
        raise InputError("settle_travel and straightness must not be negative")
    signals = ("x", "p1", "p2", *(("force",) if load_cell else ()))
    given = Log.of(log).usable(*signals)
    log = readable(given, *signals)
    limits = (least_duration, least_travel, settle_travel)
    found = _WindowReader(log, rig, load_cell, limits, _pieces(log, signals, straightness)).judged()
    windows = tuple(w for w in found if isinstance(w, Window))
    rejected = tuple(r for r in found if isinstance(r, Rejected))
    return SteadyWindows(
        windows, rejected, (*given.flags, *checked_windows(given, rig, windows)), given, rig, load_cell
    )


def _pieces(log: Log, signals: tuple[str, ...], straightness: float) -> list[tuple[int, int]]:
    """Straight pieces between gaps, changes of the command and spoilt stretches."""
    time, x, noise = log.time, log["x"], _position_noise(log)
    edges = np.flatnonzero(np.diff(log.stuck(*signals).astype(np.int8))) + 1
    cuts = sorted({*_jumps(log), *edges.tolist()})
    pieces = []
    # A position is not known better than a micrometre. A reading that alternates between two codes has an error of half
    # a step.
    sigma = max(WAVINESS * float(np.hypot(noise.sigma, 0.5 * noise.step)), 1e-6)
    for a, b in unbroken(log, *signals):
        inner = straight_pieces(time[a:b], x[a:b], sigma, straightness, [cut - a for cut in cuts])
        pieces += [(a + first, a + last) for first, last in inner]
    return pieces


def _position_noise(log: Log) -> Noise:
    """Noise of the position within the sensor's range; at the end of its range there is none."""
    return noise_of(log["x"][~log.stuck("x")])


def _jumps(log: Log) -> list[int]:
    if "command" not in log or not np.isfinite(log["command"]).all():
        return []
    return command_changes(log["command"], *noise_of(log["command"]))


class _WindowReader:
    """Judges the straight pieces of a log."""

    def __init__(
        self,
        log: Log,
        rig: RigParameters,
        load_cell: bool,
        limits: tuple[float, float, float | None],
        pieces: list[tuple[int, int]],
    ) -> None:
        self.log, self.rig, self.time, self.x = log, rig, log.time, log["x"]
        self.least_duration, self.least_travel, self.settle_travel = limits
        self.noise = _position_noise(log)
        self.friction = steady_friction(log, rig, load_cell=load_cell)
        self.pressure_force = pressure_force(log, rig)
        self.parts = [log["p1"] * rig.piston_area, log["p2"] * rig.rod_area]
        factors = {"p1": rig.piston_area, "p2": rig.rod_area} | ({"force": 1.0} if load_cell else {})
        self.noises = {name: (noise_before_rounding(log[name]), factor) for name, factor in factors.items()}
        self.bad = log.stuck(*self.noises, "x")
        self.hums = hum_of(log.time, self.pressure_force, self.x)
        self.jumps = set(_jumps(log))
        self.pieces = pieces
        self.motions = [self._motion(a, b) for a, b in pieces]

    def judged(self) -> list[Window | Rejected]:
        found: list[Window | Rejected] = []
        for i, (a, b) in enumerate(self.pieces):
            if b - a < LEAST_SAMPLES:
                # A corner between two pieces is too short to be reported.
                continue
            result = self._piece(i, a, b)
            if isinstance(result, str):
                speed = self.motions[i].velocity
                found.append(Rejected(float(self.time[a]), float(self.time[b - 1]), speed, result))
            else:
                found.append(result)
        return found

    def _motion(self, a: int, b: int) -> WindowMotion:
        if b - a < LEAST_SAMPLES:
            return WindowMotion(float("nan"), float("inf"), 0.0)
        return motion_of(self.time[a:b], self.x[a:b], self.noise)

    def _moves(self, i: int) -> bool:
        motion = self.motions[i]
        return abs(motion.velocity) > 4.0 * motion.error and abs(motion.travel) > self.least_travel

    def _piece(self, i: int, a: int, b: int) -> Window | str:
        """The window in piece i, samples a .. b - 1, or the reason why there is none."""
        time, whole = self.time, self.motions[i]
        if self.bad[a:b].any():
            return "a sensor is frozen or at the end of its range, see the flags"
        if time[b - 1] - time[a] < self.least_duration:
            return f"velocity is constant for {time[b - 1] - time[a]:.3g} s only"
        if not self._moves(i):
            return "the piston rests, or its motion is not visible"
        b -= int(MARGIN * (b - a))
        began = self._began(i)
        half = self._half_travel(began, b)
        piece = Piece(
            time[a:b],
            self.friction[a:b],
            [part[a:b] for part in self.parts],
            time[half:b],
            self.friction[half:b],
        )
        skipped = int(np.ceil((b - a) * self._left_out(abs(whole.travel))))
        first, reason = settled(piece, skipped, self._least_samples(whole.velocity))
        return reason if first is None else self._window(began, a + first, b)

    def _left_out(self, travel: float) -> float:
        """Share of a piece with this `travel`, m, that is left out at its start."""
        if self.settle_travel is None:
            return min(LEFT_OUT_SLIPS * self.rig.slip / travel, LEFT_OUT_SHARE)
        return min(self.settle_travel / travel, 1.0)

    def _began(self, i: int) -> int:
        """Sample at which the motion of piece i began: the last rest, reversal, gap or change of command or speed."""
        speed = self.motions[i].velocity
        first = i
        for j in range(i - 1, -1, -1):
            a, b = self.pieces[j]
            if b != self.pieces[j + 1][0] or b in self.jumps or self.bad[a:b].any():
                break
            motion = self.motions[j]
            if b - a >= LEAST_SAMPLES and abs(motion.velocity - speed) > SAME_SPEED * abs(speed) + 4.0 * motion.error:
                break
            first = j
            if self._moves(j):
                speed = motion.velocity
        return self.pieces[first][0]

    def _half_travel(self, began: int, b: int) -> int:
        """Sample at half of the displacement between sample `began` and sample b."""
        travel = np.abs(self.x[began:b] - self.x[began])
        return began + int(np.argmax(travel >= 0.5 * travel[-1]))

    def _least_samples(self, velocity: float) -> int:
        seconds = max(self.least_duration, self.least_travel / abs(velocity))
        rate = (self.time.size - 1) / (self.time[-1] - self.time[0])
        return max(int(np.ceil(seconds * rate)), 12)

    def _window(self, began: int, a: int, b: int) -> Window | str:
        time = self.time[a:b]
        motion = self._motion(a, b)
        if motion.error > 0.1 * abs(motion.velocity):
            return f"velocity is known to {motion.error / abs(motion.velocity):.0%} only; record for longer"
        swing, frequency = oscillation(time, self.pressure_force[a:b], self.rig.mass, self.hums)
        if swing > OSCILLATION_SHARE * abs(motion.velocity):
            share = swing / abs(motion.velocity)
            reason = f"velocity swings by {share:.0%} at {frequency:.3g} Hz, so friction has no single value"
            return reason + ("; if it is mains hum, log some seconds at rest to check" if at_mains(frequency) else "")
        readings = [(self.log[name][a:b], noise, factor) for name, (noise, factor) in self.noises.items()]
        force, error, effective = mean_force(time, self.friction[a:b], readings)
        return Window(
            start=float(time[0]),
            end=float(time[-1]),
            velocity=motion.velocity,
            velocity_error=motion.error,
            force=force,
            force_error=error,
            direction=1 if motion.velocity > 0 else -1,
            samples=b - a,
            effective_samples=effective,
            chambers=(float(self.parts[0][a:b].mean()), float(self.parts[1][a:b].mean())),
            position=float(self.x[a:b].mean()),
            before=abs(float(self.x[a] - self.x[began])),
        )
