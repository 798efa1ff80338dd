"""Responses of a linear system in time and frequency, computed in balanced coordinates.

With pressures in Pa and positions in m the entries of A differ by ten decades. A diagonal change of units (balancing)
reduces this before the solution; it does not change inputs and outputs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import Array, brief

# Number of frequencies per solution; more need memory and save no time.
_BLOCK = 256


@dataclass(frozen=True)
class StepResponse:
    """Outputs after a step of one input at a time.

    Attributes
    ----------
    time : (m,) array
        s.
    y : (m, n_outputs, n_inputs) array
        Deviation of each output from the working point for a step of each input alone.
    size : (n_inputs,) array
        Height of each step, in the unit of its input.
    output_names, input_names : tuple of str
    """

    time: Array
    y: Array
    size: Array
    output_names: tuple[str, ...]
    input_names: tuple[str, ...]

    __repr__ = brief


def balanced(a: Array, b: Array, c: Array) -> tuple[Array, Array, Array]:
    """The same system with states in units that balance the entries of A."""
    from scipy.linalg import matrix_balance

    scaled, (scale, _) = matrix_balance(a, permute=False, separate=True)
    return scaled, b / scale[:, None], c * scale


def sampled(a: Array, b: Array, period: float) -> tuple[Array, Array]:
    """Exact transition over one period with the inputs held: x[k+1] = F x[k] + G u[k]."""
    from scipy.linalg import expm

    states, inputs = b.shape
    whole = np.zeros((states + inputs, states + inputs))
    whole[:states, :states], whole[:states, states:] = a, b
    moved = expm(whole * period)
    return moved[:states, :states], moved[:states, states:]


def step_outputs(a: Array, b: Array, c: Array, d: Array, period: float, count: int) -> Array:
    """Outputs (count, n_outputs, n_inputs) at multiples of the period after unit steps of each input alone."""
    a, b, c = balanced(a, b, c)
    moved, driven = sampled(a, b, period)
    state = np.zeros_like(b)
    found = np.empty((count, c.shape[0], b.shape[1]))
    for k in range(count):
        found[k] = c @ state + d
        state = moved @ state + driven
    return found


def transfer(a: Array, b: Array, c: Array, d: Array, points: np.ndarray) -> np.ndarray:
    """C (s I - A)^-1 B + D at each complex point s, (m, n_outputs, n_inputs)."""
    a, b, c = balanced(a, b, c)
    unit = np.eye(len(a))
    found = np.empty((points.size, c.shape[0], b.shape[1]), dtype=complex)
    for first in range(0, points.size, _BLOCK):
        s = points[first : first + _BLOCK, None, None]
        found[first : first + _BLOCK] = c @ np.linalg.solve(s * unit - a, np.broadcast_to(b, (len(s), *b.shape))) + d
    return found
