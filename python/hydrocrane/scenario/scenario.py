"""What is to be simulated: machine, payload, start, spool commands against time, duration, solver.

A scenario comes from a bundled name, from a TOML file, or is built in Python::

    Scenario(machine="rottne-f9-lab", joints={"boom": 1.7, "jib": 1.7, "extension": 0.0},
             commands={"lift": ([0.0, 1.0], [0.02, 0.0])}, duration=3.0)

Numbers are SI and radians; strings in `overrides` carry their unit.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack, cast

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane import _core
from hydrocrane._core_types import CommandEntry, ControllerEntry, JoystickEntry, Pairs, PhaseEntry, ScenarioEntry
from hydrocrane.arrays import Array, brief, checked_line, checked_name, scenario_quantity, seed_number
from hydrocrane.control.controllers import AnyController, check_controller
from hydrocrane.control.joystick import MODES_OF, Joystick
from hydrocrane.errors import InputError, nearest, translated, unknown
from hydrocrane.files.whole_file import write_text
from hydrocrane.machine.machine import Machine, load_machine
from hydrocrane.machine.overrides import Override, plain_overrides
from hydrocrane.machine.sensors import SensorFault
from hydrocrane.notebook import card
from hydrocrane.result_warning import ResultWarning
from hydrocrane.scenario.changes import Changes, Pressures, ScenarioFields, check_agreement, later_counts, stated_fields
from hydrocrane.scenario.events import Burst, Goal, as_bursts
from hydrocrane.scenario.payload import payload_changes
from hydrocrane.scenario.phases import ControlLoop, Phase, ScenarioStage, in_order_of_time
from hydrocrane.scenario.recorded_span import RecordedSpan
from hydrocrane.scenario.series import MEASURED, Command, SupplyPressure, as_command, as_supply, split_table
from hydrocrane.scenario.solver import FIXED_STEPS, Solver, unusual


@dataclass(frozen=True)
class Scenario(RecordedSpan, ControlLoop):
    """A complete description of one run.

    `payload`, the `period` of a named controller and the joystick's `full_speed` are also stated by the machine. The
    scenario has priority over the machine. `changed` and :func:`hydrocrane.simulate` have priority over both, whether
    they give the field or the override. Two different values at the same level are an error.

    Parameters
    ----------
    machine : str, path or Machine
        Bundled name, path, or a loaded machine, whose source and overrides are then kept.
    joints : mapping
        Start value of every joint, rad or m.
    commands : mapping
        Per cylinder a :class:`Command`, a pair (time, spool), or one constant spool value; the spools of all other
        cylinders stay centred. Or a pair (time (k,), spool (k, n_cyl)) for all cylinders at once.
    supply : SupplyPressure, optional
        Measured pressure of the supply, or a pair (time, pressure) in s and Pa; default is the machine's constant one
        or its pump.
    duration, record_interval : float
        s.
    pressures : "equilibrium" or mapping
        Chamber pressures at the start: those that hold the crane, or (p1, p2) per cylinder, Pa.
    payload : float, optional
        kg at the tip; default is the machine's own.
    overrides : mapping
        Machine keys to change, see :func:`hydrocrane.load_machine`.
    solver : Solver
        Method of integration and its tolerances.
    name, title : str
        Name of results, letters, digits, ``-``, ``_`` and ``.``; what the scenario shows, in a few words.
    seed : int
        Of everything drawn at random.
    controller : str or object, optional
        In place of `commands`: ``tip``, ``heinze-pid``, ``lever``, or your own controller (an object with
        ``reset(machine, obs)`` and ``step(obs, command)``, or a function like ``step``) that returns spool commands.
    joystick : Joystick, optional
        Sticks of the operator; without `controller` they select ``tip``, or in mode ``lever`` ``lever``.
    goals : sequence of Goal
        Points to which the tip moves by itself; without `controller` they select ``tip``.
    period : float, optional
        Time between samples, s; default is the machine's or the controller's, 10 ms for your own.
    delay : float
        Computation delay of the controller, s.
    sensors : {"ideal", "data-sheet"}
        What the controller reads: true values, or the machine's sensors with errors drawn by `seed`.
    sensor_faults : sequence of SensorFault
    bursts : sequence of Burst
        Hoses that burst during the run.
    payload_changes : mapping
        Time, s, to the payload, kg, from then on: loads at rest that are picked up, and loads released. Entries after
        the end of the run have no effect.
    controller_model : mapping or Machine, optional
        Controller model: overrides of the machine, or another machine with as many joints of the same kinds. It does
        not change the simulated crane. By default it equals the crane. Your own controller receives this machine in
        ``reset``.
    monitor : bool, optional
        Whether implausible sensor readings close the valves until they are plausible again; default is yes for ``tip``
        and ``heinze-pid``, no for ``lever``, which reads no sensors, and for your own controller.
    phases : sequence of Phase
        Changes during the run: controller, sticks, values of the machine. After `commands` the first phase brings the
        controller. Phases after the end of the run have no effect.
    recorded_by : str
        Version of hydrocrane whose cockpit recorded it; empty if it is not a recorded drive.
    record_limit : float or str, optional
        Most memory that the columns of a run may take, ``"8 GB"`` or a number of bytes; default is 2 GB. A longer run
        is refused before it begins. A matter of the computer: files of scenarios do not state it.
    warnings : sequence of ResultWarning
        Unusual values of the file it was read from; its runs repeat them.

    Examples
    --------
    >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
    >>> plan = hc.Scenario(machine="rottne-f9-lab", joints=start, commands={"lift": 1e-3}, duration=1.0)
    >>> run = hc.simulate(plan.changed(payload=50.0))
    >>> print(run.outcome.kind, run.columns["payload"].values[0])
    completed 50.0
    """

    machine: str = "rottne-f9-lab"
    joints: Mapping[str, float] = field(default_factory=dict)
    commands: Mapping[str, Command] | Sequence[ArrayLike] = field(default_factory=dict)
    pressures: Pressures = "equilibrium"
    payload: float | None = None
    overrides: Mapping[str, Override] = field(default_factory=dict)
    solver: Solver = field(default_factory=Solver)
    name: str = "unnamed"
    title: str = ""
    seed: int = 0
    goals: Sequence[Goal] = ()
    sensor_faults: Sequence[SensorFault] = ()
    bursts: Sequence[Burst] = ()
    payload_changes: Mapping[float, float] = field(default_factory=dict)
    phases: Sequence[Phase] = ()
    supply: SupplyPressure | None = None
    recorded_by: str = ""
    warnings: Sequence[ResultWarning] = field(default=(), compare=False)

    __repr__ = brief

    if TYPE_CHECKING:
        # Arguments have more forms than the stored fields: a machine, commands and overrides.
        def __init__(self, **fields: Unpack[ScenarioFields]) -> None: ...

    def __post_init__(self) -> None:
        checked_name("the name of a scenario", self.name)
        checked_line("the title of a scenario", self.title)
        object.__setattr__(self, "goals", in_order_of_time(self.goals, Goal, "goals", "are given"))
        self._check_loop()
        object.__setattr__(self, "phases", in_order_of_time(self.phases, Phase, "phases", "begin"))
        first = self.phases[0] if self.phases and not self.closed_loop else None
        if first is not None and first.controller is None and first.joystick is None:
            raise InputError(
                "phases change controller or sticks: give a controller or a joystick, in place of commands or in the "
                "first phase"
            )
        object.__setattr__(self, "seed", seed_number(self.seed))
        object.__setattr__(self, "payload_changes", payload_changes(self.payload_changes))
        self._check_record()
        if isinstance(self.commands, Mapping):
            object.__setattr__(self, "commands", {c: as_command(c, v) for c, v in self.commands.items()})
        object.__setattr__(self, "supply", as_supply(self.supply))
        object.__setattr__(self, "bursts", as_bursts(self.bursts))
        if self.payload is not None:
            scenario_quantity("scenario.payload", "payload", self.payload)
        overrides = plain_overrides(self.overrides)
        check_agreement(self, overrides)
        if isinstance(self.machine, Machine):
            hidden = stated_fields(self)
            own = {key: value for key, value in self.machine.overrides.items() if key not in hidden}
            overrides = {**own, **overrides}
            object.__setattr__(self, "machine", self.machine.source)
        object.__setattr__(self, "machine", str(self.machine))
        object.__setattr__(self, "overrides", overrides)
        for phase in self.phases:
            load = phase.overrides.get("payload.mass")
            if load is not None and load != overrides.get("payload.mass"):
                raise InputError(
                    f"the phase from {phase.time:g} s on overrides `payload.mass`, but a phase does not change the "
                    f"load: give payload_changes={{{phase.time:g}: ...}} in kg"
                )
        object.__setattr__(self, "warnings", self._doubts())

    def _doubts(self) -> tuple[ResultWarning, ...]:
        """The warnings of its file, and those on values that Python stated; a value that is usual now has none."""
        given = {
            "scenario.duration": self.duration, "scenario.record-interval": self.record_interval,
            "scenario.payload": self.payload, "controller.delay": self.delay, **self.solver.quantities,
        }  # fmt: skip
        found = unusual({key: value for key, value in given.items() if value is not None})
        kept = tuple(warning for warning in self.warnings if warning.key not in given or warning.key in found)
        reported = {warning.key for warning in kept}
        return (*kept, *(warning for key, warning in found.items() if key not in reported))

    def changed(self, **fields: Unpack[Changes]) -> Scenario:
        """A copy with some fields, or fields of its solver, replaced; `overrides` are added to those it has.

        The values given here have priority over the scenario: ``overrides={"payload.mass": 200}`` over its
        `payload`, and ``payload=200`` over its override. Different values for both are an error.

        Examples
        --------
        >>> plan = hc.load_scenario("vertical-lift-open-loop")
        >>> plan.changed(payload=20.0).payload
        20.0
        """
        own, inner = _FIELDS, _SOLVER_FIELDS
        changes: dict[str, Any] = dict(fields)
        for name in changes:
            if name not in own | inner:
                raise InputError(f"a scenario has no `{name}`{nearest(name, sorted(own | inner))}")
        solver = changes.pop("solver", self.solver)
        inside = {name: changes.pop(name) for name in list(changes) if name in inner}
        if inside.get("method", FIXED_STEPS) != FIXED_STEPS:
            inside.setdefault("step", None)
        if "overrides" in changes:
            changes["overrides"] = plain_overrides(changes["overrides"])
        counting: dict[str, Any] = dict(later_counts(self, cast(ScenarioFields, changes)))
        return dataclasses.replace(self, solver=dataclasses.replace(solver, **inside) if inside else solver, **counting)

    def _check_loop(self) -> None:
        """Checks of the controller and its settings."""
        check_controller(self.controller)
        if (self.closed_loop or (self.goals and not self.phases)) and len(self.commands):
            raise InputError("a scenario has either commands or a controller with its joystick, not both")
        if self.sensor_faults and not self.has_controller:
            raise InputError("sensor_faults need a controller or a joystick: without one the sensors are not read")
        self._check_values()
        if self.controller_model is not None:
            if not self.closed_loop:
                raise InputError("this scenario has a `controller_model`, but no controller")
            if not isinstance(self.controller_model, Machine):
                object.__setattr__(self, "controller_model", plain_overrides(self.controller_model))
        if isinstance(self.driver, str) and self.stick_mode not in MODES_OF[self.driver]:
            raise InputError(f"controller `{self.driver}` does not support the stick mode `{self.stick_mode}`")

    @property
    def closed_loop(self) -> bool:
        """Whether a controller moves the spools from the start on."""
        goes = bool(self.goals) and not len(self.commands)
        return self.controller is not None or self.joystick is not None or goes

    @property
    def has_controller(self) -> bool:
        """Whether a controller moves the spools, from the start on or in a phase."""
        return self.closed_loop or bool(self.phases)

    @property
    def stick_mode(self) -> str:
        """Mode of the sticks."""
        if self.joystick is not None:
            return self.joystick.mode
        return "lever" if isinstance(self.controller, str) and self.controller == "lever" else "tip"

    @property
    def driver(self) -> AnyController | None:
        """The controller, or the one that the joystick or the goals select."""
        if self.controller is None and self.closed_loop:
            return "lever" if self.joystick is not None and self.joystick.mode == "lever" else "tip"
        return self.controller

    @property
    def monitored(self) -> bool:
        """Whether a sensor monitor is active."""
        if self.monitor is None:
            return isinstance(self.driver, str) and self.driver != "lever"
        return bool(self.monitor)

    @property
    def machine_overrides(self) -> dict[str, Override]:
        """The overrides, plus those of a controller's period and full speed, a measured supply and hoses that burst."""
        if self.bursts:
            return dict(self.stages()[0][1].machine_overrides)
        return {**self.overrides, **self._loop_overrides, **(MEASURED if self.supply is not None else {})}

    @property
    def _loop_overrides(self) -> dict[str, Override]:
        return {key: value for key, (_, value, _) in stated_fields(self).items() if key != "payload.mass"}

    def stages(self) -> list[tuple[float, ScenarioStage]]:
        """The time, s, at which each phase begins, and what applies from then on; the first from 0 on.

        Examples
        --------
        >>> len(hc.load_scenario("vertical-lift-open-loop").stages())
        1
        """
        with translated():
            stages = _core.stages(scenario_entry(self))
        own = own_controllers(self)
        return [(stage["from"], ScenarioStage.of(stage, own)) for stage in stages]

    def to_toml(self, machine: str | None = None) -> str:
        """The scenario as the text of a file; :func:`hydrocrane.load_scenario` reads the same scenario from it.

        Parameters
        ----------
        machine : str, optional
            What the file names as its machine, such as ``./crane.toml`` for a file beside it; default is the path of
            the machine, or its bundled name.

        Raises
        ------
        InputError
            If a file cannot hold it: your own controller, or another machine as the controller model.

        Examples
        --------
        >>> plan = hc.load_scenario("vertical-lift-open-loop")
        >>> plan.to_toml().splitlines()[0]
        '[scenario]'
        """
        made = self.load_machine()
        head = (self.name, self.title, machine or made.source, self.recorded_by)
        with translated():
            return _core.scenario_text(made.core, scenario_entry(self, made.cylinder_names), head)

    def save(self, path: str | PathLike[str]) -> Path:
        """Write the scenario as a file, whose name ends in ``.toml``; see :meth:`to_toml`.

        Examples
        --------
        >>> plan = hc.load_scenario("vertical-lift-open-loop")
        >>> plan.save("lift.toml").name
        'lift.toml'
        """
        file = Path(path)
        if file.suffix != ".toml":
            raise InputError(f"a scenario is saved as TOML: give a name that ends in .toml, got `{file.name}`")
        return write_text(file, self.to_toml())

    def _repr_html_(self) -> str:
        return _card(self)

    def load_machine(self) -> Machine:
        """The scenario's machine with its overrides.

        Examples
        --------
        >>> hc.load_scenario("vertical-lift-open-loop").load_machine().name
        'rottne-f9-lab'
        """
        return load_machine(self.machine, self.machine_overrides)

    def initial_state(self, machine: Machine) -> Array:
        """State (n_states,) at time zero.

        Examples
        --------
        >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> state = hc.Scenario(joints=start).initial_state(crane)
        >>> print(state.shape, state[:3])
        (21,) [1.745 1.745 0.   ]
        """
        return self.start(machine)[0]

    def start(self, machine: Machine) -> tuple[Array, tuple[ResultWarning, ...]]:
        """State (n_states,) at time zero, and its warnings.

        Examples
        --------
        >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> state, warnings = hc.Scenario(joints=start).start(crane)
        >>> print(state.shape, warnings)
        (21,) ()
        """
        with translated():
            state, doubts = _core.start_state(machine.core, scenario_entry(self, machine.cylinder_names))
        return state, tuple(ResultWarning(*entry) for entry in doubts)

    def command_grid(self, machine: Machine) -> tuple[Array, Array, bool]:
        """Commands of all cylinders on common times: times (k,), spools (k, n_cyl), and whether to interpolate.

        Examples
        --------
        >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> plan = hc.Scenario(joints=start, commands={"lift": ([0.5, 2.0], [0.003, 0.0])})
        >>> times, spools, linear = plan.command_grid(crane)
        >>> print(times, spools[:, 0], linear)
        [0.  0.5 2. ] [0.    0.003 0.   ] False
        """
        with translated():
            return _core.command_table(machine.core, scenario_entry(self, machine.cylinder_names))


_FIELDS = frozenset(f.name for f in dataclasses.fields(Scenario))
_SOLVER_FIELDS = frozenset(f.name for f in dataclasses.fields(Solver))


def _card(plan: Scenario) -> str:
    """Machine, duration, start, what moves the spools, loads, solver and overrides, as HTML."""
    lines = [f"title  {plan.title}"] if plan.title else []
    lines += [
        f"machine  {plan.machine}",
        f"duration  {plan.duration:g} s, recorded every {plan.record_interval * 1e3:g} ms",
        f"pressures  {plan.pressures if isinstance(plan.pressures, str) else 'given'} at the start",
    ]
    if plan.joints:
        lines.append(f"joints  {', '.join(f'{joint} {value:.4g}' for joint, value in plan.joints.items())} (rad or m)")
    lines.append(f"driven by  {_driver(plan)}")
    if plan.payload is not None:
        lines.append(f"payload  {plan.payload:g} kg")
    lines += [f"payload from {time:g} s  {mass:g} kg" for time, mass in plan.payload_changes.items()]
    if plan.supply is not None:
        lines.append("supply  measured pressure")
    lines += [f"hose of {b.cylinder}, {b.side}  bursts at {b.time:g} s" for b in plan.bursts]
    lines.append(f"solver  {plan.solver.method}, rtol {plan.solver.rtol:g}")
    lines += [f"{key}  {value}" for key, value in plan.overrides.items()]
    lines += [f"warning  {warning}" for warning in plan.warnings]
    return card(f"Scenario {plan.name}", lines, "print(scenario.to_toml())")


def _driver(plan: Scenario) -> str:
    if not plan.closed_loop:
        return "spool commands against time" if len(plan.commands) else "nothing: spools centred"
    driver = plan.driver
    name = driver if isinstance(driver, str) else getattr(driver, "__name__", type(driver).__name__)
    return f"controller {name}, {plan.sensors} sensors"


def scenario_entry(plan: Scenario, cylinders: tuple[str, ...] | None = None) -> ScenarioEntry:
    """`plan` for a machine with these `cylinders`; commands in one table need them."""
    return {
        "overrides": list(plan.overrides.items()),
        "payload": None if plan.payload is None else float(plan.payload),
        "payload_changes": list(plan.payload_changes.items()),
        "duration": float(plan.duration),
        "record_interval": float(plan.record_interval),
        "joints": [(name, _one(f"start of joint {name}", q)) for name, q in plan.joints.items()],
        "places": [getattr(q, "place", "") for q in plan.joints.values()],
        "pressures": _pressures(plan),
        "commands": _commands(plan, cylinders),
        "supply": None if plan.supply is None else plan.supply.entry,
        "controller": _controller(plan, plan.driver, 0) if plan.closed_loop else None,
        "joystick": _joystick(plan.joystick),
        "goals": [(goal.time, (goal.x, goal.z), goal.speed, goal.until) for goal in plan.goals],
        "phases": [_phase(phase, number) for number, phase in enumerate(plan.phases, start=1)],
        "sensor_faults": [fault.entry for fault in plan.sensor_faults],
        "bursts": [burst.entry for burst in plan.bursts],
        "solver": plan.solver.entry,
        "seed": plan.seed,
    }


def own_controllers(plan: Scenario) -> dict[int, AnyController]:
    """Your own controllers, by their numbers in the core."""
    drivers = [plan.driver, *(phase.controller for phase in plan.phases)]
    return {number: driver for number, driver in enumerate(drivers) if not isinstance(driver, str | None)}


def _one(what: str, value: ArrayLike) -> float:
    try:
        return float(np.asarray(value, dtype=np.float64))
    except (TypeError, ValueError):
        raise InputError(f"{what} must be one number; got {value!r}") from None


def _pressures(plan: Scenario) -> list[tuple[str, tuple[float, float]]] | None:
    if isinstance(plan.pressures, str):
        if plan.pressures != "equilibrium":
            raise unknown("start of the pressures", plan.pressures, ("equilibrium",))
        return None
    table = []
    for name, pair in plan.pressures.items():
        values = np.asarray(pair, dtype=np.float64)
        if values.shape != (2,):
            raise InputError(f"the start pressures of cylinder {name} must be two, (p1, p2); got {pair!r}")
        table.append((name, (float(values[0]), float(values[1]))))
    return table


def _commands(plan: Scenario, cylinders: tuple[str, ...] | None) -> list[CommandEntry]:
    commands = plan.commands
    if not isinstance(commands, Mapping):
        commands = split_table(commands, cylinders or ())
    return [(name, c.time, c.spool, c.interpolation == "linear") for name, c in commands.items()]


def _controller(own: ControlLoop, driver: AnyController | None, number: int) -> ControllerEntry:
    other: Machine | None = None
    changes: Pairs = []
    if isinstance(own.controller_model, Machine):
        other = own.controller_model
    elif own.controller_model is not None:
        changes = list(plain_overrides(own.controller_model).items())
    return {
        "name": driver if isinstance(driver, str) else "",
        "own": None if isinstance(driver, str) else number,
        "period": None if own.period is None else float(own.period),
        "delay": float(own.delay),
        "sensors": own.sensors,
        "controller_model": changes,
        "other_model": None if other is None else (other.source, list(other.overrides.items())),
        "monitor": own.monitor,
    }


def _joystick(stick: Joystick | None) -> JoystickEntry | None:
    if stick is None:
        return None
    return {
        "mode": stick.mode,
        "time": stick.time,
        "axes": list(stick.axes.items()),
        "log": None,
        "linear": stick.interpolation == "linear",
        "dead_zone": float(stick.dead_zone),
        "full_speed": None if stick.full_speed is None else float(stick.full_speed),
        "ramp": float(stick.ramp),
        "precision": stick.precision,
    }


def _phase(phase: Phase, number: int) -> PhaseEntry:
    return {
        "time": phase.time,
        "overrides": list(plain_overrides(phase.overrides).items()),
        "controller": None if phase.controller is None else _controller(phase, phase.controller, number),
        "joystick": _joystick(phase.joystick),
    }
