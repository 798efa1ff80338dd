"""Analysis of a single pose: natural modes of small motions."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.analysis.poses import pose_grid
from hydrocrane.arrays import Array, brief
from hydrocrane.errors import InputError, check_known
from hydrocrane.machine.machine import Machine, MachineLike, as_machine
from hydrocrane.machine.poses import poses
from hydrocrane.notebook import card
from hydrocrane.result_warning import ResultWarning
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.state_space.options import Friction
from hydrocrane.state_space.oscillations import SHOWS_WELL, Oscillations, oscillations

# Share of a joint's range in which an end stop may act: its zone is a twentieth of the barrel or less.
_END_STOPS = 0.07


FRICTION = ("held", "released", "smoothed")
# Description of the friction of a result in tables and on pictures.
FRICTION_WORDS = {
    "held": "at rest: bristles (LuGre) hold the pistons, static friction is left out",
    "released": "in larger motions: friction has no derivative, bristles do not hold",
    "smoothed": "at rest, as simulated: smoothed static friction is a damper",
}
# Least number of records per period that shows an oscillation.
_SHOWS = 2
# Piston speed of differences, m/s; the force of an end stop is linear in it.
_SPEED = 1e-3
# Between these speeds, m/s, friction grows where its sign is smoothed, and is the same where the sign jumps.
_SLOW, _LESS_SLOW = 1e-12, 1e-6


@dataclass(frozen=True)
class Modes(Oscillations):
    """Small motions about rest in one pose, slowest oscillation first; damping is negative if a motion grows.

    Attributes
    ----------
    q : (n,) array
        The pose.
    friction : str
        Treatment of friction, as in :func:`modes`.
    warnings : tuple of ResultWarning
        Limits of the numbers.
    frequency, damping, state, eigenvalues, shapes
        As of the oscillations of any linear model.

    Examples
    --------
    >>> found = hc.modes("rottne-f9-lab", np.deg2rad([100.0, 100.0, 0.0]))
    >>> print(found.frequency[:2].round(1), found.state[0], bool((found.damping > 0).all()))
    [11.1 26.3] joint.boom.qd True
    """

    q: Array
    friction: str = "held"
    warnings: tuple[ResultWarning, ...] = ()

    __repr__ = brief

    def _repr_html_(self) -> str:
        rows = zip(self.frequency, self.damping, self.state, strict=True)
        lines = [f"{frequency:.4g} Hz  damping ratio {damping:.3g}, {state}" for frequency, damping, state in rows]
        doubts = [f"warning: {warning}" for warning in self.warnings]
        return card(
            f"Natural modes {FRICTION_WORDS[self.friction]}", [*lines, *doubts], "modes.frequency, modes.damping"
        )


def modes(machine: MachineLike, q: ArrayLike, *, payload: float | None = None, friction: Friction = "held") -> Modes:
    """Natural modes at the ``hold`` equilibrium of pose q (n,), valves closed.

    They are the eigenvalues of the exact Jacobian, without the slope of friction that is not a property of the crane. A
    mode is named after its largest participation factor, the product of the left and right eigenvector entries, which
    does not depend on the units of the states.

    Parameters
    ----------
    machine : Machine, str or path
    q : (n,) array_like
        rad or m.
    payload : float, optional
        kg at the tip; the machine's own by default.
    friction : {"held", "released", "smoothed"}
        ``held``: bristles (LuGre) hold the pistons, as long as the pistons move less than the bristle deflection;
        static friction, whose only slope at rest is that of its smoothing, is removed. ``released``: no friction
        and no bristles, as in motions much larger than that: the natural frequencies of links and oil.
        ``smoothed``: the Jacobian of the simulation at rest, with the smoothing of static friction.

    Examples
    --------
    >>> held = hc.modes("rottne-f9-lab", np.deg2rad([100.0, 100.0, 0.0]), payload=100.0)
    >>> free = hc.modes("rottne-f9-lab", np.deg2rad([100.0, 100.0, 0.0]), payload=100.0, friction="released")
    >>> print(held.frequency[0].round(1), free.frequency[0].round(1))
    5.3 5.3
    """
    machine = as_machine(machine)
    q = poses(machine, q)
    if q.ndim != 1:
        raise InputError(f"modes takes one pose of shape ({len(machine.joint_names)},), got shape {q.shape}")
    check_friction(friction)
    state, doubts = machine.rest(q, payload=payload)
    jacobian = machine.jacobian(state, np.zeros(len(machine.cylinder_names)), payload=payload)
    warnings = smoothing_warnings(machine, jacobian, state, payload, friction)
    found = oscillations(with_friction(machine, jacobian, state, payload, friction), machine.state_names)
    warnings = (*doubts, *warnings, *_recording_warning(found.frequency))
    return Modes(**vars(found), q=q, friction=friction, warnings=warnings)


def check_friction(friction: str) -> None:
    """Raises an :class:`InputError` if `friction` is none of :data:`FRICTION`."""
    check_known("friction of modes", friction, FRICTION)


def with_friction(machine: Machine, jacobian: Array, state: Array, payload: float | None, friction: Friction) -> Array:
    """The Jacobian at rest with the derivative of friction for the treatment `friction`, as in :func:`modes`."""
    if friction == "smoothed":
        return jacobian
    smoothed = _smoothed(machine)
    freed = np.ones_like(smoothed) if friction == "released" else smoothed
    return _released(machine, jacobian, state, payload, freed)


def smoothing_warnings(
    machine: Machine, jacobian: Array, state: Array, payload: float | None, friction: Friction
) -> tuple[ResultWarning, ...]:
    """Warnings on the effect of the smoothing of static friction on the Jacobian at rest."""
    return _smoothing_warning(
        machine, _friction_slopes(machine, jacobian, state, payload), _smoothed(machine), friction
    )


def modes_to_show(machine: Machine, q: ArrayLike, *, payload: float | None = None) -> list[Modes]:
    """The modes for the given friction, and those that a table shows beside them, each warning once.

    With bristles these are the released modes, as in larger motions; with static friction the smoothed ones.
    """
    shown = [modes(machine, q, payload=payload)]
    if any(name.endswith(".z") for name in machine.state_names):
        shown.append(modes(machine, q, payload=payload, friction="released"))
    if _smoothed(machine).any():
        shown.append(modes(machine, q, payload=payload, friction="smoothed"))
    first = {warning.kind for warning in shown[0].warnings}
    rest = [replace(m, warnings=tuple(w for w in m.warnings if w.kind not in first)) for m in shown[1:]]
    return [shown[0], *rest]


def _released(machine: Machine, jacobian: Array, state: Array, payload: float | None, freed: np.ndarray) -> Array:
    """The Jacobian at rest without the friction of the `freed` cylinders.

    At rest the rates act on the accelerations only through friction and end stops: Coriolis forces are quadratic
    in the rates: M d(qdd)/d(qd) = -J_l^T diag(d) J_l, with d the sum of both derivatives.
    """
    rates, q = places(machine, "joint", "qd"), state[places(machine, "joint", "q")]
    train = machine.stroke_jacobian(q)
    slopes = np.where(freed, _friction_slopes(machine, jacobian, state, payload), 0.0)
    jacobian = jacobian.copy()
    push = np.linalg.solve(machine.mass_matrix(q, payload=payload), train.T)
    jacobian[np.ix_(rates, rates)] += push @ (slopes[:, None] * train)
    for cylinder in np.array(machine.cylinder_names)[freed]:
        bristle = f"cylinder.{cylinder}.z"
        if bristle in machine.state_names:
            jacobian[rates, machine.state_names.index(bristle)] = 0.0
    return jacobian


def _friction_slopes(machine: Machine, jacobian: Array, state: Array, payload: float | None) -> Array:
    """Slope dF/dv (n_cyl,) of the pistons' friction at rest, N s/m, bristles held."""
    rates, q = places(machine, "joint", "qd"), state[places(machine, "joint", "q")]
    train = machine.stroke_jacobian(q)
    both = -machine.mass_matrix(q, payload=payload) @ jacobian[np.ix_(rates, rates)]
    inverse = np.linalg.pinv(train)
    return np.diag(inverse.T @ both @ inverse) + _end_stop_slopes(machine, state, payload)


def _end_stop_slopes(machine: Machine, state: Array, payload: float | None) -> Array:
    """Slope of the end stops' force by piston velocity (n_cyl,), N s/m, zero or less."""
    rates, q = places(machine, "joint", "qd"), state[places(machine, "joint", "q")]
    moving = np.linalg.pinv(machine.stroke_jacobian(q)) @ np.full(len(machine.cylinder_names), _SPEED)
    states = np.stack([state, state])
    states[:, rates] = np.stack([moving, -moving])
    found = machine.outputs(states, np.zeros((2, len(machine.cylinder_names))), payload=payload)
    stops = [found[f"cylinder.{c}.force"] + found[f"cylinder.{c}.friction"] for c in machine.cylinder_names]
    return np.array([(out - back) / (2 * _SPEED) for out, back in stops])


def _smoothed(machine: Machine) -> np.ndarray:
    """Cylinders (n_cyl,) with static friction whose jump at zero is smoothed to a finite slope."""

    def smooth(cylinder: str) -> bool:
        static = f"cylinder.{cylinder}.z" not in machine.state_names
        slow, less_slow = machine.friction_map([_SLOW, _LESS_SLOW], cylinder)
        return bool(static and abs(slow) < 0.5 * abs(less_slow))

    return np.array([smooth(cylinder) for cylinder in machine.cylinder_names])


def places(machine: Machine, kind: str, name: str) -> list[int]:
    """Index of a state in :attr:`Machine.state_names`, for each joint or each cylinder."""
    owners = machine.joint_names if kind == "joint" else machine.cylinder_names
    return [machine.state_names.index(f"{kind}.{owner}.{name}") for owner in owners]


def _smoothing_warning(
    machine: Machine, slopes: Array, smoothed: np.ndarray, friction: str
) -> tuple[ResultWarning, ...]:
    if not smoothed.any() or friction == "released":
        return ()
    names = ", ".join(np.array(machine.cylinder_names)[smoothed])
    what = f"the smoothing of the static friction of {names} acts at rest as a damper of up to "
    size = f"{slopes[smoothed].max():.3g} N s/m"
    if friction == "held":
        return (
            ResultWarning(
                "static-friction-smoothed",
                f"{what}{size}, which is not a property of the crane: these modes omit it",
                'small motions about rest need model = "lugre" in [friction]; in motion these modes hold',
            ),
        )
    return (
        ResultWarning(
            "static-friction-smoothed",
            f"{what}{size}: these damping ratios are those of the smoothing, and modes may be missing",
            'take friction="held", which omits it, or model = "lugre" in [friction]',
        ),
    )


def _recording_warning(frequency: Array) -> tuple[ResultWarning, ...]:
    """Warning on modes that alias to a lower frequency in a run recorded at the default interval."""
    interval = Scenario.record_interval
    fast = frequency[frequency * interval * _SHOWS > 1.0]
    if not fast.size:
        return ()
    listed = ", ".join(dict.fromkeys(f"{value:.3g}" for value in fast))
    return (
        ResultWarning(
            "mode-above-recording",
            f"a run recorded every {interval * 1e3:g} ms, the default, shows frequencies up to {0.5 / interval:g} Hz:"
            f" modes at {listed} Hz would appear as slower ones",
            f"record every {1e3 / (SHOWS_WELL * fast.max()):.2g} ms (record-interval) to see them",
        ),
    )


@dataclass(frozen=True)
class ModeMap:
    """Slowest oscillation of the crane over a grid of poses (k_1, ..., k_n).

    Attributes
    ----------
    q, tip : (k_1, ..., k_n, n), (k_1, ..., k_n, 2) arrays
        Poses and their tips.
    frequency, damping : (k_1, ..., k_n) arrays
        Hz and ratio; NaN if the circuit cannot hold the crane, only the spools oscillate, or the position is forbidden.
    forbidden : (k_1, ..., k_n) array of bool
        Whether the tip is in a keep-out region, or it or its load in the ground.
    friction : str
        Treatment of friction, as in :func:`modes`.
    warnings : tuple of ResultWarning
        Limits of the numbers, one of each kind, from the fastest of the modes.
    """

    q: Array
    tip: Array
    frequency: Array
    damping: Array
    forbidden: np.ndarray
    friction: str = "held"
    warnings: tuple[ResultWarning, ...] = ()

    __repr__ = brief


def mode_map(
    machine: MachineLike, *, samples: int = 16, payload: float | None = None, friction: Friction = "held"
) -> ModeMap:
    """Slowest mode that is not a spool's own, over a grid of poses clear of the end stops.

    Poses in which the supply or a relief valve of a port does not hold the load are omitted: the crane does not come to
    rest there. So are forbidden positions of the tip.
    Parameters as in :func:`modes`; `samples` is as in :func:`load_chart`; a pose takes some 2 ms.

    Examples
    --------
    >>> found = hc.mode_map("single-cylinder", samples=3)
    >>> print(found.frequency.shape)
    (3,)
    """
    machine = as_machine(machine)
    machine.require_plane("a map of modes", slewing=True)
    poses = pose_grid(machine, samples, inset=_END_STOPS)
    tip = machine.tip_in_plane(poses)
    out = machine.forbidden(machine.tip(poses), machine.payload(payload))
    found = np.full((*poses.shape[:-1], 2), np.nan)
    found[~out] = [_slowest(machine, q, payload, friction) for q in poses[~out]]
    smoothing = modes(machine, machine.home, payload=payload, friction=friction).warnings
    warnings = [warning for warning in smoothing if warning.kind == "static-friction-smoothed"]
    if np.isfinite(found[..., 0]).any():
        warnings += _recording_warning(np.nanmax(found[..., 0], keepdims=True).reshape(1))
    return ModeMap(poses, tip, found[..., 0], found[..., 1], out, friction, tuple(warnings))


def _slowest(machine: Machine, q: Array, payload: float | None, friction: Friction) -> tuple[float, float]:
    if machine.rest(q, payload=payload)[1]:
        return np.nan, np.nan
    here = modes(machine, q, payload=payload, friction=friction)
    for frequency, damping, leading in zip(here.frequency, here.damping, here.state, strict=True):
        if not leading.endswith((".xs", ".vs")):
            return frequency, damping
    return np.nan, np.nan
