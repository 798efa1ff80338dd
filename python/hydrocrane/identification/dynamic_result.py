"""Bristle parameters from measurements, with their uncertainty and the warnings."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, cast

import numpy as np
from scipy import stats

from hydrocrane.arrays import Array, check_level
from hydrocrane.asked import ask
from hydrocrane.errors import InputError
from hydrocrane.identification.bristle import BristleReading
from hydrocrane.identification.covariance import labelled
from hydrocrane.identification.output_error import Estimate
from hydrocrane.identification.report import Section, Stage, Table, fitted_key, interval, signature
from hydrocrane.identification.result import StaticFit
from hydrocrane.identification.rig_model import RigResiduals
from hydrocrane.identification.rig_unknowns import DYNAMIC
from hydrocrane.machine.machine import Machine

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

UNITS = {"bristle-stiffness": "N/m", "bristle-damping": "N s/m"}


@dataclass(frozen=True)
class DynamicFit:
    """Bristle stiffness and damping.

    Attributes
    ----------
    rig : Machine
        With the static map that was used.
    table : str
        Table of the machine file, such as ``friction.test``.
    readings : dict
        Initial estimates by parameter and motion.
    estimate : Estimate or None
        Estimate of all unknowns, nuisance parameters included; None if the fit failed.
    rig_residuals : RigResiduals or None
        The logs with their models.
    passive_up_to : float
        Lowest speed (m/s) at which friction with these parameters returns energy; infinite if there is none.
    static : StaticFit or None
        Source of the static map.
    warnings : tuple of str
    """

    rig: Machine
    table: str
    readings: dict[str, dict[str, BristleReading]]
    estimate: Estimate | None
    rig_residuals: RigResiduals | None = field(repr=False)
    passive_up_to: float
    static: StaticFit | None = None
    warnings: tuple[str, ...] = ()

    @property
    def params(self) -> dict[str, float]:
        """``bristle-stiffness`` (N/m) and ``bristle-damping`` (N s/m): fitted, or else the mean of the initial
        estimates."""
        if self.estimate is not None:
            return {name: self.estimate[self._key(name)] for name in DYNAMIC}
        return {
            name: float(np.mean([r.value for r in found.values()])) for name, found in self.readings.items() if found
        }

    @property
    def delay(self) -> float:
        """Delay of the readings against the command, s."""
        found = self.fitted()
        return float(self._from_logs()[found.names.index("delay")])

    @property
    def bound(self) -> dict[str, float]:
        """Smallest standard deviations that these logs allow at the estimate (Cramer-Rao), SI."""
        found = self.fitted()
        deviation = np.sqrt(np.diag(found.bound))
        return {name: float(deviation[found.names.index(self._key(name))]) for name in DYNAMIC}

    @property
    def covariance(self) -> xr.DataArray:
        """Covariance of all unknowns, in products of their SI units; the bristle parameters come first."""
        return labelled(self._names(), self.fitted().covariance)

    @property
    def correlation(self) -> xr.DataArray:
        """Correlation of all unknowns; the bristle parameters come first."""
        return labelled(self._names(), self.fitted().correlation)

    def _unknown(self, name: str) -> bool:
        """Whether the logs do not identify a parameter: it ended on a bound, or may be zero."""
        found, key = self.fitted(), self._key(name)
        return key in found.at_bound or 1.96 * found.deviation(key) > abs(found[key])

    def intervals(self, level: float = 0.95) -> dict[str, tuple[float, float]]:
        """Confidence intervals of the bristle parameters, SI; infinite where one is not identifiable."""
        check_level(level)
        found, width = self.fitted(), float(stats.norm.ppf(0.5 + 0.5 * level))
        half = {name: np.inf if self._unknown(name) else width * found.deviation(self._key(name)) for name in DYNAMIC}
        return {name: (value - half[name], value + half[name]) for name, value in self.params.items()}

    def predicted(self, log: int) -> Array:
        """x, p1, p2 of a log (b, 3), SI, predicted by the fitted rig and its sensors at the times of its model."""
        found = self.fitted()
        assert self.rig_residuals is not None
        return self.rig_residuals.predicted(found.values, log)

    def summary(self) -> str:
        """Parameters, intervals and warnings, one line each."""
        if self.estimate is None:
            lines = [f"{name} {value:.4g} {UNITS[name]} (first reading)" for name, value in self.params.items()]
        else:
            ends = self.intervals(0.95)
            lines = [
                f"{name} {value:.4g} {UNITS[name]}, 95 %: {interval(*ends[name])}"
                for name, value in self.params.items()
            ]
        return "\n".join([*lines, *(f"warning: {warning}" for warning in self.warnings)])

    def plot(self) -> Figure:
        """Logs, predictions of the fitted rig, and residuals."""
        return cast("Figure", ask("plots", "dynamic-fit", self))

    def toml(self, *, source: Iterable[str] = (), date: str = "") -> str:
        """The block ``[friction.<name>]`` for a machine file, with the static map if it was fitted too.

        Parameters
        ----------
        source : iterable of str
            Names of the logs; by default those that were fitted.
        date : str
            Day of the fit, by default today.
        """
        ends = self.intervals(0.95)
        logs = ", ".join(source) or ", ".join(m.source for m in self.rig_residuals.models if m.source)  # type: ignore[union-attr]
        where = f"{logs}; output-error fit, {signature(date)}"
        lines = [
            fitted_key(name, f'"{value:.5g} {UNITS[name]}"', where, interval(*ends[name]))
            for name, value in self.params.items()
        ]
        cylinder = self.rig.cylinder_names[0]
        if self.static is not None:
            return self.static.toml(cylinder, name=self.table.split(".", 1)[1], bristles=lines)
        head = [f"[{self.table}]", f"cylinder = {json.dumps(cylinder)}", 'model = "lugre"']
        return "\n".join([*head, *lines]) + "\n"

    def stages(self) -> list[Stage]:
        """(title, function that makes the section) for :meth:`Report.stage`, in the order of a report."""
        return [
            ("Dynamic friction, initial estimates", self._first_readings),
            ("Dynamic friction", self._fit),
            ("Correlations and nuisance parameters", self._unknowns),
            ("Block with bristles for the machine file", self._block),
        ]

    def _first_readings(self) -> Section:
        rows = tuple(
            (name, motion, f"{r.value:.4g}", f"{r.error:.2g}", UNITS[name])
            for name, found in self.readings.items()
            for motion, r in found.items()
        )
        text = "Straight lines through each motion, as in the thesis; the fit starts from these estimates."
        heads = ("parameter", "motion", "reading", "scatter of the line", "unit")
        return Section("Dynamic friction, initial estimates", text, Table(heads, rows))

    def _fit(self) -> Section:
        ends, best = self.intervals(0.95), self.bound
        rows = tuple(
            (name, UNITS[name], f"{value:.4g}", interval(*ends[name]), f"{best[name]:.2g}")
            for name, value in self.params.items()
        )
        found = self.fitted()
        passive = "at every speed" if np.isinf(self.passive_up_to) else f"up to {self.passive_up_to:.3g} m/s"
        text = f"Residuals are {np.sqrt(found.variance):.2f} times the stated noise. Friction dissipates {passive}."
        heads = ("parameter", "unit", "fitted", "95 %", "smallest standard deviation")
        return Section("Dynamic friction", text, Table(heads, rows), self.plot(), self.warnings)

    def _unknowns(self) -> Section:
        found = self.fitted()
        known = self.correlation.values[:2]
        rows = tuple(
            (name, f"{value:.4g}", f"{found.deviation(name):.2g}", f"{with_0:+.2f}", f"{with_1:+.2f}")
            for name, value, with_0, with_1 in zip(found.names, self._from_logs(), *known, strict=True)
        )
        heads = ("unknown", "found, SI", "standard deviation", *(f"correlation with {name}" for name in DYNAMIC))
        return Section("Correlations and nuisance parameters", table=Table(heads, rows))

    def _block(self) -> Section:
        return Section("Block with bristles for the machine file", code=self.toml())

    def fitted(self) -> Estimate:
        """The estimate; an error with the reason if there is none."""
        if self.estimate is None:
            raise InputError("the fit did not come to an end: " + "; ".join(self.warnings))
        return self.estimate

    def _from_logs(self) -> Array:
        """Values of all unknowns, SI; start values and delay relative to the logs."""
        found = self.fitted()
        assert self.rig_residuals is not None
        return self.rig_residuals.counted_from_logs(found.values)

    def _names(self) -> list[str]:
        return [name.removeprefix(f"{self.table}.") for name in self.fitted().names]

    def _key(self, name: str) -> str:
        return f"{self.table}.{name}"
