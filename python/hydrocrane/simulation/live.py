"""A scenario run live: it goes on as planned until sticks, goals or loads are given during the run."""

from __future__ import annotations

import dataclasses
from os import PathLike
from typing import Unpack

from hydrocrane import _core
from hydrocrane._core_types import DrivenStage
from hydrocrane.arrays import Array, one_number, positive_number
from hydrocrane.control.controllers import Observation, SampledController
from hydrocrane.control.joystick import Joystick
from hydrocrane.errors import InputError, SimulationError, check_known, translated
from hydrocrane.machine.machine import Machine
from hydrocrane.result_warning import ResultWarning
from hydrocrane.results.outcome import Outcome
from hydrocrane.results.record import Event
from hydrocrane.scenario.changes import RunChanges
from hydrocrane.scenario.events import Goal
from hydrocrane.scenario.payload import PayloadChange
from hydrocrane.scenario.phases import Phase
from hydrocrane.scenario.scenario import Scenario, own_controllers, scenario_entry
from hydrocrane.scenario.scenario_file import load_scenario
from hydrocrane.simulation.running import machine_for
from hydrocrane.simulation.simulator import Sample


class LiveSimulator:
    """A scenario run sample by sample, in which you take over with sticks, goals and loads.

    It is the loop of :func:`hydrocrane.simulate` and of the page, step by step. As long as nothing is set here, the
    scenario runs as planned: spool commands, sticks, goals, loads, phases, all to the last bit those of ``simulate``.

    :meth:`set_stick`, :meth:`go_to`, :meth:`drop_goal` and :meth:`set_payload` take over. The plan then ends: sticks,
    goals, loads and phases of the scenario that are still to come have no effect any more. Controller, sensors and
    machine stay those of the present phase, the load stays at the tip, and the new input takes effect at the next
    sample. If spool commands move the crane, the controller ``lever`` takes their place at once; :attr:`axes` are then
    the cylinders. Hoses still burst and sensors still fail at the times that the scenario states.

    For your own controllers that return spool commands see :class:`hydrocrane.Simulator`.

    Parameters
    ----------
    scenario : str, path or Scenario
        Start, machine, commands or controller, sensors and delays, phases. Its duration is ignored: held commands and
        sticks keep their last values.
    machine : Machine, str or path, optional
        Used in place of the scenario's machine; the scenario's overrides still apply.
    **changes
        Fields of the scenario or its solver to change, as for :func:`hydrocrane.simulate`.

    Raises
    ------
    InputError
        For any error of the scenario.

    Examples
    --------
    >>> import numpy as np
    >>> import hydrocrane as hc
    >>> start = {"boom": np.deg2rad(100), "jib": np.deg2rad(100), "extension": 0.0}
    >>> live = hc.LiveSimulator(hc.Scenario(joints=start, controller="tip"))
    >>> live.set_stick(z=0.2)
    >>> obs = live.step(0.5)
    >>> live.set_stick()
    >>> live.go_to(2.7, 0.2, speed=0.3)
    >>> obs = live.step(4.0)
    >>> print(obs.tip.round(3), live.goal, live.events[-1].text)
    [2.7 0.2] None the tip has reached its goal (2.700, 0.200) m
    """

    def __init__(
        self,
        scenario: str | PathLike[str] | Scenario,
        *,
        machine: Machine | str | PathLike[str] | None = None,
        **changes: Unpack[RunChanges],
    ) -> None:
        plan = scenario if isinstance(scenario, Scenario) else load_scenario(scenario)
        plan = plan.changed(**changes)
        self.machine = machine_for(plan, machine)
        self._plan = plan
        own = own_controllers(plan)

        def make(number: int, model: _core.Machine, mode: str, full_speed: float | None) -> SampledController:
            law = own[number]
            assert not isinstance(law, str), "controllers by name are the core's"
            return SampledController(law, self.machine.made(model), mode, full_speed)

        with translated():
            entry = scenario_entry(plan, self.machine.cylinder_names)
            self._core = _core.LiveSimulator(self.machine.core, entry, make if own else None)
        self._read_by, self._sample = 0, Sample(self.machine, self._core.signals)
        self._outcome: Outcome | None = None
        self._reported: list[Event] = []
        self._warnings: tuple[ResultWarning, ...] = ()

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the sticks' axes in the present phase: x, z and, of a crane that slews, slew; or the cylinders."""
        return tuple(self._core.axes)

    @property
    def period(self) -> float:
        """Time between samples of the controller of the present phase, s; under spool commands that of ``lever``."""
        return self._core.period

    @property
    def time(self) -> float:
        """s."""
        return self._core.time

    @property
    def state(self) -> Array:
        """(n_states,) in the order of ``machine.state_names``."""
        return self._core.state

    @property
    def observation(self) -> Observation:
        """The crane now.

        Its `measured` is what the controller read at its last sample; NaN before the first one of a phase, and under
        spool commands.
        """
        stage = self._core.ended_stages
        if stage != self._read_by:
            # The sensors of another phase may have other signals.
            self._read_by, self._sample = stage, Sample(self.machine, self._core.signals)
        return self._sample.seen(self._core.observation)

    @property
    def as_planned(self) -> bool:
        """Whether the scenario's own plan moves the crane; false once somebody has taken over, or without a plan."""
        return self._core.replaying

    @property
    def payload(self) -> float:
        """At the tip, kg."""
        return self._core.payload

    @property
    def goal(self) -> tuple[float, float] | None:
        """Goal of the tip (x, z), m; ``None`` once it is reached, or a stick or :meth:`drop_goal` ended it."""
        place = self._core.goal
        return None if place is None else (place[0], place[1])

    @property
    def set_point(self) -> tuple[float, ...] | None:
        """Set-point of the tip, m, if the controller has one: (x, z), or (x, y, z) of a machine in space."""
        place = self._core.set_point
        return None if place is None else tuple(place)

    @property
    def events(self) -> tuple[Event, ...]:
        """Events so far, such as a goal that was reached, in order of time."""
        self._reported += [Event(time, text) for time, text in self._core.events()]
        loads = [Event(change.time, change.text) for change in self.payload_changes]
        return tuple(sorted(self._reported + loads, key=lambda event: event.time))

    @property
    def payload_changes(self) -> tuple[PayloadChange, ...]:
        """Loads picked up and released so far."""
        return tuple(PayloadChange.of(entry) for entry in self._core.payload_changes())

    @property
    def warnings(self) -> tuple[ResultWarning, ...]:
        """Warnings so far, see docs/reference/warnings.md."""
        self._warnings += tuple(ResultWarning(*entry) for entry in self._core.warnings())
        return self._warnings

    @property
    def outcome(self) -> Outcome | None:
        """How it ended; ``None`` while it continues."""
        return self._outcome

    def step(self, duration: float | None = None) -> Observation:
        """Advance by one sample of the controller, or by `duration` (s) rounded up to whole samples.

        The begin of a phase counts as a sample. Under spool commands the solver's steps end where they would in
        :func:`hydrocrane.simulate`, so that :attr:`time` can pass a sample by less than one step.

        Raises
        ------
        SimulationError
            If it fails; ``state`` keeps the last good one.

        Examples
        --------
        >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
        >>> live = hc.LiveSimulator(hc.Scenario(joints=start, controller="tip"))
        >>> obs = live.step()
        >>> print(obs.t, live.step(0.1).t)
        0.01 0.11
        """
        seconds = None if duration is None else positive_number("the duration", duration, "seconds")
        if self._outcome is not None:
            raise SimulationError(f"{self._end()}; begin a new one")
        kind, message = self._core.step(seconds)
        if kind != "completed":
            self._outcome = Outcome(kind, self.time, message)
            raise SimulationError(self._end())
        return self.observation

    def set_stick(self, **deflections: float) -> None:
        """Set and hold the sticks from the next sample on: ``set_stick(x=0.5, z=-0.2)``, or cylinders by name.

        Deflections are shares from -1 to 1; all other axes are centred, so ``set_stick()`` releases all. A
        stick outside its dead zone cancels a goal.

        Examples
        --------
        >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
        >>> live = hc.LiveSimulator(hc.Scenario(joints=start, controller="tip"))
        >>> before = live.observation.tip[1]
        >>> live.set_stick(z=0.5)
        >>> print(live.step(0.5).tip[1] > before, live.as_planned)
        True False
        """
        axes = self.axes
        for name, value in deflections.items():
            check_known("stick axis", name, axes)
            if not abs(one_number(f"the deflection of `{name}`", value)) <= 1:
                raise InputError(f"the deflection of `{name}` is {value!r}; a stick ends at -1 and 1")
        self._core.set_sticks([float(deflections.get(name, 0.0)) for name in axes])

    def set_precision(self, share: float) -> None:
        """Set the share of the full speed from the next sample on, 0 to 1: a slower stick for precise work.

        Examples
        --------
        >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
        >>> live = hc.LiveSimulator(hc.Scenario(joints=start, controller="tip"))
        >>> live.set_stick(z=1.0)
        >>> live.set_precision(0.1)
        >>> slow = live.step(0.3).tip[1]
        >>> live.set_precision(1.0)
        >>> print(live.step(0.3).tip[1] - slow > 0.01)
        True
        """
        if not 0 <= one_number("the precision", share) <= 1:
            raise InputError(f"the precision is a share of the full speed, from 0 to 1; got {share!r}")
        self._core.set_precision(float(share))

    def go_to(self, x: float, z: float, speed: float | None = None) -> None:
        """Move the tip to the point (x, z), m, on a straight line from the next sample on.

        Parameters
        ----------
        speed : float, optional
            Speed towards the goal, m/s; default is the speed at full stick.

        Raises
        ------
        InputError
            A point out of reach or in a keep-out region, with the nearest valid one; a controller other than ``tip``; a
            stick that is deflected.

        Examples
        --------
        >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
        >>> live = hc.LiveSimulator(hc.Scenario(joints=start, controller="tip"))
        >>> live.go_to(2.7, 0.0, speed=0.3)
        >>> obs = live.step(0.2)
        >>> print(live.goal)
        (2.7, 0.0)
        """
        place = (one_number("`x` of a goal", x), one_number("`z` of a goal", z))
        with translated():
            self._core.go_to(place, None if speed is None else one_number("the speed to a goal", speed))

    def drop_goal(self) -> None:
        """Cancel the goal from the next sample on: the tip comes to rest smoothly where it is.

        Examples
        --------
        >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
        >>> live = hc.LiveSimulator(hc.Scenario(joints=start, controller="tip"))
        >>> live.go_to(2.7, 0.0)
        >>> obs = live.step(0.2)
        >>> live.drop_goal()
        >>> obs = live.step(0.1)
        >>> print(live.goal)
        None
        """
        self._core.drop_goal()

    def set_payload(self, mass: float) -> None:
        """Set the load at the tip to `mass`, kg, from the next sample on.

        Examples
        --------
        >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
        >>> live = hc.LiveSimulator(hc.Scenario(joints=start, controller="tip"))
        >>> live.set_payload(50.0)
        >>> obs = live.step(0.1)
        >>> print(live.payload, len(live.payload_changes))
        50.0 1
        """
        self._core.set_payload(self.machine.payload(mass))

    def scenario(self, **changes: Unpack[RunChanges]) -> Scenario:
        """The drive so far as a scenario, which :func:`hydrocrane.simulate` repeats to the last bit.

        If somebody took over from spool commands, the bits are the same with steps of one size (``Solver(step=...)``),
        and within the tolerance otherwise. Its duration ends at the last sample. ``live.scenario().save("drive.toml")``
        writes it to a file.

        Examples
        --------
        >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
        >>> live = hc.LiveSimulator(hc.Scenario(joints=start, controller="tip"))
        >>> live.set_stick(z=0.2)
        >>> obs = live.step(0.5)
        >>> again = live.scenario()
        >>> print(again.controller, again.joystick.axes["z"][-1])
        tip 0.2
        """
        record = self._core.record()
        if record["end"] <= 0:
            raise InputError("nothing has been driven yet: step first")
        first, *later = record["stages"]
        driven: RunChanges = {
            "duration": record["end"],
            "joystick": _moved(first) if self._plan.closed_loop else None,
            "goals": [Goal(time, *place, speed, until) for time, place, speed, until in record["goals"]],
            "payload": record["payload"],
            "payload_changes": {load.time: load.after for load in self.payload_changes if load.time < record["end"]},
            "phases": [self._phase(number, stage) for number, stage in enumerate(later)],
        }
        return self._plan.changed(**driven).changed(**changes)

    def _phase(self, number: int, stage: DrivenStage) -> Phase:
        """A stage after the first as it was driven: a phase of the scenario, or the levers after spool commands."""
        planned = self._plan.phases[number : number + 1]
        if planned and planned[0].time == stage["from"]:
            return dataclasses.replace(planned[0], joystick=_moved(stage))
        return Phase(stage["from"], controller="lever", joystick=_moved(stage))

    def _end(self) -> str:
        assert self._outcome is not None
        return f"the simulation ended with `{self._outcome.kind}` at {self.time:.4g} s: {self._outcome.message}"


def _moved(stage: DrivenStage) -> Joystick | None:
    """The joystick of a stage as it was moved."""
    if stage["stated"] is None and not stage["time"].size:
        return None
    dead_zone, full_speed, ramp = stage["stated"] or (0.0, None, 0.0)
    axes = dict(zip(stage["names"], stage["axes"].T, strict=True))
    linear = "linear" if stage["linear"] else "hold"
    return Joystick(stage["time"], axes, stage["mode"], linear, dead_zone, full_speed, ramp, stage["precision"])
