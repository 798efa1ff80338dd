"""What the file of a machine states: values with unit and origin, choices, sensors, switches, regions."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hydrocrane import _core
from hydrocrane.arrays import Array, brief
from hydrocrane.errors import check_known
from hydrocrane.notebook import card
from hydrocrane.result_warning import ResultWarning


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


PROVENANCE_CLASSES = ("measured", "fitted", "literature", "assumed", "setting")


class Stated:
    """The part of a machine that its file and the overrides state."""

    core: _core.Machine

    @property
    def provenance(self) -> tuple[tuple[str, str, str], ...]:
        """(key, class, source) of every value of the machine file."""
        return tuple((value.key, value.provenance, value.source) for value in self._values.values())

    def value(self, key: str) -> Value:
        """A value that the file or an override states, by its dotted key, for example ``friction.lift.coulomb``.

        Raises
        ------
        InputError
            If nothing states it, also if a default applies.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> coulomb = crane.value("friction.extension.coulomb")
        >>> print(coulomb.si, coulomb.unit, coulomb.provenance)
        [160. 280.] N fitted
        """
        check_known(f"value of {self.core.name}", key, self._values)
        return self._values[key]

    @property
    def keys(self) -> tuple[str, ...]:
        """Every key that :meth:`value` takes, in file order."""
        return tuple(self._values)

    @cached_property
    def _values(self) -> dict[str, Value]:
        def plain(si: list[float]) -> float | Array:
            return si[0] if len(si) == 1 else np.array(si, dtype=np.float64)

        return {key: Value(key, plain(si), unit, kind, source) for key, si, unit, kind, source in self.core.values}

    @property
    def warnings(self) -> tuple[ResultWarning, ...]:
        """Values outside their usual ranges, with the unit that was probably meant; kind ``implausible-value``."""
        return tuple(ResultWarning(*entry) for entry in self.core.warnings)

    @property
    def words(self) -> dict[str, str]:
        """Names and choices that the file or an override states, by key, for example ``valve.lift.type``."""
        return dict(self.core.words)

    @property
    def sensors(self) -> dict[str, str]:
        """Sensors of the file: the signal that each measures, by its name."""
        return dict(self.core.sensors)

    @property
    def provenance_tally(self) -> dict[str, int]:
        """How many values are measured, fitted, from the literature, assumed, or a setting."""
        count = Counter(kind for _, kind, _ in self.provenance)
        return {kind: count.get(kind, 0) for kind in PROVENANCE_CLASSES}

    @property
    def errata(self) -> dict[str, bool]:
        """Correction switches of the thesis; True where the law is corrected."""
        return dict(self.core.errata)

    @property
    def keep_out(self) -> dict[str, Array]:
        """Keep-out regions of the controllers, by name: corners (k, 2) in the inertial frame, m."""
        return dict(self.core.keep_out)
