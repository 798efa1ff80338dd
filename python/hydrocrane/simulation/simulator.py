"""The stepping interface for your own controllers."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane import _core
from hydrocrane.arrays import Array, positive_number, seed_number, vectors
from hydrocrane.control.controllers import Observation
from hydrocrane.errors import InputError, SimulationError, check_known, translated
from hydrocrane.machine.machine import Machine, MachineLike, as_machine
from hydrocrane.machine.poses import states
from hydrocrane.machine.sensors import SENSORS, SensorFault
from hydrocrane.result_warning import ResultWarning
from hydrocrane.results.outcome import Outcome
from hydrocrane.scenario.payload import PayloadChange
from hydrocrane.scenario.solver import AUTO, Solver, unusual


class Simulator:
    """A crane that advances by one sample per :meth:`Simulator.step`, its spool commands held in between.

    Parameters
    ----------
    machine : Machine, str or path
    sample_time : float
        s.
    payload : float, optional
        kg at the tip at every reset; default is the machine's own. :meth:`set_payload` changes it during the run.
    method, rtol, step
        As in :class:`~hydrocrane.Solver`: ``step=1e-3`` for a bounded cost per sample.
    sensors : {"ideal", "data-sheet"}
        Content of ``obs.measured``: true values, or readings of the machine's sensors.
    seed : int
        Seed of the sensors' errors and noise.
    sensor_faults : sequence of SensorFault

    Notes
    -----
    Several threads may use one simulator: while one steps, the others wait for the end of its step.

    Examples
    --------
    >>> plant = hc.Simulator("rottne-f9-lab", sample_time=0.01)
    >>> obs = plant.reset(q=np.deg2rad([100.0, 100.0, 0.0]))
    >>> start = obs.tip
    >>> for _ in range(100):
    ...     obs = plant.step([20e-3, 0.0, 0.0])
    >>> print(f"{obs.t:.2f} s, up by {obs.tip[1] - start[1]:.2f} m")
    1.00 s, up by 0.07 m
    """

    def __init__(
        self,
        machine: MachineLike,
        sample_time: float = 0.01,
        *,
        payload: float | None = None,
        method: str = AUTO,
        rtol: float = Solver.rtol,
        step: float | None = None,
        sensors: str = "ideal",
        seed: int = 0,
        sensor_faults: Sequence[SensorFault] = (),
    ) -> None:
        machine = as_machine(machine)
        solver = Solver(method=method, rtol=rtol, step=step)
        self.machine = machine
        self._start_payload = machine.payload(payload)
        self.sample_time = positive_number("sample_time", sample_time, "seconds")
        # Outcome of the last sample; None before the first reset.
        self._ended: str | None = None
        self._warnings: tuple[ResultWarning, ...] = ()
        self._unusual = tuple(unusual(solver.quantities).values())
        check_known("kind of sensors", sensors, SENSORS)
        faults = [fault.entry for fault in sensor_faults]
        seed = seed_number(seed)
        with translated():
            self._core = _core.Simulator(
                machine.core,
                self.sample_time,
                self._start_payload,
                solver.method,
                solver.rtol,
                solver.step,
                sensors,
                seed,
                faults,
            )
        self._sample = Sample(machine, self._core.signals)

    @property
    def state(self) -> Array:
        """(n_states,) in the order of ``machine.state_names``."""
        return np.array(self._core.state, dtype=np.float64)

    @property
    def method(self) -> str:
        """The method of integration: the requested one, or the one that ``auto`` selected."""
        return self._core.method

    @property
    def time(self) -> float:
        """s."""
        return float(self._core.time)

    @property
    def outcome(self) -> Outcome | None:
        """How the last sample ended: ``completed``, or why there is no next one; ``None`` before the first reset."""
        if self._ended is None:
            return None
        return Outcome(self._ended, self.time, "" if self._ended == "completed" else self._end())

    @property
    def payload(self) -> float:
        """At the tip, kg."""
        return float(self._core.payload)

    @property
    def warnings(self) -> tuple[ResultWarning, ...]:
        """Warnings since the last reset, see docs/reference/warnings.md."""
        self._warnings += tuple(ResultWarning(*entry) for entry in self._core.warnings())
        return self._warnings

    def set_payload(self, mass: float) -> PayloadChange:
        """Set the load at the tip to `mass`, kg: picks up a load at rest, or releases one.

        A load that is picked up changes the joint rates at once: ``state`` has the new values, sensors read them at the
        next step. A reset restores the payload of the start.

        Raises
        ------
        SimulationError
            Before the first reset, and after a step that failed.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> sim = hc.Simulator(crane, sample_time=0.01)
        >>> start = sim.reset(q=np.deg2rad([100.0, 100.0, 0.0]))
        >>> sim.set_payload(50.0)
        PayloadChange(time=0.0, before=0.0, after=50.0, velocity_before=(0.0, 0.0), velocity_after=(0.0, 0.0), loss=0.0)
        >>> bool(sim.step(np.zeros(3)).tip[1] < start.tip[1])
        True
        """
        self._require_running()
        return PayloadChange.of(self._core.set_payload(self.machine.payload(mass)))

    def reset(self, q: ArrayLike | None = None, state: ArrayLike | None = None) -> Observation:
        """Return to time zero, at rest in pose q (n,) with holding pressures, or at a full state (n_states,).

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> sim = hc.Simulator(crane, sample_time=0.01)
        >>> sim.reset(q=np.deg2rad([100.0, 100.0, 0.0])).t
        0.0
        """
        if (q is None) == (state is None):
            raise InputError("reset takes either q, a pose to rest in, or state, a full state")
        if q is not None:
            start, doubts = self.machine.rest(q, payload=self._start_payload)
        else:
            start, doubts = states(self.machine, cast(ArrayLike, state)), ()
        if start.ndim != 1:
            raise InputError(f"reset takes one pose or one state, got a batch of shape {start.shape[:-1]}")
        with translated():
            self._core.reset(np.ascontiguousarray(start))
        self._ended, self._warnings = "completed", (*self._unusual, *doubts)
        return self._sample.seen(self._core.observation)

    def step(self, spool_command: ArrayLike) -> Observation:
        """Advance by one sample with the spool commands (n_cyl,), m, held.

        Raises
        ------
        SimulationError
            Before the first reset, and if the sample fails; ``state`` keeps the last good one.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> sim = hc.Simulator(crane, sample_time=0.01)
        >>> start = sim.reset(q=np.deg2rad([100.0, 100.0, 0.0]))
        >>> sim.step([0.005, 0.0, 0.0]).t
        0.01
        """
        self._require_running()
        seen = None
        # Called in every sample: a valid command goes directly to the core.
        with suppress(TypeError, ValueError):
            self._ended, seen = self._core.step(np.asarray(spool_command))
        if seen is None:
            with translated():
                self._ended, seen = self._core.step(self._checked(spool_command))
        if self._ended != "completed":
            raise SimulationError(self._end())
        return self._sample.seen(seen)

    def _end(self) -> str:
        """Message of a step that failed."""
        return f"the simulation ended with `{self._ended}` at {self.time:.4g} s: {self._core.reason}"

    def _checked(self, spool_command: ArrayLike) -> Array:
        """One finite command per cylinder, in the form of the core."""
        command = vectors(spool_command, "spool_command", self.machine.cylinder_names)
        if command.ndim != 1:
            raise InputError(f"step takes one command of shape ({len(self.machine.cylinder_names)},)")
        return np.ascontiguousarray(command)

    def _require_running(self) -> None:
        if self._ended is None:
            raise SimulationError("call reset(q=...) or reset(state=...) before the first step")
        if self._ended != "completed":
            raise SimulationError(f"{self._end()}; call reset first")


class Sample:
    """The core's row of a sample, part by part."""

    def __init__(self, machine: Machine, signals: list[str]) -> None:
        # Ends of q, qd, p and the tip, after the time.
        self._ends = (
            1 + np.cumsum([len(machine.joint_names)] * 2 + [2 * len(machine.cylinder_names), len(machine.tip_axes)])
        ).tolist()
        self._signals = signals

    def seen(self, seen: Array) -> Observation:
        q, qd, p, tip = self._ends
        return Observation(
            t=seen.item(0),
            q=seen[1:q],
            qd=seen[q:qd],
            p=seen[qd:p].reshape(-1, 2),
            tip=seen[p:tip],
            measured=dict(zip(self._signals, seen[tip:].tolist(), strict=True)),
        )
