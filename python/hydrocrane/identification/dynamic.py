"""Dynamic friction from logs of ramps and steps (thesis 5.2.3).   theory: docs/theory/identification/dynamic.md

The initial estimates come from :mod:`~hydrocrane.identification.bristle`. The simulated rig is then fitted to all logs
at once. Nuisance parameters are fitted too, each with a prior: the static map, valve, oil and leakage of the rig, and
the errors of each sensor.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from hydrocrane.arrays import rms
from hydrocrane.errors import HydrocraneError, InputError
from hydrocrane.identification import output_error
from hydrocrane.identification.bristle import first_readings, goes_beyond
from hydrocrane.identification.dynamic_result import DynamicFit
from hydrocrane.identification.neighbours import succession
from hydrocrane.identification.output_error import Estimate, JointPrior, Unknown
from hydrocrane.identification.result import StaticFit
from hydrocrane.identification.rig_model import (
    OTHER_DELAY,
    OTHER_FRICTION,
    OTHER_PLACE,
    OTHER_PRESSURE,
    Progress,
    RigLogModel,
    RigResiduals,
)
from hydrocrane.identification.rig_unknowns import (
    DYNAMIC,
    check_bristles,
    key_of,
    map_prior,
    rig_map,
    unknowns_of,
    with_map,
    with_values,
)
from hydrocrane.identification.sensors import Calibrated, RigSensors
from hydrocrane.logs import Log
from hydrocrane.machine.machine import Machine

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
        near = output_error.fit(unknowns, residuals, joint=joint, tolerance=ON_THE_WAY, softened=softened)
        unknowns = [unknown.started(value) for unknown, value in zip(unknowns, near.values, strict=True)]
    estimate = output_error.fit(unknowns, residuals, joint=joint, tolerance=ROUGH)
    if estimate.variance > FAR_OFF:
        return estimate, residuals, list(unknowns)
    for _ in range(MOST_MOVES):
        unknowns = [_moved(unknown, float(value)) for unknown, value in zip(unknowns, estimate.values, strict=True)]
        residuals = residuals.restarted(estimate.values)
        estimate = output_error.fit(unknowns, residuals, joint=joint)
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
    found = output_error.bound([*keys, *nuisances], residuals, joint=joint)
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
