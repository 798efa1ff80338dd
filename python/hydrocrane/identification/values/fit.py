"""Fit values of a machine to logs: the public function, and the way from its arguments to unknowns and models."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from os import PathLike
from typing import Literal, TypeAlias, Unpack

import numpy as np

from hydrocrane.arrays import positive_number, seed_number, whole_number
from hydrocrane.errors import InputError, check_known
from hydrocrane.identification.records import (
    LEAST_SAMPLES,
    FittedLog,
    HoldOut,
    chosen_signals,
    opened,
    record_of,
    window_of,
)
from hydrocrane.identification.solve import Unknown
from hydrocrane.identification.values.doubts import accurate, suspected
from hydrocrane.identification.values.measured_motion import (
    MeasuredMotion,
    force_noise,
    joint_signals,
    measured_forces,
    motion_of,
)
from hydrocrane.identification.values.models import (
    ClosedLoop,
    LogModel,
    OpenLoop,
    SensorReading,
    modelled_signals,
    replayed,
    starts_doubtfully,
    starts_moving,
)
from hydrocrane.identification.values.parameters import (
    Priors,
    SensorError,
    Tie,
    Ties,
    check_names,
    sensor_error,
    stated_errors,
    tie_matrix,
    ties_of,
    unknown_error,
    unknown_key,
    unknown_start,
)
from hydrocrane.identification.values.result import Fit
from hydrocrane.identification.values.search import FitTask, searched
from hydrocrane.logs import Log, log_mapping
from hydrocrane.logs.columns import LogLike
from hydrocrane.logs.mapping import MappingLike
from hydrocrane.machine.machine import Machine
from hydrocrane.scenario.changes import Changes
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.scenario.scenario_file import load_scenario
from hydrocrane.scenario.series import MAINS, SUPPLY

# Number of poses of a log that are checked.
POSES = 50
# Largest load in excess of that of the file, kg.
MORE = 300.0
# Difference of forces that counts as clear, as a share of the force at supply pressure.
CLEAR = 0.1


def swapped_pressures(machine: Machine, log: Log) -> list[str]:
    """Cylinders whose pressures carry the crane only if p1 and p2 are exchanged.

    The required static force is that along the log's poses for any load from zero to :data:`MORE` above that of the
    file.
    """
    names = [f"joint.{j}.q" for j in machine.joint_names]
    if not all(name in log for name in names):
        return []
    rows = np.unique(np.linspace(0, log.time.size - 1, POSES).astype(int))
    q = np.stack([log[name][rows] for name in names], axis=1)
    good = np.isfinite(q).all(axis=1)
    loads = (0.0, machine.payload_mass + MORE)
    empty, loaded = (machine.static_cylinder_force(q[good], payload=load) for load in loads)
    low, high = np.minimum(empty, loaded), np.maximum(empty, loaded)
    found = []
    for c, name in enumerate(machine.cylinder_names):
        signals = [f"cylinder.{name}.p{side}" for side in (1, 2)]
        if not all(signal in log for signal in signals):
            continue
        p1, p2 = (log[signal][rows][good] for signal in signals)
        piston, rod = machine.piston_areas[c]
        outside = [
            float(np.nanmedian(np.maximum(np.maximum(low[:, c] - force, force - high[:, c]), 0.0)))
            for force in (piston * p1 - rod * p2, piston * p2 - rod * p1)
        ]
        if outside[0] > CLEAR * piston * machine.supply_pressure and outside[1] < 0.2 * outside[0]:
            found.append(
                f"{log.source}: the pressures of `{name}` do not carry the crane by {outside[0]:.3g} N, but would if "
                f"`{signals[0]}` and `{signals[1]}` were exchanged: are the columns swapped?"
            )
    return found


# Speed of a piston about to move, m/s, where friction is largest.
SLOW = 1e-3


@dataclass(frozen=True)
class Setup:
    """The arguments of a fit; each is checked when it is used."""

    plan: Scenario
    machine: Machine
    parameters: tuple[str, ...]
    priors: Priors
    signals: Sequence[str] | None
    hold_out: HoldOut
    interpolation: str
    bandwidth: float
    at_rest: bool
    sensor_errors: bool
    robust: bool
    ties: tuple[Tie, ...] = ()

    def simulated(self, windows: Sequence[Log]) -> tuple[FitTask, list[str]]:
        """Models of logs whose motion follows from commands, and notes."""
        units = modelled_signals(self.machine)
        if self.plan.supply is not None:
            units.pop(MAINS)
        records, replays, notes = [], [], []
        for log in windows:
            records.append(self._record(log, chosen_signals(log, self.signals, units), units, {}))
            replays.append(replayed(self.plan, self.machine, log, self.interpolation))
            notes += [*records[-1].notes, starts_moving(self.machine, log), *swapped_pressures(self.machine, log)]
            notes += starts_doubtfully(replays[-1].plan, log)
        if SUPPLY in self.parameters and any(replay.plan.supply is not None for replay in replays):
            raise InputError(
                f"`{SUPPLY}` does not enter a run that follows a measured supply pressure; leave it out of the "
                "parameters, or that pressure out of scenario and mapping"
            )
        keys = self._keys(_signals(records), ())
        errors = self._errors(_signals(records), records)
        errors += [
            unknown_start(signal, log, error)
            for log, (record, replay) in enumerate(zip(records, replays, strict=True))
            for signal, error in replay.errors.items()
            if signal in record.signals
        ]
        names, scales = self._with_ties(keys)
        models = [
            ClosedLoop(replay.plan, record, names, scales)
            if replay.plan.has_controller
            else OpenLoop(replay.plan, record, names)
            for record, replay in zip(records, replays, strict=True)
        ]
        return self._task(keys, len(keys), models, errors, records), [note for note in notes if note]

    def measured(self, windows: Sequence[Log]) -> tuple[FitTask, list[str]]:
        """Models of logs with measured motion, and notes."""
        records, motions, notes = [], [], []
        for log in windows:
            motion = motion_of(self.machine, log, dict(self.plan.joints), self.bandwidth)
            forces, moves = measured_forces(self.machine, log, motion, self.bandwidth, self.at_rest)
            idle = [name for name, force in forces.items() if np.isfinite(force).sum() < LEAST_SAMPLES]
            notes += [f"{log.source}: `{name}` is not compared: its piston may be at rest throughout" for name in idle]
            forces = {name: force for name, force in forces.items() if name not in idle}
            if not forces:
                raise InputError(
                    f"{log.source}: all pistons may be at rest throughout; compare them at rest with at_rest=True"
                )
            units = dict.fromkeys(forces, "N")
            records.append(self._record(log, chosen_signals(log, self.signals, units, list(forces)), units, forces))
            records[-1] = replace(records[-1], noise=force_noise(self.machine, log, records[-1].signals))
            every = records[-1].every
            if self.at_rest:
                records[-1] = replace(records[-1], unmodelled=self._friction_at_rest(records[-1], moves))
            motions.append((motion.every(every), {name: moving[::every] for name, moving in moves.items()}))
            notes += [*records[-1].notes, _at_rest(log, moves, self.at_rest), *swapped_pressures(self.machine, log)]
        measured = [joint_signals(self.machine, log) for log in windows]
        joints = [f"joint.{j}.q" for i, j in enumerate(self.machine.joint_names) if all(row[i] for row in measured)]
        pressures = [f"cylinder.{c}.p{side}" for c in self.machine.cylinder_names for side in (1, 2)]
        inputs = [*joints, *(name for name in pressures if all(name in log for log in windows))]
        keys = self._keys(_signals(records), inputs)
        errors = [error for error, _ in self._errors(inputs, records)]
        for error in errors:
            if error.kind != "zero" and (error.kind == "delay" or error.signal in joints):
                raise InputError(
                    f"`{error.name}`: of a measured motion the zeros of joints and pressures, and the spans of "
                    "pressures, can be fitted"
                )
        own = (*keys, *(unknown for _, unknown in self._errors(inputs, records)))
        names, scales = self._with_ties(keys)
        scales = (*scales, *(unknown.scale for unknown in own[len(keys) :]))
        models = []
        for record, (motion, moves) in zip(records, motions, strict=True):
            cylinders = tuple(name.split(".")[1] for name in record.signals)
            read = {p: np.nan_to_num(record.log[p])[:: record.every] for p in pressures if p in record.log}
            models.append(
                MeasuredMotion(self.machine, record, motion, cylinders, names, tuple(errors), read, moves, scales)
            )
        return self._task(own, len(keys), models, self._errors(_signals(records), records), records), notes

    def _with_ties(self, keys: Sequence[Unknown]) -> tuple[tuple[str, ...], tuple[float, ...]]:
        """Names and scales of the keys and of the tied keys."""
        scales = {unknown.name: unknown.scale for unknown in keys}
        scales |= {tie.key: abs(tie.ratio) * scales[tie.leader] for tie in self.ties}
        return tuple(scales), tuple(scales.values())

    def _friction_at_rest(self, record: FittedLog, moves: dict[str, np.ndarray]) -> np.ndarray:
        """Standard deviation (m, n) of the friction of pistons that may be at rest, N: uniform up to the break-away
        force."""
        columns = []
        for signal in record.signals:
            name = signal.split(".")[1]
            most = max(abs(float(self.machine.friction_map(speed, name))) for speed in (SLOW, -SLOW))
            columns.append(np.where(moves[name][:: record.every], 0.0, most / np.sqrt(3.0)))
        return np.stack(columns, axis=1)

    def _record(
        self, log: Log, signals: Sequence[str], units: dict[str, str], values: dict[str, np.ndarray]
    ) -> FittedLog:
        record = record_of(log, signals, units, self.hold_out, values)
        for i, name in enumerate(record.signals):
            if not record.used[:, i].any():
                raise InputError(
                    f"{record.name}: `{name}` has no usable reading to fit; see window and hold_out, or leave it out "
                    "of signals"
                )
        return record

    def _named(self, signals: Sequence[str]) -> list[SensorError | None]:
        """The sensor error behind each parameter that names one of these signals."""
        return [sensor_error(name, signals) for name in self.parameters]

    def _keys(self, signals: Sequence[str], inputs: Sequence[str]) -> list[Unknown]:
        """Unknowns that are keys of the machine file."""
        errors = self._named([*signals, *inputs])
        keys = [name for name, error in zip(self.parameters, errors, strict=True) if error is None]
        if not keys:
            raise InputError("name at least one key of the machine file among the parameters, such as `payload.mass`")
        tables = [name.rpartition(".")[0] for name in keys]
        along = {name: {tie.key: tie.ratio for tie in self.ties if tie.leader == name} for name in keys}
        return [
            unknown_key(self.machine, name, self.priors, tables.count(table) == 1, along[name])
            for name, table in zip(keys, tables, strict=True)
        ]

    def _errors(self, signals: Sequence[str], records: Sequence[FittedLog]) -> list[tuple[SensorError, Unknown]]:
        """Sensor errors of the signals: the named ones, and those bounded by the machine file."""
        errors = [e for e in self._named(signals) if e is not None]
        if self.sensor_errors:
            errors += [e for e in stated_errors(self.machine, signals) if e not in errors]
        return [(e, unknown_error(self.machine, e, _spread(records, e.signal), self.priors)) for e in errors]

    def _task(
        self,
        own: Sequence[Unknown],
        keys: int,
        models: Sequence[LogModel],
        errors: Sequence[tuple[SensorError, Unknown]],
        records: Sequence[FittedLog],
    ) -> FitTask:
        unknowns = (*own, *(unknown for _, unknown in errors))
        count = sum(int(record.used.sum()) for record in records)
        if count <= len(unknowns):
            raise InputError(
                f"{count} readings cannot identify {len(unknowns)} parameters; take longer logs or fewer parameters"
            )
        reading = SensorReading(tuple(error for error, _ in errors))
        ties = tie_matrix(self.ties, [unknown.name for unknown in own[:keys]], len(own) - keys)
        return FitTask(unknowns, tuple(models), reading, len(own), keys, self.robust, ties)


def _signals(records: Sequence[FittedLog]) -> list[str]:
    return list(dict.fromkeys(name for record in records for name in record.signals))


def _spread(records: Sequence[FittedLog], name: str) -> float:
    """Largest range of a signal in a log, in its unit."""
    columns = [
        record.readings[:, record.signals.index(name)] if name in record.signals else record.log[name]
        for record in records
        if name in record.signals or name in record.log
    ]
    return max((float(np.nanmax(values) - np.nanmin(values)) for values in columns), default=1.0)


def _at_rest(log: Log, moves: dict[str, np.ndarray], compared: bool) -> str:
    """Note on the share of samples in which pistons may be at rest."""
    shares = ", ".join(f"`{name}` in {1.0 - float(moving.mean()):.0%}" for name, moving in moves.items())
    then = "compared without friction, which may be anything up to the break-away force" if compared else "left out"
    return f"{log.source}: pistons may be at rest in {shares} of the samples; these are {then}"


MOTIONS = ("simulated", "measured")
MotionKind: TypeAlias = Literal["simulated", "measured"]
# Most starts of a search.
MOST_STARTS = 1000


def fit(
    scenario: str | PathLike[str] | Scenario,
    logs: LogLike | list[LogLike] | tuple[LogLike, ...],
    parameters: Sequence[str],
    *,
    mapping: MappingLike = None,
    signals: Sequence[str] | None = None,
    motion: MotionKind = "simulated",
    interpolation: str = "linear",
    bandwidth: float = 2.0,
    at_rest: bool = False,
    window: tuple[float, float] | None = None,
    hold_out: HoldOut = None,
    priors: Priors | None = None,
    sensor_errors: bool = True,
    robust: bool = True,
    ties: Ties | None = None,
    starts: int = 1,
    starts_seed: int = 0,
    executor: Executor | None = None,
    progress: Callable[[str], None] | None = None,
    **changes: Unpack[Changes],
) -> Fit:
    """Fit values of a machine file, and errors of sensors, to measured logs.

    Parameters
    ----------
    scenario : str, path or Scenario
        States the machine, and everything that the logs do not contain: commands, pose, controller.
    logs : path, DataFrame, Dataset, mapping, Run, or several
        With a time column. Columns named like signals of a run, ``cylinder.lift.p1``, are compared with these; columns
        ``cylinder.<name>.command`` are the spool commands that the run replays; angles and pressures at the start give
        the start of the crane.
    parameters : sequence of str
        Keys of the machine file, ``friction.lift.coulomb[0]``, ``payload.mass``, ``link.jib.mass``; and errors of
        the sensor of a signal: ``cylinder.lift.p1.zero`` (in its unit), ``.span`` (share), ``.delay`` (s).
    mapping : path or dict, optional
        Assigns columns of the logs to signals, with unit and sign (docs/reference/log-files.md).
    signals : sequence of str, optional
        Signals to compare; default is all that the log and the model have in common.
    motion : {"simulated", "measured"}
        ``simulated``: the run follows from the commands. ``measured``: joints move as measured, and
        A_1 p_1 - A_2 p_2 of each cylinder, ``cylinder.<name>.pressure_force``, is compared with weight, inertia and
        static friction. Valve, supply and oil then do not matter.
    interpolation : {"linear", "hold"}
        Interpolation of a logged command between its samples.
    bandwidth : float
        Of a measured motion and its forces, Hz: faster components are filtered out of both.
    at_rest : bool
        For a measured motion, also compare pistons that may stand still, without friction. Friction there is anything
        up to the break-away force, so values and intervals may be wrong by that.
    window : (float, float), optional
        Part of each log that is used, s of its clock.
    hold_out : float or (float, float), optional
        Compared, but not fitted: the last share of each log, or a stretch, s.
    priors : mapping, optional
        Standard deviation, or (mean, standard deviation), SI, by parameter; None for no prior. Default is a share of
        the value by the class of its source: 2 % measured, 5 % setting, 10 % fitted, 20 % literature, 100 % assumed or
        given in the call.
    sensor_errors : bool
        Let zero and span of signals vary within the accuracy that the machine file states for their sensors.
    robust : bool
        Reduce the weight of outliers (Huber).
    ties : mapping, optional
        Keys that change in proportion to a parameter, with the ratio of the machine file, by the parameter:
        ``{"friction.lift.breakaway": "friction.lift.coulomb"}``. Without a tie a fitted Coulomb friction leaves
        break-away friction constant, and a warning says so if their ratio changes.
    starts : int
        Number of searches; those after the first begin at values drawn from the priors by `starts_seed`.
    executor : Executor, optional
        Runs the starts, for example ``dask.distributed.Client(...).get_executor()``; default is this process, in turn.
    progress : callable, optional
        Called with a text about the progress.
    **changes
        Fields of the scenario or its solver to change, as in :func:`hydrocrane.simulate`. The tolerance is the loosest
        one: the fit tightens it until errors of integration are negligible beside the noise of the logs
        (``Fit.accuracy``).

    Returns
    -------
    Fit

    Raises
    ------
    HydrocraneError
        If a name, a file or an argument is invalid, or the model cannot be run at the start.

    Examples
    --------
    >>> log = hc.simulate("single-cylinder-step", overrides={"supply.pressure": "95 bar"}).data
    >>> found = hc.fit("single-cylinder-step", log, ["supply.pressure"], signals=["cylinder.test.x"])
    >>> print(f"{found.value('supply.pressure') / 1e5:.0f} bar")
    95 bar
    """
    check_known("motion", motion, MOTIONS)
    whole_number("starts", starts, 1, MOST_STARTS)
    positive_number("bandwidth", bandwidth)
    tell = progress or (lambda _: None)
    plan = (scenario if isinstance(scenario, Scenario) else load_scenario(scenario)).changed(**changes)
    machine = _machine(plan)
    check_names(parameters, priors or {})
    tell("reading the logs")
    listed = list(logs) if isinstance(logs, list | tuple) else [logs]
    if not listed:
        raise InputError("no log was given; a fit needs one or more")
    found_mapping = log_mapping(mapping)
    windows = [window_of(opened(log, found_mapping), window) for log in listed]
    bound = ties_of(machine, ties or {}, parameters)
    setup = Setup(
        plan,
        machine,
        tuple(parameters),
        priors or {},
        signals,
        hold_out,
        interpolation,
        bandwidth,
        at_rest,
        sensor_errors,
        robust,
        bound,
    )
    task, notes = setup.measured(windows) if motion == "measured" else setup.simulated(windows)
    found = searched(task, starts, seed_number(starts_seed), map if executor is None else executor.map, tell)
    tell("intervals")
    found, known, accuracy = accurate(found, tell)
    looks = suspected(found, machine, interpolation)
    return Fit(plan, machine, found, known, motion, accuracy, tuple(notes), bound, looks)


def _machine(plan: Scenario) -> Machine:
    """The scenario's machine with its payload among the values."""
    machine = plan.load_machine()
    return machine if plan.payload is None else machine.changed({"payload.mass": plan.payload})
