"""Exact derivatives of a run by keys of its machine file, for fits, tuning and ranking of parameters.

A key is a dotted key of the machine file with a numeric value, ``supply.pressure``; one value of a pair or point is
``friction.test.coulomb[0]``. Theory, accuracy and limits: docs/theory/sensitivities.md.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import Unpack

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from hydrocrane import _core
from hydrocrane._core_types import SensitivityRecord
from hydrocrane.arrays import Array, real_array
from hydrocrane.errors import InputError, check_known, translated
from hydrocrane.notebook import card
from hydrocrane.result_warning import ResultWarning
from hydrocrane.results.dataset import run_dataset
from hydrocrane.results.outcome import Outcome
from hydrocrane.results.recording import RecordedStage, Recording
from hydrocrane.results.run import Run
from hydrocrane.scenario.changes import Changes
from hydrocrane.scenario.record_size import check_record
from hydrocrane.scenario.scenario import Scenario, scenario_entry
from hydrocrane.scenario.scenario_file import load_scenario
from hydrocrane.simulation.interruption import interruptible

# Its derivative by the oil's parameters is not computed.
WITHOUT_SLOPE = "energy.oil"
Progress = Callable[[float, float], None]


@dataclass(frozen=True)
class Parameter:
    """A key with its value in SI; `unit` is empty for a plain number."""

    key: str
    value: float
    unit: str


@dataclass(frozen=True)
class Solution:
    """Signals and their derivatives at the times of one experiment, up to its end.

    Attributes
    ----------
    times : (m,) array
        s. A run that ends early has fewer than requested, its last state included.
    y : (m, n_signals) array
        SI.
    sensitivities : (m, n_signals, n_keys) array
        d(y)/d(value), SI units of the signal per SI unit of the key.
    outcome : Outcome
    """

    times: Array
    y: Array
    sensitivities: Array
    outcome: Outcome


class Experiment:
    """A scenario prepared to be run again and again with other values of some keys of its machine.

    Parameters
    ----------
    scenario : str, path or Scenario
        With spool commands; sensitivities of sampled controllers are not computed. Loads that are picked up or released
        make the sensitivities jump as exactly as the state; their masses do not depend on the keys.
    keys : str or sequence of str
        Keys by which to differentiate.
    signals : sequence of str, optional
        States and outputs to return, by their names; default is all except ``energy.oil``.
    times : (m,) array_like, optional
        Times to record, s, increasing, within the duration; default is the scenario's record interval.
    start : (n_states,) array, optional
        State at time zero, which no key moves; default is that of the scenario.
    resolve_sensitivities : bool
        Choose step sizes so that the sensitivities keep the tolerance too. Without it the states are, to the last bit,
        those of :func:`hydrocrane.simulate` by the same method, and the sensitivities inaccurate at kinks of the laws.
    **changes
        Fields of the scenario or its solver to change, as in :func:`hydrocrane.simulate`.
    """

    def __init__(
        self,
        scenario: str | PathLike[str] | Scenario,
        keys: str | Sequence[str],
        *,
        signals: Sequence[str] | None = None,
        times: ArrayLike | None = None,
        start: Array | None = None,
        resolve_sensitivities: bool = True,
        **changes: Unpack[Changes],
    ) -> None:
        plan = scenario if isinstance(scenario, Scenario) else load_scenario(scenario)
        self.plan = plan.changed(**changes)
        if self.plan.has_controller:
            raise InputError(
                "sensitivities need spool commands; this scenario has a controller, whose samples depend on the run. "
                "Give its commands as a table: commands=(time, spool), from `cylinder.<c>.command` of a run"
            )
        self.keys = _checked_keys(keys)
        self.machine = self.plan.load_machine()
        self.payload = self.machine.payload(self.plan.payload)
        wanted = _checked_times(times, self.plan)
        check_record(self.machine, self.plan, wanted.size, parameters=len(self.keys))
        self._core = self._prepared(wanted, start, resolve_sensitivities)
        with translated():
            self.parameters = tuple(Parameter(*entry) for entry in self._core.parameters())
        known = self.known_signals
        self.signals = tuple(known if signals is None else signals)
        for name in self.signals:
            check_known("signal", name, known)
        self._columns = np.array([known.index(name) for name in self.signals], dtype=np.intp)

    @property
    def known_signals(self) -> tuple[str, ...]:
        """Names of all states and outputs that have sensitivities."""
        outputs = (name for name, _, _ in self.machine.core.output_info if name != WITHOUT_SLOPE)
        return (*self.machine.state_names, *outputs)

    @property
    def values(self) -> Array:
        """(n_keys,) values of the keys in the machine, SI."""
        return np.array([parameter.value for parameter in self.parameters])

    def run(
        self, values: ArrayLike | Mapping[str, float] | None = None, progress: Progress | None = None
    ) -> SensitivityRecord:
        """The core's result with these `values` (n_keys,) of the keys, SI; default is the machine's.

        Raises
        ------
        KeyboardInterrupt
            After Ctrl-C; its attribute ``record`` holds the result until then.
        """
        given = None if values is None else self._checked_values(values).tolist()
        failed: list[BaseException] = []
        with interruptible() as should_stop, translated():
            raw = self._core.run(given, _watch(should_stop, progress, float(self.plan.duration), failed))
        if failed:
            raise failed[0]
        # Also where the core ended before it asked.
        if should_stop is not None and should_stop():
            stopped = KeyboardInterrupt(f"the run was stopped at t = {raw['outcome'][1]:.4g} s")
            stopped.record = raw  # type: ignore[attr-defined]
            raise stopped
        return raw

    def select(self, raw: SensitivityRecord) -> Solution:
        """The signals of this experiment in the result of :meth:`run`."""
        y, derivatives = (np.asarray(raw[key])[:, self._columns] for key in ("values", "sensitivities"))
        return Solution(np.asarray(raw["t"]), y, derivatives, Outcome(*raw["outcome"]))

    def stage(self) -> RecordedStage:
        """The machine, and those that take its place when a hose bursts."""
        plan, machine = self.plan, self.machine
        with translated():
            changes = _core.machine_changes(machine.core, scenario_entry(plan, machine.cylinder_names))
        later = tuple((time, machine.made(changed)) for time, changed in changes)
        return RecordedStage(0.0, machine, machine, plan.stick_mode, controlled=False, changes=later)

    def _prepared(self, times: Array, start: Array | None, resolve_sensitivities: bool) -> _core.SensitivityExperiment:
        plan, machine = self.plan, self.machine
        state = plan.initial_state(machine) if start is None else start
        at_rest = isinstance(plan.pressures, str) and start is None
        given = state[: len(machine.joint_names)] if at_rest else state
        overrides = {**machine.overrides, "payload.mass": self.payload}
        with translated():
            return _core.SensitivityExperiment(
                machine.core,
                machine.source,
                list(overrides.items()),
                scenario_entry(plan, machine.cylinder_names),
                self.keys,
                np.ascontiguousarray(given),
                at_rest,
                times,
                bool(resolve_sensitivities),
            )

    def _checked_values(self, values: ArrayLike | Mapping[str, float]) -> Array:
        if isinstance(values, Mapping):
            for key in values:
                check_known("key", key, self.keys)
            values = [values.get(parameter.key, parameter.value) for parameter in self.parameters]
        array = real_array(values, "values")
        if array.shape != (len(self.keys),):
            raise InputError(f"values must have shape ({len(self.keys)},), one of each key; got {array.shape}")
        return array


def solve(experiment: Experiment, values: ArrayLike | Mapping[str, float] | None = None) -> Solution:
    """Run an experiment and return its signals with their derivatives as plain arrays: the fast way, for fits.

    Parameters
    ----------
    experiment : Experiment
        Made once.
    values : (n_keys,) array_like or mapping, optional
        SI values of the keys; a mapping may leave keys at the machine's value.
    """
    return experiment.select(experiment.run(values))


class Sensitivities:
    """Sensitivities of all recorded signals of a run.

    Attributes
    ----------
    data : xarray.Dataset
        Over ``time`` and ``parameter``: d(signal)/d(parameter) for every state and output by its name, with ``units``
        and ``long_name``; coordinates ``parameter_value`` and ``parameter_unit``.
    relative : bool
        Sensitivities are multiplied by the parameter's value: change of the signal per 100 % of the parameter.

    Examples
    --------
    >>> keys = ["supply.pressure", "friction.lift.coulomb[0]"]
    >>> by = hc.sensitivities("vertical-lift-open-loop", keys, relative=True, duration=1.0)
    >>> print(by.data["tip.z"].dims, by.data["tip.z"].attrs["units"])
    ('time', 'parameter') m
    """

    def __init__(self, experiment: Experiment, raw: SensitivityRecord, wall: float, relative: bool) -> None:
        self._experiment, self._raw, self._wall = experiment, raw, wall
        self.relative = relative
        self.parameters = tuple(Parameter(*entry) for entry in raw["parameters"])

    def __repr__(self) -> str:
        keys = ", ".join(parameter.key for parameter in self.parameters)
        return f"<Sensitivities by {keys}: {self.outcome.kind} at {self.outcome.time:.4g} s>"

    def _repr_html_(self) -> str:
        words = "change per 100 % of" if self.relative else "derivative by"
        lines = [f"{p.key}  {words} {p.value:.6g} {p.unit}".rstrip() for p in self.parameters]
        end = f"{self.outcome.kind}  at {self.outcome.time:.4g} s, {len(self._raw['signals'])} signals"
        doubts = [f"warning: {ResultWarning(*entry)}" for entry in self._raw["warnings"]]
        return card(f"Sensitivities of {self._experiment.plan.name}", [*lines, end, *doubts], "sensitivities.data")

    @property
    def outcome(self) -> Outcome:
        """How and when the run ended."""
        return Outcome(*self._raw["outcome"])

    @cached_property
    def run(self) -> Run:
        """The run itself, as from :func:`hydrocrane.simulate` without ledger."""
        made, raw = self._experiment, self._raw
        recorded = Recording(
            time=np.asarray(raw["t"]),
            states=np.ascontiguousarray(np.asarray(raw["values"])[:, : len(made.machine.state_names)]),
            commands=np.asarray(raw["commands"]),
            ledger=np.empty((0, 0)),
            payloads=np.asarray(raw["payloads"]),
            outcome=self.outcome,
            method=raw["method"],
            effort=raw["stats"],
            warnings=(
                *(ResultWarning(*entry) for entry in raw["warnings"]),
                *self.outcome.doubts(float(made.plan.duration)),
            ),
            payload_changes=raw["payload_changes"],
            stages=() if not made.plan.bursts else (made.stage(),),
        )
        data = run_dataset(made.machine, made.plan, recorded, payload=made.payload, wall=self._wall)
        return Run(data, made.machine)

    @cached_property
    def data(self) -> xr.Dataset:
        keys, values, units = zip(*((p.key, p.value, p.unit or "1") for p in self.parameters), strict=True)
        axes = ("time", "parameter")
        data = xr.Dataset(
            coords={
                "time": ("time", np.asarray(self._raw["t"]), {"units": "s", "long_name": "time"}),
                "parameter": ("parameter", list(keys), {"long_name": "key of the machine file"}),
                "parameter_value": ("parameter", np.array(values), {"long_name": "value of the key, SI"}),
                "parameter_unit": ("parameter", list(units), {"long_name": "unit of the key"}),
            }
        )
        found = np.asarray(self._raw["sensitivities"]) * (np.array(values) if self.relative else 1.0)
        per = "" if self.relative else f" per {units[0] if len(set(units)) == 1 else 'unit of the parameter'}"
        for i, (name, unit, meaning) in enumerate(self._raw["signals"]):
            data[name] = (axes, found[:, i].copy(), {"units": unit + per, "long_name": f"sensitivity of {meaning}"})
        data.attrs = {**self.run.data.attrs, "relative": int(self.relative)}
        return data


def sensitivities(
    scenario: str | PathLike[str] | Scenario,
    keys: str | Sequence[str],
    *,
    relative: bool = False,
    resolve_sensitivities: bool = True,
    progress: Progress | None = None,
    **changes: Unpack[Changes],
) -> Sensitivities:
    """Run a scenario together with the exact derivatives of its states and outputs by keys of its machine file.

    Parameters
    ----------
    scenario : str, path or Scenario
        With spool commands, and no controller in any phase. Measured supply pressures, hoses that burst and loads that
        are picked up or released are part of the run; ``payload.mass`` is the load until the first of its changes.
    keys : str or sequence of str
        Keys of the machine file with numeric values, such as ``friction.lift.bristle-stiffness``, ``payload.mass`` or
        ``friction.lift.coulomb[0]``.
    relative : bool
        Multiply each sensitivity by its parameter's value, so that those by different keys can be compared.
    resolve_sensitivities : bool
        Choose step sizes so that the sensitivities keep the tolerance too. Without it the states are, to the last bit,
        those of :func:`hydrocrane.simulate` by the same method, and the sensitivities are inaccurate where a law has a
        kink.
    progress : callable, optional
        Called from time to time with (time reached, duration), s.
    **changes
        Fields of the scenario or its solver to change, as in :func:`hydrocrane.simulate`.

    Returns
    -------
    Sensitivities
        Also if the run ends early: then up to its end.

    Raises
    ------
    KeyboardInterrupt
        After Ctrl-C; its attribute ``sensitivities`` holds them until then, with outcome and warning ``interrupted``.

    Examples
    --------
    >>> by = hc.sensitivities("vertical-lift-open-loop", "supply.pressure", duration=1.0)
    >>> derivative = float(by.data["tip.z"].isel(time=-1, parameter=0))
    >>> print(f"{derivative * 1e5 * 1e3:.1f} mm per bar")
    0.2 mm per bar
    """
    experiment = Experiment(scenario, keys, resolve_sensitivities=resolve_sensitivities, **changes)
    if relative:
        for parameter in experiment.parameters:
            if parameter.value == 0.0:
                raise InputError(
                    f"`{parameter.key}` is zero, so nothing can be relative to it; leave out relative=True"
                )
    began = time.perf_counter()
    try:
        raw = experiment.run(progress=progress)
    except KeyboardInterrupt as stopped:
        if part := getattr(stopped, "record", None):
            found = Sensitivities(experiment, part, time.perf_counter() - began, relative)
            stopped.sensitivities = found  # type: ignore[attr-defined]
            stopped.add_note("The sensitivities until then are the attribute `sensitivities` of this exception.")
        raise
    return Sensitivities(experiment, raw, time.perf_counter() - began, relative)


def _checked_keys(keys: str | Sequence[str]) -> list[str]:
    listed = [keys] if isinstance(keys, str) else list(keys)
    if not listed or not all(isinstance(key, str) for key in listed):
        raise InputError(f"keys must be one or more keys of the machine file, such as `supply.pressure`; got {keys!r}")
    return listed


def _checked_times(times: ArrayLike | None, plan: Scenario) -> Array:
    if times is None:
        return plan.record_times()
    array = real_array(times, "times")
    inside = array.ndim == 1 and array.size and array[0] >= 0 and array[-1] <= plan.duration * (1 + 1e-12)
    if not inside or (np.diff(array) <= 0).any():
        raise InputError(f"times must be one row that increases within 0 and the duration, {plan.duration:g} s")
    return np.ascontiguousarray(array)


def _watch(
    should_stop: Callable[[], bool] | None, progress: Progress | None, duration: float, failed: list[BaseException]
) -> Callable[[float], bool] | None:
    """Callback of the core: reports progress, and returns whether to stop; what `progress` raises goes to `failed`."""
    if should_stop is None and progress is None:
        return None

    def watch(reached: float) -> bool:
        if progress is not None:
            try:
                progress(reached, duration)
            except BaseException as error:
                failed.append(error)
        return bool(failed) or (should_stop is not None and should_stop())

    return watch
