"""Dynamic friction from logs of ramps and steps (thesis 5.2.3).   theory: docs/theory/identification/dynamic.md

First the readings of :mod:`~hydrocrane.identification.bristle`; from there the simulated rig is fitted to all logs at
once. What the fit does not want to know but cannot leave out goes along with a prior: the static map with its own
covariance, the valve's flow, bias and span of each sensor.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import stats

from hydrocrane.arrays import Array
from hydrocrane.errors import HydrocraneError, InputError
from hydrocrane.identification import bristle, output_error
from hydrocrane.identification.output_error import Estimate, Unknown
from hydrocrane.identification.rig_model import LogModel, Reader
from hydrocrane.identification.static_map import LABELS, StaticMap
from hydrocrane.logs import Log
from hydrocrane.machine import Machine, load_machine
from hydrocrane.signals import friction_force

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from hydrocrane.identification.result import StaticFit

DYNAMIC = ("bristle-stiffness", "bristle-damping")
UNITS = {"bristle-stiffness": "N/m", "bristle-damping": "N s/m"}
# Parameters of the static map that go along; its exponents stay as they are.
STATIC = ("coulomb", "breakaway", "stribeck-velocity", "viscous")
# How far the static map may be off where no fit of it is given, as a share.
UNFITTED_SHARE = 0.1
# How far the valve's flow may be off its data sheet, as a share.
VALVE_SHARE = 0.2
# Largest bias of a pressure after and without a zero calibration, and of its span and the potentiometer's, as shares of
# the data sheet's bound: the bounds are those of a uniform distribution.
UNIFORM = 1.0 / np.sqrt(3.0)
CALIBRATED_BIAS = 2e3
# A parameter with a wider 95 % interval than this share of its value is not told by the data.
TOO_WIDE = 0.5
NUISANCES = ("p1.offset", "p2.offset", "p1.span", "p2.span", "x.span")


@dataclass(frozen=True)
class DynamicFit:
    """Bristle stiffness and damping, and how far they can be trusted.

    Attributes
    ----------
    readings : dict
        By parameter and log, the first readings.
    estimate : Estimate or None
        Of all unknowns, nuisances too; None where the fit failed.
    bound : dict
        Smallest standard deviation that these logs allow at the estimate (Cramer-Rao), by unknown.
    passive_up_to : float
        Lowest speed (m/s) at which friction with these parameters gives energy back; infinite: nowhere.
    models : tuple of LogModel
    warnings : tuple of str
    """

    cylinder: str
    readings: dict[str, dict[str, bristle.Reading]]
    estimate: Estimate | None
    bound: Mapping[str, float]
    passive_up_to: float
    models: tuple[LogModel, ...]
    warnings: tuple[str, ...] = field(default=())

    @property
    def params(self) -> dict[str, float]:
        """``bristle-stiffness`` (N/m) and ``bristle-damping`` (N s/m): fitted, else the mean of the readings."""
        if self.estimate is not None:
            return {name: self.estimate[self._key(name)] for name in DYNAMIC}
        return {name: float(np.mean([r.value for r in found.values()])) for name, found in self.readings.items() if found}

    @property
    def covariance(self) -> xr.DataArray:
        """(2, 2) covariance of the two, in products of their units, everything else left free."""
        import xarray as xr

        found = self._fitted()
        pick = [found.names.index(self._key(name)) for name in DYNAMIC]
        return xr.DataArray(
            found.covariance[np.ix_(pick, pick)], dims=("row", "column"), coords={"row": list(DYNAMIC), "column": list(DYNAMIC)}
        )

    def intervals(self, level: float = 0.95) -> dict[str, tuple[float, float]]:
        """Confidence intervals, SI."""
        if not 0.0 < level < 1.0:
            raise InputError(f"a confidence level lies between 0 and 1, got {level!r}")
        found, width = self._fitted(), float(stats.norm.ppf(0.5 + 0.5 * level))
        half = {name: width * found.deviation(self._key(name)) for name in DYNAMIC}
        return {name: (value - half[name], value + half[name]) for name, value in self.params.items()}

    def plot(self) -> Figure:
        """The logs with what the fitted rig would have given."""
        from hydrocrane.plots.identification import dynamic_fit

        return dynamic_fit(self)

    def predicted(self, model: LogModel) -> Array:
        """x, p1, p2 of a log (m, 3), SI, as the fitted rig and its sensors give them."""
        found = self._fitted()
        index = self.models.index(model)
        theta = found.values
        return _read(model.predict(theta[: len(model.experiment.keys)])[0], _nuisances(found, index))[0]

    def _key(self, name: str) -> str:
        return f"friction.{self.cylinder}.{name}"

    def _fitted(self) -> Estimate:
        if self.estimate is None:
            raise InputError("the fit did not come to an end: " + "; ".join(self.warnings))
        return self.estimate


def fit_dynamic(
    ramps: Sequence[Log],
    steps: Sequence[Log],
    rig: Machine,
    static: StaticFit | None = None,
    *,
    payload: float | None = None,
    calibrated: bool = False,
    progress: Callable[[int, float], None] | None = None,
) -> DynamicFit:
    """Find the bristles' stiffness and damping.

    Parameters
    ----------
    ramps, steps : sequences of Log
        Each from rest, with ``x``, ``p1``, ``p2`` and ``command``, evenly sampled; either may be empty.
    rig : Machine
        With one cylinder; what is not fitted is taken from it, the valve and the oil above all.
    static : StaticFit, optional
        The static map; without it the rig's own is taken, and allowed to be off by 10 %.
    payload : float, optional
        kg.
    calibrated : bool
        The zero of the pressure transmitters has been subtracted.
    progress : callable, optional
        Called with evaluations of the fit and the root-mean-square weighted residual.
    """
    logs = [*ramps, *steps]
    if not logs:
        raise InputError("a dynamic fit needs the log of a ramp or a step")
    cylinder = rig.cylinder_names[0]
    law = rig_map(rig) if static is None else static.law
    crane = _with_map(rig, law)
    readings, warnings = _readings(ramps, steps, crane, law, payload)
    unknowns = _unknowns(crane, readings, static, calibrated, len(logs))
    keys = [u.name for u in unknowns if u.name.startswith(("friction.", "valve."))]
    models = tuple(LogModel(log, crane, reader(crane), payload=payload, keys=keys) for log in logs)
    misfit = _Misfit(models, len(keys), progress)
    estimate, bound = None, {}
    try:
        estimate = output_error.fit(unknowns, misfit)
        bound = output_error.bound(_moved(unknowns, estimate), misfit)
    except HydrocraneError as error:
        warnings.append(f"the simulated rig could not be fitted: {error}")
    if estimate is not None:
        warnings += _doubts(estimate, cylinder)
    passive = _passive_up_to(crane, cylinder, estimate)
    if np.isfinite(passive):
        warnings.append(f"friction with this damping gives energy back above {passive:.3g} m/s")
    return DynamicFit(cylinder, readings, estimate, bound, passive, models, tuple(warnings))


def expected(
    logs: Sequence[Log], rig: Machine, static: StaticFit | None = None, *, payload: float | None = None, calibrated: bool = False
) -> Mapping[str, float]:
    """Smallest standard deviations that such logs allow where the rig's own parameters are the true ones, by unknown:
    the Fisher information of an experiment. The readings in the logs do not matter, only when they were taken."""
    unknowns = _unknowns(rig, {name: {} for name in DYNAMIC}, static, calibrated, len(logs))
    keys = [u.name for u in unknowns if u.name.startswith(("friction.", "valve."))]
    models = tuple(LogModel(log, rig, reader(rig), payload=payload, keys=keys) for log in logs)
    return output_error.bound(unknowns, _Misfit(models, len(keys), None))


def rig_map(rig: Machine) -> StaticMap:
    """The static map that a rig's file has."""
    name = f"friction.{rig.cylinder_names[0]}."
    return StaticMap.of({key: rig.value(name + key).si for key in dict.fromkeys(label.split(".")[0] for label in LABELS)})


def reader(rig: Machine) -> Reader:
    """What the sensors of a rig do, by its file."""
    pressure, position = _sensor(rig, ".p1"), _sensor(rig, ".q")
    steps = {"pressure": 2.0 ** -pressure.get("bits", 24), "position": 2.0 ** -position.get("bits", 24)}
    full, span = pressure["range"], position["range"]
    white = np.hypot(pressure.get("noise", 0.0), steps["pressure"] / np.sqrt(12.0)) * full
    fine = np.hypot(position.get("noise", 0.0), steps["position"] / np.sqrt(12.0)) * span
    coarse = np.hypot(position.get("repeatability", 0.0), 0.1 * position.get("linearity", 0.0)) * span * UNIFORM
    return Reader(pressure.get("rise-time", 0.0) / np.log(9.0), max(white, 1.0), max(fine, 1e-7), float(coarse))


def _sensor(rig: Machine, ending: str) -> dict[str, float]:
    """Numbers of the sensor whose signal ends like this."""
    measured = rig.sensors
    name = next((name for name, signal in measured.items() if signal.endswith(ending)), None)
    if name is None:
        raise InputError(f"{rig.name} has no sensor for a signal that ends in `{ending}`; add one to its file")
    head = f"sensor.{name}."
    return {key.removeprefix(head): float(rig.value(key).si) for key in rig.keys if key.startswith(head)}


def _with_map(rig: Machine, law: StaticMap) -> Machine:
    head = f"friction.{rig.cylinder_names[0]}."
    changes = {head + name: list(pair) for name, pair in law.pairs.items()}
    return load_machine(rig.source, {**rig.overrides, **changes})


def _readings(
    ramps: Sequence[Log], steps: Sequence[Log], rig: Machine, law: StaticMap, payload: float | None
) -> tuple[dict[str, dict[str, bristle.Reading]], list[str]]:
    """First readings of every piece of every log; what cannot be read becomes a warning."""
    found: dict[str, dict[str, bristle.Reading]] = {name: {} for name in DYNAMIC}
    warnings = []
    for log in ramps:
        for label, piece in _motions(log, rig, payload):
            try:
                found["bristle-stiffness"][label] = bristle.stiffness(*piece, law)
            except HydrocraneError as error:
                warnings.append(f"{label}: no reading of the stiffness: {error}")
    known = [r.value for r in found["bristle-stiffness"].values()]
    stiffness = float(np.mean(known)) if known else _own(rig, "bristle-stiffness")
    for log in steps:
        for label, piece in _motions(log, rig, payload):
            try:
                found["bristle-damping"][label] = bristle.damping(*piece, law, stiffness)
            except HydrocraneError as error:
                warnings.append(f"{label}: no reading of the damping: {error}")
    return found, warnings


def _motions(log: Log, rig: Machine, payload: float | None) -> list[tuple[str, tuple[Array, Array, Array, Array]]]:
    """(time, position, velocity, friction) from the first rest to the end of the first motion, less their values at
    rest: later motions start with bent bristles."""
    from hydrocrane.signals import RigParameters

    data = friction_force(log.usable("x", "p1", "p2", "command"), RigParameters.of(rig, payload=payload))
    time = np.asarray(data["time"].values)
    command = np.interp(time, log.time, log["command"])
    open_ = np.abs(command) > 1e-3 * np.abs(command).max()
    if not open_.any():
        return []
    first = int(np.argmax(open_))
    closed = np.flatnonzero(~open_[first:])
    last = first + int(closed[0]) if closed.size else len(time)
    start = max(first - 5, 0)
    rest = slice(0, max(first, 1))
    x = np.interp(time, log.time, log["x"])
    friction, velocity = np.asarray(data["friction"].values), np.asarray(data["velocity"].values)
    pick = slice(start, last)
    piece = (time[pick], (x - np.median(x[rest]))[pick], velocity[pick], (friction - np.median(friction[rest]))[pick])
    return [(f"{log.source}, {time[start]:.2f} to {time[last - 1]:.2f} s", piece)]


def _own(rig: Machine, name: str) -> float:
    return float(rig.value(f"friction.{rig.cylinder_names[0]}.{name}").si)


def _unknowns(
    rig: Machine, readings: dict[str, dict[str, bristle.Reading]], static: StaticFit | None, calibrated: bool, logs: int
) -> list[Unknown]:
    head = f"friction.{rig.cylinder_names[0]}."
    unknowns = []
    for name in DYNAMIC:
        own = _own(rig, name)
        read = [r.value for r in readings[name].values() if 0.1 * own < r.value < 10.0 * own]
        start = float(np.median(read)) if read else own
        highest = _most_damping(rig) if name == "bristle-damping" else np.inf
        unknowns.append(Unknown(head + name, min(start, 0.9 * highest), 0.1 * start, bounds=(0.0, highest)))
    for name in STATIC:
        for side, value in enumerate(np.atleast_1d(rig.value(head + name).si)):
            deviation = _deviation(static, f"{name}.{('extending', 'retracting')[side]}", float(value))
            bounds = _static_bounds(rig, name, side)
            unknowns.append(Unknown(f"{head}{name}[{side}]", float(value), deviation, (float(value), deviation), bounds))
    valve = f"valve.{rig.cylinder_names[0]}.nominal-flow"
    flow = float(rig.value(valve).si)
    unknowns.append(Unknown(valve, flow, 0.01 * flow, (flow, VALVE_SHARE * flow), (0.1 * flow, 10.0 * flow)))
    pressure, position = _sensor(rig, ".p1"), _sensor(rig, ".q")
    bias = CALIBRATED_BIAS if calibrated else pressure.get("accuracy", 0.003) * pressure["range"] * UNIFORM
    span = max(pressure.get("accuracy", 0.003), 1e-6) * UNIFORM
    bow = max(4.0 * position.get("linearity", 0.0), 1e-6) * UNIFORM
    for name, deviation in zip(NUISANCES, (bias, bias, span, span, bow), strict=True):
        unknowns.append(Unknown(name, 0.0, deviation, (0.0, deviation)))
    coarse = 2.0 * reader(rig).position_error + 1e-4
    return unknowns + [Unknown(f"x.offset {k}", 0.0, coarse, (0.0, coarse)) for k in range(logs)]


def _static_bounds(rig: Machine, name: str, side: int) -> tuple[float, float]:
    """Coulomb and break-away force stay on their sides of the middle between them; velocities stay above zero."""
    head = f"friction.{rig.cylinder_names[0]}."
    middle = 0.5 * float(rig.value(head + "coulomb").si[side] + rig.value(head + "breakaway").si[side])
    own = float(np.atleast_1d(rig.value(head + name).si)[side])
    return {"coulomb": (0.0, middle), "breakaway": (middle, np.inf)}.get(name, (0.1 * own, 10.0 * own))


def _deviation(static: StaticFit | None, label: str, value: float) -> float:
    """Standard deviation of a parameter of the static map."""
    if static is not None and static.spread is not None and label in static.spread.labels:
        i = static.spread.labels.index(label)
        variance = float(static.covariance.values[i, i])
        if np.isfinite(variance) and variance > 0.0:
            return float(np.clip(np.sqrt(variance), 1e-3 * value, value))
    return UNFITTED_SHARE * value


def _most_damping(rig: Machine) -> float:
    """Largest sigma_1 with which friction dissipates at every speed: sigma_1(v) |v| has its top at v_d / sqrt(2) and
    must stay below four times the smaller Coulomb force."""
    head = f"friction.{rig.cylinder_names[0]}."
    coulomb = float(np.min(rig.value(head + "coulomb").si))
    if head + "bristle-damping-velocity" not in rig.keys:
        return 4.0 * coulomb / 0.1
    return 4.0 * coulomb * np.sqrt(2.0 * np.e) / float(rig.value(head + "bristle-damping-velocity").si)


class _Misfit:
    """Weighted residuals of all logs with their slopes by keys, common nuisances and one position offset per log."""

    def __init__(self, models: Sequence[LogModel], keys: int, progress: Callable[[int, float], None] | None) -> None:
        self.models, self.keys, self.progress = models, keys, progress
        self.calls = 0

    def __call__(self, theta: Array) -> tuple[Array, Array]:
        residuals, slopes = [], []
        common = theta[self.keys : self.keys + len(NUISANCES)]
        for k, model in enumerate(self.models):
            y, dy = model.predict(theta[: self.keys])
            offset = theta[self.keys + len(NUISANCES) + k]
            seen, by_nuisance = _read(y, np.append(common, offset))
            spans = 1.0 + np.array([common[4], common[2], common[3]])
            row = np.zeros((*y.shape, len(theta)))
            row[:, :, : self.keys] = dy * spans[:, np.newaxis]
            row[:, 0, : self.keys] -= common[4] * dy[:1, 0]
            row[:, :, self.keys : self.keys + len(NUISANCES)] = by_nuisance[:, :, :-1]
            row[:, :, self.keys + len(NUISANCES) + k] = by_nuisance[:, :, -1]
            residuals.append(((seen - model.measured) * model.weight).ravel())
            slopes.append((row * model.weight[:, :, np.newaxis]).reshape(-1, len(theta)))
        found = np.concatenate(residuals)
        self.calls += 1
        if self.progress is not None:
            self.progress(self.calls, float(np.sqrt(np.mean(found**2))))
        return found, np.vstack(slopes)


def _read(y: Array, nuisance: Array) -> tuple[Array, Array]:
    """Readings (m, 3) of signals (m, 3) with bias and span of the sensors, and their slopes by these (m, 3, 6)."""
    p1_offset, p2_offset, p1_span, p2_span, x_span, x_offset = nuisance
    way = y[:, 0] - y[0, 0]
    seen = np.stack(
        [y[:, 0] + x_offset + x_span * way, y[:, 1] * (1.0 + p1_span) + p1_offset, y[:, 2] * (1.0 + p2_span) + p2_offset],
        axis=-1,
    )
    slopes = np.zeros((*y.shape, 6))
    slopes[:, 1, 0] = slopes[:, 2, 1] = slopes[:, 0, 5] = 1.0
    slopes[:, 1, 2], slopes[:, 2, 3], slopes[:, 0, 4] = y[:, 1], y[:, 2], way
    return seen, slopes


def _nuisances(found: Estimate, log: int) -> Array:
    return np.array([*(found[name] for name in NUISANCES), found[f"x.offset {log}"]])


def _moved(unknowns: Sequence[Unknown], estimate: Estimate) -> list[Unknown]:
    return [Unknown(u.name, float(v), u.scale, u.prior, u.bounds) for u, v in zip(unknowns, estimate.values)]


def _doubts(estimate: Estimate, cylinder: str) -> list[str]:
    """What the data do not tell."""
    found = [] if estimate.converged else [f"the fit stopped early: {estimate.message}"]
    if estimate.variance > 2.0:
        found.append(
            f"the residuals are {np.sqrt(estimate.variance):.1f} times what the sensors' noise explains; the model of the rig "
            "lacks something, or a sensor is worse than its file says. The intervals are widened by that"
        )
    for name in DYNAMIC:
        key = f"friction.{cylinder}.{name}"
        value, half = estimate[key], 1.96 * estimate.deviation(key)
        if key in estimate.at_bound:
            found.append(f"{name} ended at the edge of what is physical, {value:.4g}; these logs do not tell it")
        elif half > TOO_WIDE * abs(value):
            found.append(f"{name} cannot be told from these logs: {value:.4g} +- {half:.2g} {UNITS[name]}")
    return found


def _passive_up_to(rig: Machine, cylinder: str, estimate: Estimate | None) -> float:
    if estimate is None:
        return float("inf")
    changes: dict[str, Any] = {f"friction.{cylinder}.{n}": estimate[f"friction.{cylinder}.{n}"] for n in DYNAMIC}
    fitted = load_machine(rig.source, {**rig.overrides, **changes})
    limits = [entry["velocity_limit"] for entry in fitted.passivity() if not entry["holds"]]
    return float(min(limits, default=np.inf))
