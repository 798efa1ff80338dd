"""A linear model: its matrices with names and units, and its methods."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane.arrays import real_array
from hydrocrane.errors import InputError, check_known
from hydrocrane.notebook import card
from hydrocrane.state_space import responses
from hydrocrane.state_space.matrices import Matrices
from hydrocrane.state_space.oscillations import Oscillations, oscillations
from hydrocrane.state_space.responses import StepResponse

if TYPE_CHECKING:
    import control

# Points of a step response, and its default length in periods of the slowest oscillation.
_POINTS, _PERIODS = 1001, 10
# Relative rounding error of a time grid that still counts as even.
_EVEN = 1e-6


@dataclass(frozen=True, repr=False, eq=False)
class LinearModel(Matrices):
    """x' = A x + B u, y = C x + D u, for small deviations of states, inputs and outputs from a working point.

    Made by :func:`hydrocrane.linearise`, also as ``crane.linearise(...)``.

    Attributes
    ----------
    A, B, C, D : arrays
        (n, n), (n, n_inputs), (n_outputs, n), (n_outputs, n_inputs); SI.
    state_names, state_units, input_names, input_units, output_names, output_units : tuple of str
    x, u, y : arrays
        The working point: state, inputs and outputs.
    drift : (n,) array
        d(state)/dt at the working point. If it is not zero, the deviations are relative to the motion that starts
        there.
    output_error : (n_outputs,) array
        Estimated error of each row of [C D], relative to its largest entry in the units of the states' scales. Zero for
        an exact row.
    machine : str
        Name of the machine.
    payload : float
        At the tip, kg.
    friction, side : str
        As in :func:`~hydrocrane.linearise`.
    warnings : tuple of ResultWarning
        Limits of the model.

    Examples
    --------
    >>> crane = hc.load_machine("rottne-f9-lab")
    >>> model = crane.linearise([1.9, 2.0, 0.0], outputs="tip.z", friction="released")
    >>> print(model.A.shape, model.output_names, model.input_names[0])
    (21, 21) ('tip.z',) cylinder.lift.command
    """

    def __repr__(self) -> str:
        sizes = f"{len(self.A)} states, {len(self.input_names)} inputs, {len(self.output_names)} outputs"
        return f"<LinearModel of {self.machine}: {sizes}>"

    @cached_property
    def oscillations(self) -> Oscillations:
        """Frequency, damping ratio, leading state and shape of each oscillating pair of poles."""
        return oscillations(self.A, self.state_names)

    def poles(self) -> np.ndarray:
        """(n,) complex eigenvalues of A, 1/s.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> model = crane.linearise(crane.home, friction="released")
        >>> len(model.poles()) == len(model.A)
        True
        """
        return self.oscillations.eigenvalues

    def select(
        self, inputs: str | Sequence[str] | None = None, outputs: str | Sequence[str] | None = None
    ) -> LinearModel:
        """The same model with only these inputs and outputs, in this order.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> model = crane.linearise(crane.home, friction="released")
        >>> model.select("cylinder.lift.command", "tip.z").B.shape[1]
        1
        """
        columns = chosen("input", inputs, self.input_names)
        rows = chosen("output", outputs, self.output_names)
        return replace(
            self,
            B=self.B[:, columns],
            C=self.C[rows],
            D=self.D[np.ix_(rows, columns)],
            input_names=tuple(self.input_names[i] for i in columns),
            input_units=tuple(self.input_units[i] for i in columns),
            output_names=tuple(self.output_names[i] for i in rows),
            output_units=tuple(self.output_units[i] for i in rows),
            u=self.u[columns],
            y=self.y[rows],
            output_error=self.output_error[rows],
        )

    def step(self, times: ArrayLike | None = None, *, size: ArrayLike = 1.0) -> StepResponse:
        """Outputs after a step of each input alone, exact at the given times.

        Parameters
        ----------
        times : (m,) array_like, optional
            Evenly spaced from 0 on, s; by default ten periods of the slowest oscillation.
        size : float or (n_inputs,) array_like
            Height of the steps, in the unit of each input.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> model = crane.linearise(crane.home, friction="released")
        >>> model.step(np.linspace(0.0, 0.1, 5)).y.shape[0]
        5
        """
        slowest = self.oscillations.frequency
        end = _PERIODS / slowest[0] if slowest.size else 1.0
        grid = np.linspace(0.0, end, _POINTS) if times is None else real_array(times, "times")
        if grid.ndim != 1 or grid.size < 2 or grid[0] != 0 or grid[1] <= 0:
            raise InputError("times of a step response are a row of at least two numbers that begins with 0 and grows")
        if np.abs(np.diff(grid) - grid[1]).max() > _EVEN * grid[1]:
            raise InputError("times of a step response must be evenly spaced; take numpy.linspace(0, end, points)")
        height = np.broadcast_to(real_array(size, "size"), (len(self.input_names),))
        y = responses.step_outputs(self.A, self.B, self.C, self.D, float(grid[-1] / (grid.size - 1)), grid.size)
        return StepResponse(grid, y * height, height, self.output_names, self.input_names)

    def frequency_response(self, omega: ArrayLike) -> np.ndarray:
        """Complex gains (..., n_outputs, n_inputs) at angular frequencies `omega` (...), rad/s.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> model = crane.linearise(crane.home, friction="released")
        >>> model.frequency_response([1.0, 10.0]).shape[0]
        2
        """
        omega = real_array(omega, "omega")
        found = responses.transfer(self.A, self.B, self.C, self.D, 1j * omega.ravel())
        return found.reshape(*omega.shape, *self.D.shape)

    def to_control(self) -> control.StateSpace:
        """The model as a ``StateSpace`` of python-control, with underscores for the dots in names.

        Raises
        ------
        InputError
            If python-control is not installed.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> model = crane.linearise(crane.home, outputs="tip.z", friction="released")
        >>> print(model.to_control().output_labels)
        ['tip_z']
        """
        from hydrocrane.state_space.exports import state_space

        return state_space(self)

    def save(self, path: str | PathLike[str]) -> Path:
        """Write the model; the suffix decides: ``.mat`` (MATLAB) or ``.json``. Returns the path.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> model = crane.linearise(crane.home, friction="released")
        >>> model.save("crane.json").name
        'crane.json'
        """
        from hydrocrane.state_space.exports import save

        return save(self, Path(path))

    def _repr_html_(self) -> str:
        """For notebooks: the working point, the oscillations, inputs, outputs and warnings."""
        modes = self.oscillations
        lines = [f"states  {len(self.A)}", f"payload  {self.payload:g} kg"]
        lines += [
            f"oscillation  {frequency:.4g} Hz, damping ratio {damping:.3g}, mostly in {state}"
            for frequency, damping, state in zip(modes.frequency, modes.damping, modes.state, strict=True)
        ]
        for kind, names, units in (
            ("inputs", self.input_names, self.input_units),
            ("outputs", self.output_names, self.output_units),
        ):
            lines.append(f"{kind}  {', '.join(f'{name} [{unit}]' for name, unit in zip(names, units, strict=True))}")
        lines += [f"warning  {warning}" for warning in self.warnings]
        return card(f"Linear model of {self.machine}", lines, "print(model.oscillations)")


def chosen(what: str, names: str | Sequence[str] | None, known: Sequence[str]) -> list[int]:
    """Indices of `names` among the `known` ones; all if none are named."""
    if names is None:
        return list(range(len(known)))
    wanted = [names] if isinstance(names, str) else list(names)
    for name in wanted:
        check_known(what, name, known)
        if wanted.count(name) > 1:
            raise InputError(f"{what} `{name}` is named twice; name it once")
    if not wanted:
        raise InputError(f"a linear model needs at least one {what}; choose from {', '.join(known)}")
    return [list(known).index(name) for name in wanted]
