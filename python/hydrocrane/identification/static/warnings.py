"""Warnings of a static fit, the most fundamental first."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrocrane.identification.report import interval
from hydrocrane.identification.static.maps import FAR, of_sensors
from hydrocrane.identification.static.points import DIRECTIONS
from hydrocrane.identification.static.result import StaticFit, missing_directions

# A parameter whose 95 % interval reaches further than this share of its value is called poorly known.
POOR = 0.5
# The same for the friction at a speed beyond the measured ones.
OPEN = 0.2
# Above this condition number of the scaled columns parameters have the same effect.
ILL_CONDITIONED = 1e4


def warnings_of(fit: StaticFit, with_prior: bool) -> tuple[str, ...]:
    """Warnings of a fit, the most fundamental first."""
    return (
        *(f"no points {name}: friction is unknown {name}" for name in missing_directions(fit)),
        *_levels(fit),
        *_bounds(fit),
        *_poorly_known(fit),
        *_extrapolated(fit),
        *_too_few(fit),
        *(fit.residual_analysis.warnings if fit.residual_analysis else ()),
        *(fit.held_out.warnings if fit.held_out else ()),
        *(each.warning for each in fit.successions if each.shows),
        *_of_sensors(fit, with_prior),
        *_rejection(fit),
    )


def _levels(fit: StaticFit) -> Iterator[str]:
    """Warnings on missing velocities."""
    used = fit.points.select(fit.accepted)
    known = () if fit.spread is None else zip(fit.spread.labels, np.diag(fit.spread.from_data), strict=True)
    not_identifiable = [label for label, variance in known if np.isinf(variance)]
    for side, name in enumerate(DIRECTIONS):
        here = used.levels.direction == side
        speed = np.abs(used.levels.velocity[here])
        if speed.size == 0:
            continue
        stribeck = fit.params["stribeck-velocity"][side]
        if speed.size == 1:
            yield (
                f"{name}: one velocity level only; Coulomb, Stribeck and viscous friction cannot be distinguished, "
                "and all is counted as Coulomb friction"
            )
            continue
        if f"stribeck-velocity.{name}" in not_identifiable:
            yield (
                f"{name}: Stribeck friction is not seen in these levels (the slowest at {speed.min() * 1e3:.3g} mm/s) "
                "and was left out: break-away force and Stribeck velocity are not measured values. Add slower "
                "levels or break-away readings"
            )
            stribeck = 0.0
        elif not (speed < stribeck).any():
            yield (
                f"{name}: no level slower than the Stribeck velocity ({stribeck * 1e3:.3g} mm/s); "
                "break-away force and Stribeck velocity have the same effect: add slower levels"
            )
        if (speed > FAR * stribeck).sum() < 2:
            yield (
                f"{name}: fewer than two levels beyond {FAR:g} Stribeck velocities ({FAR * stribeck * 1e3:.3g} mm/s); "
                "viscous and Coulomb friction cannot be distinguished: add faster levels"
            )


def _bounds(fit: StaticFit) -> Iterator[str]:
    for label in fit.at_bounds:
        name, direction = label.split(".")
        what = "Stribeck rise (break-away less Coulomb)" if name == "breakaway" else name
        yield f"{direction}: {what} ended at its physical bound"


def _poorly_known(fit: StaticFit) -> Iterator[str]:
    for label, (low, high) in fit.intervals(0.95).items():
        value = fit.value(label)
        if of_sensors(label):
            continue
        if not np.isfinite([low, high]).all():
            yield f"{label} is not identifiable from these points"
        elif low == 0.0:
            yield f"{label} is {interval(low, high)} (95 %)"
        elif max(high - value, value - low) > POOR * abs(value):
            yield f"{label} is poorly known: {value:.4g}, 95 % interval {low:.4g} to {high:.4g}"
    spread = fit.spread
    if spread is not None and spread.condition > ILL_CONDITIONED:
        yield f"parameters have the same effect: condition number {spread.condition:.2g}; see the correlation"


def _extrapolated(fit: StaticFit) -> Iterator[str]:
    """Warning on a map that leaves friction open beyond the measured speeds."""
    for side, (name, sign) in enumerate(zip(DIRECTIONS, (1.0, -1.0), strict=True)):
        speeds = fit.shown_speeds(side)
        if not speeds.size:
            continue
        low, high = sorted(np.abs(fit.force_interval(sign * speeds[-1:])[0]))
        force = float(np.abs(fit.force(sign * speeds[-1])))
        if max(high - force, force - low) > OPEN * force:
            known = f"95 % {low:.3g} to {high:.3g} N" if np.isfinite(high) else "but anything else is as likely"
            yield (
                f"{name}: beyond {speeds[-2] * 1e3:.3g} mm/s, the fastest level, the map is an extrapolation: at "
                f"{speeds[-1] * 1e3:.3g} mm/s it gives {force:.3g} N, {known}; add faster levels"
            )


def _too_few(fit: StaticFit) -> Iterator[str]:
    if fit.residual_analysis is not None and fit.residual_analysis.spare <= 0:
        yield "as many parameters as levels or more: no level is left to check the map"


def _of_sensors(fit: StaticFit, with_prior: bool) -> Iterator[str]:
    """Warning on constant errors of the force and on spans: both shift the Coulomb friction of one direction against
    the other."""
    spread = fit.spread
    if not with_prior or spread is None:
        return
    for label in ("coulomb.extending", "coulomb.retracting"):
        if label in spread.labels:
            at = spread.labels.index(label)
            if spread.from_prior[at, at] > spread.from_data[at, at]:
                yield (
                    "the constant error of the force sensors limits how well Coulomb friction of a single direction "
                    "is known; its sum over both directions is known better. A zero calibration helps"
                    + (", logs at a second supply pressure identify the spans" if any(fit.spans) else "")
                )
                return


def _rejection(fit: StaticFit) -> Iterator[str]:
    if len(fit.rejected) > 0.1 * len(fit.points):
        yield f"{len(fit.rejected)} of {len(fit.points)} points were left out; look at them before trusting the rest"
