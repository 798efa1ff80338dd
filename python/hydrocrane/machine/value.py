"""A value that a machine states, with its unit and where it comes from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import Array, brief
from hydrocrane.notebook import card


@dataclass(frozen=True)
class Value:
    """A value that a machine file, or an override, states.

    Attributes
    ----------
    key : str
        Dotted, as in overrides.
    si : float or array
        In SI: a number, two of a pair or a point, or those of a list one after the other.
    unit : str
        SI unit; empty for a plain number.
    provenance, source : str
        Class and source, as in :attr:`Machine.provenance`.

    Examples
    --------
    >>> value = hc.load_machine("rottne-f9-lab").value("supply.pressure")
    >>> print(value.si, value.unit, value.provenance)
    14000000.0 Pa setting
    """

    key: str
    si: float | Array
    unit: str
    provenance: str
    source: str

    __repr__ = brief

    def _repr_html_(self) -> str:
        numbers = np.atleast_1d(self.si)
        shown = ", ".join(f"{number:.6g}" for number in numbers[:8]) + (", ..." if numbers.size > 8 else "")
        return card(self.key, [f"value  {shown} {self.unit}", f"{self.provenance}  {self.source}"])
