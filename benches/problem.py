"""The task that every solver gets, the clock they all have, and what they hand back."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

import hydrocrane as hc
from hydrocrane import _core
from hydrocrane.scenario.scenario import scenario_entry

SCENARIO = "vertical-lift-open-loop"
REFERENCE = 1e-12
MAX_STEP = 0.05
# Size of a state per kind: the absolute tolerance of every solver is its relative one times this, as hydrocrane's own.
SIZES = {"q": 0.1, "qd": 0.1, "p1": 1e6, "p2": 1e6, "vs": 50.0, "z": 1e-3, "p": 1e6, "load": 1e6, "displacement": 0.1}
SAME_INSTANT = 1e-9


class NotAvailable(Exception):
    """A competitor cannot run here; the text says what is missing."""


@dataclass(frozen=True)
class Solution:
    """States at the record times (rows, states), CPU seconds, and counts of steps, right-hand sides and Jacobians."""

    states: np.ndarray
    seconds: float
    counts: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Segment:
    """A stretch of time with constant commands, and the record times in it, its begin left out."""

    begin: float
    end: float
    spools: np.ndarray
    record: np.ndarray


# Solves the task at a relative tolerance.
Solver = Callable[[float], Solution]


class Problem:
    """A scenario with its tables, so that every solver does the same work and nothing else."""

    def __init__(self, scenario: str | hc.Scenario = SCENARIO) -> None:
        self.plan = hc.load_scenario(scenario) if isinstance(scenario, str) else scenario
        self.crane = self.plan.load_machine()
        self.start = self.plan.initial_state(self.crane)
        self.record, self.end = self.plan.record_times(), float(self.plan.duration)
        times, spools, self.linear = self.plan.command_grid(self.crane)
        self.times, self.spools = times[times < self.end], spools[times < self.end]
        self.payload = self.crane.payload(self.plan.payload)
        strokes = dict(zip(self.crane.cylinder_names, self.crane.spool_strokes, strict=True))
        kinds = [name.split(".")[-2:] for name in self.crane.state_names]
        self.sizes = np.array([strokes[owner] if kind == "xs" else SIZES[kind] for owner, kind in kinds])

    def segments(self) -> Iterator[Segment]:
        """Stretches between changes of the commands, in order."""
        for k, begin in enumerate(self.times):
            end = float(self.times[k + 1]) if k + 1 < len(self.times) else self.end
            inside = self.record[(self.record > begin + SAME_INSTANT) & (self.record <= end + SAME_INSTANT)]
            yield Segment(float(begin), end, self.spools[k], np.minimum(inside, end))

    def integrate(self, method: str, rtol: float, step: float | None = None) -> dict[str, Any]:
        """One run by the core, as ``hc.simulate`` asks for it."""
        solver = hc.Solver(method=method, rtol=rtol, max_step=MAX_STEP, step=step)
        entry = scenario_entry(self.plan.changed(solver=solver), self.crane.cylinder_names)
        raw = _core.run(self.crane.core, entry, self.record, False, None, None)
        if raw["outcome"][0] != "completed":
            raise RuntimeError(f"{method} at {rtol:g} ended early: {raw['outcome']}")
        return raw

    def tip(self, states: np.ndarray) -> np.ndarray:
        return self.crane.tip(states[:, : len(self.crane.joint_names)])

    @cached_property
    def exact(self) -> np.ndarray:
        """The tip's path by the tightest run."""
        return self.tip(self.integrate("rodas5p", REFERENCE)["states"])

    def tip_error(self, states: np.ndarray) -> float:
        """Largest distance of the tip from the tightest run, m; infinite where a solver gave up."""
        if states.shape[0] != self.record.size or not np.isfinite(states).all():
            return float("inf")
        return float(np.linalg.norm(self.tip(states) - self.exact, axis=1).max())


def clocked(work: Callable[[], np.ndarray], count: Callable[[], dict[str, float]] = dict) -> Solution:
    """Run it under the clock of all solvers: CPU time of this thread, which other work on the computer hardly moves."""
    began = time.thread_time()
    states = work()
    return Solution(states, time.thread_time() - began, count())
