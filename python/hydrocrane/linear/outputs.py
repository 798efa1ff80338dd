"""Rows of C and D: exact if the core has the derivative, otherwise differences with an error estimate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrocrane.analysis.linear import places
from hydrocrane.arrays import Array
from hydrocrane.linear.differences import central
from hydrocrane.machine.machine import Machine
from hydrocrane.result_warning import ResultWarning

# Step of the differences of a state by the end of its name, in its SI unit. Spools have a separate one. The step of a
# rate is small because viscous friction has a curved root at rest; in motion it grows with the rate, for rounding.
_STEPS = {"q": 1e-4, "qd": 1e-9, "p1": 1e3, "p2": 1e3, "vs": 1e-4, "z": 1e-6, "p": 1e3, "load": 1e3}
_ANY_STEP, _MOVING = 1e-4, 1e-6
# Step as a share of the spool's stroke. It stays on one side of a closed valve, whose spool is `ASIDE` from its kink.
_SPOOL_STEP, ASIDE = 2e-10, 1e-9
# Estimated error above which a warning is given.
_ROUGH = 0.01
# Relative changes of an output below this share are rounding.
_ROUNDING = 1e-11


@dataclass(frozen=True)
class OutputRows:
    """C and D of some outputs, their values at the working point, units, errors, and warnings."""

    c: Array
    d: Array
    y: Array
    units: tuple[str, ...]
    error: Array
    warnings: tuple[ResultWarning, ...]


def known_outputs(machine: Machine) -> dict[str, str]:
    """Unit of every available output, by its name: states, commands and derived quantities."""
    states = dict(zip(machine.state_names, machine.state_units, strict=True))
    commands = {f"cylinder.{c}.command": "m" for c in machine.cylinder_names}
    return {**states, **{name: unit for name, unit, _ in machine.core.output_info}, **commands}


def output_rows(machine: Machine, names: tuple[str, ...], state: Array, command: Array, payload: float) -> OutputRows:
    """Derivatives of the outputs `names` by state and spool commands."""
    exact = _exact(machine, state)
    rows = [exact.get(name) for name in names]
    error = np.zeros(len(names))
    warnings: list[ResultWarning] = []
    inexact = [i for i, row in enumerate(rows) if row is None]
    values = machine.outputs(state, command, payload=payload)
    steps = _steps(machine, state)
    if inexact:
        asked = [names[i] for i in inexact]

        def outputs(states: Array) -> Array:
            found = machine.outputs(states, command, payload=payload)
            return np.stack([found[name] for name in asked], axis=-1)

        found = central(outputs, state, steps)
        for i, value, doubt, kinks in zip(inexact, found.value, found.error, found.kinks, strict=True):
            rows[i] = np.concatenate([value, np.zeros(len(command))])
            largest, own = np.abs(value * steps).max(), np.abs(doubt * steps).max()
            error[i] = own / largest if own > _ROUNDING * abs(float(values[names[i]])) else 0.0
            rough = kinks | (doubt * steps > _ROUGH * largest) if error[i] > _ROUGH or kinks.any() else kinks
            if rough.any():
                warnings.append(_kink(names[i], ", ".join(np.array(machine.state_names)[rough])))
    table = np.array(rows, dtype=np.float64)
    units = known_outputs(machine)
    plain = dict(zip(machine.state_names, state, strict=True))
    plain |= {f"cylinder.{c}.command": u for c, u in zip(machine.cylinder_names, command, strict=True)}
    y = np.array([float({**values, **plain}[name]) for name in names])
    n = len(state)
    return OutputRows(table[:, :n], table[:, n:], y, tuple(units[name] for name in names), error, tuple(warnings))


def _exact(machine: Machine, state: Array) -> dict[str, Array]:
    """Exact rows by state and command: states, commands, tip position, piston positions."""
    n, width = len(state), len(state) + len(machine.cylinder_names)
    unit = np.eye(width)
    rows = {name: unit[i] for i, name in enumerate(machine.state_names)}
    rows |= {f"cylinder.{c}.command": unit[n + i] for i, c in enumerate(machine.cylinder_names)}
    joints = places(machine, "joint", "q")
    q = state[joints]
    geometry = dict(zip((f"tip.{axis}" for axis in machine.tip_axes), machine.tip_jacobian(q), strict=True))
    train = machine.stroke_jacobian(q)
    geometry |= {f"cylinder.{c}.x": row for c, row in zip(machine.cylinder_names, train, strict=True)}
    for name, slopes in geometry.items():
        rows[name] = np.zeros(width)
        rows[name][joints] = slopes
    return rows


def _steps(machine: Machine, state: Array) -> Array:
    """(n_states,) step of the differences by each state."""
    strokes = dict(zip(machine.cylinder_names, machine.spool_strokes, strict=True))

    def step(name: str, value: float) -> float:
        owner, last = name.split(".")[-2:]
        least = _SPOOL_STEP * float(strokes[owner]) if last == "xs" else _STEPS.get(last, _ANY_STEP)
        return max(least, _MOVING * abs(value)) if last in ("qd", "xs") else least

    return np.array([step(name, value) for name, value in zip(machine.state_names, state, strict=True)])


def _kink(output: str, by: str) -> ResultWarning:
    return ResultWarning(
        "output-kink",
        f"{output} has a kink or a jump over {by} at the working point: its derivative there is a mean of both sides",
        "choose a working point beside the kink, for example one in motion",
    )
