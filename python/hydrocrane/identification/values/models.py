"""Prediction of a log: a simulated motion, by given spool commands with exact derivatives or with a controller in the
loop, and the errors of the sensors."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, Self

import numpy as np

from hydrocrane.analysis.sensitivity import Experiment, solve
from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, SimulationError
from hydrocrane.identification.records import FittedLog, at_start
from hydrocrane.identification.values.parameters import SensorError
from hydrocrane.logs import Log, noise_of
from hydrocrane.machine.machine import Machine
from hydrocrane.machine.overrides import Overrides
from hydrocrane.scenario.changes import Changes
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.scenario.series import MAINS, SUPPLY, SUPPLY_SIGNALS, Command, SupplyPressure
from hydrocrane.scenario.solver import Solver
from hydrocrane.simulation.running import simulate

# Half step of a central difference for smooth functions, in standard deviations of a parameter.
DIFFERENCE = 1e-2


class LogModel(Protocol):
    """A model of one log, as a function of its own unknowns."""

    @property
    def record(self) -> FittedLog: ...
    @property
    def solver(self) -> Solver | None:
        """Of its runs; None if it has no runs."""
        ...

    def predict(self, values: Array) -> tuple[Array, Array]:
        """Signals (m, n) at the record's times and their derivatives (m, n, k) by the values (k,), SI."""
        ...

    def varied(self, values: Array, overrides: Overrides, interpolation: str = "") -> Array:
        """Signals (m, n) at these values with further `overrides`, or with commands interpolated differently."""
        ...

    def with_solver(self, solver: Solver) -> LogModel:
        """The same model with another solver of its runs."""
        ...


@dataclass(frozen=True)
class SensorReading:
    """Sensors between signals and readings: ``reading = (1 + span) signal(t - delay) + zero``."""

    errors: tuple[SensorError, ...]

    def read(self, log: int, record: FittedLog, y: Array, slopes: Array, values: Array) -> tuple[Array, Array]:
        """Readings (m, n) of a log by its number and their derivatives (m, n, k + e) by the model's unknowns and by the
        errors' `values` (e,)."""
        m, n, k = slopes.shape
        out, by = y.copy(), np.zeros((m, n, k + len(self.errors)))
        by[:, :, :k] = slopes
        for i, signal in enumerate(record.signals):
            mine = {
                e.kind: (k + j, values[j])
                for j, e in enumerate(self.errors)
                if e.signal == signal and e.log in (None, log)
            }
            _delayed(record.time, out[:, i], by[:, i], mine.get("delay"))
            column, span = mine.get("span", (None, 0.0))
            if column is not None:
                by[:, i] *= 1.0 + span
                by[:, i, column] = out[:, i]
                out[:, i] *= 1.0 + span
            for kind in ("zero", "start"):
                column, zero = mine.get(kind, (None, 0.0))
                if column is not None:
                    by[:, i, column] = 1.0
                    out[:, i] += zero
        return out, by


def _delayed(time: Array, y: Array, by: Array, delay: tuple[int, float] | None) -> None:
    """Shift a signal (m,) and its derivatives (m, k) to later times, in place."""
    if delay is None:
        return
    column, late = delay
    rate = np.gradient(y, time)
    earlier = time - late
    y[:] = np.interp(earlier, time, y)
    for j in np.flatnonzero(np.any(by != 0.0, axis=0)):
        by[:, j] = np.interp(earlier, time, by[:, j])
    by[:, column] = -np.interp(earlier, time, rate)


def by_differences(
    function: Callable[[Array], Array], values: Array, scales: Sequence[float], share: float = DIFFERENCE
) -> tuple[Array, Array]:
    """A function's value (m, n) and its derivatives (m, n, k) by central differences over a `share` of `scales` (k,).

    If one side cannot be evaluated, the difference is one-sided.
    """
    y = function(values)
    slopes = np.zeros((*y.shape, values.size))
    for j, scale in enumerate(scales):
        ends = []
        for sign in (1.0, -1.0):
            moved = values.copy()
            moved[j] += sign * share * scale
            try:
                ends.append((moved[j], function(moved)))
            except ValueError:
                ends.append((values[j], y))
        (high, above), (low, below) = ends
        if high != low:
            slopes[:, :, j] = (above - below) / (high - low)
    return y, slopes


# Half step of a difference between runs with a sampled controller, in standard deviations of a parameter. It is large
# because decisions at thresholds make these runs non-smooth functions of the parameters.
SAMPLED = 0.1
# Least and most time at the start of a log for the reading of pose and pressures, s.
START = (0.1, 2.0)


@dataclass(frozen=True)
class _Simulated:
    """A run of `plan`, as from :func:`replayed`, with other values of the `keys`."""

    plan: Scenario
    record: FittedLog
    keys: tuple[str, ...]

    @cached_property
    def _machine(self) -> Machine:
        return self.plan.load_machine()

    def varied(self, values: Array, overrides: Overrides, interpolation: str = "") -> Array:
        moved = {**self._machine.overrides_at(self.keys, values), **overrides}
        payload = moved.pop("payload.mass", None)
        changes: Changes = {"overrides": moved}
        if payload is not None:
            changes["payload"] = float(payload)  # type: ignore[arg-type]
        commands = self.plan.commands
        if interpolation and isinstance(commands, Mapping):
            changes["commands"] = {c: dataclasses.replace(u, interpolation=interpolation) for c, u in commands.items()}
        run = simulate(self.plan, ledger=False, **changes)
        if run.outcome.kind != "completed":
            raise _broken_off(self.record, run.outcome.kind, run.outcome.time, run.outcome.message)
        columns = [run.columns[name].values for name in self.record.signals]
        return np.stack([np.interp(self.record.time, run.columns.time, column) for column in columns], axis=1)

    @property
    def solver(self) -> Solver:
        return self.plan.solver

    def with_solver(self, solver: Solver) -> Self:
        return dataclasses.replace(self, plan=self.plan.changed(solver=solver))


@dataclass(frozen=True)
class OpenLoop(_Simulated):
    """A run with spool commands."""

    @cached_property
    def _experiment(self) -> Experiment:
        # A search needs derivatives to one per mille only, so the step size control uses the states alone.
        return Experiment(
            self.plan, self.keys, signals=self.record.signals, times=self.record.time, resolve_sensitivities=False
        )

    def __getstate__(self) -> dict[str, object]:
        return {name: value for name, value in self.__dict__.items() if name != "_experiment"}

    def predict(self, values: Array) -> tuple[Array, Array]:
        found = solve(self._experiment, values)
        if found.times.size < self.record.time.size:
            raise _broken_off(self.record, found.outcome.kind, found.outcome.time, found.outcome.message)
        return found.y, found.sensitivities


@dataclass(frozen=True)
class ClosedLoop(_Simulated):
    """A run with a controller; its derivatives are differences between runs.

    Parameters
    ----------
    scales : tuple of float
        Standard deviations of the keys, SI.
    """

    scales: tuple[float, ...]

    def predict(self, values: Array) -> tuple[Array, Array]:
        return by_differences(lambda at: self.varied(at, {}), values, self.scales, SAMPLED)


@dataclass(frozen=True)
class Replay:
    """A scenario over the time of a log, and standard errors of the start values of its joints, SI."""

    plan: Scenario
    errors: dict[str, float]


def replayed(plan: Scenario, machine: Machine, log: Log, interpolation: str) -> Replay:
    """The scenario over the time of a log, with the log's spool commands, pose and pressures at its start.

    Spool commands are columns ``cylinder.<name>.command``; without these columns the scenario's own commands are used,
    and the log's clock is the scenario's. A measured supply pressure is the column ``supply.pressure``, or ``mains.p``
    as in saved runs. Where the log begins later, hoses burst on its clock.
    """
    begin = float(log.time[0])
    changes: Changes = {"duration": float(log.time[-1]) - begin}
    logged = [c for c in machine.cylinder_names if f"cylinder.{c}.command" in log]
    if logged and plan.has_controller:
        raise InputError(
            f"{log.source} has spool commands and the scenario a controller; leave the columns out of the mapping to "
            "run the controller, or take a scenario without one to replay the commands"
        )
    if begin > 0.0 and plan.has_controller:
        raise InputError(
            f"{log.source} begins at {begin:g} s; a controller has internal states, so its run begins at 0: omit window"
        )
    if logged:
        changes["commands"] = {c: _command(log, c, begin, interpolation) for c in logged}
    elif begin > 0.0:
        times, spools, linear = plan.command_grid(machine)
        changes["commands"] = {
            name: _later(Command(times, spools[:, c], "linear" if linear else "hold"), begin)
            for c, name in enumerate(machine.cylinder_names)
            if times.size
        }
    supply = _supply(log, machine, begin, interpolation) or _later_supply(plan.supply, begin)
    if supply is not None:
        changes["supply"] = supply
    if begin > 0.0 and plan.payload_changes:
        changes |= _later_loads(plan, begin)
    changes["bursts"] = [dataclasses.replace(b, time=max(b.time - begin, 0.0)) for b in plan.bursts]
    still = _still(plan.changed(**changes), machine)
    starts = {j: at_start(log, f"joint.{j}.q", still) for j in machine.joint_names if f"joint.{j}.q" in log}
    changes["joints"] = {**plan.joints, **{joint: start.value for joint, start in starts.items()}}
    both = [c for c in machine.cylinder_names if f"cylinder.{c}.p1" in log and f"cylinder.{c}.p2" in log]
    if len(both) == len(machine.cylinder_names):
        changes["pressures"] = {
            c: (at_start(log, f"cylinder.{c}.p1", still).value, at_start(log, f"cylinder.{c}.p2", still).value)
            for c in both
        }
    errors = {f"joint.{joint}.q": start.error for joint, start in starts.items() if start.error > 0.0}
    return Replay(plan.changed(**changes), errors)


def _later_loads(plan: Scenario, begin: float) -> Changes:
    """The loads of a run that begins later, at the time `begin` (s) of the scenario."""
    carried = [mass for time, mass in plan.payload_changes.items() if time <= begin]
    later = {time - begin: mass for time, mass in plan.payload_changes.items() if time > begin}
    loads: Changes = {"payload_changes": later}
    if carried:
        loads["payload"] = carried[-1]
    return loads


def _still(plan: Scenario, machine: Machine) -> float:
    """Time without a command at the start of a run, s, within :data:`START`."""
    if plan.closed_loop:
        return START[0]
    times, spools, _ = plan.command_grid(machine)
    moved = np.flatnonzero(np.any(spools != 0.0, axis=1)) if times.size else np.array([], dtype=int)
    # A line to the first command begins at the time before it.
    until = float(times[max(moved[0] - 1, 0)]) if moved.size else START[1]
    return float(np.clip(until, *START))


def starts_doubtfully(plan: Scenario, log: Log) -> list[str]:
    """Warnings on the start of the run over a log, including its supply pressure."""
    return [f"{log.source}: {doubt.text}; {doubt.cure}" for doubt in plan.start(plan.load_machine())[1]]


def starts_moving(machine: Machine, log: Log) -> str:
    """Warning if a log begins in motion; empty if it begins at rest."""
    span = min(0.5, 0.2 * float(log.time[-1] - log.time[0]))
    early = log.time <= log.time[0] + span
    for joint in machine.joint_names:
        name = f"joint.{joint}.q"
        if name not in log or np.isfinite(log[name][early]).sum() < 5:
            continue
        values, times = log[name][early], log.time[early]
        good = np.isfinite(values)
        slope = float(np.polynomial.polynomial.polyfit(times[good] - times[0], values[good], 1)[1])
        travel = float(np.nanmax(log[name]) - np.nanmin(log[name]))
        if abs(slope) * span > max(0.02 * travel, 5.0 * noise_of(values).total) and travel > 0.0:
            return (
                f"{log.source} begins in motion (`{name}` changes by {slope:.3g} per s), but the run begins at rest; "
                "begin the window where the crane is at rest, window=(from, to)"
            )
    return ""


def _check_unit(log: Log, name: str, unit: str) -> None:
    """Refuse a column whose unit differs from that of the replayed signal."""
    stated = str(log.data[name].attrs.get("units", ""))
    if stated not in ("", unit):
        cure = 'state what one of its numbers means in a mapping, unit = "0.5 mm"' if unit == "m" else "state its unit"
        raise InputError(f"{log.source}: `{name}` is in {stated} and is replayed in {unit}; {cure}")


def _command(log: Log, cylinder: str, begin: float, interpolation: str) -> Command:
    _check_unit(log, f"cylinder.{cylinder}.command", "m")
    values = log[f"cylinder.{cylinder}.command"]
    good = np.isfinite(values)
    if not good.any():
        raise InputError(f"{log.source}: `cylinder.{cylinder}.command` has no readings")
    return Command(log.time[good] - begin, values[good], interpolation)


def _supply(log: Log, machine: Machine, begin: float, interpolation: str) -> SupplyPressure | None:
    """The measured supply pressure, for a machine without a pump model."""
    pumped = "mains.volume" in machine.keys
    if pumped and SUPPLY in log:
        raise InputError(
            f"{log.source} has `{SUPPLY}` to be replayed, but the supply pressure of the machine follows from its "
            f"pump; map the column to `{MAINS}` to compare the two, or leave it out of the mapping"
        )
    name = next((signal for signal in SUPPLY_SIGNALS if signal in log and not pumped), None)
    if name is None:
        return None
    _check_unit(log, name, "Pa")
    good = np.isfinite(log[name]) & ~log.spoilt(name)
    if not good.any():
        raise InputError(f"{log.source}: `{name}` has no usable readings; check its sensor, or leave it out")
    return SupplyPressure(log.time[good] - begin, log[name][good], interpolation)


def _later_supply(supply: SupplyPressure | None, begin: float) -> SupplyPressure | None:
    """A supply pressure on a clock that starts at `begin`, s."""
    return None if supply is None else dataclasses.replace(supply, time=supply.time - begin)


def _later(command: Command, begin: float) -> Command:
    """The part of a command after `begin`, s."""
    after = command.time > begin
    now = command.at(np.array([begin]))
    return Command([0.0, *(command.time[after] - begin)], [*now, *command.spool[after]], command.interpolation)


def _broken_off(record: FittedLog, kind: str, time: float, message: str) -> SimulationError:
    return SimulationError(f"{record.name}: the run of the model ends at {time:.4g} s, {kind}: {message}")


def modelled_signals(machine: Machine, without: Sequence[str] = ("energy.oil",)) -> dict[str, str]:
    """Units of all signals that a run has, by name."""
    states = dict(zip(machine.state_names, machine.state_units, strict=True))
    outputs = {name: unit for name, unit, _ in machine.core.output_info if name not in without}
    return {**states, **outputs}
