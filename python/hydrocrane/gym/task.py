"""The task: bring the tip to a target and keep it there."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import gymnasium
import numpy as np
from numpy.typing import NDArray

from hydrocrane.arrays import Array, positive_number, real_array, vectors
from hydrocrane.errors import InputError, check_known
from hydrocrane.machine.machine import Machine, MachineLike, as_machine
from hydrocrane.result_warning import DoubtfulResult
from hydrocrane.simulation.batch import BatchObservation, BatchSimulator
from hydrocrane.simulation.crane_parameters import CraneValues, crane_values

Numbers = NDArray[np.float32]

# Share of every joint's range, at either end, without starts and targets.
MARGIN = 0.15
# Bounds to which an observation is clipped: share of a range, rad/s or m/s, share of the supply pressure, m.
SHARE, RATE, PRESSURE, TRAVEL = 2.0, 20.0, 20.0, 100.0
# Distance from the nearest place within reach at which a target is out of reach, m.
WITHIN_REACH = 1e-3
# Pairs that are drawn until the tip is permitted at both: if one pair in a hundred is, all miss once in 20,000 times.
DRAWS = 1000
# What the options of a reset may state.
OPTIONS = ("q", "target", "parameters")
# Draws values of machine keys, (n,) each, with the random numbers of n cranes.
Draw: TypeAlias = Callable[[Sequence[np.random.Generator]], CraneValues]
# Reward if the crane is lost, m s: that of a minute at 1 m distance.
LOSS = -60.0


@dataclass(frozen=True)
class TipTask:
    """Definition of an episode, for one crane and for many.

    An action is one number per cylinder in -1 to 1, the spool command as a share of the spool's stroke. An observation
    is, per joint, the coordinate as a share of its range (-1 to 1) and the rate (rad/s or m/s), the chamber pressures
    as shares of the supply pressure, and the vector from the tip to the target (x, z in m). The reward of a sample is
    minus the distance of the tip from the target times the sample time, m s, and -60 m s if the crane is lost, which
    ends the episode; otherwise it ends after `duration`. Starts (at rest) and targets belong to random poses with the
    tip and its load outside of keep-out regions and of the ground.

    Cranes may differ from `machine` in values of its keys. Start, target and motion then are those of each crane's own
    machine; the strokes, ranges and the pressure of which actions and observations are shares stay those of `machine`,
    because who controls a crane does not know what it differs in.

    Parameters
    ----------
    machine : Machine
    sample_time : float
        s between actions.
    duration : float
        s after which an episode is cut off.
    payload : float, optional
        kg at the tip.
    """

    machine: Machine
    sample_time: float = 0.05
    duration: float = 10.0
    payload: float | None = None

    def __post_init__(self) -> None:
        positive_number("sample_time", self.sample_time, "seconds")
        if self.sample_time > positive_number("duration", self.duration, "seconds"):
            raise InputError(
                f"an episode must last one sample or more; got duration={self.duration:g} s, "
                f"sample_time={self.sample_time:g} s"
            )

    @classmethod
    def of(cls, machine: MachineLike, **settings: float | None) -> TipTask:
        """The task for a machine or the name of one."""
        return cls(as_machine(machine), **settings)  # type: ignore[arg-type]

    @property
    def samples(self) -> int:
        """Number of actions of an episode."""
        return max(1, round(self.duration / self.sample_time))

    @property
    def action_space(self) -> gymnasium.spaces.Box:
        return gymnasium.spaces.Box(-1.0, 1.0, (len(self.machine.cylinder_names),), np.float32)

    @property
    def observation_space(self) -> gymnasium.spaces.Box:
        joints, cylinders = len(self.machine.joint_names), len(self.machine.cylinder_names)
        bounds = np.repeat(
            [SHARE, RATE, PRESSURE, TRAVEL], [joints, joints, 2 * cylinders, len(self.machine.tip_axes)]
        ).astype(np.float32)
        return gymnasium.spaces.Box(-bounds, bounds, dtype=np.float32)

    def simulator(self, n: int, threads: int | None = None) -> BatchSimulator:
        """A simulator of the cranes."""
        return BatchSimulator(self.machine, n, self.sample_time, payload=self.payload, threads=threads)

    def begin(
        self,
        cranes: BatchSimulator,
        numbers: NDArray[np.int64],
        randoms: Sequence[np.random.Generator],
        options: Mapping[str, object] | None = None,
        draw: Draw | None = None,
    ) -> tuple[Array, dict[str, Array]]:
        """Starts episodes of these of the `cranes`, each with random numbers of its own: targets (m, 2), m, or
        (m, 3) in space, and the values of machine keys, (m,) each, that differ. What `options` state replaces what is
        drawn."""
        given = dict(options or {})
        for name in given:
            check_known("option", name, OPTIONS)
        own = crane_values(given.pop("parameters", {}))
        parameters = {**(draw(randoms) if draw else {}), **own}
        requested = {name: self._requested(name, value, len(numbers)) for name, value in given.items()}
        generator = iter(randoms)
        targets: list[Array] = []

        def poses(numbers: NDArray[np.int64], machines: Sequence[Machine]) -> Array:
            done = len(targets)
            start, target = starts_and_targets(machines, [next(generator) for _ in numbers], self.payload)
            rows = slice(done, done + len(numbers))
            if "target" in requested:
                target = requested["target"][rows]
                _check_reach(machines, target, self.payload)
            targets.extend(target)
            return requested["q"][rows] if "q" in requested else start

        cranes.reset(q=poses, cranes=numbers, parameters=parameters)
        for doubt in cranes.warnings if own else ():
            if doubt.kind == "implausible-value":
                warnings.warn(str(doubt), DoubtfulResult, stacklevel=4)
        return np.array(targets), {name: own[numbers] for name, own in cranes.parameters.items()}

    def _requested(self, name: str, value: object, count: int) -> Array:
        width = {"q": len(self.machine.joint_names), "target": len(self.machine.tip_axes)}[name]
        requested = real_array(value, name)  # type: ignore[arg-type]
        if requested.shape not in ((width,), (count, width)):
            raise InputError(
                f"the option `{name}` must have shape {(width,)}, or {(count, width)}; got {requested.shape}"
            )
        return np.broadcast_to(requested, (count, width))

    def commands(self, action: NDArray[np.floating]) -> Array:
        """Spool commands, m, of actions (..., n_cyl)."""
        shares = vectors(action, "action", self.machine.cylinder_names)
        return np.clip(shares, -1.0, 1.0) * self.machine.spool_strokes

    def observation(self, seen: BatchObservation, target: Array) -> Numbers:
        """(n, width) observations of n cranes and their targets."""
        lower, upper = self.machine.joint_limits.T
        share = (2.0 * seen.q - lower - upper) / (upper - lower)
        pressures = seen.p.reshape(len(seen.q), -1) / self.machine.supply_pressure
        space = self.observation_space
        together = np.concatenate([share, seen.qd, pressures, target - seen.tip], axis=1)
        return np.clip(together, space.low, space.high).astype(np.float32)

    def reward(self, seen: BatchObservation, target: Array, lost: NDArray[np.bool_]) -> Array:
        """(n,) rewards, m s."""
        distance = np.linalg.norm(seen.tip - target, axis=1)
        return np.where(lost, LOSS, -distance * self.sample_time)


def starts_and_targets(
    machines: Sequence[Machine], randoms: Sequence[np.random.Generator], payload: float | None = None
) -> tuple[Array, Array]:
    """Poses (n, n_joints) to start from and targets (n, 2 or 3), m, of n cranes with random numbers of their own.

    Pairs of which the tip or its load is in a keep-out region or in the ground are drawn again.
    """
    lower, upper = np.moveaxis(np.array([machine.joint_limits for machine in machines]), 2, 0)
    start, target = np.empty_like(lower), np.empty((len(machines), len(machines[0].tip_axes)))
    left = np.arange(len(machines))
    for _ in range(DRAWS):
        share = np.array([randoms[i].uniform(MARGIN, 1.0 - MARGIN, (2, lower.shape[1])) for i in left.tolist()])
        pairs = lower[left, np.newaxis] + (upper - lower)[left, np.newaxis] * share
        start[left] = pairs[:, 0]
        of_machine: dict[int, list[int]] = {}
        for k, i in enumerate(left.tolist()):
            of_machine.setdefault(id(machines[i]), []).append(k)
        again = np.zeros(len(left), dtype=bool)
        for own in of_machine.values():
            machine = machines[int(left[own[0]])]
            tips = machine.tip(pairs[own])
            target[left[own]] = tips[:, 1]
            again[own] = machine.forbidden(tips, machine.payload(payload)).any(axis=1)
        left = left[again]
        if not left.size:
            return start, target
    raise InputError(
        f"{machines[int(left[0])].name}: of {DRAWS} pairs of a start and a target, all had the tip or its load in a "
        "keep-out region or in the ground; lower the ground or the regions, or widen the limits of the joints"
    )


def _check_reach(machines: Sequence[Machine], targets: Array, payload: float | None) -> None:
    """Refuse the first of the targets to which the tip of the machine in its row cannot, or must not, go."""
    unlike = {(id(machine), *target): machine for machine, target in zip(machines, targets, strict=True)}
    for (_, *place), machine in unlike.items():
        near = machine.core.nearest_tip(np.array(place))
        far = math.dist(place, near) > WITHIN_REACH
        if not far and not machine.forbidden(place, machine.payload(payload)):
            continue
        wanted, found = (", ".join(f"{x:.7g}" for x in of) for of in (place, near))
        fault = (
            f"out of reach of {machine.name}; the nearest place within reach is ({found}) m"
            if far
            else f"in a keep-out region of {machine.name}, or the tip or its load is in the ground there"
        )
        raise InputError(
            f"the option `target`: ({', '.join(machine.tip_axes)}) = ({wanted}) m is {fault}; give another one, or "
            "leave the option out to have a target drawn"
        )
