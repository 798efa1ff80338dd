"""Outcome of a run, and its difference from a repeat with a tighter tolerance."""

from __future__ import annotations

from dataclasses import dataclass

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
        Largest difference of a chamber pressure, Pa.
    time : float
        Time of the largest distance between the tips, s.
    """

    solver: str
    tip: float
    pressure: float
    time: float

    def __str__(self) -> str:
        tip, pressure = self.tip * 1e3, self.pressure / 1e5
        return f"a repeat with {self.solver} differs by at most {tip:.3g} mm at the tip and {pressure:.3g} bar"
