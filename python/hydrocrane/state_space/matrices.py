"""The matrices of a linear model, with the names and units of states, inputs and outputs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hydrocrane.arrays import Array
from hydrocrane.result_warning import ResultWarning


@dataclass(frozen=True, repr=False, eq=False)
class Matrices:
    """The fields of :class:`hydrocrane.linear.LinearModel`; described there."""

    A: Array
    B: Array
    C: Array
    D: Array
    state_names: tuple[str, ...]
    state_units: tuple[str, ...]
    input_names: tuple[str, ...]
    input_units: tuple[str, ...]
    output_names: tuple[str, ...]
    output_units: tuple[str, ...]
    x: Array
    u: Array
    y: Array
    drift: Array
    output_error: Array
    machine: str
    payload: float
    friction: str
    side: str
    warnings: tuple[ResultWarning, ...] = ()

    @property
    def about(self) -> Mapping[str, str | float]:
        """Description of the model, in words and numbers."""
        return {
            "machine": self.machine,
            "payload": self.payload,
            "friction": self.friction,
            "side": self.side,
            "warnings": "; ".join(str(warning) for warning in self.warnings),
        }
