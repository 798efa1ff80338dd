"""From a machine at a working point to its linear model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.analysis.linear import check_friction, places, smoothing_warnings, with_friction
from hydrocrane.arrays import Array, vectors
from hydrocrane.errors import InputError, check_known
from hydrocrane.linear.command_path import path_warnings
from hydrocrane.linear.outputs import ASIDE, known_outputs, output_rows
from hydrocrane.machine.machine import Machine, MachineLike, as_machine
from hydrocrane.machine.poses import states
from hydrocrane.result_warning import ResultWarning
from hydrocrane.state_space.model import LinearModel, chosen
from hydrocrane.state_space.options import Friction, Side

SIDES = ("extend", "retract")


# Forces on the tip, N, which can be inputs besides the spool commands.
def tip_forces(machine: Machine) -> tuple[str, ...]:
    """Names of the forces on the tip."""
    return tuple(f"tip.force.{axis}" for axis in machine.tip_axes)


# Step of the spool command, as a share of the stroke. The law is linear in it, so any step gives the derivative.
_COMMAND_STEP = 1e-3
# Share of the stroke up to which a spool counts as closed, and the ratio of both sides above which a warning is given.
_CLOSED, _DIFFERS = 0.01, 0.01
# Below these rates the working point counts as an equilibrium: rad/s^2 or m/s^2, Pa/s.
_STILL, _CREEP = 1e-6, 1e5


def linearise(
    machine: MachineLike,
    q: ArrayLike | None = None,
    *,
    state: ArrayLike | None = None,
    command: ArrayLike | None = None,
    inputs: str | Sequence[str] | None = None,
    outputs: str | Sequence[str] | None = None,
    mode: Literal["hold", "steady"] = "hold",
    side: Side = "extend",
    friction: Friction = "smoothed",
    payload: float | None = None,
) -> LinearModel:
    """Linear model of a crane about a working point; also ``crane.linearise(...)``.

    A is the exact Jacobian of the equations of motion. B is exact: the equations are linear in the commands and in a
    force on the tip. C is exact for states, commands, ``tip.x``, ``tip.z`` and ``cylinder.<c>.x``. All other outputs
    have differences of order four, with an estimate of their error in ``output_error``.

    Parameters
    ----------
    machine : Machine, str or path
    q : (n,) array_like, optional
        Pose at rest, rad or m; or give `state`.
    state : (n_states,) array_like, optional
        Any state, for example ``simulator.state`` of a crane in motion.
    command : (n_cyl,) array_like, optional
        Spool commands at the working point, m. With `q` the spools also have these positions; by default the commands
        are the spool positions of the state.
    inputs : str or sequence of str, optional
        ``cylinder.<c>.command`` (m, all of them by default), ``tip.force.x`` and ``tip.force.z`` (N, on the tip).
    outputs : str or sequence of str, optional
        Names of states, or of :meth:`Machine.outputs`; the joint coordinates and the tip by default.
    mode : {"hold", "steady"}
        Equilibrium of `q`, as of :meth:`Machine.equilibrium`.
    side : {"extend", "retract"}
        The gain of a closed valve differs between the sides; this side is used.
    friction : {"smoothed", "held", "released"}
        As of :func:`hydrocrane.modes`: ``smoothed`` is that of the simulation. ``released`` leaves friction out, as in
        motions larger than the bristle deflection; use it for the design of motion controllers. The last two need a
        state at rest.
    payload : float, optional
        kg at the tip; the machine's own by default.

    Raises
    ------
    InputError
        Both or neither of `q` and `state`, a batch, an unknown name.
    OutOfReachError
        A pose outside the joint limits.

    Examples
    --------
    >>> import numpy as np
    >>> import hydrocrane as hc
    >>> crane = hc.load_machine("rottne-f9-lab")
    >>> model = crane.linearise(np.array([1.9, 2.0, 0.0]), outputs=["joint.boom.q"], friction="released")
    >>> model.A.shape, model.B.shape
    ((21, 21), (21, 3))
    """
    machine = as_machine(machine)
    check_friction(friction)
    check_known("side of a valve", side, SIDES)
    mass = machine.payload(payload)
    point, given, doubts = _working_point(machine, q, state, command, mode, mass)
    asked = _asked_inputs(machine, inputs)
    names = _asked_outputs(machine, outputs)
    a, b, warnings = _state_matrices(machine, point, given, mass, side, friction)
    rows = output_rows(machine, names, _beside_the_kink(machine, point, side), given, mass)
    columns, forces = list(asked.values()), tip_forces(machine)
    by_command = min(columns) < len(given)
    drift = machine.state_derivative(point, given, payload=mass)
    return LinearModel(
        A=a,
        B=b[:, columns],
        C=rows.c,
        D=np.hstack([rows.d, np.zeros((len(names), len(forces)))])[:, columns],
        state_names=machine.state_names,
        state_units=machine.state_units,
        input_names=tuple(asked),
        input_units=tuple("m" if i < len(given) else "N" for i in columns),
        output_names=names,
        output_units=rows.units,
        x=point,
        u=np.append(given, np.zeros(len(forces)))[columns],
        y=rows.y,
        drift=drift,
        output_error=rows.error,
        machine=machine.name,
        payload=mass,
        friction=friction,
        side=side,
        warnings=(
            *doubts,
            *_motion_warning(machine, drift, point),
            *warnings,
            *(path_warnings(machine) if by_command else ()),
            *rows.warnings,
        ),
    )


def _asked_inputs(machine: Machine, inputs: str | Sequence[str] | None) -> dict[str, int]:
    """Column of each input among the spool commands and the forces on the tip."""
    commands = [f"cylinder.{c}.command" for c in machine.cylinder_names]
    known = [*commands, *tip_forces(machine)]
    return {known[i]: i for i in chosen("input", commands if inputs is None else inputs, known)}


def _asked_outputs(machine: Machine, outputs: str | Sequence[str] | None) -> tuple[str, ...]:
    known = list(known_outputs(machine))
    default = [f"joint.{j}.q" for j in machine.joint_names] + [f"tip.{axis}" for axis in machine.tip_axes]
    return tuple(known[i] for i in chosen("output", default if outputs is None else outputs, known))


def _state_matrices(
    machine: Machine, point: Array, command: Array, payload: float, side: Side, friction: Friction
) -> tuple[Array, Array, tuple[ResultWarning, ...]]:
    """A, B by all inputs, and the warnings."""
    moving = bool(point[places(machine, "joint", "qd")].any())
    if friction != "smoothed" and moving:
        raise InputError(
            f'friction="{friction}" needs a crane at rest, and joints move here; take friction="smoothed", '
            "which has the slopes of friction in motion"
        )
    beside = _beside_the_kink(machine, point, side)
    jacobian = machine.jacobian(beside, command, payload=payload)
    b, limited = _input_matrix(machine, beside, command, payload)
    smoothing = () if moving else smoothing_warnings(machine, jacobian, beside, payload, friction)
    valves = _valve_warnings(machine, point, command, payload, side)
    return with_friction(machine, jacobian, beside, payload, friction), b, (*valves, *limited, *smoothing)


def _working_point(
    machine: Machine,
    q: ArrayLike | None,
    state: ArrayLike | None,
    command: ArrayLike | None,
    mode: Literal["hold", "steady"],
    payload: float,
) -> tuple[Array, Array, tuple[ResultWarning, ...]]:
    """State, command, and warnings on the state."""
    if (q is None) == (state is None):
        raise InputError("linearise takes either q, a pose to rest in, or state, a full state")
    spools = places(machine, "cylinder", "xs")
    if q is not None:
        point, doubts = machine.rest(q, mode, payload=payload)
    else:
        point, doubts = states(machine, np.asarray(state)).copy(), ()
    if point.ndim != 1:
        raise InputError(f"linearise takes one pose or one state, got a batch of shape {point.shape[:-1]}")
    given = point[spools].copy() if command is None else vectors(command, "command", machine.cylinder_names)
    if given.ndim != 1:
        raise InputError(f"linearise takes one command of shape ({len(spools)},), got shape {given.shape}")
    if q is not None:
        point[spools] = given
    return point, given, doubts


def _beside_the_kink(machine: Machine, state: Array, side: Side) -> Array:
    """The state with closed spools moved by a negligible amount to their side."""
    spools, aside = places(machine, "cylinder", "xs"), ASIDE * machine.spool_strokes
    moved = state.copy()
    to = aside if side == "extend" else -aside
    moved[spools] = np.where(np.abs(state[spools]) < aside, to, state[spools])
    return moved


def _input_matrix(
    machine: Machine, state: Array, command: Array, payload: float
) -> tuple[Array, tuple[ResultWarning, ...]]:
    """d(state_derivative) by the spool commands and the force on the tip, (n_states, n_cyl + 2 or 3)."""
    steps = _COMMAND_STEP * machine.spool_strokes
    moves = np.stack([np.zeros_like(np.diag(steps)), np.diag(steps), -np.diag(steps)])
    none, up, down = machine.state_derivative(state, command + moves, payload=payload)
    by_command = (up - down).T / (2 * steps)
    forward, backward = (up - none).T / steps, (none - down).T / steps
    bent = np.abs(forward - backward).max(axis=0) > 1e-6 * np.abs(forward).max(axis=0)
    joints, rates = places(machine, "joint", "q"), places(machine, "joint", "qd")
    q = state[joints]
    by_force = np.zeros((len(state), len(machine.tip_axes)))
    by_force[rates] = np.linalg.solve(machine.mass_matrix(q, payload=payload), machine.tip_jacobian(q).T)
    still = bent | ~by_command.any(axis=0)
    warnings = tuple(
        ResultWarning(
            "spool-limited",
            f"the spool of {cylinder} is at its limit of speed or acceleration: a command has no linear effect",
            "choose a command nearer to the position of the spool",
        )
        for cylinder in np.array(machine.cylinder_names)[still]
    )
    return np.hstack([by_command, by_force]), warnings


def _valve_warnings(
    machine: Machine, state: Array, command: Array, payload: float, side: Side
) -> tuple[ResultWarning, ...]:
    """Warnings on closed valves: no effect in the dead band, and another gain on the other side."""
    spools = places(machine, "cylinder", "xs")
    pressures = [i for i, name in enumerate(machine.state_names) if name.endswith((".p1", ".p2"))]
    columns = {}
    for label in SIDES:
        closed = state.copy()
        closed[spools] = (1.0 if label == "extend" else -1.0) * ASIDE * machine.spool_strokes
        columns[label] = machine.jacobian(closed, command, payload=payload)[np.ix_(pressures, spools)]
    here, other = (columns[label] for label in (side, next(s for s in SIDES if s != side)))
    warnings = []
    for i, cylinder in enumerate(machine.cylinder_names):
        if abs(state[spools[i]]) > _CLOSED * machine.spool_strokes[i]:
            continue
        if not here[:, i].any():
            warnings.append(
                ResultWarning(
                    "valve-in-dead-band",
                    f"the spool of {cylinder} is in the dead band of its valve: a small command has no effect",
                    f"give a command beyond the overlap of the valve of {cylinder}",
                )
            )
        elif np.abs(here[:, i] - other[:, i]).max() > _DIFFERS * np.abs(here[:, i]).max():
            one, two = np.abs(here[:, i]).max(), np.abs(other[:, i]).max()
            warnings.append(
                ResultWarning(
                    "valve-gain-jumps",
                    f"the valve of {cylinder} is closed: its gain is that of side={side!r}, "
                    f"and the largest one of the other side is {two / one:.3g} times as large",
                    "give a command that opens the valve, or compare both sides",
                )
            )
    return tuple(warnings)


def _motion_warning(machine: Machine, drift: Array, state: Array) -> tuple[ResultWarning, ...]:
    """Warning on a working point that is no equilibrium."""
    rates = places(machine, "joint", "qd")
    pressures = [i for i, name in enumerate(machine.state_names) if name.endswith((".p1", ".p2"))]
    speed, acceleration, creep = (np.abs(v).max() for v in (state[rates], drift[rates], drift[pressures]))
    if speed < _STILL and acceleration < _STILL and creep < _CREEP:
        return ()
    return (
        ResultWarning(
            "not-in-equilibrium",
            f"the working point moves: rates up to {speed:.3g}, accelerations up to {acceleration:.3g} (SI), pressures "
            f"up to {creep * 1e-5:.3g} bar/s; the model describes deviations from the motion that starts there",
            'use it for times in which the pose hardly changes, or take mode="steady"',
        ),
    )
