"""Dynamic friction from logs of ramps and steps (thesis 5.2.3).   theory: docs/theory/identification/dynamic.md

The initial estimates come from :mod:`~hydrocrane.identification.bristles.readings`. The simulated rig is then fitted
to all logs at once. Nuisance parameters are fitted too, each with a prior: the static map, valve, oil and leakage of
the rig, and the errors of each sensor.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, cast

import numpy as np
from scipy import stats

from hydrocrane.arrays import Array, check_level, rms
from hydrocrane.asked import ask
from hydrocrane.errors import HydrocraneError, InputError
from hydrocrane.identification import solve
from hydrocrane.identification.bristles.model import (
    OTHER_DELAY,
    OTHER_FRICTION,
    OTHER_PLACE,
    OTHER_PRESSURE,
    Progress,
    RigLogModel,
    RigResiduals,
)
from hydrocrane.identification.bristles.readings import (
    DYNAMIC,
    BristleReading,
    check_bristles,
    first_readings,
    goes_beyond,
    key_of,
    map_prior,
    rig_map,
    unknowns_of,
    with_map,
    with_values,
)
from hydrocrane.identification.report import Section, Stage, Table, fitted_key, interval, signature
from hydrocrane.identification.sensors import Calibrated, RigSensors
from hydrocrane.identification.solve import Estimate, JointPrior, Unknown, labelled
from hydrocrane.identification.static.residuals import succession
from hydrocrane.identification.static.result import StaticFit
from hydrocrane.logs import Log
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


# A root-mean-square residual beyond this many standard deviations is not noise.
TOO_FAR = 1.5
# A parameter with a wider 95 % interval than this share of its value is not identifiable.
TOO_WIDE = 0.5
# Largest distance from its prior, in standard deviations, that is expected of an unknown in a correct model.
STRAINED = 4.5
# Tolerance of the fit that finds the start values, and the variance above which the model counts as wrong.
ROUGH, FAR_OFF = 1e-3, 100.0
# Factor on the noise in the first, softened fit, and its tolerance.
SOFTENED, ON_THE_WAY = (100.0, 10.0), 0.1
# Unknowns in the start of the simulation, with the largest change, Pa, m, N and s, that needs no new start, and the
# most repetitions of the fit from a new start.
MOVED = {
    "p1.start": 0.1 * OTHER_PRESSURE,
    "x.start": 0.1 * OTHER_PLACE,
    "rest.friction": 0.1 * OTHER_FRICTION,
    "delay": OTHER_DELAY,
}
MOST_MOVES = 5


def fit_dynamic(
    ramps: Sequence[Log],
    steps: Sequence[Log],
    rig: Machine,
    static: StaticFit | None = None,
    *,
    payload: float | None = None,
    calibrated: Calibrated = False,
    progress: Progress | None = None,
) -> DynamicFit:
    """Fit stiffness and damping of the bristles.

    Parameters
    ----------
    ramps, steps : sequences of Log
        Each from rest, with ``x``, ``p1``, ``p2`` and ``command``, evenly sampled; either may be empty.
    rig : Machine
        With bristle friction, whose parameters are guesses, and sensors as they were.
    static : StaticFit, optional
        The static map. Default is that of the rig with a standard deviation of 10 %, and of 20 % for its exponents if a
        ramp continues after break-away.
    payload : float, optional
        kg.
    calibrated : bool or (float, float)
        Whether the zeros of the pressure transmitters have been subtracted; or the remaining standard errors of p1 and
        p2 in Pa, as in :attr:`hydrocrane.signals.ZeroCalibrated.errors`.
    progress : callable, optional
        Called with evaluations of the fit and the root-mean-square residual in standard deviations.

    Returns
    -------
    DynamicFit
        If the simulated rig cannot be fitted, it has only the initial estimates and a warning with the reason.
    """
    logs = [*ramps, *steps]
    if not logs:
        raise InputError("a dynamic fit needs the log of a ramp or a step")
    check_bristles(rig)
    static = None if static is None else static.for_machines
    law = rig_map(rig) if static is None else static.law
    machine = with_map(rig, law)
    readings, warnings = first_readings(ramps, steps, machine, law, payload=payload)
    estimate: Estimate | None = None
    residuals: RigResiduals | None = None
    try:
        sensors = RigSensors.of(machine, calibrated=calibrated)
        read = {name: [r.value for r in found.values()] for name, found in readings.items()}
        joint = map_prior(machine, logs, static)
        exponents = static is None and any(goes_beyond(log, machine, law, payload) for log in ramps)

        def fitted_from(read: Mapping[str, Sequence[float]]) -> tuple[Estimate, RigResiduals, list[Unknown]]:
            keys, nuisances = unknowns_of(machine, logs, sensors, read, joint, exponents=exponents)
            names = [unknown.name for unknown in keys]
            models = [RigLogModel(log, machine, sensors, payload=payload, keys=names) for log in logs]
            return _fitted([*keys, *nuisances], RigResiduals(models, progress), joint)

        estimate, residuals, unknowns = fitted_from(read)
        if estimate.variance > FAR_OFF:
            # Initial estimates may mislead the search: repeat it from the values of the rig's file.
            other = fitted_from(dict.fromkeys(DYNAMIC, ()))
            estimate, residuals, unknowns = min(
                (estimate, residuals, unknowns), other, key=lambda found: found[0].variance
            )
        warnings += [*_doubts(estimate, residuals, machine), *_strained(estimate, unknowns, joint)]
        if static is None and not ramps:
            warnings += _resting(estimate, residuals)
    except HydrocraneError as error:
        if not any(readings.values()):
            raise
        warnings.append(f"the simulated rig could not be fitted; only the initial estimates are given: {error}")
    if static is None and estimate is not None and not any("exponent" in name for name in estimate.names):
        warnings.append(
            "the static map was not fitted and its exponents are those of the rig's file: viscous friction of another "
            "exponent counts as bristle damping; fit the map to logs of constant velocities, or add a ramp beyond "
            "break-away"
        )
    passive = _passive_up_to(machine, estimate)
    if np.isfinite(passive):
        warnings.append(f"friction with this damping returns energy above {passive:.3g} m/s")
    table = key_of(machine, "friction", DYNAMIC[0]).rsplit(".", 1)[0]
    return DynamicFit(machine, table, readings, estimate, residuals, passive, static, tuple(warnings))


def _fitted(
    unknowns: Sequence[Unknown], residuals: RigResiduals, joint: JointPrior | None
) -> tuple[Estimate, RigResiduals, list[Unknown]]:
    """The fit, repeated from the start values that it found until they no longer change: their effects are linear only
    nearby.

    A model with large residuals is not fitted again.
    """
    for softened in SOFTENED:
        near = solve.fit(unknowns, residuals, joint=joint, tolerance=ON_THE_WAY, softened=softened)
        unknowns = [unknown.started(value) for unknown, value in zip(unknowns, near.values, strict=True)]
    estimate = solve.fit(unknowns, residuals, joint=joint, tolerance=ROUGH)
    if estimate.variance > FAR_OFF:
        return estimate, residuals, list(unknowns)
    for _ in range(MOST_MOVES):
        unknowns = [_moved(unknown, float(value)) for unknown, value in zip(unknowns, estimate.values, strict=True)]
        residuals = residuals.restarted(estimate.values)
        estimate = solve.fit(unknowns, residuals, joint=joint)
        if _near(estimate):
            break
    return estimate, residuals, list(unknowns)


def _near(estimate: Estimate) -> bool:
    """Whether the fitted start values are close to those of the simulation."""
    by_name = zip(estimate.names, estimate.values, strict=True)
    return all(abs(value) <= MOVED.get(name.rsplit(" ", 1)[0], np.inf) for name, value in by_name)


def _moved(unknown: Unknown, value: float) -> Unknown:
    """The unknown with the fitted value as start; start values count from those of the new simulation."""
    if not unknown.name.startswith(tuple(MOVED)):
        return unknown.started(value)
    assert unknown.prior is not None
    mean, deviation = unknown.prior
    low, high = unknown.bounds
    return dataclasses.replace(unknown, start=0.0, prior=(mean - value, deviation), bounds=(low - value, high - value))


def expected(
    logs: Sequence[Log],
    rig: Machine,
    static: StaticFit | None = None,
    *,
    payload: float | None = None,
    calibrated: Calibrated = False,
) -> dict[str, float]:
    """Smallest standard deviations (Cramer-Rao), SI, that such logs allow if the values of the rig's file are true.

    By name: the bristle parameters, then all other unknowns of :func:`fit_dynamic`. Only the times, the command and the
    initial state of the logs matter, not their readings, so an experiment can be judged before it is run.
    """
    check_bristles(rig)
    sensors = RigSensors.of(rig, calibrated=calibrated)
    joint = map_prior(rig, logs, static)
    keys, nuisances = unknowns_of(rig, logs, sensors, dict.fromkeys(DYNAMIC, ()), joint)
    names = [unknown.name for unknown in keys]
    residuals = RigResiduals([RigLogModel(log, rig, sensors, payload=payload, keys=names) for log in logs])
    found = solve.bound([*keys, *nuisances], residuals, joint=joint)
    short = {key_of(rig, "friction", name): name for name in DYNAMIC}
    return {short.get(name, name): deviation for name, deviation in found.items()}


def _doubts(estimate: Estimate, residuals: RigResiduals, rig: Machine) -> list[str]:
    """Warnings on parameters that are not identifiable and on large residuals."""
    found = [] if estimate.converged else [f"the fit stopped early: {estimate.message}"]
    for log, signal, white in residuals.of_signals(estimate.values):
        size = rms(white[:, 0])
        along = succession("samples", white, [np.arange(len(white))])
        if size > TOO_FAR:
            found.append(
                f"{log}: residuals of {signal} are {size:.1f} times what its sensor explains: the rig's file, load or "
                "command is not that of the log, or the sensor is worse than its data sheet. Intervals are widened, "
                "but do not cover it"
            )
        if along is not None and along.shows:
            found.append(f"{log}, {signal}: {along.warning}")
    for name in DYNAMIC:
        key = key_of(rig, "friction", name)
        value, half = estimate[key], 1.96 * estimate.deviation(key)
        unit = rig.value(key).unit
        if key in estimate.at_bound:
            found.append(f"{name} ended at its physical bound, {value:.4g} {unit}: not identifiable from these logs")
        elif half > TOO_WIDE * abs(value):
            found.append(f"{name} is not identifiable from these logs: {value:.4g} +- {half:.2g} {unit}")
    return found


def _strained(estimate: Estimate, unknowns: Sequence[Unknown], joint: JointPrior | None) -> list[str]:
    """Warning on unknowns further from their priors than chance explains, which points to another error."""
    priors = {u.name: u.prior for u in unknowns if u.prior is not None}
    if joint is not None:
        priors |= {
            name: (mean, deviation)
            for name, mean, deviation in zip(joint.names, joint.mean, joint.deviations, strict=True)
        }
    far = {name: abs(estimate[name] - mean) / deviation for name, (mean, deviation) in priors.items()}
    worst = max(far, key=lambda name: far[name])
    if far[worst] < STRAINED:
        return []
    return [
        f"the fit moves {worst} by {far[worst]:.0f} standard deviations from its prior; check load, rig file "
        "and sensors before trusting anything here"
    ]


def _resting(estimate: Estimate, residuals: RigResiduals) -> list[str]:
    """Warnings on friction at rest, which a wrong load looks like where no log moves on."""
    found = []
    for k, model in enumerate(residuals.models):
        name = f"rest.friction {k}"
        friction = model.moved[2] + estimate[name]
        if abs(friction) > STRAINED * estimate.deviation(name):
            found.append(
                f"{model.source}: the piston rests with {friction:.3g} N of friction, or the load is off by as much: "
                "steps alone do not tell them apart; check load, or add a ramp beyond break-away"
            )
    return found


def _passive_up_to(rig: Machine, estimate: Estimate | None) -> float:
    """Lowest speed, m/s, at which friction with the fitted damping returns energy; infinite if there is none."""
    if estimate is None:
        return float("inf")
    keys = [key_of(rig, "friction", name) for name in DYNAMIC]
    fitted = with_values(rig, keys, np.array([estimate[key] for key in keys]))
    limits = [e["velocity_limit"] for e in fitted.passivity() if e["velocity_limit"] is not None]
    return float(min(limits, default=np.inf))
