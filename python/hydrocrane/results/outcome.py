"""Outcome of a run, and its difference from a repeat with a tighter tolerance."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hydrocrane.result_warning import ResultWarning

KINDS = ("completed", "stroke-limit", "solver-failed", "controller-failed", "bad-state", "interrupted")


@dataclass(frozen=True)
class Outcome:
    """Outcome of a run and its time.

    Attributes
    ----------
    kind : str
        completed, stroke-limit, solver-failed, controller-failed, bad-state or interrupted.
    time : float
        s.
    message : str
        Cause and cure; empty for a completed run.

    Examples
    --------
    >>> run = hc.simulate("vertical-lift-open-loop", duration=1.0)
    >>> print(run.outcome.kind, run.outcome.time, run.outcome.completed)
    completed 1.0 True
    """

    kind: str
    time: float
    message: str

    @property
    def completed(self) -> bool:
        """Whether the run reached its end."""
        return self.kind == "completed"

    @classmethod
    def stopped(cls, time: float) -> Outcome:
        """Of a run that somebody stopped at `time`, s.

        Examples
        --------
        >>> from hydrocrane.results.outcome import Outcome
        >>> print(Outcome.stopped(0.5).kind)
        interrupted
        """
        return cls("interrupted", time, "stopped from outside, by Ctrl-C or a KeyboardInterrupt of its controller")

    def doubts(self, duration: float) -> tuple[ResultWarning, ...]:
        """Of a run that was to last `duration`, s: what stopped from outside is no shorter run of the scenario.

        Examples
        --------
        >>> from hydrocrane.results.outcome import Outcome
        >>> print([warning.kind for warning in Outcome.stopped(0.5).doubts(2.0)])
        ['interrupted']
        """
        if self.kind != "interrupted":
            return ()
        text = f"the run was {self.message}, at {self.time:.4g} of {duration:.4g} s: nothing after that was computed"
        cure = "run it again to its end, or give that time as its `duration`"
        return (ResultWarning(self.kind, text, cure, self.time),)


@dataclass(frozen=True)
class Verification:
    """Difference of a run from its repeat with a tighter tolerance.

    Attributes
    ----------
    solver : str
        Settings of the repeat.
    tip : float
        Largest distance between the tips at one time, m.
    pressure : float
        Largest difference of a pressure that lasts longer than 20 ms, Pa.
    time : float
        Time of the largest distance between the tips, s.
    tip_limit, pressure_limit : float
        Largest distance, m, and difference, Pa, of a converged run. Infinite in files of earlier versions.
    """

    solver: str
    tip: float
    pressure: float
    time: float
    tip_limit: float = math.inf
    pressure_limit: float = math.inf

    @property
    def converged(self) -> bool:
        """Whether tip and pressures are within the limits."""
        return self.tip <= self.tip_limit and self.pressure <= self.pressure_limit

    def __str__(self) -> str:
        word = "converged" if self.converged else "not converged"
        tip = f"{self.tip * 1e3:.3g} mm at the tip ({self.tip_limit * 1e3:.2g} allowed)"
        pressure = f"{self.pressure / 1e5:.3g} bar ({self.pressure_limit / 1e5:.2g} allowed)"
        return f"{word}: a repeat with {self.solver} differs by at most {tip} and {pressure}"
