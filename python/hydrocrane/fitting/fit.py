"""Fit values of a machine to logs: the public function."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from os import PathLike
from typing import Literal, TypeAlias, Unpack

from hydrocrane.arrays import positive_number, seed_number, whole_number
from hydrocrane.errors import InputError, check_known
from hydrocrane.fitting.accuracy import accurate
from hydrocrane.fitting.doubts import suspected
from hydrocrane.fitting.parameters import Priors, check_names
from hydrocrane.fitting.records import HoldOut, opened, window_of
from hydrocrane.fitting.result import Fit
from hydrocrane.fitting.search import searched
from hydrocrane.fitting.setup import Setup
from hydrocrane.fitting.ties import Ties, ties_of
from hydrocrane.logs import log_mapping
from hydrocrane.logs.columns import LogLike
from hydrocrane.logs.mapping import MappingLike
from hydrocrane.machine.machine import Machine
from hydrocrane.scenario.changes import Changes
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.scenario.scenario_file import load_scenario

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
