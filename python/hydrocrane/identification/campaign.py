"""Identification of a cylinder's friction from the logs of a rig: all stages in order. A failed stage does not end
it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.identification.bristles.fit import DynamicFit, fit_dynamic
from hydrocrane.identification.campaign_result import Identification, LeftOut, Stage
from hydrocrane.identification.records import RAMP, STEADY, STEP, FrictionLog, ReadingOptions
from hydrocrane.identification.sensors import PRESSURES, bias_without_zero, largest_error, linearity_error, span_error
from hydrocrane.identification.static.comparison import FrictionComparison, compare_friction
from hydrocrane.identification.static.maps import EXPONENTS, Exponents, FormRequest
from hydrocrane.identification.static.points import DIRECTIONS, FrictionPoints
from hydrocrane.identification.static.stage import StaticIdentification, identify_static
from hydrocrane.logs.columns import LogLike
from hydrocrane.logs.mapping import MappingLike
from hydrocrane.machine.machine import Machine, MachineLike, as_machine
from hydrocrane.signals import RigParameters, SteadyWindows, steady_windows

if TYPE_CHECKING:
    from hydrocrane.identification.static.result import StaticFit


T = TypeVar("T")
LOGS, WINDOWS, STATIC, COMPARISON, BRISTLES = (
    "logs",
    "steady windows",
    "static friction",
    "load and pressure",
    "bristles",
)
# A difference between loads or pressures that would matter, as a share of the friction.
MARGIN = 0.1
# Sensor errors explain a deviation up to this many standard deviations.
CLEAR = 3.0


def identify_friction(
    logs: LogLike | Iterable[LogLike] = (),
    rig: MachineLike = "rig-rottne",
    *,
    ramps: LogLike | Iterable[LogLike] = (),
    steps: LogLike | Iterable[LogLike] = (),
    mapping: MappingLike = None,
    payload: float | None = None,
    zero: tuple[float, float] | None = None,
    window: tuple[float, float] | None = None,
    load_cell: bool = False,
    rod_mass: float = 0.0,
    exponents: Exponents = "chosen",
    progress: Callable[[str], None] | None = None,
) -> Identification:
    """Identify the friction of a rig's cylinder from its logs.

    Parameters
    ----------
    logs : path, Log, RigLog, or several
        Logs of constant velocities; those that name their experiment may also be ramps and steps.
    rig : Machine, str or path
        With one cylinder that moves its load along a straight line.
    ramps, steps : as `logs`
        Logs from rest of a slowly opening valve and of small steps within the bristles' reach.
    mapping : path or dict, optional
        Assigns columns of the logs to signals, see ``docs/reference/log-files.md``.
    payload : float, optional
        Load on the rod, kg; by default as the logs state, else the rig's own.
    zero : (float, float), optional
        Seconds (from, to) in which both chambers were open to the tank with the load supported, in every log. By
        default the calibration that a log states.
    window : (float, float), optional
        Seconds (from, to) of every log to use; the zero may lie outside. A ramp or step must be at rest at its begin.
    load_cell : bool
        Take the load's weight from ``force``.
    rod_mass : float
        Moving mass on the cylinder's side of the load cell, kg.
    exponents : {"chosen", "fixed", "free"} or dict
        As for ``hydrocrane.identification.fit_static``. Held exponents have the values of the
        rig's file.
    progress : callable, optional
        Called with a text about the progress.

    Returns
    -------
    Identification
        All identified parameters, and for each failed stage the reason.

    Raises
    ------
    HydrocraneError
        If a file cannot be read or an argument is invalid. Faulty readings fail their stage instead.

    Examples
    --------
    >>> from hydrocrane import rig
    >>> log = rig.run("constant-velocity", seed=3, calibration=1.0)
    >>> found = hc.identify_friction([log], "rig-rottne")
    >>> low, high = found.static.fit.intervals(0.95)["coulomb.extending"]
    >>> print(f"Coulomb friction, extending: {low:.0f} to {high:.0f} N")
    Coulomb friction, extending: 160 to 164 N
    """
    machine = as_machine(rig)
    RigParameters.of(machine, payload=payload)
    FormRequest.of(exponents)
    tell = progress or (lambda _: None)
    tell("reading the logs")
    reading = ReadingOptions(machine, mapping, payload, zero, load_cell, window)
    records = [*reading.records(logs, ""), *reading.records(ramps, RAMP), *reading.records(steps, STEP)]
    if not records:
        raise InputError("no log was given; identification starts from logs of constant velocity")
    campaign = _Campaign(Identification(machine, records), tell, load_cell, rod_mass, exponents)
    campaign.run()
    return campaign.found


def held_exponents(rig: Machine) -> dict[str, Array]:
    """Exponents of the friction of a rig's cylinder, (extending, retracting), that its file states."""
    found = {}
    for name in EXPONENTS:
        for key in rig.keys:
            if key.startswith("friction.") and key.endswith(f".{name}"):
                found[name] = np.asarray(rig.value(key).si, dtype=float)
    return found


class _Campaign:
    """The stages in order; each uses the results of the earlier ones."""

    def __init__(
        self,
        found: Identification,
        tell: Callable[[str], None],
        load_cell: bool,
        rod_mass: float,
        exponents: Exponents,
    ) -> None:
        self.found, self.tell, self.load_cell = found, tell, load_cell
        self.rod_mass, self.exponents = rod_mass, exponents
        self.usable: list[FrictionLog] = []
        self.steady: list[FrictionLog] = []

    def run(self) -> None:
        found = self.found
        self._stage(LOGS, self._check)
        if self._of(STEADY):
            self._stage(WINDOWS, self._windows)
            found.static = self._stage(STATIC, self._static) if found.windows else None
            if found.static is not None:
                found.warnings += found.static.fit.warnings
            if len(self._groups()) > 1:
                found.comparison = self._stage(COMPARISON, self._compare)
        else:
            found.stages.append(Stage(STATIC, "skipped", self._lack("log of constant velocity", STEADY)))
        if self._of(RAMP, STEP):
            found.dynamic = self._stage(BRISTLES, self._dynamic)
        else:
            found.stages.append(Stage(BRISTLES, "skipped", self._lack("ramp or step", RAMP, STEP)))

    def _of(self, *roles: str) -> list[FrictionLog]:
        return [record for record in self.usable if record.role in roles]

    def _lack(self, what: str, *roles: str) -> str:
        given = any(record.role in roles for record in self.found.records)
        return f"no {what} can be used" if given else f"no {what} was given"

    def _stage(self, name: str, make: Callable[[], T]) -> T | None:
        """The result of `make`; if it fails, its message becomes that of the stage."""
        try:
            result = make()
        except (ValueError, ArithmeticError) as error:
            self.found.stages.append(Stage(name, "failed", str(error) or type(error).__name__))
            return None
        if not any(stage.name == name for stage in self.found.stages):
            self.found.stages.append(Stage(name))
        return result

    # --- logs -------------------------------------------------------------------------------------------------------

    def _check(self) -> None:
        """Leaves out logs with a fatal flag; other flags become warnings."""
        spoilt = []
        for record in self.found.records:
            self.found.warnings += [f"{record.name} {note}" for note in record.notes]
            self.found.warnings += [f"{record.name}: {flag.message}" for flag in record.log.flags if not flag.fatal]
            if record.log.fatal:
                spoilt.append(f"{record.name}: " + "; ".join(flag.message for flag in record.log.fatal))
            elif record.role:
                self.usable.append(record)
        self._warn_of_zeros()
        if spoilt:
            raise InputError("; ".join(spoilt))

    def _warn_of_zeros(self) -> None:
        rig = self.found.rig
        if any(largest_error(rig, name) is None for name in PRESSURES):
            self.found.warnings.append(
                f"the file of {rig.name} has no sensors of p1 and p2: intervals do not include their bias and span"
            )
        lacking = [record for record in self.usable if record.zero is None]
        bias = max((self._bias(record) for record in lacking), default=0.0)
        if bias:
            self.found.warnings.append(
                f"no zero calibration in {', '.join(record.name for record in lacking)}: by their data sheets the "
                f"sensors may add a constant {bias:.0f} N (standard deviation) to the friction; `zero` says where a "
                "log has one"
            )

    def _biases(self) -> float | list[float]:
        """Errors of zero calibrations are independent. Without a calibration all logs share the zero error of the
        sensors."""
        if all(record.zero is None for record in self.steady):
            return max(self._bias(record) for record in self.steady)
        return [self._bias(record) for record in self.steady]

    def _bias(self, record: FrictionLog) -> float:
        """Standard deviation of the constant error of a log's friction, N.

        A load cell carries the weight all the time: the error of its span adds to that of its zero.
        """
        rig, parameters, load_cell = self.found.rig, self._parameters(record), self.load_cell
        if record.zero is None:
            bias = bias_without_zero(rig, parameters, load_cell=load_cell)
        else:
            bias = record.zero.force_error(parameters, load_cell=load_cell)
        weight = (parameters.mass - parameters.rod_mass) * parameters.gravity if load_cell else 0.0
        return float(np.hypot(bias, span_error(rig, ("force",)) * weight))

    def _parameters(self, record: FrictionLog) -> RigParameters:
        return RigParameters.of(self.found.rig, payload=record.payload, rod_mass=self.rod_mass)

    # --- static map -------------------------------------------------------------------------------------------------

    def _windows(self) -> None:
        """Windows of every steady log. Logs without windows, or with friction that drives the piston, are left out."""
        reasons = []
        for record in self._of(STEADY):
            self.tell(f"searching steady motion in {record.name}")
            windows = steady_windows(record.log, self._parameters(record), load_cell=self.load_cell)
            known = {flag.message for flag in record.log.flags}
            span = span_error(self.found.rig)
            reason = _driving(windows, self._bias(record), span) if len(windows) else _why(windows)
            if reason:
                reasons.append(f"{record.name}: {reason}{_dead(record)}")
                continue
            self.found.warnings += [f"{record.name}: {f.message}" for f in windows.flags if f.message not in known]
            self.steady.append(record)
            self.found.windows.append(windows)
        if reasons:
            raise InputError("; ".join(reasons))

    def _points(self, chosen: Iterable[int]) -> FrictionPoints:
        """Points of some of the steady logs, by number."""
        numbers = list(chosen)
        return FrictionPoints.joined([self._points_of(i) for i in numbers])

    def _points_of(self, i: int) -> FrictionPoints:
        points = FrictionPoints.from_windows(self.found.windows[i], source=[self.steady[i].name])
        return replace(points, load=np.full(len(points), self.steady[i].payload))

    def _static(self) -> StaticIdentification:
        self.tell("fitting the static map")
        pairs = list(zip(self.steady, self.found.windows, strict=True))
        left_out = [LeftOut(r.start, r.end, f"{log.name}: {r.reason}") for log, found in pairs for r in found.rejected]
        return identify_static(
            self._points(range(len(pairs))),
            rejected_windows=left_out,
            exponents=self.exponents,
            held=held_exponents(self.found.rig),
            bias=self._biases(),
            span=span_error(self.found.rig),
            linearity_error=linearity_error(self.found.rig),
            velocity_share=span_error(self.found.rig, ("x",)),
        )

    def _groups(self) -> dict[str, list[int]]:
        """Numbers of the steady logs by load, by pressure, or by both, where they differ."""
        found: dict[tuple[float, float], list[int]] = {}
        for i, record in enumerate(self.steady):
            found.setdefault((record.payload, record.supply), []).append(i)
        by_load = len({payload for payload, _ in found}) > 1
        by_pressure = len({supply for _, supply in found}) > 1
        return {
            " ".join([f"{payload:g} kg"] * by_load + [f"{supply * 1e-5:.3g} bar"] * by_pressure): numbers
            for (payload, supply), numbers in found.items()
        }

    def _compare(self) -> FrictionComparison:
        self.tell("comparing loads and pressures")
        numbers = self._groups()
        biases = self._biases()
        found = compare_friction(
            {name: self._points(logs) for name, logs in numbers.items()},
            margin=MARGIN,
            exponents=self.exponents,
            held=held_exponents(self.found.rig),
            bias=biases if isinstance(biases, float) else [biases[i] for logs in numbers.values() for i in logs],
            span=span_error(self.found.rig),
            linearity_error=linearity_error(self.found.rig),
        )
        if found.conclusion.startswith("different"):
            self.found.warnings.append(f"one map was fitted to all logs, but: {found.sentence}")
        return found

    # --- bristles ---------------------------------------------------------------------------------------------------

    def _dynamic(self) -> DynamicFit:
        ramps, steps = self._of(RAMP), self._of(STEP)
        chosen = [*ramps, *steps]
        _one_alone("loads", "kg", {r.payload for r in chosen})
        _one_alone("pressures", "Pa", {r.supply for r in chosen})
        rig, supply = self.found.rig, chosen[0].supply
        self.tell("fitting the bristles")
        fit = fit_dynamic(
            [r.log for r in ramps],
            [r.log for r in steps],
            rig if supply == rig.supply_pressure else rig.changed({"supply.pressure": supply}),
            self._whole_map(),
            payload=chosen[0].payload,
            calibrated=_left_of_zeros(chosen),
            progress=self._evaluation,
        )
        if fit.estimate is None:
            self.found.stages.append(Stage(BRISTLES, "failed", "; ".join(fit.warnings)))
        else:
            self.found.warnings += fit.warnings
        return fit

    def _whole_map(self) -> StaticFit | None:
        """The fitted map if it has both directions."""
        fit = self.found.static.fit if self.found.static is not None else None
        return fit if fit is not None and np.isfinite(fit.law.values).all() else None

    def _evaluation(self, count: int, residuals: float) -> None:
        self.tell(f"fitting the bristles: evaluation {count}, residuals {residuals:.3g} of the sensors' noise")


def _left_of_zeros(records: list[FrictionLog]) -> bool | tuple[float, float]:
    """Standard errors of the zeros of p1 and p2, Pa, the largest of any log; False without a calibration."""
    errors = [record.zero.errors for record in records if record.zero is not None]
    if len(errors) < len(records):
        return False
    return max(e["p1"] for e in errors), max(e["p2"] for e in errors)


def _one_alone(what: str, unit: str, values: set[float]) -> None:
    if len(values) > 1:
        shown = ", ".join(f"{value:g}" for value in sorted(values))
        raise InputError(f"ramps and steps of different {what}, {shown} {unit}; give those of one only")


def _why(windows: SteadyWindows) -> str:
    """Reasons why a log has no window, the most frequent first."""
    reasons = Counter(re.sub(r" for [\d.e-]+ s only", " for too short a time", r.reason) for r in windows.rejected)
    shown = "; ".join(f"{reason} ({count} x)" if count > 1 else reason for reason, count in reasons.most_common(3))
    return (
        f"no steady motion: {shown or 'the piston never moves along a straight line'}. Is it a log of constant "
        "velocities? Pass ramps and steps as `ramps` and `steps`"
    )


def _dead(record: FrictionLog) -> str:
    """Note on pressures that never change, for a log with impossible friction."""
    still = [name for name in PRESSURES if np.ptp(record.log[name]) == 0.0]
    texts = (f"; `{name}` never changes: its sensor is dead or at the end of its range" for name in still)
    return "".join(texts)


def _driving(windows: SteadyWindows, bias: float, span: float) -> str:
    """Message if friction drives the piston by more than sensor errors explain; else empty."""
    for sign, name in zip((1, -1), DIRECTIONS, strict=True):
        here = [w for w in windows if w.direction == sign]
        chambers = [span * np.hypot(*w.chambers) if w.chambers else 0.0 for w in here]
        errors = [np.linalg.norm([w.force_error, bias, error]) for w, error in zip(here, chambers, strict=True)]
        driving = [w for w, error in zip(here, errors, strict=True) if w.force * sign < -CLEAR * error]
        if 2 * len(driving) > len(here):
            push = -sign * float(np.median([w.force for w in here]))
            return (
                f"{name}, friction would drive the piston with {push:.0f} N; are p1 and p2 exchanged, is the sign of "
                "x right, are rig and load those of the log? It was left out"
            )
    return ""
