"""Many cranes stepped together, of one machine or each with values of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrocrane import _core
from hydrocrane.arrays import Array, brief, positive_number, real_array, scenario_quantity, vectors, whole_number
from hydrocrane.errors import HydrocraneError, InputError, SimulationError, translated
from hydrocrane.machine.machine import Machine, MachineLike, as_machine
from hydrocrane.machine.poses import states
from hydrocrane.result_warning import ResultWarning
from hydrocrane.scenario.record_size import check_size, row_numbers
from hydrocrane.simulation.crane_parameters import CraneParameters, CraneValues

# Default tolerance of the errors of a step; see docs/theory/batch.md for the resulting accuracy.
TOLERANCE = 0.01
# Twice the largest error of the tip there, 1.5 mm, is what a run by default promises; errors grow in proportion.
# Beyond LOOSEST a step may be wrong by the scale of a state.
LOOSE, LOOSEST = 0.02, 1.0
# Cranes whose machines exist at the same time while they are reset, so that memory is bounded: a machine has 0.2 MB.
BLOCK = 256
# Gives the poses (m, n_joints) that m cranes start from, by their numbers and their machines.
Poses: TypeAlias = Callable[[NDArray[np.int64], Sequence[Machine]], Array]


@dataclass(frozen=True)
class BatchObservation:
    """Observation of a batch of n cranes at a sample: that of :class:`hydrocrane.Observation` with a leading axis.

    Attributes
    ----------
    t : (n,) array
        s since each crane's reset.
    q, qd : (n, n_joints) arrays
        Joint coordinates and rates, rad or m, and per second.
    p : (n, n_cyl, 2) array
        Chamber pressures p1, p2, Pa gauge.
    tip : (n, 2) array
        x, z in the inertial frame, m.

    Examples
    --------
    >>> cranes = hc.BatchSimulator("rottne-f9-lab", 3)
    >>> obs = cranes.reset(q=hc.load_machine("rottne-f9-lab").home)
    >>> obs.q.shape, obs.p.shape, obs.tip.shape
    ((3, 3), (3, 3, 2), (3, 2))
    """

    t: Array
    q: Array
    qd: Array
    p: Array
    tip: Array

    __repr__ = brief


class BatchSimulator:
    """n cranes that advance together, sample by sample, each with its own spool commands.

    Each crane has its own step sizes (GRK4T, order four), chosen for `tolerance`. Its result depends only
    on its own machine, start, commands and payload, bit for bit: not on its place, on n, on the number of threads or
    on the processor's vector instructions. A crane that leaves its admissible states stays at its last good one until
    it is reset; the others are not affected.

    Parameters
    ----------
    machine : Machine, str or path
    n : int
        Number of cranes.
    sample_time : float
        s.
    step : float, optional
        Longest step, s; default is the sample time, which no step exceeds.
    tolerance : float
        Errors of a step, root mean square over the states, in units of their scales: 10 bar, 0.1 rad,
        0.1 rad/s, 1 mm of bristle.
        How exact the default is: ``docs/validation/step-accuracy.md``.
    payload : float or (n,) array, optional
        kg at the tips at every reset; default is each machine's own.
    parameters : mapping of str to float, str or sequence, optional
        Machine keys in which the cranes differ: by key one value for all or one for each crane, SI numbers or texts
        with units. Any key that is a number; ``friction.lift.coulomb[0]`` is one value of a list. All cranes have the
        same joints, parts, laws and tables. Start, limits, payload and
        motion of a crane are those of its own machine (:meth:`machines`).
    threads : int, optional
        Default is the number of cores.
    instruction_set : {"sse2", "avx2", "avx512"}, optional
        A narrower set of vector instructions than the processor's widest, for measurements.

    Examples
    --------
    >>> crane = hc.load_machine("rottne-f9-lab")
    >>> cranes = hc.BatchSimulator(crane, 100, payload=np.linspace(0.0, 200.0, 100))
    >>> obs = cranes.reset(q=crane.home)
    >>> for _ in range(50):
    ...     obs = cranes.step([2e-3, 0.0, 0.0])
    >>> print(obs.tip.shape, cranes.alive.sum())
    (100, 2) 100
    >>> some = hc.BatchSimulator(crane, 3, parameters={"cylinder.lift.bore": ["98 mm", "100 mm", "102 mm"]})
    >>> print(some.parameters)
    {'cylinder.lift.bore': array([0.098, 0.1  , 0.102])}
    """

    def __init__(
        self,
        machine: MachineLike,
        n: int,
        sample_time: float = 0.01,
        *,
        step: float | None = None,
        tolerance: float = TOLERANCE,
        payload: ArrayLike | None = None,
        parameters: CraneValues | None = None,
        threads: int | None = None,
        instruction_set: str | None = None,
    ) -> None:
        machine = as_machine(machine)
        self.machine = machine
        self.n = whole_number("n, the number of cranes,", n)
        each = row_numbers(machine)
        check_size(
            "this batch", self.n * each, f"{self.n} cranes of {each} numbers", "fewer cranes, in several batches"
        )
        self.sample_time = positive_number("sample_time", sample_time, "seconds")
        self.step_size = self.sample_time if step is None else positive_number("step", step, "seconds")
        self.tolerance = positive_number("tolerance", tolerance, "units of the states' scales")
        if self.tolerance > LOOSEST:
            raise InputError(
                f"tolerance must be at most {LOOSEST:g}, beyond which a step may be wrong by the scale of a state; got "
                f"{tolerance!r}; {TOLERANCE:g} is usual"
            )
        self._start_payload = None if payload is None else _masses(payload, "payload", self.n)
        self._parameters = CraneParameters(machine, self.n).changed(parameters or {}, self._chosen(None))
        workers = 0 if threads is None else whole_number("threads", threads)
        self._started = np.zeros(self.n, dtype=bool)
        self._doubts: list[tuple[ResultWarning, ...]] = [()] * self.n
        with translated():
            self._core = _core.BatchSimulator(
                machine.core, self.n, self.sample_time, self.step_size, self.tolerance, workers, instruction_set
            )

    @property
    def state(self) -> Array:
        """(n, n_states) in the order of ``machine.state_names``."""
        return self._core.state

    @property
    def payload(self) -> Array:
        """(n,) at the tips, kg."""
        return self._core.payload

    @property
    def parameters(self) -> dict[str, Array]:
        """Per key in which cranes may differ the values (n,), SI; nan where the batch's machine states none."""
        found = {}
        for name, own in self._parameters.values.items():
            key, _, place = name.removesuffix("]").partition("[")
            stated = np.atleast_1d(self.machine.value(key).si)[int(place or 0)] if key in self.machine.keys else np.nan
            found[name] = np.where(np.isnan(own), stated, own)
        return found

    @property
    def time(self) -> Array:
        """(n,) s since each crane's reset; a lost crane's is when it was lost."""
        return self._core.time

    @property
    def alive(self) -> NDArray[np.bool_]:
        """(n,) whether each crane still moves."""
        return self._core.alive

    @property
    def inexact(self) -> NDArray[np.bool_]:
        """(n,) whether even the shortest step of a crane missed `tolerance` since its reset."""
        return self._core.inexact

    @property
    def warnings(self) -> tuple[ResultWarning, ...]:
        """What makes cranes doubtful: a loose `tolerance`, ``step-too-long`` where some are :attr:`inexact`,
        ``command-beyond-stroke`` where a command is likely in mm, and their starts at rest.
        """
        found = []
        if self.tolerance > LOOSE:
            text = f"tolerance {self.tolerance:g} is above {LOOSE:g}: tips may be off by more than 3 mm"
            found.append(ResultWarning("tolerance-too-loose", text, f"tighten `tolerance`: {TOLERANCE:g} is usual"))
        count = int(self.inexact.sum())
        if count:
            text = f"the error of the shortest steps exceeds the tolerance in {count} of {self.n} cranes: see `inexact`"
            cure = "shorten `step`, or check single cranes with hc.Simulator"
            found.append(ResultWarning("step-too-long", text, cure))
        if self._core.astray is not None:
            crane, kind, text, cure = self._core.astray
            found.append(ResultWarning(kind, f"crane {crane}: {text}", cure))
        for kind in dict.fromkeys(doubt.kind for doubts in self._doubts for doubt in doubts):
            own = {i: doubt for i, doubts in enumerate(self._doubts) for doubt in doubts if doubt.kind == kind}
            first, doubt = next(iter(own.items()))
            found.append(replace(doubt, text=f"{len(own)} of {self.n} cranes, the first being {first}: {doubt.text}"))
        return tuple(found)

    @property
    def outcomes(self) -> list[str]:
        """Per crane ``completed``, or why it was lost: ``stroke-limit``, ``solver-failed``; ``bad-state`` at first."""
        return self._core.outcomes

    @property
    def threads(self) -> int:
        """Threads that share the cranes."""
        return self._core.threads

    @property
    def instruction_set(self) -> str:
        """Vector instructions that the cranes run in."""
        return self._core.instruction_set

    def machines(self, cranes: ArrayLike | None = None) -> list[Machine]:
        """The machines of `cranes`, as in :meth:`reset`, built anew from their values; each has 0.2 MB.

        Examples
        --------
        >>> cranes = hc.BatchSimulator("rottne-f9-lab", 2, parameters={"payload.mass": [0.0, 50.0]})
        >>> print([machine.payload() for machine in cranes.machines()])
        [0.0, 50.0]
        """
        return self._machines(self._chosen(cranes), self._parameters)

    def reset(
        self,
        q: ArrayLike | Poses | None = None,
        state: ArrayLike | None = None,
        *,
        cranes: ArrayLike | None = None,
        parameters: CraneValues | None = None,
    ) -> BatchObservation:
        """Return to time zero with the payload of the start, at rest in poses q or at full states.

        Parameters
        ----------
        q : (n_joints,) or (m, n_joints) array, or function
            Poses to rest in with holding pressures; one pose serves all. A function gives them, (k, n_joints), for
            the numbers (k,) and the list of the machines of some of these cranes; it is called until all have one.
        state : (n_states,) or (m, n_states) array
            In place of q.
        cranes : (m,) array of int or (n,) array of bool, optional
            Which cranes; default is all n.
        parameters : mapping of str to float, str or sequence, optional
            Machine keys with one value for all these cranes or m values, as for the batch; in force until changed.

        Raises
        ------
        InputError, MachineFileError, OutOfReachError
            With the number of the crane. Cranes before it may be reset already, with their new parameters.

        Examples
        --------
        >>> cranes = hc.BatchSimulator("rottne-f9-lab", 3)
        >>> obs = cranes.reset(q=cranes.machine.home)
        >>> obs = cranes.reset(q=np.deg2rad([100.0, 100.0, 0.0]), cranes=[1], parameters={"supply.pressure": "130 bar"})
        >>> print(np.rad2deg(obs.q[:, 0]).round(2))
        [ 82.11 100.    82.11]
        """
        if (q is None) == (state is None):
            raise InputError("reset takes either q, poses to rest in, or state, full states")
        chosen = self._chosen(cranes)
        table = self._parameters.changed(parameters or {}, chosen)
        given: Array | None = None
        if state is not None:
            given = _table(states(self.machine, state), len(chosen), "state")
        elif not callable(q):
            given = _table(vectors(cast(ArrayLike, q), "q", self.machine.joint_names), len(chosen), "q")
        for first in range(0, len(chosen), BLOCK):
            part = chosen[first : first + BLOCK]
            machines = self._machines(part, table)
            own = cast(Poses, q)(part, machines) if given is None else given[first : first + BLOCK]
            self._begin(part, machines, own, at_rest=state is None)
            self._parameters = self._parameters.taken(table, part)
        return self.observe()

    def _machines(self, cranes: NDArray[np.int64], parameters: CraneParameters) -> list[Machine]:
        if not parameters.values:
            return [self.machine] * len(cranes)
        changes = [parameters.changes(int(crane)) for crane in cranes]
        with translated():
            return [self.machine.made(core) for core in self._core.machines(self.machine.core, cranes, changes)]

    def _begin(self, cranes: NDArray[np.int64], machines: list[Machine], starts: Array, *, at_rest: bool) -> None:
        """Resets cranes, which are these machines now, to poses of rest or to states."""
        if self._start_payload is None:
            payloads = np.array([machine.payload() for machine in machines])
        else:
            payloads = self._start_payload[cranes]
        doubts: list[tuple[ResultWarning, ...]] = [()] * len(cranes)
        if at_rest:
            starts, doubts = _at_rest(cranes, machines, _table(starts, len(cranes), "q"), payloads)
        # If one of them cannot start, none of them has a state that its parameters belong to.
        self._started[cranes] = False
        with translated():
            self._core.reset(cranes, [machine.core for machine in machines], np.ascontiguousarray(starts), payloads)
        for crane, machine, own in zip(cranes, machines, doubts, strict=True):
            unusual = () if machine is self.machine else machine.warnings
            self._doubts[crane] = (*(doubt for doubt in unusual if doubt not in self.machine.warnings), *own)
        self._started[cranes] = True

    def step(self, spool_commands: ArrayLike) -> BatchObservation:
        """Advance every crane by one sample with its spool commands, (n, n_cyl) or one row for all, m, held.

        Raises
        ------
        SimulationError
            Before every crane was reset.

        Examples
        --------
        >>> cranes = hc.BatchSimulator("rottne-f9-lab", 3)
        >>> obs = cranes.reset(q=cranes.machine.home)
        >>> obs = cranes.step([[2e-3, 0, 0], [0, 0, 0], [-2e-3, 0, 0]])
        >>> print(obs.t, obs.qd[0, 0] > obs.qd[2, 0])
        [0.01 0.01 0.01] True
        """
        if not self._started.all():
            missing = int(np.argmin(self._started))
            raise SimulationError(
                f"call reset(q=...) or reset(state=...) before the first step; crane {missing} has no state"
            )
        commands = vectors(spool_commands, "spool_commands", self.machine.cylinder_names)
        with translated():
            self._core.step(_table(commands, self.n, "spool_commands"))
        return self.observe()

    def set_payload(self, mass: ArrayLike, *, cranes: ArrayLike | None = None) -> None:
        """Set the load at the tips to `mass`, kg, one for each of `cranes` or one for all.

        Picking up a load, which is at rest, changes the joint rates at once; releasing one leaves the state unchanged.

        Examples
        --------
        >>> cranes = hc.BatchSimulator("rottne-f9-lab", 3)
        >>> obs = cranes.reset(q=cranes.machine.home)
        >>> cranes.set_payload([0.0, 50.0, 100.0])
        >>> print(cranes.payload)
        [  0.  50. 100.]
        """
        chosen = self._chosen(cranes)
        if not self._started[chosen].all():
            raise SimulationError("call reset before set_payload")
        self._core.set_payload(chosen, _masses(mass, "mass", len(chosen)))

    def observe(self) -> BatchObservation:
        """Observation of the cranes in their present state.

        Examples
        --------
        >>> cranes = hc.BatchSimulator("rottne-f9-lab", 3)
        >>> obs = cranes.reset(q=cranes.machine.home)
        >>> print(np.array_equal(cranes.observe().tip, obs.tip))
        True
        """
        rows, joints = self._core.observe(), len(self.machine.joint_names)
        pressures = rows[:, 2 * joints : 4 * joints].reshape(self.n, joints, 2)
        return BatchObservation(
            self.time, rows[:, :joints], rows[:, joints : 2 * joints], pressures, rows[:, -len(self.machine.tip_axes) :]
        )

    def _chosen(self, cranes: ArrayLike | None) -> NDArray[np.int64]:
        if cranes is None:
            return np.arange(self.n, dtype=np.int64)
        chosen = np.asarray(cranes)
        if chosen.dtype == bool and chosen.shape == (self.n,):
            return np.flatnonzero(chosen).astype(np.int64)
        if chosen.dtype.kind not in "iu" or chosen.ndim > 1:
            raise InputError(f"cranes must be numbers of cranes or {self.n} truth values, got {cranes!r}")
        chosen = np.atleast_1d(chosen).astype(np.int64)
        if ((chosen < 0) | (chosen >= self.n)).any():
            raise InputError(f"cranes must lie between 0 and {self.n - 1}, got {cranes!r}")
        return chosen


def _at_rest(
    cranes: NDArray[np.int64], machines: Sequence[Machine], q: Array, payloads: Array
) -> tuple[Array, list[tuple[ResultWarning, ...]]]:
    """States at rest with their warnings, each machine, pose and payload solved once."""
    kinds = {id(machine): k for k, machine in enumerate(machines)}
    tasks = np.column_stack([[kinds[id(machine)] for machine in machines], q, payloads])
    _, first, where = np.unique(tasks, axis=0, return_index=True, return_inverse=True)
    rests = []
    for k in first:
        try:
            rests.append(machines[k].rest(q[k], payload=float(payloads[k])))
        except HydrocraneError as error:
            raise type(error)(f"crane {cranes[k]}: {error}") from None
    where = where.reshape(-1)
    return np.array([state for state, _ in rests])[where], [rests[k][1] for k in where]


def _masses(mass: ArrayLike, name: str, count: int) -> Array:
    """`mass` as `count` masses, kg; one serves all."""
    masses = real_array(mass, name)
    if masses.ndim > 1 or masses.size not in (1, count):
        raise InputError(f"{name} must be one mass in kg, zero or more, or {count} of them; got {mass!r}")
    for end in (masses.min(), masses.max()):
        scenario_quantity("scenario.payload", name, end)
    return np.array(np.broadcast_to(masses, count))


def _table(array: Array, rows: int, name: str) -> Array:
    """`array` as a contiguous table of `rows` rows; one row serves all."""
    if array.ndim > 2 or (array.ndim == 2 and len(array) not in (1, rows)):
        raise InputError(f"{name} must have one row or {rows}, one per crane; got shape {array.shape}")
    return np.ascontiguousarray(np.broadcast_to(array, (rows, array.shape[-1])))
